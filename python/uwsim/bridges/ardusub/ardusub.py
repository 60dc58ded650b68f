"""ArduSub: physics for ArduPilot's JSON interface, through which a compiled ArduSub flies a simulated vehicle."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.commands.table import SERVO_FRAMES
from uwsim.bridges.ardusub.auxiliary import Auxiliary
from uwsim.bridges.ardusub.servo_frames import thrusters_of, unpacked
from uwsim.bridges.ardusub.servo_steps import LIVE_PATIENCE_S, ServoSteps
from uwsim.bridges.doors.admission import warn_beyond_loopback
from uwsim.bridges.rare_log import RareLog
from uwsim.live import LiveSimulator
from uwsim.recording.real_flights.frames import frame_of, servo_motors
from uwsim.scenario import Scenario
from uwsim.simulator.helm import Clock, Lease, Source, Timeout
from uwsim.simulator.lockstep import FRAME_BYTES
from uwsim.simulator.simulator import Simulator
from uwsim.simulator.vehicle import Vehicle

PORT, PORTS_APART = 9002, 10
"""UDP port of the first ArduSub, and the distance to the next one's, as between ArduPilot's instances (-I)."""
RATE_HZ = 400
"""ArduSub's loop (SCHED_LOOP_RATE); physics with a longer step would slow it down."""
VEHICLE = "bluerov2_heavy_outfit"
"""The model that replaces the first vehicle if it has no thrusters; it reaches the speed that its maker states."""
NET_BUOYANCY_N = 2.0
"""Blue Robotics, BlueROV2, specifications: 0.2 kg with ballast."""
SILENT_S = 1.0  # silence after which the world counts as paused

logger = logging.getLogger("uwsim.bridges.ardusub")


class SilentAutopilotError(TimeoutError):
    """Raised by Simulator.step if no frame arrives from the autopilot."""


def prepared(scenario: Scenario, vehicle: str | Path | None = None, names: Sequence[str] = ()) -> Scenario:
    """Return a variant of a scenario that ArduSub can fly: steps of at most 1/400 s, vehicles with thrusters.

    vehicle: the model that replaces those of the vehicles to be flown, as a packaged name or a path; by default, only
    those without thrusters are replaced, by bluerov2_heavy_outfit. Without `trim`, the new model is trimmed to a net
    buoyancy of 2 N. names: of the vehicles to be flown; by default, the first. Raises ScenarioError or ValueError.
    """
    from uwsim.scenario.read.validated import validated
    from uwsim.scenario.spec.vehicle import Trim, load_vehicle

    known = [entry.name for entry in scenario.vehicles]
    for name in names:
        if name not in known or list(names).count(name) > 1:
            raise ValueError(f"vehicle = {name!r}: must be one of {', '.join(known)}, each once")
    entries = []
    for entry in scenario.vehicles:
        data = entry.given()
        if entry.name in (names or known[:1]) and (vehicle is not None or not entry.model.thrusters):
            model = load_vehicle(VEHICLE if vehicle is None else vehicle)
            trim = model.trim or Trim(net_buoyancy_n=NET_BUOYANCY_N)
            data["model"] = model.model_copy(update={"trim": trim})
        entries.append(data)
    changes = {"step_s": min(scenario.step_s, 1 / RATE_HZ), "vehicles": entries}
    return validated(Scenario, {**scenario.given(), **changes}).read_from(scenario.source_file)


class ArduSub:
    """Lets a compiled ArduSub fly a vehicle and step its simulator, through ArduPilot's "JSON" interface.

        with Simulator(prepared(load("lagoon"))) as sim, ArduSub(sim):
            sim.advance(60)          # as fast as the firmware sends its frames

    The firmware sends its servo outputs by UDP and receives the vehicle's motion after one step; see ServoExchange for
    the protocol. Each frame makes one step; with several ArduSubs, a frame of each. While it is attached, other
    commands that would move the vehicle raise ValueError, but all stop and the failsafe take precedence over the
    firmware's outputs. The frames are journalled as commands, so that recordings and logs are replayed byte for byte. A
    docked vehicle is undocked.

    simulator: a Simulator, whose `step` then waits for frames and raises SilentAutopilotError after patience_s without
    a frame; or a LiveSimulator, which pauses while the firmware is silent. vehicle: its name; by default the first.
    frame: "vectored" or "vectored_6dof"; by default the frame that fits the thrusters. port: 0 for any free port. host:
    the address to listen on. with_noise: whether the IMU and the altimeter are read with their errors, in addition to
    those that the firmware simulates. lights, tilt: numbers of the servo outputs, from 1, that dim the lamps and tilt
    the cameras. The attributes port and address are those in use. Raises ValueError, or OSError if the port is not
    available.

    require_alive: called while no frame arrives; raises an OSError if none can arrive any more, since the program has
    ended, and `step` passes it on.
    """

    def __init__(
        self,
        simulator: Simulator | LiveSimulator,
        *,
        vehicle: str | None = None,
        frame: str | None = None,
        port: int = PORT,
        host: str = "127.0.0.1",
        with_noise: bool = False,
        lights: int | None = None,
        tilt: int | None = None,
        patience_s: float = 10.0,
    ) -> None:
        self._live = simulator if isinstance(simulator, LiveSimulator) else None
        self._sim = sim = simulator.simulator if isinstance(simulator, LiveSimulator) else simulator
        if vehicle is not None and vehicle not in sim.vehicles:
            raise ValueError(f"vehicle = {vehicle!r}: must be one of {', '.join(sim.vehicles)}")
        self.vehicle = vehicle or next(iter(sim.vehicles))
        if sim.step_s > 1 / RATE_HZ + 1e-12:
            rule = f"must be at most {1 / RATE_HZ:g} s for ArduSub: take scenario.with_changes(step_s={1 / RATE_HZ:g})"
            raise ValueError(f"step_s = {sim.step_s:g} s: {rule}")
        thrusters = thrusters_of(sim, self.vehicle)
        self.frame = frame or frame_of(thrusters, self.vehicle)
        self.with_noise = with_noise
        self.lights, self.tilt = lights, tilt
        self.require_alive: Callable[[], object] = lambda: None
        self.patience_s = patience_s
        self._name = f"ArduSub of '{self.vehicle}'"
        self._rov = rov = sim.vehicles[self.vehicle]
        self._log = RareLog(logger)
        self.auxiliary = Auxiliary(rov, lights, tilt, self._command, self._set_parameter, self._log)
        kinds = [sensor.kind for sensor in rov.sensors.values()]
        if "imu" not in kinds:
            raise ValueError(f"vehicle '{self.vehicle}': has no IMU, which ArduSub needs")
        self._exchange: _core.ServoExchange | None = _core.ServoExchange(
            sim._core,
            list(sim.vehicles).index(self.vehicle),
            servo_motors(self.frame, thrusters, self.vehicle),
            imu=kinds.index("imu"),
            altimeter=kinds.index("altitude") if "altitude" in kinds else None,
            with_noise=with_noise,
            watched=self.auxiliary.watched,
            host=host,
            port=port,
        )
        warn_beyond_loopback(host, None, tls=False)
        self.port: int = self._exchange.port
        self.address = f"{host}:{self.port}"
        self._reported = self._exchange.counts
        self._last_frame = bytes(FRAME_BYTES)
        self._lease: Lease | None = None
        self._steps: ServoSteps | None = None
        limit_s = patience_s if self._live is None else SILENT_S
        self._silence = Timeout(Clock.LOCKSTEP, lambda: max(limit_s, 1e-9), heard_ns=time.monotonic_ns())
        self._is_silent = False

    @property
    def simulator(self) -> Simulator:
        """The simulator whose steps the firmware makes."""
        return self._sim

    @property
    def flown(self) -> Vehicle:
        """The vehicle that the firmware flies."""
        return self._rov

    @property
    def exchange(self) -> _core.ServoExchange:
        """The exchange of packets. Raises ValueError if this is closed."""
        if self._exchange is None:
            raise ValueError("this ArduSub is closed: make another")
        return self._exchange

    @property
    def outputs_us(self) -> NDArray[np.uint16]:
        """The pulse widths of the last frame, (32,) [us]; 0 for outputs that do not exist, and before the first."""
        return unpacked(self._last_frame).reshape(-1)

    @property
    def counts(self) -> _core.ServoCounts:
        """The numbers of frames and packets received so far."""
        return self._reported if self._exchange is None else self._exchange.counts

    @property
    def peer(self) -> str:
        """The firmware's address and port; empty before its first frame and after `close`."""
        return "" if self._exchange is None else self._exchange.peer

    def wait(self) -> None:
        """Wait until the firmware has sent its next frame; it then waits for the next step.

        A MAVLink message sent to the firmware before that step is received at the same frame in every run. Raises
        SilentAutopilotError, or what require_alive raises.
        """
        end_s = time.monotonic() + self.patience_s
        while not self.is_waiting(min(LIVE_PATIENCE_S, self.patience_s)):
            self.require_alive()
            if self._exchange is None or time.monotonic() >= end_s:
                raise SilentAutopilotError(f"{self._name}: no frame on UDP {self.address} for {self.patience_s:g} s")

    def is_ready(self) -> bool:
        """Return whether the firmware waits for a step. Without a live simulator this waits for it; see `wait`."""
        if self._live is not None:
            return self.is_waiting()
        self.wait()
        return True

    def is_waiting(self, patience_s: float = LIVE_PATIENCE_S) -> bool:
        """Return whether the firmware waits for a step, after waiting up to patience_s for its frame."""
        return self._exchange is not None and self._exchange.wait(patience_s)

    def start(self) -> Self:
        """Take over the simulator's steps; return self. Raises ValueError."""
        self._between_steps(self._attach)
        return self

    def close(self) -> None:
        """Return control of the steps to the simulator, stop the thrusters, and close the socket."""
        if self._exchange is not None:
            self._between_steps(self._detach)

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    def _between_steps(self, function: Callable[[], None]) -> None:
        if self._live is not None and self._live.running:
            self._live.read(lambda sim: function()).result()
        else:
            function()

    def _attach(self) -> None:
        _ = self.exchange
        steps = ServoSteps.of(self._sim)
        steps.require_free(self.vehicle)
        if not self._rov.released:
            self._command("undock")
        steps.join(self)
        self._steps = steps
        self._lease = self._rov.helm.take(Source.AUTOPILOT, "ArduSub")
        self._silence.heard_ns = time.monotonic_ns()

    def _detach(self) -> None:
        if self._steps is not None and self._lease is not None:
            self._steps.leave(self)
            self._lease.end()
        self._command("set_effort")
        self._reported, self._exchange = self.counts, None

    def _command(self, name: str, **arguments: object) -> None:
        """Issue a command between two steps."""
        if self._live is None:
            self._rov.command(name, **arguments)
        else:
            self._live.command_now(name, vehicle=self.vehicle, **arguments)

    def _set_parameter(self, name: str, value: float) -> None:
        """Set a parameter between two steps."""
        if self._live is None:
            self._sim.parameters[name] = value
        else:
            self._live.command_now("set_parameter", name=name, value=value)

    def take(self, frames: bytes, tick: int, *, changed: bool) -> None:
        """Note the frames that made steps from a tick on. changed: whether the last may have changed lights or tilt."""
        self._report()
        if not frames:
            return
        self._rov.helm.note_command()
        self._last_frame = frames[-FRAME_BYTES:]
        self._sim.journal.note(SERVO_FRAMES, vehicle=self.vehicle, frame=self.frame, from_tick=tick, frames=frames)
        if changed:
            self.auxiliary.ask(self.outputs_us)
        if self._is_silent:
            logger.warning("%s: frames arrive again: the world continues", self._name)
        self._silence.heard_ns, self._is_silent = time.monotonic_ns(), False

    @property
    def is_live(self) -> bool:
        """True if the simulator is a live one."""
        return self._live is not None

    def note_missing(self) -> None:
        """Note that no step could be made.

        Raises SilentAutopilotError if this firmware has been silent too long, unless the simulator is live, or what
        require_alive raises.
        """
        self.require_alive()
        now_ns = time.monotonic_ns()
        if self.exchange.has_frame:  # another firmware is silent
            self._silence.heard_ns = now_ns
        elif not self._silence.left_ns(now_ns):
            if self._live is None:
                where = f"since {self._sim.time_s:.4f} s" if self.peer else f"on UDP {self.address}"
                raise SilentAutopilotError(f"{self._name}: no frame {where} for {self.patience_s:g} s: is it running?")
            self._note_silence()

    def _note_silence(self) -> None:
        if not self._is_silent:
            self._is_silent = True
            if self.peer:
                text = "%s: no frame for %g s: the world is paused at %.4f s"
                logger.warning(text, self._name, SILENT_S, self._sim.time_s)
            else:
                logger.warning("%s: waits for its first frame on UDP %s", self._name, self.address)

    def _report(self) -> None:
        """Log any problems with packets since the last call, each kind at most once a minute."""
        now, before = self.counts, self._reported
        self._reported = now
        where = f"{self._name}: UDP {self.address}"
        if now.foreign > before.foreign:
            self._log.warning(f"{where}: packets that are no servo packets are ignored")
        if now.cut > before.cut:
            self._log.warning(f"{where}: servo packets of a wrong length are ignored")
        if now.others > before.others:
            self._log.warning(f"{where}: a second autopilot is ignored while {self.peer} sends frames")
        if now.lost > before.lost:
            self._log.warning(f"{where}: frames were lost")
        if now.resets > before.resets:
            self._log.warning(f"{where}: the autopilot started again; the vehicle stays where it is")
