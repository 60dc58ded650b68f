"""A ground station that flies a firmware in simulated time, so that each message arrives at the same frame."""

from __future__ import annotations

from collections.abc import Callable
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from uwsim.bridges.doors.datagrams import ALL, Address, Datagrams
from uwsim.bridges.firmware.firmware import FirmwareError
from uwsim.bridges.mavlink.earth import NED_FROM_ENU, Vector

if TYPE_CHECKING:
    from uwsim.bridges.ardusub.ardusub import ArduSub

MODES = {"STABILIZE": 0, "ALT_HOLD": 2, "AUTO": 3, "GUIDED": 4, "POSHOLD": 16, "MANUAL": 19, "SURFTRAK": 21}
CHUNK = 20
"""Frames between two exchanges of messages: 0.05 s."""
RATE_HZ, STICKS_EVERY = 400, 40
NEUTRAL = {"x": 0, "y": 0, "z": 500, "r": 0}
BUFFER_BYTES = 1 << 22


class FirmwarePilot:
    """Flies a firmware through a simulator that runs as fast as both can, within a `with` statement.

        with ArduSub(sim, port=0) as ardusub, FirmwarePilot(ardusub) as pilot:
            with firmware_flying(ardusub, binary, station=pilot.address):
                pilot.get_ready()
                pilot.arm()
                pilot.mode("ALT_HOLD")
                track = pilot.fly(20)

    system: the firmware's MAVLink system id. The pilot is system 255, whose sticks ArduSub obeys, and sends heartbeats
    while has_station is True. sticks: MANUAL_CONTROL at 10 Hz; None: nothing. messages: the last of each kind. texts:
    all STATUSTEXT. variances: the largest EKF variance of each report while armed. each: called after each 0.05 s. The
    first program that sends something is the firmware. Methods raise FirmwareError.
    """

    def __init__(self, ardusub: ArduSub, system: int = 1) -> None:
        from pymavlink.dialects.v20 import ardupilotmega as dialect

        self.dialect: Any = dialect
        self.ardusub, self.sim, self._system = ardusub, ardusub.simulator, system
        self._mav: Any = dialect.MAVLink(None, srcSystem=255, srcComponent=190)
        self._mav.robust_parsing = True
        self._datagrams = Datagrams(("127.0.0.1", 0), buffer_bytes=BUFFER_BYTES)
        self.address = f"127.0.0.1:{self._datagrams.port}"
        self._peer: Address | None = None
        self.texts: list[str] = []
        self.messages: dict[str, Any] = {}
        self.variances: list[float] = []
        self.sticks: dict[str, int] | None = dict(NEUTRAL)
        self.has_station = True
        self.each: Callable[[], object] = lambda: None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the socket."""
        self._datagrams.close()

    @property
    def armed(self) -> bool:
        """True if the firmware reports that it is armed."""
        beat = self.messages.get("HEARTBEAT")
        return beat is not None and bool(beat.base_mode & self.dialect.MAV_MODE_FLAG_SAFETY_ARMED)

    @property
    def ned_m(self) -> Vector:
        """The true position, north, east, down."""
        return NED_FROM_ENU @ self.ardusub.flown.pose.position_world_m

    def fly(self, seconds: float, until: Callable[[], bool] = lambda: False) -> list[Vector]:
        """Fly for a time, or until a condition is true; return the true positions every 0.05 s, (n, 3)."""
        track = []
        for _ in range(round(seconds * RATE_HZ / CHUNK)):
            if until():
                break
            self.exchange()
            self.sim.step(CHUNK)
            self.each()
            track.append(self.ned_m)
        return track

    def exchange(self) -> None:
        """Take the firmware's messages, and send what is due, before its next frame; `fly` does so every 0.05 s."""
        self.ardusub.wait()
        self._receive()
        self._send_regularly()

    def steer(self, **sticks: int) -> None:
        """Move the sticks of MANUAL_CONTROL from now on; those that are not given are neutral."""
        self.sticks = {**NEUTRAL, **sticks}

    def send(self, message: Any) -> None:
        """Send a message before the next frame."""
        self.ardusub.wait()
        if self._peer is not None:
            self._datagrams.send(message.pack(self._mav), self._peer)

    def command(self, command: int, *values: float) -> None:
        """Send a command; the next `fly` delivers its effect."""
        filled = (*values, *[0.0] * (7 - len(values)))
        self.send(self._mav.command_long_encode(self._system, 1, command, 0, *filled))

    def set(self, name: str, value: float) -> None:
        """Set a parameter."""
        real32 = self.dialect.MAV_PARAM_TYPE_REAL32
        self.send(self._mav.param_set_encode(self._system, 1, name.encode(), value, real32))
        self.fly(0.5)

    def get_ready(self, seconds: float = 30.0) -> None:
        """Let the firmware start its filter and learn its position."""
        self.fly(seconds)
        if "HEARTBEAT" not in self.messages:
            raise FirmwareError("the firmware has sent no HEARTBEAT")

    def mode(self, name: str) -> None:
        """Request a mode, and wait until the firmware has changed to it."""
        self.command(self.dialect.MAV_CMD_DO_SET_MODE, 1, MODES[name])
        self.fly(5, lambda: bool(self.messages["HEARTBEAT"].custom_mode == MODES[name]))
        if self.messages["HEARTBEAT"].custom_mode != MODES[name]:
            raise FirmwareError(f"the firmware has refused the mode {name}{self._why()}")

    def arm(self, *, on: bool = True) -> None:
        """Arm or disarm, and wait until the firmware has done so."""
        self.command(self.dialect.MAV_CMD_COMPONENT_ARM_DISARM, float(on))
        self.fly(5, lambda: self.armed == on)
        if self.armed != on:
            raise FirmwareError(f"the firmware has refused to {'arm' if on else 'disarm'}{self._why()}")

    def _why(self) -> str:
        return f": {self.texts[-1]}" if self.texts else ""

    def _receive(self) -> None:
        for data, sender in self._datagrams.received(ALL):
            self._peer = self._peer or sender
            for message in (self._mav.parse_buffer(data) or ()) if sender == self._peer else ():
                self._take(message)

    def _take(self, message: Any) -> None:
        kind = message.get_type()
        if kind == "STATUSTEXT":
            self.texts.append(message.text)
        elif kind == "EKF_STATUS_REPORT" and self.armed:
            parts = (message.velocity_variance, message.pos_horiz_variance, message.compass_variance)
            self.variances.append(max(parts))
        self.messages[kind] = message

    def _send_regularly(self) -> None:
        dialect, tick = self.dialect, self.sim.tick
        if self.has_station and tick % RATE_HZ < CHUNK:
            station = (dialect.MAV_TYPE_GCS, dialect.MAV_AUTOPILOT_INVALID)
            self.send(self._mav.heartbeat_encode(*station, 0, 0, 0))
        if self.sticks is not None and tick % STICKS_EVERY < CHUNK:
            self.send(self._mav.manual_control_encode(self._system, **self.sticks, buttons=0))
