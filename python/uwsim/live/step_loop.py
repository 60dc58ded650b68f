"""The loop of the thread that owns a simulator. It answers requests and makes the steps that are due."""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import replace
from functools import partial
from typing import Any, TypeVar

from uwsim.base.agenda import Rank, act, due_tick
from uwsim.base.commands.table import SERVO_FRAMES
from uwsim.live.command_log import CALL, RESET, CommandLog, Entry
from uwsim.live.pace import Pace
from uwsim.live.requests import Alarm, NotRunningError, Request, Subscription
from uwsim.simulator.simulator import Simulator

T = TypeVar("T")

REQUESTS_MAX = 10_000  # limit of the queue; further requests are refused, so that a flood cannot fill the memory
REQUESTS_PER_STEP = 1_000  # requests answered between two steps, so that a flood cannot stop time
REQUESTS_S = 0.02  # the same as a time, since a request may be slow; at least one is answered
START_NAVIGATION = "start_navigation"
# Items of the agenda that others wait for: they must be on time, so steps are not batched across them.
AWAITED = (Rank.FRAME, Rank.READING, Rank.DELIVERY, Rank.REPLAY)

logger = logging.getLogger("uwsim.live")


class StepLoop:
    """The state shared by the stepping thread and other threads, guarded by `lock`.

    An alarm is a future that resolves when the loop has made a given number of steps. steps_made keeps increasing even
    when a reset moves simulated time back. holds: the value of steps_made beyond which no step may be made, by holder.
    error: the error that stopped the simulation, if any.
    """

    def __init__(self, sim: Simulator, pace: Pace, log: CommandLog, *, paused: bool) -> None:
        self.sim = sim
        self.pace = pace
        self.log = log
        self.lock = threading.RLock()  # taken itself: an interrupt in Condition.__enter__ would leave it taken
        self.changed = threading.Condition(self.lock)
        self.paused = paused
        self.steps_made = 0
        self.error: Exception | None = None
        self._requests: deque[Request] = deque()
        self._alarms: list[tuple[int, Alarm]] = []
        self._steps_until = 0  # while paused, step until steps_made reaches this
        self._tick = sim.tick
        self._is_open = False
        self._stepping = False
        self.holds: dict[object, int] = {}

    @property
    def tick(self) -> int:
        """The simulator's tick after the last step or jump."""
        return self._tick

    def open(self) -> None:
        """Accept requests before `run` starts."""
        with self.lock:
            self._is_open = True

    def close(self) -> None:
        """Refuse further requests, and end `run`."""
        with self.lock:
            self._is_open = False
            self.changed.notify_all()

    def submit(self, request: Request) -> None:
        """Queue a request; one that stops a vehicle comes first. Raises NotRunningError if not running.

        Raises RuntimeError if the queue is full.
        """
        with self.lock:
            self._require_open()
            if len(self._requests) >= (2 if request.is_vital else 1) * REQUESTS_MAX:
                raise RuntimeError(f"{REQUESTS_MAX} commands are already waiting for the next step: more are refused")
            overtaken = [] if request.stops is None else self._put_first(request)
            if request.stops is None:
                self._requests.append(request)
            self.changed.notify_all()
        for release in overtaken:
            if release.future.set_running_or_notify_cancel():
                release.future.set_exception(RuntimeError("all stop was set before it could be released"))

    def _put_first(self, stop: Request) -> list[Request]:
        """Queue a stop ahead of all requests; return the waiting releases of the same vehicle, which are removed.

        If a waiting request may go to another state, in which the vehicle is not stopped, stop it again after that.
        """
        overtaken = [each for each in self._requests if each.releases == stop.stops]
        kept = [each for each in self._requests if each.releases != stop.stops]
        again = [replace(stop, future=Future())] if any(each.name in (CALL, RESET) for each in kept) else []
        self._requests = deque([stop, *kept, *again])
        return overtaken

    def in_turn(self, function: Callable[[], T]) -> T:
        """Call a function on the stepping thread after all earlier requests. Return its result, or raise its error."""
        request = Request(lambda sim: function())
        self.submit(request)
        return request.future.result()  # type: ignore[no-any-return]

    def subscribe(self, subscription: Subscription) -> None:
        """Start taking a subscription's readings. Raises NotRunningError if not running."""
        with self.lock:
            self._require_open()
            read = partial(self._read, subscription)
            rank = Rank.FRAME if subscription.leads else Rank.READING
            self.sim.agenda.add(subscription, rank, read, jump=subscription.jump)
            self.changed.notify_all()

    def _read(self, subscription: Subscription, tick: int) -> None:
        self._tick = tick  # sinks may read it
        subscription.act(tick)

    def alarm(self, until: int, *, holder: object = None) -> Alarm:
        """Return an alarm that rings when steps_made is `until`.

        holder: if given, no step beyond `until` is made before the holder's next alarm or release. Raises
        NotRunningError, or the error that stopped the simulation, if any.
        """
        with self.lock:
            self._require_open()
            if holder is not None:
                self.holds[holder] = until
            return self._alarm(until)

    def hold(self, holder: object) -> int:
        """Stop making steps until this holder's `release` or `alarm`.

        Return steps_made once no step is in progress.
        """
        with self.lock:
            self._require_open()
            while self._stepping:
                self.changed.wait()
            self.holds[holder] = self.steps_made
            return self.steps_made

    def release(self, holder: object) -> None:
        """End a hold."""
        with self.lock:
            self.holds.pop(holder, None)
            self.changed.notify_all()

    def step_when_paused(self, steps: int) -> Alarm:
        """Request a number of steps; return a future that resolves after the last one.

        Raises ValueError if the simulator is not paused, or the same errors as `alarm`.
        """
        with self.lock:
            self._require_open()
            if not self.paused:
                raise ValueError("step: the simulator is running; pause it first")
            self._steps_until = max(self.steps_made, self._steps_until) + steps
            return self._alarm(self._steps_until)

    def _alarm(self, until: int) -> Alarm:
        if self.error is not None:
            raise self.error
        alarm = Alarm()
        if until <= self.steps_made:
            alarm.ring()
        else:
            self._alarms.append((until, alarm))
        self.changed.notify_all()
        return alarm

    def set_paused(self, paused: bool) -> None:
        """Pause or continue. Raises the error that stopped the simulation, if any."""
        with self.lock:
            if not paused and self.error is not None:
                raise self.error
            self.paused = paused
            self._steps_until = self.steps_made
            self.pace.restart()
            self.changed.notify_all()

    def run(self) -> None:
        """Make steps and answer requests until closed. Errors in requests, readings and steps do not end it."""
        try:
            while self._wait_for_work():
                self._make_steps()  # those that are due before the pending requests
                if self._requests:
                    self._answer_requests()
                act(self.sim.agenda.of(*AWAITED), self._tick)  # items that became due through a request
        finally:
            self._refuse_what_waits()

    def _require_open(self) -> None:
        if not self._is_open:
            raise NotRunningError("the live simulator is not running: start it first")

    def _wait_for_work(self) -> bool:
        """Sleep until there is work to do; return whether to continue."""
        with self.lock:
            while self._is_open:
                awaited = self._awaited_tick - self._tick
                if self._requests or awaited <= 0:
                    return True
                wait_s = self._time_to_step_s(time.monotonic(), awaited)
                if wait_s is not None and wait_s <= 0:
                    return True
                self.changed.wait(wait_s)
            return False

    def _time_to_step_s(self, now_s: float, awaited: int) -> float | None:
        """Return the time to wait before the next step, or None to wait for a change. awaited: as in `_steps_left`."""
        if self.holds and min(self.holds.values()) <= self.steps_made:
            return None
        if self.paused:
            return 0.0 if self.steps_made < self._steps_until else None
        return self.pace.wait_s(now_s, self._steps_left(awaited))

    @property
    def _awaited_tick(self) -> int:
        return due_tick(self.sim.agenda.of(*AWAITED))

    def _answer_requests(self) -> None:
        until_s = time.monotonic() + REQUESTS_S
        for _ in range(REQUESTS_PER_STEP):
            with self.lock:
                if not self._requests:
                    return
                request = self._requests.popleft()
            self.answer(request)
            if time.monotonic() >= until_s:
                return

    def answer(self, request: Request) -> None:
        """Execute a request. Called on the stepping thread."""
        if not request.future.set_running_or_notify_cancel():
            return
        tick = self._tick = self.sim.tick
        try:
            result = request.function(self.sim)
        except BaseException as error:
            if request.name == CALL:
                self.log.append(Entry(tick, CALL, {**request.arguments, "raised": True}))
            self._notice_jump(request, tick)
            request.future.set_exception(error)
            return
        if request.name is not None and request.name not in (START_NAVIGATION, SERVO_FRAMES):
            self.log.append(Entry(tick, request.name, request.arguments))
        self._notice_jump(request, tick)
        request.future.set_result(result)

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        """Log commands that no request issued: autopilots' frames, and the start of navigation by a first reading."""
        if name == START_NAVIGATION:
            self.log.append(Entry(self.sim.tick, name, arguments))
        elif name == SERVO_FRAMES:
            self.log.append(Entry(arguments["from_tick"], name, arguments))

    def _notice_jump(self, request: Request, before: int) -> None:
        """If a request has changed the simulated time, end all waits, since their times no longer apply."""
        tick = self.sim.tick
        if tick == before and request.name != RESET:
            return
        with self.lock:
            self._tick = tick
            self.error = None
            self._steps_until = self.steps_made
            self.pace.restart()
            alarms, self._alarms = self._alarms, []
        for _, alarm in alarms:
            alarm.ring(RuntimeError("the simulation was reset while this waited"))

    def _make_steps(self) -> None:
        with self.lock:
            steps = self._steps_to_make(time.monotonic())
            self._stepping = steps > 0
        if steps <= 0:
            return
        began_s, before = time.monotonic(), self.sim.tick
        try:
            self.sim.step(steps)
        except Exception as error:
            what = "the simulation stopped near tick %d: %s"
            logger.error(what, self._tick, error, exc_info=not isinstance(error, OSError))  # OSError: not our mistake
            self._halt(error)
            return
        self._tick = self.sim.tick
        is_complete = self.sim.lockstep.is_free or self._tick - before == steps
        if not is_complete:  # the autopilot is silent
            steps = max(self._tick - before, 0)
        with self.lock:
            if is_complete:
                self.pace.made(steps, began_s, time.monotonic())
            else:
                self.pace.restart()
            self._stepping = False
            self.steps_made += steps
            self.changed.notify_all()
            rung = [each for each in self._alarms if each[0] <= self.steps_made] if self._alarms else []
            for each in rung:
                self._alarms.remove(each)
        for _, alarm in rung:
            alarm.ring()

    def _steps_to_make(self, now_s: float) -> int:
        """Return the number of steps due on the wall clock, up to the next reading, delivery, alarm or hold."""
        wanted = self._steps_until - self.steps_made
        steps = min(wanted, self.pace.batch) if self.paused else self.pace.due(now_s)
        return min(steps, self._steps_left(self._awaited_tick - self._tick))

    def _steps_left(self, awaited: int) -> int:
        """Return the number of steps until a reading or delivery (in `awaited` steps), an alarm or a hold is due."""
        for until, _ in self._alarms:
            awaited = min(awaited, until - self.steps_made)
        for until in self.holds.values():
            awaited = min(awaited, until - self.steps_made)
        return awaited

    def _halt(self, error: Exception) -> None:
        with self.lock:
            self._stepping = False
            self.changed.notify_all()
            self.error = error
            self.paused = True
            self._tick = self.sim.tick
            self._steps_until = self.steps_made
            alarms, self._alarms = self._alarms, []
        for _, alarm in alarms:
            alarm.ring(error)

    def _refuse_what_waits(self) -> None:
        with self.lock:
            requests, self._requests = list(self._requests), deque()
            alarms, self._alarms = self._alarms, []
        self.sim.agenda.clear(*AWAITED)
        for _, alarm in alarms:
            alarm.ring(NotRunningError("the live simulator has stopped"))
        for request in requests:
            if request.future.set_running_or_notify_cancel():
                request.future.set_exception(NotRunningError("the live simulator has stopped"))
