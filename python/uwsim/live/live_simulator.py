"""LiveSimulator, the interface to a simulator that runs on the wall clock."""

from __future__ import annotations

import logging
import threading
import weakref
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import replace
from types import TracebackType
from typing import Any, Self, TypeVar

from uwsim.base.arguments import plain
from uwsim.base.commands import ALL_STOP, COMMANDS, bound_command
from uwsim.live.clock import LiveClock, MissionClock
from uwsim.live.command_log import CALL, RESET, CommandLog
from uwsim.live.pace import Pace, Speed
from uwsim.live.requests import Request, Subscription
from uwsim.live.step_loop import StepLoop
from uwsim.live.vehicle import LiveVehicle
from uwsim.scenario import AnyScenario
from uwsim.simulator.simulator import Simulator

T = TypeVar("T")

STOP_S = 1.0
HELD = 0.95  # fraction of the requested speed that counts as reaching it
PACE_ACTS = ("pause", "resume", "step", "speed")
ACTS = (CALL, RESET, *PACE_ACTS)
"""The acts on a live simulator that are not commands: a call of a function, a jump in time, and changes of the pace."""

logger = logging.getLogger("uwsim.live")


class LiveSimulator:
    """A simulator that one thread steps at the pace of the wall clock, while other threads command and read it.

        with LiveSimulator("lake", speed=1.0) as live:
            live.command("set_effort", vehicle="rov", surge=0.5).result()
            live.every(0.1, lambda sim: sim.rov.pose, poses.append)

    simulator: a Simulator, which this object takes over, or the scenario to create one from. speed: simulated seconds
    per wall second, or "max". paused: whether the simulator starts paused.

    Commands from all threads are queued in order of arrival. They take effect between two steps, or immediately while
    the simulator is paused. Each command is logged with its tick, so that `replay(scenario, live.log, tick)` reproduces
    the same bytes. If the simulator cannot keep the pace, it catches up after short delays and lets the schedule slip
    after longer delays; see `factor`, `lateness` and `slipped_s`. If a step fails, the simulator pauses; `error`
    contains the reason, and `reset` allows it to continue.

    refusal_of: returns the reason why an act (a command's name, or one of ACTS) is refused now, or "". The act then
    raises ValueError with this reason, except within `privileged`. By default nothing is refused.

    The attribute `simulator` is for fixed properties and single readings; do not step or command it directly.
    `vehicles` and `rov` accept commands from any thread. `log` is the CommandLog.
    """

    def __init__(
        self, simulator: Simulator | AnyScenario = "lake", *, speed: Speed = 1.0, paused: bool = False
    ) -> None:
        self.simulator = simulator if isinstance(simulator, Simulator) else Simulator(simulator)
        self.simulator.scene.prepare()  # otherwise the first ray would make the clock late
        self.log = CommandLog(self.simulator.save_state(), self.simulator.tick)
        self.vehicles = {name: LiveVehicle(self, vehicle) for name, vehicle in self.simulator.vehicles.items()}
        self._pace = Pace(speed, self.simulator.step_s)
        self._loop = StepLoop(self.simulator, self._pace, self.log, paused=paused)
        self._thread: threading.Thread | None = None
        self._end: weakref.finalize[Any, Any] | None = None
        self.refusal_of: Callable[[str], str] = lambda act: ""
        self._privileges = threading.local()

    def __repr__(self) -> str:
        state = "stopped" if not self.running else "paused" if self.paused else f"at speed {self.speed}"
        return f"<LiveSimulator, {state}: {self.simulator!r}>"

    @property
    def rov(self) -> LiveVehicle:
        """The scenario's first vehicle."""
        return next(iter(self.vehicles.values()))

    @property
    def clock(self) -> LiveClock:
        """A clock for one mission on one thread; see uwsim.navigation.control.Clock."""
        return LiveClock(self._loop)

    @contextmanager
    def mission_clock(self) -> Iterator[MissionClock]:
        """Return a clock for one mission that pauses simulated time while the mission computes.

            with live.mission_clock() as clock:
                run(mission, live.rov, clock)

        The mission thus produces the same bytes as on a Simulator, no matter how busy the machine is. Long computations
        in the mission make the simulator late.
        """
        clock = MissionClock(self._loop)
        try:
            yield clock
        finally:
            clock.close()

    def start(self) -> Self:
        """Start stepping; return self.

        Raises RuntimeError if the simulator is already running or has not yet stopped.
        """
        if self.running:
            raise RuntimeError("the live simulator is already running")
        self._pace.restart()
        self._loop.open()
        self.simulator.journal.listen(self._loop)
        self._thread = threading.Thread(target=self._loop.run, name="uwsim-live", daemon=True)
        self._thread.start()
        # A thread in native code at the interpreter's shutdown would abort the process.
        self._end = weakref.finalize(self, _end, self._loop, self._thread)
        return self

    def stop(self) -> None:
        """Stop stepping within a second. Pending requests raise NotRunningError. `start` can resume stepping."""
        self._loop.close()
        if self._thread is None or self._on_loop:
            return
        self._thread.join(STOP_S)
        self.simulator.journal.detach(self._loop)
        if self._thread.is_alive():
            logger.warning("the live simulator stops as soon as a call ends that has lasted for %g s", STOP_S)
        elif self._end is not None:
            self._end.detach()  # it keeps the loop, and all that the loop's readers hold

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop."""
        self.stop()

    @property
    def running(self) -> bool:
        """Whether the stepping thread is running, paused or not."""
        return self._thread is not None and self._thread.is_alive()

    @property
    def tick(self) -> int:
        """The number of steps completed since the start.

        Unlike Simulator.tick, reading this never waits for a step.
        """
        return self._loop.tick

    @property
    def time_ns(self) -> int:
        """Simulated time since the start in nanoseconds; reading it never waits for a step."""
        return self.tick * round(self.simulator.step_s * 1e9)

    @property
    def speed(self) -> Speed:
        """The requested pace: simulated seconds per wall second, or "max".

        Setting an invalid value raises ValueError.
        """
        return self._pace.speed

    @speed.setter
    def speed(self, speed: Speed) -> None:
        self._require("speed")
        with self._loop.lock:
            self._pace.set_speed(speed)
            self._loop.changed.notify_all()

    @property
    def factor(self) -> float:
        """The speed achieved over the last second; 0 while paused."""
        with self._loop.lock:
            return 0.0 if self.paused or not self.running else self._pace.factor

    @property
    def is_behind(self) -> bool:
        """True if the steps have not reached the requested speed in the last second; False at full speed."""
        speed, factor = self.speed, self.factor
        return speed != "max" and 0.0 < factor < HELD * speed

    @property
    def lateness(self) -> float:
        """The largest delay of a step relative to the schedule, in seconds, since the start or `forget_delays`."""
        return self._pace.lateness_s

    @property
    def slipped_s(self) -> float:
        """The total wall time in seconds by which the schedule has slipped since the start or `forget_delays`."""
        return self._pace.slipped_s

    def forget_delays(self) -> None:
        """Restart the measurement of `lateness` and `slipped_s`."""
        self._pace.forget_delays()

    @property
    def paused(self) -> bool:
        """Whether simulated time is paused."""
        return self._loop.paused

    @property
    def error(self) -> Exception | None:
        """The error that stopped the simulation, such as diverging motion, or None."""
        return self._loop.error

    def pause(self) -> None:
        """Pause; return once no step is in progress."""
        self._require("pause")
        self._loop.set_paused(True)
        if self.running and not self._on_loop:
            self.read(lambda sim: None).result()

    def resume(self) -> None:
        """Continue, after all earlier commands. Raises the error that stopped the simulation, if any."""
        self._require("resume")
        if self.running and not self._on_loop:
            self._loop.in_turn(lambda: self._loop.set_paused(False))
        else:
            self._loop.set_paused(False)

    def step(self, n: int = 1) -> None:
        """Make n steps while paused, as fast as possible; return after the last one.

        Raises ValueError if n is invalid or the simulator is not paused.
        """
        if isinstance(n, bool) or not isinstance(n, int) or not 0 <= n < 2**53:
            raise ValueError(f"n = {n!r} steps: must be a whole number, not negative")
        self._require("step")
        if self._on_loop:
            raise RuntimeError("step: a call or sink must not wait for steps")
        self._loop.in_turn(lambda: self._loop.step_when_paused(n)).wait()

    def reset(self, state: bytes | None = None) -> None:
        """Restore a state returned by save_state, by default the initial state; return once it is in effect.

        Raises ValueError if the state does not fit this simulator.
        """
        future = self._submit(lambda sim: sim.restore_state(state or self.log.start_state), RESET, {"state": state})
        future.result()

    def call(self, function: Callable[[Simulator], T]) -> Future[T]:
        """Call function(simulator) at the start of the next step. From then on, the log cannot be written to a file.

        The function must be brief, since it delays the steps. The future receives its result or error. Raises
        NotRunningError if the simulator is not running.
        """
        return self._submit(function, CALL, {"function": function, "raised": False})

    def read(self, function: Callable[[Simulator], T]) -> Future[T]:
        """Call function(simulator) between two steps, without logging it. The function must not change anything."""
        return self._submit(function, None, {})

    def follow(self, function: Callable[[Simulator], T]) -> Future[T]:
        """Call function(simulator) between two steps, even if commands are refused.

        Used by a replay to set the time.
        """
        return self._submit(function, None, {})

    def command(self, name: str, /, **arguments: Any) -> Future[Any]:
        """Issue one of uwsim.live.COMMANDS at the start of the next step. Arguments must be of JSON types or arrays.

        All stop comes before all commands that wait. Raises ValueError for an unknown name or arguments that the table
        of commands does not allow; the future
        receives exceptions raised by the command itself.
        """
        kept = {key: plain(value, f"command '{name}': {key}") for key, value in arguments.items()}
        return self._submit(bound_command(name, kept), name, kept)

    def carry_stop(self, vehicle: str, is_stop: bool, name: str, /, **arguments: Any) -> Future[Any]:
        """Issue a command that carries an all stop, or its release, to a vehicle: it takes the place of an all stop."""
        kept = {key: plain(value, f"command '{name}': {key}") for key, value in arguments.items()}
        request = self._request(bound_command(name, kept), name, kept)
        return self._queue(replace(_stopping(request, vehicle, is_stop), is_vital=True))

    def command_now(self, name: str, /, **arguments: Any) -> Any:
        """Issue a command like `command`, but at once; return its result, or raise its error.

        Only for the stepping thread, or for any thread while the simulator is not running.
        """
        kept = {key: plain(value, f"command '{name}': {key}") for key, value in arguments.items()}
        request = self._request(bound_command(name, kept), name, kept)
        self._loop.answer(request)
        return request.future.result()

    def every(
        self,
        period_s: float,
        read: Callable[[Simulator], T],
        sink: Callable[[T], object],
        *,
        leads: bool = False,
    ) -> Subscription:
        """Take a reading now, after each jump in time, and at all multiples of period_s, and pass it to the sink.

        Readings are taken after the first step at or after each multiple, in simulated time. Both functions run on the
        stepping thread and must be brief; the sink must not block. Their errors are logged and stored in the
        subscription. leads: whether these readings precede all others at the same tick, as time and transforms do.
        Raises ValueError if the period is invalid, NotRunningError if the simulator is not running.
        """
        if not 0 < period_s <= 1e9:
            raise ValueError(f"period_s = {period_s} s: must be in (0, 1e9]")
        subscription = Subscription(self.simulator, max(round(period_s * 1e9), 1), read, sink, leads=leads)
        self._loop.subscribe(subscription)
        return subscription

    @contextmanager
    def privileged(self) -> Iterator[None]:
        """Within the block, this thread's acts are not refused: those of the program itself."""
        before, self._privileges.is_held = getattr(self._privileges, "is_held", False), True
        try:
            yield
        finally:
            self._privileges.is_held = before

    def _require(self, act: str) -> None:
        if not getattr(self._privileges, "is_held", False) and (reason := self.refusal_of(act)):
            raise ValueError(reason)

    @property
    def _on_loop(self) -> bool:
        return threading.current_thread() is self._thread

    def _request(self, function: Callable[[Simulator], Any], name: str | None, arguments: dict[str, Any]) -> Request:
        if name is not None:
            self._require(name)
        is_vital = name in COMMANDS and COMMANDS[name].is_vital
        request = Request(function, name, arguments, is_vital=is_vital)
        return _stopping(request, arguments["vehicle"], arguments.get("on", True)) if name == ALL_STOP else request

    def _submit(self, function: Callable[[Simulator], Any], name: str | None, arguments: dict[str, Any]) -> Future[Any]:
        return self._queue(self._request(function, name, arguments))

    def _queue(self, request: Request) -> Future[Any]:
        if self._on_loop:  # for example a sink, which issues commands between two steps
            self._loop.answer(request)
        else:
            self._loop.submit(request)
        return request.future


def _stopping(request: Request, vehicle: str, is_stop: bool) -> Request:
    return replace(request, stops=vehicle if is_stop else None, releases=None if is_stop else vehicle)


def _end(loop: StepLoop, thread: threading.Thread) -> None:
    loop.close()
    if thread is not threading.current_thread():
        thread.join(STOP_S)
