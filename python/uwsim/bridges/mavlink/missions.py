"""MAVLink missions: their transfer, and the route that they describe."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from uwsim.bridges.actions.action import Route
from uwsim.bridges.actions.table import SPEED_M_S
from uwsim.bridges.mavlink.earth import Home, Vector
from uwsim.bridges.mavlink.endpoint import Peer

WAYPOINT, CHANGE_SPEED = 16, 178  # MAV_CMD
ABOVE_SEA, ABOVE_HOME = (0, 5), (3, 6)  # MAV_FRAME; both altitudes are relative to the surface
ITEMS_MAX = 1000
SPEED_MAX_M_S, FAR_M = 10.0, 1e5
"""Limits of speeds, and of distances from the world's origin."""
AGAIN_S = 1.0  # interval at which a missing item is requested again
GIVE_UP_S = 15.0  # time without an item after which an upload ends
MISSION = 0  # MAV_MISSION_TYPE; fences and rally points are other types
ACCEPTED, UNSUPPORTED_FRAME, UNSUPPORTED, NO_SPACE, INVALID, INVALID_SEQUENCE, DENIED, CANCELLED = (
    0,
    2,
    3,
    4,
    5,
    13,
    14,
    15,
)
"""MAV_MISSION_RESULT."""


class RefusedItemError(ValueError):
    """Raised for an item that cannot be flown. result: a MAV_MISSION_RESULT."""

    def __init__(self, result: int, reason: str) -> None:
        super().__init__(reason)
        self.result = result


def checked(item: Any) -> Any:
    """Return the item if it can be flown. Raises RefusedItemError."""
    where = f"mission item {item.seq}"
    if item.seq == 0:  # ArduPilot keeps the home position here
        return item
    if item.command not in (WAYPOINT, CHANGE_SPEED):
        raise RefusedItemError(UNSUPPORTED, f"{where}: command {item.command}: must be waypoint (16) or speed (178)")
    if item.command == CHANGE_SPEED:
        if not 0 < item.param2 <= SPEED_MAX_M_S:
            raise RefusedItemError(INVALID, f"{where}: speed = {item.param2:g} m/s: must be in (0, {SPEED_MAX_M_S:g}]")
        return item
    if item.frame not in ABOVE_SEA + ABOVE_HOME:
        raise RefusedItemError(UNSUPPORTED_FRAME, f"{where}: frame {item.frame}: must be a global one")
    if not -FAR_M < item.z <= 0:
        raise RefusedItemError(
            INVALID, f"{where}: altitude = {item.z:g} m: must not be above the surface, 0 m, nor below {-FAR_M:g} m"
        )
    return item


def route_of(items: list[Any], home: Home) -> tuple[Route, list[int]]:
    """Return the route through a mission's waypoints, and their sequence numbers.

    Raises ValueError if there are none.
    """
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


@dataclass
class _Upload:
    """An upload in progress. asker: the station's system and component. heard_s, asked_s: wall-clock times."""

    peer: Peer
    asker: tuple[int, int]
    count: int
    heard_s: float
    asked_s: float = 0.0
    items: list[Any] = field(default_factory=list)


class MissionStore:
    """Exchanges the mission with ground stations. items: the items of the last complete upload.

    A missing item is requested again every second, and an upload ends after 15 s without an item. Fences and rally
    points, which MAVLink treats as other types of missions, are empty and cannot be uploaded. output: queue for the
    messages of a flight's thread. Other methods must be called on one thread.
    """

    def __init__(
        self, mav: Any, send: Callable[..., None], send_text: Callable[[str], None], output: deque[Any]
    ) -> None:
        self._mav, self._send, self._send_text, self._output = mav, send, send_text, output
        self.items: list[Any] = []
        self._upload: _Upload | None = None
        self._ended: _Upload | None = None  # the last upload, whose acknowledgement may have been lost

    def retry(self, now_s: float) -> None:
        """Request the next item of an upload again if it has not arrived, or give up."""
        upload = self._upload
        if upload is None or now_s - upload.asked_s < AGAIN_S:
            return
        if now_s - upload.heard_s > GIVE_UP_S:
            self._upload = None
            self._send_text(
                f"mission upload: item {len(upload.items)} did not arrive within {GIVE_UP_S:g} s: cancelled"
            )
            self._acknowledge(upload.peer, upload.asker, CANCELLED)
        else:
            self._request_item(upload)

    def report(self, numbers: list[int], leg: int) -> None:
        """Report the item that is being flown, from any thread. numbers: the sequence numbers of the waypoints."""
        if numbers:
            self._output.append(self._mav.mission_current_encode(numbers[min(leg, len(numbers) - 1)]))

    def report_reached(self, numbers: list[int]) -> None:
        """Report that the waypoints have been reached, from any thread."""
        for number in numbers:
            self._output.append(self._mav.mission_item_reached_encode(number))

    def on_mission_request_list(self, peer: Peer, message: Any) -> None:
        """Report the number of items."""
        count = len(self.items) if message.mission_type == MISSION else 0
        self._send(self._mav.mission_count_encode(*_from(message), count, message.mission_type), peer)

    def on_mission_request_int(self, peer: Peer, message: Any) -> None:
        """Send an item."""
        item = self._item(peer, message)
        if item is not None:
            place = item.x, item.y, item.z
            self._send(self._mav.mission_item_int_encode(*_from(message), *_plain(item), *place), peer)

    def on_mission_request(self, peer: Peer, message: Any) -> None:
        """Send an item with its position in degrees."""
        item = self._item(peer, message)
        if item is not None:
            place = 1e-7 * item.x, 1e-7 * item.y, item.z
            self._send(self._mav.mission_item_encode(*_from(message), *_plain(item), *place), peer)

    def _item(self, peer: Peer, message: Any) -> Any:
        if message.mission_type == MISSION and 0 <= message.seq < len(self.items):
            return self.items[message.seq]
        self._acknowledge(peer, _from(message), INVALID_SEQUENCE, message.mission_type)
        return None

    def on_mission_count(self, peer: Peer, message: Any) -> None:
        """Begin an upload."""
        if message.mission_type != MISSION:
            self._acknowledge(peer, _from(message), UNSUPPORTED, message.mission_type)
        elif message.count == 0:
            self.on_mission_clear_all(peer, message)
        elif message.count > ITEMS_MAX:
            self._acknowledge(peer, _from(message), NO_SPACE)
        elif self._upload is not None and self._upload.peer != peer:
            self._send_text("mission upload: refused while another ground station uploads")
            self._acknowledge(peer, _from(message), DENIED)
        else:
            self._upload = _Upload(peer, _from(message), message.count, time.monotonic())
            self._request_item(self._upload)

    def _request_item(self, upload: _Upload) -> None:
        upload.asked_s = time.monotonic()
        self._send(self._mav.mission_request_int_encode(*upload.asker, len(upload.items)), upload.peer)

    def on_mission_item(self, peer: Peer, message: Any) -> None:
        """Accept an item with its position in degrees."""
        if not (abs(message.x) <= 180 and abs(message.y) <= 180):
            place = f"{message.x:g}, {message.y:g} deg"
            self._send_text(f"mission item {message.seq}: latitude, longitude = {place}: must be in [-180, 180]")
            self._refuse(peer, INVALID)
            return
        message.x, message.y = round(1e7 * message.x), round(1e7 * message.y)
        self.on_mission_item_int(peer, message)

    def on_mission_item_int(self, peer: Peer, message: Any) -> None:
        """Accept the next item of an upload; after the last item, acknowledge the upload."""
        upload, ended = self._upload, self._ended
        if upload is None and ended is not None and ended.peer == peer and message.seq == ended.count - 1:
            self._acknowledge(peer, ended.asker, ACCEPTED)  # again
        if upload is None or peer != upload.peer or message.seq != len(upload.items):
            return
        try:
            upload.items.append(checked(message))
        except RefusedItemError as error:
            self._send_text(str(error))
            self._refuse(peer, error.result)
            return
        upload.heard_s = time.monotonic()
        if len(upload.items) < upload.count:
            self._request_item(upload)
            return
        self.items, self._upload, self._ended = upload.items, None, upload
        self._acknowledge(peer, upload.asker, ACCEPTED)

    def _refuse(self, peer: Peer, result: int) -> None:
        """End this peer's upload."""
        upload = self._upload
        if upload is not None and upload.peer == peer:
            self._upload = None
            self._acknowledge(peer, upload.asker, result)

    def on_mission_clear_all(self, peer: Peer, message: Any) -> None:
        """Delete the mission."""
        if message.mission_type == MISSION:
            self.items = []
        self._acknowledge(peer, _from(message), ACCEPTED, message.mission_type)

    def _acknowledge(self, peer: Peer, asker: tuple[int, int], result: int, kind: int = MISSION) -> None:
        self._send(self._mav.mission_ack_encode(*asker, result, kind), peer)


def _plain(item: Any) -> tuple[Any, ...]:
    return (
        item.seq,
        item.frame,
        item.command,
        0,
        item.autocontinue,
        item.param1,
        item.param2,
        item.param3,
        item.param4,
    )


def _from(message: Any) -> tuple[int, int]:
    return message.get_srcSystem(), message.get_srcComponent()
