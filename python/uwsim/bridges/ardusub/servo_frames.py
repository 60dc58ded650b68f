"""An autopilot's frames of servo outputs: which output drives which thruster, and the replay of recorded frames."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.commands.table import SERVO_FRAMES
from uwsim.recording.real_flights.frames import servo_motors
from uwsim.simulator.lockstep import FRAME_BYTES

if TYPE_CHECKING:
    from uwsim.scenario.spec.actuator import ThrusterMount
    from uwsim.simulator.lockstep import StepSource
    from uwsim.simulator.simulator import Simulator


def played(
    sim: Simulator, source: StepSource | None, *, vehicle: str, frame: str, from_tick: float, frames: bytes
) -> StepSource:
    """Return a source of steps that repeats an autopilot's frames from now on, beside those of other vehicles.

    source: the present one. frames: pulse widths [us], 32 little-endian uint16 for each step. Raises ValueError.
    """
    if vehicle not in sim.vehicles:
        raise ValueError(f"{SERVO_FRAMES}: vehicle = {vehicle!r}: must be one of {', '.join(sim.vehicles)}")
    if from_tick != sim.tick:
        raise ValueError(f"{SERVO_FRAMES}: from_tick = {from_tick:g}: must be the present tick, {sim.tick}")
    if not frames or len(frames) % FRAME_BYTES:
        raise ValueError(f"{SERVO_FRAMES}: frames has {len(frames)} bytes: must be a multiple of {FRAME_BYTES}")
    motors = servo_motors(frame, thrusters_of(sim, vehicle), vehicle)
    playback = _Playback(sim) if source is None else source
    if not isinstance(playback, _Playback) or vehicle in playback.parts:
        raise ValueError(f"{SERVO_FRAMES}: an autopilot makes the steps of this simulation")
    playback.parts[vehicle] = _Part((list(sim.vehicles).index(vehicle), motors), frames)
    return playback


@dataclass
class _Part:
    """The frames of a vehicle, given by its index and motors, that remain."""

    of: tuple[int, list[_core.ServoMotor]]
    frames: bytes


class _Playback:
    """Repeats the steps of recorded frames, by vehicle, then returns control of the simulation."""

    def __init__(self, sim: Simulator) -> None:
        self._sim = sim
        self._tick = sim.tick
        self.parts: dict[str, _Part] = {}

    def advance(self, steps: int) -> None:
        core = self._sim._core  # a part of the simulator
        if core.tick != self._tick:  # after a jump, the frames belong to another time
            self.parts = {}
        while steps and self.parts:
            count = min(steps, *(len(part.frames) // FRAME_BYTES for part in self.parts.values()))
            self._play(core, count)
            steps -= count
        if not self.parts:
            self._sim.lockstep.detach()
        if steps:
            core.step(steps)
        self._tick = core.tick

    def _play(self, core: _core.Simulation, count: int) -> None:
        parts, end = list(self.parts.values()), count * FRAME_BYTES
        helms = [self._sim.vehicles[name].helm for name in self.parts]
        steers = [helm.admit_frames() for helm in helms]
        _core.play_servo_frames(core, [part.of for part in parts], [part.frames[:end] for part in parts], steers)
        for helm, part in zip(helms, parts, strict=True):
            helm.note_command()
            part.frames = part.frames[end:]
        self.parts = {name: part for name, part in self.parts.items() if part.frames}


def thrusters_of(sim: Simulator, vehicle: str) -> Mapping[str, ThrusterMount]:
    """Return a vehicle's thrusters as mounted."""
    return next(entry.model.thrusters for entry in sim.scenario.vehicles if entry.name == vehicle)


def unpacked(frames: bytes) -> NDArray[np.uint16]:
    """Return frames as pulse widths (n, 32) [us]."""
    return np.frombuffer(frames, "<u2").reshape(-1, 32)
