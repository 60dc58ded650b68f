"""Device: the part of a Ping1D and a Ping360 that is the same, a thread that answers messages of the ping protocol."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, Self, TypeVar

import numpy as np
from brping import definitions as ids
from numpy.typing import NDArray

from uwsim.bridges.doors.waiting import Waiting
from uwsim.bridges.ping_protocol.line import Line
from uwsim.bridges.ping_protocol.wire import Message, encoded
from uwsim.live import LiveSimulator, NotRunningError
from uwsim.simulator.simulator import Simulator

IDLE_S, BUSY_S = 0.1, 0.002
"""The longest wait for a message, and between looks at simulated time while a ping is on its way."""
WAITING_MAX = 64
"""Messages that wait while a ping is on its way; older ones are lost."""
FIRMWARE = {"firmware_version_major": 3, "firmware_version_minor": 3, "firmware_version_patch": 1}
"""A version that knows all messages here; programs compare it."""
SPAN_DB = 60.0
"""From the least to the greatest intensity, 0 to 255; assumed."""

Values = dict[str, Any]
T = TypeVar("T")


class Device:
    """Answers messages until it is closed. Use it as a context.

    type: the number of its kind. reports: functions that return the fields of a message that may be requested, by
    number. commands: functions that take the fields of a message, by number; they return whether they have answered,
    and raise ValueError for what the device refuses, which is then its answer (nack).

    The state is captured between two steps and the ping computed on this thread, so that steps never wait for it; its
    answer leaves when simulated time has come to the end of the ping.
    """

    type: ClassVar[int]

    def __init__(self, live: LiveSimulator, vehicle: str, instrument: str, line: Line) -> None:
        self.line, self.address = line, line.address
        self._live, self._vehicle, self._instrument = live, vehicle, instrument
        self._log = logging.getLogger("uwsim.ping")
        self._id = 1
        self._waiting = Waiting[Message](WAITING_MAX)
        self._answer: tuple[int, int, bytes] | None = None
        self._is_closed = False
        self._thread = threading.Thread(target=self._run, name="uwsim-ping", daemon=True)
        self.reports: Mapping[int, Callable[[], Values]] = {}
        self.commands: Mapping[int, Callable[[Values], bool | None]] = {}

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Close."""
        self._is_closed = True
        self._thread.join()
        self.line.close()

    def work(self) -> None:
        """Do what is due without a message."""

    @property
    def is_driven(self) -> bool:
        """True if `work` must be called while no message arrives."""
        return False

    def capture(self, read: Callable[[Simulator], T]) -> T:
        """Return what is read between two steps. Raises NotRunningError."""
        return self._live.read(read).result()

    def send(self, number: int, values: Mapping[str, Any]) -> None:
        """Send a message now."""
        self.line.send(encoded(number, values, source=self._id))

    def send_at(self, began_ns: int, due_ns: int, number: int, values: Mapping[str, Any]) -> None:
        """Send a message when simulated time is due_ns; the device is busy until then."""
        self._answer = began_ns, due_ns, encoded(number, values, source=self._id)

    def rename(self, number: int) -> None:
        """Change the device's number. Raises ValueError."""
        if not 1 <= number <= 254:
            raise ValueError("the device's number must be in [1, 254]")
        self._id = number

    def _run(self) -> None:
        try:
            while not self._is_closed:
                self.line.wait(BUSY_S if self._answer is not None or self.is_driven else IDLE_S)
                for message in self.line.received():
                    self._waiting.put(message)
                self._send_due()
                while self._answer is None and (asked := self._waiting.take()) is not None:
                    self._take(asked)
                if self._answer is None:
                    self.work()
        except NotRunningError:
            pass  # the simulator has been stopped
        except Exception:
            self._log.exception("the device at %s has failed", self.line.address)

    def _send_due(self) -> None:
        if self._answer is None:
            return
        began_ns, due_ns, data = self._answer
        if not began_ns <= self._live.time_ns < due_ns:  # also if simulated time went back
            self._answer = None
            self.line.send(data)

    def _take(self, message: Message) -> None:
        try:
            if message.number == ids.COMMON_GENERAL_REQUEST:
                self._report(message.values["requested_id"])
            elif not message.payload and message.number in self.reports:  # an older form of a request
                self._report(message.number)
            elif message.number == ids.COMMON_SET_DEVICE_ID:
                self.rename(message.values["device_id"])
                self.send(ids.COMMON_ACK, {"acked_id": message.number})
            elif message.number not in self.commands:
                raise ValueError("this device does not have this message")
            elif not self.commands[message.number](message.values):
                self.send(ids.COMMON_ACK, {"acked_id": message.number})
        except ValueError as error:
            self.send(
                ids.COMMON_NACK, {"nacked_id": message.number, "nack_message": str(error).encode("ascii", "replace")}
            )

    def _report(self, number: int) -> None:
        if number == ids.COMMON_DEVICE_INFORMATION:
            self.send(number, {"device_type": self.type, "device_revision": 1, "reserved": 0, **FIRMWARE})
        elif number == ids.COMMON_PROTOCOL_VERSION:
            self.send(number, {"version_major": 1, "version_minor": 0, "version_patch": 0, "reserved": 0})
        elif number in self.reports:
            self.send(number, self.reports[number]())
        else:
            raise ValueError(f"this device does not have message {number}")


def intensities(level_db: NDArray[np.float32], full_db: float) -> bytes:
    """Return echo levels as a device reports them, 0 to 255. full_db: the level of 255; 0 is SPAN_DB below."""
    return bytes(np.clip(255.0 * (1.0 + (level_db - full_db) / SPAN_DB), 0, 255).astype(np.uint8))


def within(values: Mapping[str, Any], limits: Mapping[str, tuple[int, int]]) -> None:
    """Raise ValueError unless all values that have limits are within them."""
    for name, (low, high) in limits.items():
        if name in values and not low <= values[name] <= high:
            raise ValueError(f"{name} = {values[name]}: must be in [{low}, {high}]")
