"""The connection between the pilot's terminal and a vehicle: a plain rosbridge client for the published topics.

One thread listens and another sends the current efforts, so that they expire in time even if the screen hangs. While
the pilot has the helm, efforts are sent repeatedly to show that the pilot is present.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any

from websockets.exceptions import WebSocketException

from uwsim.bridges.nodes.node import Node
from uwsim.bridges.nodes.websocket import checked_url
from uwsim.channels.families.key import POSE, Function, key_message
from uwsim.operator.teleop.hands import ZERO, Hands
from uwsim.operator.teleop.readout import PANELS, Reader, Readout, topics_to_read

PERIOD_S = 0.05  # interval at which the hands are polled
STOP_AGAIN_S = 1.0  # interval at which an unanswered all stop is requested again
REPEAT_S = 0.2  # interval at which unchanged efforts are sent again
FIRST_WAIT_S, LONGEST_WAIT_S = 0.5, 5.0  # shortest and longest wait between attempts to connect
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
        self.url, self.hands, self.report = checked_url(url), hands, report
        self.readout = Readout()
        self.state = "connecting"
        self.received_s, self.interval_s = -math.inf, 0.0
        self.stop_is_wanted = False
        self._vehicle, self._prefix = vehicle, ""
        self._node: Node | None = None
        self._publish: Callable[[Any], None] = lambda message: None
        self._sending = threading.Lock()  # guards the node, and the last efforts and requests
        self._efforts, self._tilt, self._published_s = dict(ZERO), Function.TILT_HOLD, -math.inf
        self._stop_asked_s: float | None = None  # time of the last request for all stop, until it is answered
        self._stopping = threading.Event()
        self._threads = [threading.Thread(target=run, daemon=True) for run in (self._listen, self._send_on)]

    def start(self) -> None:
        """Start connecting."""
        for thread in self._threads:
            thread.start()

    def stop(self) -> None:
        """Set the efforts to zero, send them to the vehicle, and disconnect. May be called twice, on any thread."""
        self.hands.drop()
        with self._sending:
            if self._efforts != ZERO or self._tilt != Function.TILT_HOLD or self.hands.has_helm:
                self._publish_efforts(ZERO, Function.TILT_HOLD)
            node, self._node = self._node, None
        self._stopping.set()
        if node is not None:
            node.close()  # after the zero efforts have been sent
        for thread in self._threads:
            if thread is not threading.current_thread() and thread.is_alive():
                thread.join(STOP_S)

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
                self._call(service, partial(self._report_answer, service))

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
            if on and not (response.get("result") and is_refused):
                with self._sending:  # it is set, or the server lacks the service, but efforts are zero anyway
                    self._stop_asked_s = None
            self._report_answer("all stop" if on else "release of all stop", response)

        self._stop_asked_s = time.monotonic() if on else None
        self._call("all_stop", answered, {"data": on})

    def _report_answer(self, service: str, response: dict[str, Any]) -> None:
        values = response.get("values")
        text = values.get("message") if isinstance(values, dict) else values
        is_done = response.get("result") and isinstance(values, dict) and values.get("success", True)
        self.report(f"{service}: {text or ('done' if is_done else 'failed')}")

    # Listening

    def _listen(self) -> None:
        wait_s = FIRST_WAIT_S
        while not self._stopping.is_set():
            try:
                node = Node(self.url, QUEUE)
            except (OSError, WebSocketException) as error:
                self.report(f"{self.url}: {error}")
                self._stopping.wait(wait_s)
                wait_s = min(2.0 * wait_s, LONGEST_WAIT_S)
                continue
            wait_s = FIRST_WAIT_S
            try:
                self._converse(node)
            except (OSError, ValueError, WebSocketException) as error:
                self.report(f"{self.url}: {error}")
            self.state = "lost"
            self.hands.drop()
            with self._sending:
                self._node = None
            node.close()
            if not self._stopping.is_set():
                self.report("the connection is lost: efforts are zero")
                self._stopping.wait(FIRST_WAIT_S)

    def _converse(self, node: Node) -> None:
        node.complain = self.report
        values = node.ask("/rosapi/topics", ANSWER_S).get("values")
        topics = values.get("topics", []) if isinstance(values, dict) else []
        offered = {str(topic).lstrip("/") for topic in topics}  # none: taken for a server of the published topics
        self._prefix = self._found_prefix(offered)
        key = f"{self._prefix}key"
        if offered and key not in offered:
            raise ValueError("the server has no topic 'key': start it with --wire both or published")
        for name, (kind, read) in topics_to_read(offered, self._prefix).items():
            node.subscribe(f"/{name}", kind, partial(self._receive, read))
        with self._sending:
            self._publish, self._node = node.advertise(f"/{key}", POSE), node
            self._efforts, self._tilt = dict(ZERO), Function.TILT_HOLD
        self.state = "connected"
        self.report(f"connected to {self.url}")
        node.spin(self._stopping.is_set)

    def _found_prefix(self, offered: set[str]) -> str:
        vehicles = sorted(name.removesuffix("/key") for name in offered if name.endswith("/key"))
        if self._vehicle is None or (not vehicles and "key" in offered):
            return "" if "key" in offered or not vehicles else f"{vehicles[0]}/"
        if offered and self._vehicle not in vehicles:
            raise ValueError(f"--vehicle = {self._vehicle!r}: the server has {', '.join(vehicles) or 'no vehicle'}")
        return f"{self._vehicle}/"

    def _receive(self, read: Reader, message: Any) -> None:
        try:
            read(self.readout, message)
        except (ValueError, AttributeError) as error:
            self.report(str(error))
        if read in PANELS:
            now_s = time.monotonic()
            self.interval_s = now_s - self.received_s if math.isfinite(self.received_s) else 0.0
            self.received_s = now_s

    # Sending, with the lock held

    def _send_on(self) -> None:
        while not self._stopping.wait(PERIOD_S):
            efforts, tilt = self.hands.efforts(), self.hands.tilt()
            with self._sending:
                if self._node is None:
                    continue
                if self._stop_asked_s is not None and time.monotonic() - self._stop_asked_s >= STOP_AGAIN_S:
                    self._ask_to_stop(on=True)
                due = self.hands.has_helm and time.monotonic() - self._published_s >= REPEAT_S
                if tilt != self._tilt or efforts != self._efforts or due:
                    self._publish_efforts(efforts, tilt if tilt != self._tilt else Function.NONE)
                self._tilt = tilt

    def _is_connected(self, otherwise: str = "") -> bool:
        if self._node is None:
            self.report(f"not connected{otherwise}")
        return self._node is not None

    def _publish_efforts(self, efforts: dict[str, float], function: Function) -> None:
        message = key_message(efforts, function)
        self._efforts, self._published_s = dict(efforts), time.monotonic()
        self._guarded(lambda node: self._publish(message))

    def _call(self, service: str, answer: Callable[[dict[str, Any]], None], arguments: Any = None) -> None:
        self._guarded(lambda node: node.call(f"/{self._prefix}{service}", answer, arguments))

    def _guarded(self, act: Callable[[Node], object]) -> None:
        """Call `act` with the node unless its connection is closing, which the listening thread reports."""
        try:
            if self._node is not None:
                act(self._node)
        except (OSError, WebSocketException):
            self._node = None
