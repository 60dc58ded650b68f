"""An autopilot's frames of servo outputs: which output drives which thruster, and the replay of recorded frames."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.commands.table import SERVO_FRAMES
from uwsim.simulator.lockstep import FRAME_BYTES

if TYPE_CHECKING:
    from uwsim.scenario.spec.actuator import ThrusterMount
    from uwsim.simulator.lockstep import StepSource
    from uwsim.simulator.simulator import Simulator


class Factors(NamedTuple):
    """The effect of a motor at full command, in the autopilot's axes.

    Forces are forward, right (lateral) and up (throttle); moments are right-handed about the forward, right and down
    axes.
    """

    roll: int
    pitch: int
    yaw: int
    throttle: int
    forward: int
    lateral: int


_HORIZONTAL = (
    Factors(0, 0, 1, 0, -1, 1),
    Factors(0, 0, -1, 0, -1, -1),
    Factors(0, 0, -1, 0, 1, 1),
    Factors(0, 0, 1, 0, 1, -1),
)
FRAMES: Mapping[str, tuple[Factors, ...]] = {
    "vectored": (*_HORIZONTAL, Factors(1, 0, 0, -1, 0, 0), Factors(-1, 0, 0, -1, 0, 0)),
    "vectored_6dof": (
        *_HORIZONTAL,
        Factors(1, -1, 0, -1, 0, 0),
        Factors(-1, -1, 0, -1, 0, 0),
        Factors(1, 1, 0, -1, 0, 0),
        Factors(-1, 1, 0, -1, 0, 0),
    ),
}
"""ArduSub's frames (libraries/AP_Motors/AP_Motors6DOF.cpp): the factors of each motor, by servo output."""

ACROSS = 0.2
"""The largest share of a thrust that may act along an axis for which a motor's factor is 0."""


def frame_of(thrusters: Mapping[str, ThrusterMount], vehicle: str) -> str:
    """Return the name of the frame to which a vehicle's thrusters belong. Raises ValueError if there is none."""
    for name in FRAMES:
        if len(_fitting(name, thrusters)) == len(thrusters):
            return name
    raise ValueError(f"vehicle '{vehicle}': its thrusters fit none of ArduSub's frames {', '.join(FRAMES)}")


def servo_motors(frame: str, thrusters: Mapping[str, ThrusterMount], vehicle: str) -> list[_core.ServoMotor]:
    """Return which servo output drives which thruster, determined from the directions of forces and moments.

    Raises ValueError for an unknown frame, or one whose motors are arranged differently from the vehicle's.
    """
    if frame not in FRAMES:
        raise ValueError(f"frame = '{frame}': must be one of {', '.join(FRAMES)}")
    found, wanted = _fitting(frame, thrusters), len(FRAMES[frame])
    if not len(found) == wanted == len(thrusters):
        number = f"{len(thrusters)} thrusters of vehicle '{vehicle}'"
        raise ValueError(f"frame = '{frame}': has {wanted} motors, to which {len(found)} of the {number} correspond")
    return found


def _fitting(frame: str, thrusters: Mapping[str, ThrusterMount]) -> list[_core.ServoMotor]:
    """Return the motors that match exactly one thruster which, in turn, matches no other motor."""
    pairs = [
        (output, name, direction)
        for output, motor in enumerate(FRAMES[frame])
        for name, mount in thrusters.items()
        if (direction := _direction(motor, mount))
    ]
    outputs, names = [output for output, _, _ in pairs], [name for _, name, _ in pairs]
    alone = [pair for pair in pairs if outputs.count(pair[0]) == names.count(pair[1]) == 1]
    return [_core.ServoMotor(output, name, direction) for output, name, direction in alone]


def _direction(motor: Factors, mount: ThrusterMount) -> int:
    """Return the sign of a thruster's command for a positive motor command; 0 if their directions differ."""
    force = np.array(mount.axis) / np.linalg.norm(mount.axis)
    moment = np.cross(mount.position_m, force)
    acts = np.array([moment[0], -moment[1], -moment[2], force[2], force[0], -force[1]])
    factors = np.array(motor, np.float64)
    for sign in (1, -1):
        agrees = np.all(sign * acts[factors != 0] * factors[factors != 0] > 0)
        if agrees and np.all(np.abs(acts[3:][factors[3:] == 0]) <= ACROSS):
            return sign
    return 0


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
