"""The pilot's efforts and speed hold, which must be recent and last only while the pilot's page repeats them."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import Any

from uwsim.base.arguments import is_number
from uwsim.base.axes import AXES
from uwsim.base.commands import ALL_STOP, COMMANDS, HOLDS
from uwsim.channels.authority.steering import Steering, require_link
from uwsim.channels.guest import Values
from uwsim.live import LiveSimulator, NotRunningError
from uwsim.operator.station.controls.arm import ArmPilot
from uwsim.simulator.helm import Clock, Lease, Source, Timeout

SILENCE_S = 0.5
"""The age beyond which a command is rejected, and the time without a command after which efforts are set to zero."""
CRUISE_S = 1.5
"""The same for a speed hold, which must survive a pause in the browser, since it does not resume by itself."""
RETRY_S = 0.05  # delay before setting efforts to zero is attempted again
WINDOW_S = 30.0
ZERO = dict.fromkeys(AXES, 0.0)
UNKNOWN: dict[str, float] = {}  # set by another client


class LeastDelay:
    """Estimates the delay of a message from its time stamp, which is from the sender's clock.

    The sender's clock differs from ours. The smallest difference in the last WINDOW_S to 2 WINDOW_S is assumed to
    belong to a message without delay. The limited window allows the clocks to drift.
    """

    def __init__(self) -> None:
        self._least = [math.inf, math.inf]  # in the current and in the previous window
        self._began_s = -math.inf

    def age_s(self, sent_s: float, now_s: float) -> float:
        """Return the age of a message sent at sent_s and received at now_s."""
        if now_s - self._began_s > WINDOW_S:
            self._least = [math.inf, self._least[0]]
            self._began_s = now_s
        self._least[0] = min(self._least[0], now_s - sent_s)
        return now_s - sent_s - min(self._least)


class Pilot:
    """Steers the vehicles of one simulator for the pilot. Commands are logged with their tick.

    Every command is issued, even if it repeats the last one: other clients may have commanded the vehicle since, its
    failsafe may be waiting for a sign of life, and earlier commands may have been lost on a link. Call `beat` at least
    twice a second, and at the times that it returns. It sets efforts to zero when commands have ceased.

    live: the simulator as commanded, perhaps over a link. near: the simulator itself, if that is another.
    """

    def __init__(
        self,
        live: LiveSimulator,
        steering: Mapping[str, Steering],
        *,
        near: LiveSimulator | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._live = live
        self._steering = steering
        self._clock = clock
        self._lock = threading.Lock()
        self._delay = LeastDelay()
        self._efforts = dict.fromkeys(steering, ZERO)  # as last set by this pilot
        self._cruising: dict[str, dict[str, bool]] = {}  # the other holds of each vehicle with a speed hold
        self._silence = Timeout(Clock.WALL, lambda: SILENCE_S)
        self._cruise = Timeout(Clock.WALL, lambda: CRUISE_S)
        self._leases: list[Lease] = []
        self._arms = ArmPilot(near or live, live, steering, Timeout(Clock.WALL, lambda: SILENCE_S))

    def drive(self, request: Values) -> Future[Values]:
        """Set efforts from a request (docs/connections/station-wire.md). Raises ValueError."""
        vehicle = self._named(request)
        efforts = {axis: _effort(request, axis) for axis in AXES}
        with self._lock:
            age_s = self._age_s(request)
            self._renew()
            return self._set(vehicle, efforts, {"age_s": age_s})

    def move_arm(self, request: Values) -> Future[Values]:
        """Move a vehicle's arm from a request (docs/connections/station-wire.md). Raises ValueError."""
        vehicle = self._named(request)
        with self._lock:
            age_s = self._age_s(request)
        future = self._arms.move(vehicle, request)
        self._arms.silence.heard_ns = self._now_ns()
        return answered(self._live, future, {"age_s": age_s})

    def _age_s(self, request: Values) -> float:
        """Return the age of a command. Raises ValueError for one that is too old."""
        now_s = self._clock()
        age_s = self._delay.age_s(1e-3 * _number(request, "stamp_ms", 1e3 * now_s), now_s)
        if age_s > SILENCE_S:
            raise ValueError(f"the command arrived {age_s:.1f} s late: it was refused")
        return age_s

    def all_stop(self, request: Values, text: str = "") -> Future[Values]:
        """Set or release all stop according to request["on"]. text: the message of the response. Raises ValueError."""
        vehicle, on = self._named(request), is_stop(request)
        require_link(self._live, vehicle, ALL_STOP)
        with self._lock:
            self._cruising.pop(vehicle, None)
            self._efforts[vehicle] = ZERO  # all stop sets them to zero, and releasing it leaves them there
        return answered(self._live, self._live.command(ALL_STOP, vehicle=vehicle, on=on), text=text)

    def note_holds(self, vehicle: str, arguments: Mapping[str, Any]) -> None:
        """Record the holds that the pilot has requested.

        A speed hold keeps the vehicle moving, so it expires like efforts.
        """
        with self._lock:
            self._cruising.pop(vehicle, None)
            if arguments.get("speed") is True:
                self._cruising[vehicle] = {name: arguments.get(name) is True for name in HOLDS if name != "speed"}
                self._renew()

    def _named(self, request: Values) -> str:
        vehicle = request.get("vehicle")
        if not isinstance(vehicle, str) or vehicle not in self._steering:
            raise ValueError(f"vehicle = {str(vehicle)[:40]!r}: must be one of {', '.join(self._steering)}")
        return vehicle

    def beat(self) -> float:
        """End efforts, speed holds and arms' motion when commands have ceased.

        Return the time [s] until the next check.
        """
        return min(self._beat(), self._arms.beat(self._now_ns()))

    def _beat(self) -> float:
        with self._lock:
            now_ns = self._now_ns()
            drive_ns, cruise_ns = self._silence.left_ns(now_ns), self._cruise.left_ns(now_ns)
            if not drive_ns:
                self._zero()
            if not cruise_ns:
                self._end_cruises()
            if any(efforts != ZERO for efforts in self._efforts.values()):
                return max(1e-9 * drive_ns, RETRY_S)
            return max(1e-9 * cruise_ns, RETRY_S) if self._cruising else math.inf

    def _now_ns(self) -> int:
        return round(1e9 * self._clock())

    def _renew(self) -> None:
        self._silence.heard_ns = self._cruise.heard_ns = self._now_ns()

    def pass_to(self, pilot: str) -> None:
        """Give the helms of all vehicles to a pilot, by name, or back to other clients if the name is ""."""
        with self._lock:
            leases, self._leases = self._leases, []
            for vehicle, steering in self._steering.items():
                if steering.driver:
                    self._efforts[vehicle] = UNKNOWN
                if pilot:
                    self._leases.append(steering.helm.take(Source.PILOT, pilot))
            for lease in leases:
                lease.end()

    def release(self) -> None:
        """Set efforts to zero, even those of other clients. Called when the pilot has changed.

        This also resets the delay estimate, since the new pilot has a different clock.
        """
        with self._lock:
            self._delay = LeastDelay()
            self._zero()
            self._end_cruises()
        self._arms.stop()

    def _zero(self) -> None:
        for vehicle, efforts in self._efforts.items():
            if efforts != ZERO:
                try:
                    self._set(vehicle, ZERO, {})
                except (NotRunningError, RuntimeError):  # paused or overloaded: the next beat tries again
                    return

    def _end_cruises(self) -> None:
        for vehicle, others in list(self._cruising.items()):
            try:
                answered(self._live, self._live.command("hold", vehicle=vehicle, **others))
            except (NotRunningError, RuntimeError):
                return
            del self._cruising[vehicle]

    def _set(self, vehicle: str, efforts: dict[str, float], answer: Values) -> Future[Values]:
        self._steering[vehicle].forget()
        future = self._steering[vehicle].give(self._live, "set_effort", Source.PILOT, **efforts)
        self._efforts[vehicle] = efforts
        return answered(self._live, future, answer)


def answered(live: LiveSimulator, future: Future[Any], answer: Values | None = None, text: str = "") -> Future[Values]:
    """Return the service response once a command has taken effect: success, message (an error or text) and tick."""
    response: Future[Values] = Future()

    def respond(done: Future[Any]) -> None:  # on the simulator's thread, so the tick is that of the command
        error = None if done.cancelled() else done.exception()
        found = {"success": error is None, "message": text if error is None else str(error), "tick": live.tick}
        response.set_result({**found, **(answer or {})})

    future.add_done_callback(respond)
    return response


def is_stop(request: Values) -> bool:
    """Return True if all stop is to be set (the default), False if it is to be released. Raises ValueError."""
    on = request.get("on", True)
    if not isinstance(on, bool):
        raise ValueError(f"on = {str(on)[:40]!r}: must be true or false")
    return on


def _effort(request: Values, axis: str) -> float:
    effort = _number(request, axis, 0.0)
    COMMANDS["set_effort"].argument(axis).check_number(effort, axis)
    return effort


def _number(request: Values, name: str, default: float) -> float:
    value = request.get(name, default)
    if not is_number(value):
        raise ValueError(f"{name} = {str(value)[:40]}: must be a number")
    return float(value)
