"""A ground station for tests, by pymavlink."""

from __future__ import annotations

import os
import queue
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

os.environ["MAVLINK20"] = "1"  # read by pymavlink
from pymavlink import mavutil
from pymavlink.dialects.v20 import ardupilotmega as dialect

from uwsim import Simulator
from uwsim.bridges.actions import actions_of
from uwsim.bridges.doors.endpoint import Endpoint
from uwsim.bridges.mavlink import MavlinkVehicle
from uwsim.channels.served import served_table
from uwsim.live import LiveSimulator
from uwsim.scenario import load, load_vehicle

AUTOPILOT, CAMERA = 1, 100
TRIES, AGAIN_S = 30, 20.0
"""Seconds until a command is sent again: on loopback little is lost; a late answer passes for the next command's."""
PATIENCE_S = 180.0  # generous because the machine may be busy


class Station:
    """A ground station. heard: all messages so far. address: as for mavutil.mavlink_connection."""

    def __init__(self, address: str, system: int = 255) -> None:
        self.link: Any = mavutil.mavlink_connection(address, source_system=system, dialect="ardupilotmega")
        self.mav = self.link.mav
        self.heard: list[Any] = []
        self._beaten_s = 0.0
        self._arrived: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._is_open = True
        threading.Thread(target=self._read, daemon=True).start()

    def close(self) -> None:
        """Leave."""
        self._is_open = False

    def _read(self) -> None:
        """Read all the time, so that the socket's buffer does not overflow."""
        while self._is_open:
            message = self.link.recv_match(blocking=True, timeout=0.2)
            if message is not None:
                self._arrived.put(message)
        self.link.close()

    def poll(self, timeout_s: float = 0.2) -> Any:
        """Return the next message, or None. Once a second, send a heartbeat, as ground stations do."""
        if time.monotonic() - self._beaten_s > 1.0:
            self._beaten_s = time.monotonic()
            self.mav.heartbeat_send(dialect.MAV_TYPE_GCS, dialect.MAV_AUTOPILOT_INVALID, 0, 0, 0)
        try:
            message = self._arrived.get(timeout=timeout_s)
        except queue.Empty:
            return None
        self.heard.append(message)
        return message

    def receive(
        self, kind: str, wanted: Callable[[Any], bool] = lambda message: True, limit_s: float = PATIENCE_S
    ) -> Any:
        """Return the next message of a kind that fits."""
        end = time.monotonic() + limit_s
        while time.monotonic() < end:
            message = self.poll()
            if message is not None and message.get_type() == kind and wanted(message):
                return message
        raise AssertionError(f"no such {kind} within {limit_s} s")

    def command(self, command: int, *values: float, component: int = AUTOPILOT, as_int: bool = False) -> int:
        """Send a command; return its result. as_int: by COMMAND_INT, with integers as the fifth and sixth value."""
        padded = [*values, *[0.0] * (7 - len(values))]
        fits = lambda ack: ack.command == command and (component == 0 or ack.get_srcComponent() == component)  # noqa: E731
        for confirmation in range(TRIES):
            if as_int:
                x, y = (round(value) for value in padded[4:6])
                self.mav.command_int_send(1, component, 6, command, 0, 0, *padded[:4], x, y, padded[6])
            else:
                self.mav.command_long_send(1, component, command, confirmation, *padded)
            with suppress(AssertionError):  # lost: again, as ground stations do
                return int(self.receive("COMMAND_ACK", fits, AGAIN_S).result)
        raise AssertionError(f"command {command} is not acknowledged")

    def drain(self) -> None:
        """Forget all that has arrived, up to the answers to what was sent before."""
        number = time.monotonic_ns()
        self.mav.timesync_send(0, number)
        self.receive("TIMESYNC", lambda answer: answer.ts1 == number)
        self.heard.clear()

    def request(self, kind: str, component: int = AUTOPILOT, value: float = 0.0) -> Any:
        """Request a message by REQUEST_MESSAGE; return it, which must follow its acknowledgement at once."""
        number = getattr(dialect, f"MAVLINK_MSG_ID_{kind}")
        result = self.command(dialect.MAV_CMD_REQUEST_MESSAGE, number, value, component=component)
        return result or self.receive(kind, lambda message: message.get_srcComponent() == component)

    def mode(self, mode: int) -> int:
        """Change the mode; return the result."""
        return self.command(dialect.MAV_CMD_DO_SET_MODE, 1, mode)

    def arm(self, on: bool = True) -> int:
        """Arm or disarm; return the result."""
        return self.command(dialect.MAV_CMD_COMPONENT_ARM_DISARM, float(on))


DONE, DENIED, UNSUPPORTED, FAILED = 0, 2, 3, 4  # MAV_RESULT
MANUAL, ALT_HOLD, GUIDED = 19, 2, 4


@contextmanager
def lagoon() -> Iterator[LiveSimulator]:
    """Run the lagoon with a BlueROV2 that has the lake vehicle's cameras, one of which has a motor, and its lamps."""
    rov = load_vehicle("rov")
    model = load_vehicle("bluerov2_heavy").model_copy(update={"cameras": rov.cameras, "lamps": rov.lamps})
    with LiveSimulator(Simulator(load("lagoon").with_changes(vehicle_model=model), seed=3), speed=5.0) as live:
        yield live


@contextmanager
def served(live: LiveSimulator) -> Iterator[MavlinkVehicle]:
    """Serve its vehicle by UDP."""
    table = served_table(live, wire=None, origin="world", tf="truth", frame_prefix="")
    flight = next(action for action in actions_of(live.simulator, table) if action.name == "fly_path")
    with MavlinkVehicle(live, Endpoint("127.0.0.1", 0, "udpin"), table.channels, action=flight) as vehicle:
        yield vehicle


def station_at(vehicle: MavlinkVehicle, system: int = 255) -> Station:
    station = Station(f"udpout:127.0.0.1:{vehicle.endpoint.port}", system)
    station.receive("HEARTBEAT")
    return station


def interval(station: Station, number: int, interval_us: float) -> int:
    return station.command(dialect.MAV_CMD_SET_MESSAGE_INTERVAL, number, interval_us)
