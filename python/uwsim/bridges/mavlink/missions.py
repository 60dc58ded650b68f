"""MAVLink missions: their transfer, and the route that they describe."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from uwsim.bridges.actions.action import Route
from uwsim.bridges.actions.table import SPEED_M_S
from uwsim.bridges.mavlink.earth import Home, Vector
from uwsim.bridges.mavlink.endpoint import Peer

WAYPOINT, CHANGE_SPEED = 16, 178  # MAV_CMD
ABOVE_SEA, ABOVE_HOME = (0, 5), (3, 6)  # MAV_FRAME; the surface is both
ITEMS_MAX = 1000
AGAIN_S = 1.0  # after which an item is requested again
ACCEPTED, FAILED, UNSUPPORTED_FRAME, UNSUPPORTED, NO_SPACE, INVALID, INVALID_SEQUENCE = 0, 1, 2, 3, 4, 5, 13


class RefusedItemError(ValueError):
    """Raised for an item that cannot be flown. result: a MAV_MISSION_RESULT."""

    def __init__(self, result: int, reason: str) -> None:
        super().__init__(reason)
        self.result = result


def checked(item: Any) -> Any:
    """Return an item if it can be flown. Raises RefusedItemError."""
    where = f"mission item {item.seq}"
    if item.seq == 0:  # ArduPilot keeps the home position here
        return item
    if item.command not in (WAYPOINT, CHANGE_SPEED):
        raise RefusedItemError(UNSUPPORTED, f"{where}: command {item.command}: must be waypoint (16) or speed (178)")
    if item.command == CHANGE_SPEED:
        if not 0 < item.param2 <= 10:
            raise RefusedItemError(INVALID, f"{where}: speed = {item.param2:g} m/s: must be in (0, 10]")
        return item
    if item.frame not in ABOVE_SEA + ABOVE_HOME:
        raise RefusedItemError(UNSUPPORTED_FRAME, f"{where}: frame {item.frame}: must be a global one")
    if not (math.isfinite(item.z) and item.z <= 0):
        raise RefusedItemError(INVALID, f"{where}: altitude = {item.z:g} m: must not be above the surface, 0 m")
    return item


def route_of(items: list[Any], home: Home) -> tuple[Route, list[int]]:
    """Return the route through a mission's waypoints, and their sequence numbers. Raises ValueError without any."""
    points: list[Vector] = []
    numbers: list[int] = []
    speed_m_s = SPEED_M_S
    for item in items[1:]:
        if item.command == CHANGE_SPEED:
            speed_m_s = item.param2 if not points else min(speed_m_s, item.param2)
        else:
            points.append(home.world_m(1e-7 * item.x, 1e-7 * item.y, item.z))
            numbers.append(item.seq)
    if not points:
        raise ValueError("the mission has no waypoint: upload one")
    return Route(np.array(points), speed_m_s, None), numbers


class MissionStore:
    """Exchanges the mission with ground stations. items: those of the last complete upload. For one thread."""

    def __init__(self, mav: Any, send: Callable[..., None], say: Callable[[str], None]) -> None:
        self._mav, self._send, self._say = mav, send, say
        self.items: list[Any] = []
        self._uploading: tuple[Peer, int, list[Any], float, tuple[int, int]] | None = None

    def ask_again(self, now_s: float) -> None:
        """Request the next item of an upload again if it has not arrived."""
        if self._uploading is not None and now_s - self._uploading[3] > AGAIN_S:
            self._request_item()

    def on_mission_request_list(self, peer: Peer, message: Any) -> None:
        """Report the number of items."""
        self._send(self._mav.mission_count_encode(*_from(message), len(self.items)), peer)

    def on_mission_request_int(self, peer: Peer, message: Any) -> None:
        """Send an item."""
        if not 0 <= message.seq < len(self.items):
            self._send(self._mav.mission_ack_encode(*_from(message), INVALID_SEQUENCE), peer)
            return
        item = self.items[message.seq]
        self._send(
            self._mav.mission_item_int_encode(
                *_from(message), item.seq, item.frame, item.command, 0, item.autocontinue, item.param1, item.param2,
                item.param3, item.param4, item.x, item.y, item.z,
            ),
            peer,
        )  # fmt: skip

    on_mission_request = on_mission_request_int

    def on_mission_count(self, peer: Peer, message: Any) -> None:
        """Begin an upload."""
        if not 0 < message.count <= ITEMS_MAX:
            self._acknowledge(peer, _from(message), NO_SPACE)
            return
        self._uploading = (peer, message.count, [], 0.0, _from(message))
        self._request_item()

    def _request_item(self) -> None:
        assert self._uploading is not None
        peer, count, items, _, asker = self._uploading
        self._uploading = (peer, count, items, time.monotonic(), asker)
        self._send(self._mav.mission_request_int_encode(*asker, len(items)), peer)

    def on_mission_item_int(self, peer: Peer, message: Any) -> None:
        """Take the next item of an upload, and acknowledge the last one."""
        if self._uploading is None or peer != self._uploading[0] or message.seq != len(self._uploading[2]):
            return
        _, count, items, _, asker = self._uploading
        try:
            items.append(checked(message))
        except RefusedItemError as error:
            self._uploading = None
            self._acknowledge(peer, asker, error.result)
            self._say(str(error))
            return
        if len(items) < count:
            self._request_item()
            return
        self.items, self._uploading = items, None
        self._acknowledge(peer, asker, ACCEPTED)

    def on_mission_clear_all(self, peer: Peer, message: Any) -> None:
        """Delete the mission."""
        self.items = []
        self._acknowledge(peer, _from(message), ACCEPTED)

    def _acknowledge(self, peer: Peer, asker: tuple[int, int], result: int) -> None:
        self._send(self._mav.mission_ack_encode(*asker, result), peer)


def _from(message: Any) -> tuple[int, int]:
    return message.get_srcSystem(), message.get_srcComponent()
