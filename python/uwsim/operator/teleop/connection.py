"""The connection between the pilot's terminal and a vehicle: a plain rosbridge client for the published topics.

A thread sends the current efforts, so that they expire in time even if the screen hangs. While the pilot has the helm,
efforts are sent repeatedly to show that the pilot is present.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any

from uwsim.bridges.rosbridge.client import Client
from uwsim.channels.families.key import POSE, Function, key_message
from uwsim.operator.teleop.hands import ZERO, Hands
from uwsim.operator.teleop.readout import Readout

PERIOD_S = 0.05  # interval at which the hands are polled
STOP_AGAIN_S = 1.0  # interval at which an unanswered all stop is requested again
REPEAT_S = 0.2  # interval at which unchanged efforts are sent again
ANSWER_S = 3.0  # time limit for a server to list its topics
STOP_S = 2.0
QUEUE = 2  # maximum number of queued messages per topic, since a pilot needs the newest


class Connection:
    """Keeps a terminal connected to a rosbridge server.

    vehicle: the vehicle's name, needed if there are several. report: called with text for the pilot, on any thread.
    stop_is_wanted: whether the pilot's last word on all stop was to set it. interval_s: between the last two messages
    of telemetry. Raises ValueError for an invalid url.
    """

    def __init__(
        self, url: str, hands: Hands, vehicle: str | None = None, report: Callable[[str], object] = lambda text: None
    ) -> None:
        self.url, self.hands, self.report = url, hands, report
        self.client = Client(
            url, queue=QUEUE, joined=self._join, left=self._leave, report=lambda text: self.report(text),
            failed=lambda why, wait_s: self.report(f"{url}: {why}"),
        )  # fmt: skip
        self.readout = Readout()
        self._topics = {
            "telemetry": ("uwsim_msgs/msg/Telemetry", self._take_telemetry),
            "link": ("uwsim_msgs/msg/Link", self.readout.read_link),
        }
        self.state = "connecting"
        self.received_s, self.interval_s = -math.inf, 0.0
        self.stop_is_wanted = False
        self._vehicle, self._prefix = vehicle, ""
        self._is_flying = False  # whether the server is known to take efforts
        self._sending = threading.RLock()  # guards this, and the last efforts and requests
        self._efforts, self._tilt, self._published_s = dict(ZERO), Function.TILT_HOLD, -math.inf
        self._stop_asked_s: float | None = None  # time of the last request for all stop, until it is answered
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._send_on, daemon=True)

    def start(self) -> None:
        """Start connecting."""
        self.client.start()
        self._thread.start()

    def stop(self) -> None:
        """Set the efforts to zero, send them to the vehicle, and disconnect. May be called twice, on any thread."""
        self.hands.drop()
        with self._sending:
            if self._efforts != ZERO or self._tilt != Function.TILT_HOLD or self.hands.has_helm:
                self._publish_efforts(ZERO, Function.TILT_HOLD)
            self._is_flying = False
        self._stopping.set()
        self.client.close()
        if self._thread.is_alive():
            self._thread.join(STOP_S)

    @property
    def silence_s(self) -> float:
        """Time since the last telemetry message."""
        return time.monotonic() - self.received_s

    def do(self, function: Function) -> None:
        """Request a function from the published wire, such as release."""
        with self._sending:
            if self._is_connected():
                self._publish_efforts(self._efforts, function)

    def call(self, service: str) -> None:
        """Call a service of the vehicle and show its response."""
        with self._sending:
            if self._is_connected():
                self.client.call(f"{self._prefix}{service}", partial(self._report_answer, service))

    def all_stop(self, *, on: bool) -> None:
        """Set or release all stop.

        The request to set all stop is repeated, across reconnections, until a server has carried it out.
        """
        with self._sending:
            if on and self._stop_asked_s is not None:
                return  # the key has repeated
            self.stop_is_wanted = on
            self._stop_asked_s = -math.inf if on else None
            if self._is_connected(", all stop is sent as soon as it is" if on else ""):
                self._ask_to_stop(on)

    def _ask_to_stop(self, on: bool) -> None:
        def answered(response: dict[str, Any]) -> None:
            values = response.get("values")
            is_refused = isinstance(values, dict) and not values.get("success", True)
            if on and response and not (response.get("result") and is_refused):
                with self._sending:  # it is set, or the server lacks the service, but efforts are zero anyway
                    self._stop_asked_s = None
            self._report_answer("all stop" if on else "release of all stop", response)

        self._stop_asked_s = time.monotonic() if on else None
        self.client.call(f"{self._prefix}all_stop", answered, {"data": on})

    def _report_answer(self, service: str, response: dict[str, Any]) -> None:
        values = response.get("values")
        text = values.get("message") if isinstance(values, dict) else values
        is_done = response.get("result") and isinstance(values, dict) and values.get("success", True)
        if response:  # otherwise the connection has ended
            self.report(f"{service}: {text or ('done' if is_done else 'failed')}")

    # On the client's thread

    def _join(self) -> None:
        self.client.call("rosapi/topics", self._fly, patience_s=ANSWER_S)

    def _fly(self, response: dict[str, Any]) -> None:
        if not self.client.connected.is_set():
            return
        values = response.get("values")
        topics = values.get("topics", []) if isinstance(values, dict) else []
        offered = {str(topic).lstrip("/") for topic in topics}  # none: taken for a server of the published topics
        self._prefix = self._found_prefix(offered)
        key = f"{self._prefix}key"
        if offered and key not in offered:
            raise ValueError("the server has no topic 'key': start it with --wire both or published")
        for topic, (kind, read) in self._topics.items():
            if not offered or f"{self._prefix}{topic}" in offered:
                self.client.subscribe(f"{self._prefix}{topic}", kind, read)
        self.client.advertise(key, POSE)
        with self._sending:
            self._is_flying = not self._stopping.is_set()
            self._efforts, self._tilt = dict(ZERO), Function.TILT_HOLD
        self.state = "connected"
        self.report(f"connected to {self.url}")

    def _found_prefix(self, offered: set[str]) -> str:
        vehicles = sorted(name.removesuffix("/key") for name in offered if name.endswith("/key"))
        if self._vehicle is None or (not vehicles and "key" in offered):
            return "" if "key" in offered or not vehicles else f"{vehicles[0]}/"
        if offered and self._vehicle not in vehicles:
            raise ValueError(f"--vehicle = {self._vehicle!r}: the server has {', '.join(vehicles) or 'no vehicle'}")
        return f"{self._vehicle}/"

    def _take_telemetry(self, message: Any) -> None:
        self.readout.read_telemetry(message)
        now_s = time.monotonic()
        self.interval_s = now_s - self.received_s if math.isfinite(self.received_s) else 0.0
        self.received_s = now_s

    def _leave(self) -> None:
        self.hands.drop()
        with self._sending:
            self._is_flying = False
        if not self._stopping.is_set() and self.state == "connected":
            self.state = "lost"
            self.report("the connection is lost: efforts are zero")

    # Sending, with the lock held

    def _send_on(self) -> None:
        while not self._stopping.wait(PERIOD_S):
            efforts, tilt = self.hands.efforts(), self.hands.tilt()
            with self._sending:
                if not self._is_flying:
                    continue
                if self._stop_asked_s is not None and time.monotonic() - self._stop_asked_s >= STOP_AGAIN_S:
                    self._ask_to_stop(on=True)
                due = self.hands.has_helm and time.monotonic() - self._published_s >= REPEAT_S
                if tilt != self._tilt or efforts != self._efforts or due:
                    self._publish_efforts(efforts, tilt if tilt != self._tilt else Function.NONE)
                self._tilt = tilt

    def _is_connected(self, otherwise: str = "") -> bool:
        if not self._is_flying:
            self.report(f"not connected{otherwise}")
        return self._is_flying

    def _publish_efforts(self, efforts: dict[str, float], function: Function) -> None:
        self._efforts, self._published_s = dict(efforts), time.monotonic()
        if self._is_flying:
            self.client.publish(f"{self._prefix}key", partial(key_message, dict(efforts), function))
