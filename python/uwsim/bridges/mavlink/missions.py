"""MAVLink missions: their transfer, and the item that is flown."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from uwsim.bridges.doors.datagrams import Address
from uwsim.bridges.doors.waiting import Waiting
from uwsim.bridges.mavlink.component import SendText
from uwsim.bridges.mavlink.fence import FenceKeeper
from uwsim.bridges.mavlink.telemetry import EXTENDED_STATUS, Kind
from uwsim.missions.items import INVALID_X, ITEMS_MAX, RefusedItemError

AGAIN_S = 1.0  # interval at which a missing item is requested again
GIVE_UP_S = 15.0  # time without an item after which an upload ends
MISSION, FENCE, RALLY, ALL = 0, 1, 2, 255  # MAV_MISSION_TYPE
COMMANDS: Mapping[int, Sequence[int]] = {FENCE: range(5000, 5005), RALLY: (5100,)}
NAMES: Mapping[int, str] = {FENCE: "geofence", RALLY: "rally points"}
"""MAV_CMD of items of fences and rally points, and what they are called."""
ACCEPTED, UNSUPPORTED, NO_SPACE, INVALID, INVALID_SEQUENCE, DENIED, CANCELLED = 0, 3, 4, 5, 13, 14, 15
"""MAV_MISSION_RESULT."""
NO_MISSION, NOT_STARTED, ACTIVE, PAUSED, COMPLETE = range(1, 6)  # MISSION_STATE
CURRENT_HZ = 1


@dataclass
class _Upload:
    """An upload in progress. kind: a MAV_MISSION_TYPE. asker: the station's system and component.

    heard_s, asked_s: wall-clock times.
    """

    kind: int
    peer: Address
    asker: tuple[int, int]
    count: int
    heard_s: float
    asked_s: float = 0.0
    items: list[Any] = field(default_factory=list)


class MissionStore:
    """Exchanges the mission with ground stations, and reports the progress of its flight.

    A missing item is requested again every second, and an upload ends after 15 s without an item. Fences and rally
    points, which MAVLink treats as other types of missions, are kept and given back. A mission that leaves the fence is
    refused; rally points have no effect, which a text states. Must be used on one thread, except for `begin` and
    `reached`, which a flight calls.

    mav: encodes messages. output: queue for the messages of a flight's thread. check: returns an item that can be
    flown; raises RefusedItemError. items: of the last complete upload. current: the number of the item that is flown
    now, or next. state: a MISSION_STATE.
    """

    def __init__(
        self,
        mav: Any,
        send: Callable[..., None],
        send_text: SendText,
        output: Waiting[Any],
        check: Callable[[Any], Any],
        fence: FenceKeeper,
    ) -> None:
        self.mav, self._send, self._send_text, self._output, self._check = mav, send, send_text, output, check
        self._fence = fence
        self.items: list[Any] = []
        self._kept: dict[int, list[Any]] = {FENCE: [], RALLY: []}
        self.current, self.state = 0, NO_MISSION
        self._upload: _Upload | None = None
        self._ended: _Upload | None = None  # the last upload, whose acknowledgement may have been lost

    @property
    def kinds(self) -> list[Kind]:
        """The messages that are sent at a fixed rate: MISSION_CURRENT."""
        return [Kind(42, lambda mav, figures: [self._progress()], CURRENT_HZ, EXTENDED_STATUS)]

    def _progress(self) -> Any:
        count = max(len(self.items) - 1, 0)  # without the home position
        return self.mav.mission_current_encode(self.current, count, self.state, 1 if self.state == ACTIVE else 2)

    def begin(self, number: int) -> None:
        """Report that an item is flown now, from any thread."""
        self.current, self.state = number, ACTIVE
        self._output.put(self._progress)

    def reached(self, number: int) -> None:
        """Report that an item has been flown, from any thread."""
        self._output.put(self.mav.mission_item_reached_encode(number))

    def end(self, state: int) -> None:
        """Report that the mission is no longer flown: PAUSED or COMPLETE, from any thread."""
        if self.state == ACTIVE:
            self.state = state
            if state == COMPLETE:
                self.current = 1
            self._output.put(self._progress)

    def choose(self, number: int) -> None:
        """Make an item the next one that is flown; 0: the first. Raises ValueError."""
        if number and number >= len(self.items):
            raise ValueError(f"mission item {number}: there are {len(self.items)} items, numbered from 0")
        self.current = min(max(number, 1), len(self.items))
        self._output.put(self._progress)

    def _replace(self, items: list[Any]) -> None:
        self.items, self.current, self.state = items, min(len(items), 1), NOT_STARTED if items else NO_MISSION

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
            self._acknowledge(upload.peer, upload.asker, CANCELLED, upload.kind)
        else:
            self._request_item(upload)

    def _of(self, kind: int) -> list[Any]:
        """Return the items of a type, none of an unknown one."""
        return self.items if kind == MISSION else self._kept.get(kind, [])

    def on_mission_request_list(self, peer: Address, message: Any) -> None:
        """Report the number of items."""
        count = len(self._of(message.mission_type))
        self._send(self.mav.mission_count_encode(*_from(message), count, message.mission_type), peer)

    def on_mission_request_int(self, peer: Address, message: Any) -> None:
        """Send an item."""
        item = self._item(peer, message)
        if item is not None:
            place = item.x, item.y, item.z
            self._send(
                self.mav.mission_item_int_encode(*_from(message), *_plain(item), *place, message.mission_type), peer
            )

    def on_mission_request(self, peer: Address, message: Any) -> None:
        """Send an item with its position in degrees."""
        item = self._item(peer, message)
        if item is not None:
            place = *(part / _scale(item) for part in (item.x, item.y)), item.z, message.mission_type
            self._send(self.mav.mission_item_encode(*_from(message), *_plain(item), *place), peer)

    def _item(self, peer: Address, message: Any) -> Any:
        items = self._of(message.mission_type)
        if 0 <= message.seq < len(items):
            return items[message.seq]
        self._acknowledge(peer, _from(message), INVALID_SEQUENCE, message.mission_type)
        return None

    def on_mission_count(self, peer: Address, message: Any) -> None:
        """Begin an upload."""
        kind = message.mission_type
        if kind not in (MISSION, *COMMANDS):
            self._acknowledge(peer, _from(message), UNSUPPORTED, kind)
        elif kind == MISSION and self.state == ACTIVE:
            self._send_text("mission upload: refused while the mission is flown: change the mode first")
            self._acknowledge(peer, _from(message), DENIED)
        elif message.count == 0:
            self.on_mission_clear_all(peer, message)
        elif message.count > ITEMS_MAX:
            self._acknowledge(peer, _from(message), NO_SPACE, kind)
        elif self._upload is not None and self._upload.peer != peer:
            self._send_text("mission upload: refused while another ground station uploads")
            self._acknowledge(peer, _from(message), DENIED, kind)
        else:
            self._upload = _Upload(kind, peer, _from(message), message.count, time.monotonic())
            self._request_item(self._upload)

    def _request_item(self, upload: _Upload) -> None:
        """Ask for an item as ArduPilot does (MissionItemProtocol::queued_request_send), which takes either kind."""
        upload.asked_s = time.monotonic()
        self._send(self.mav.mission_request_encode(*upload.asker, len(upload.items), upload.kind), upload.peer)

    def on_mission_item(self, peer: Address, message: Any) -> None:
        """Accept an item with its position in degrees."""
        if not (abs(message.x) <= 180 and abs(message.y) <= 180):
            place = f"{message.x:g}, {message.y:g} deg"
            self._send_text(f"mission item {message.seq}: latitude, longitude = {place}: must be in [-180, 180]")
            self._refuse(peer, INVALID)
            return
        message.x, message.y = (round(_scale(message) * part) for part in (message.x, message.y))
        self.on_mission_item_int(peer, message)

    def on_mission_item_int(self, peer: Address, message: Any) -> None:
        """Accept the next item of an upload; after the last item, acknowledge the upload."""
        upload, ended = self._upload, self._ended
        if upload is None and ended is not None and ended.peer == peer and message.seq == ended.count - 1:
            self._acknowledge(peer, ended.asker, ACCEPTED, ended.kind)  # again
        if upload is None or peer != upload.peer or message.seq != len(upload.items):
            return
        if message.mission_type != upload.kind:
            return
        try:
            upload.items.append(self._check(message) if upload.kind == MISSION else self._shape(message))
        except RefusedItemError as error:
            self._send_text(str(error))
            self._refuse(peer, error.result)
            return
        upload.heard_s = time.monotonic()
        if len(upload.items) < upload.count:
            self._request_item(upload)
            return
        try:
            self._accept(upload.kind, upload.items)
        except ValueError as error:
            self._send_text(str(error))
            self._refuse(peer, INVALID_X if upload.kind == MISSION else INVALID)
            return
        self._upload, self._ended = None, upload
        self._acknowledge(peer, upload.asker, ACCEPTED, upload.kind)

    def _accept(self, kind: int, items: list[Any]) -> None:
        """Keep the items of a whole upload. Raises ValueError for those that do not fit together, or the fence."""
        if kind == MISSION:
            if (why := self._fence.refusal(items[1:])) is not None:
                raise ValueError(why)
            self._replace(items)
            return
        if kind == FENCE:
            zones = self._fence.keep(items)
            self._send_text(f"{NAMES[kind]}: {zones} zone{'s' * (zones != 1)}: missions that leave it are refused")
            if (why := self._fence.refusal(self.items[1:])) is not None:
                self._send_text(f"{why}: AUTO is refused")
        else:
            self._send_text(f"{NAMES[kind]}: {len(items)} items are kept, and have no effect")
        self._kept[kind] = items

    def require_within_fence(self) -> None:
        """Raise ValueError if the mission leaves the fence."""
        if (why := self._fence.refusal(self.items[1:])) is not None:
            raise ValueError(why)

    def _shape(self, item: Any) -> Any:
        """Return an item of a fence or of rally points. Raises RefusedItemError."""
        known = COMMANDS[item.mission_type]
        if item.command not in known:
            rule = f"must be one of {', '.join(map(str, known))}"
            raise RefusedItemError(item, UNSUPPORTED, f"{NAMES[item.mission_type]}: command {item.command}: {rule}")
        return item

    def _refuse(self, peer: Address, result: int) -> None:
        """End this peer's upload."""
        upload = self._upload
        if upload is not None and upload.peer == peer:
            self._upload = None
            self._acknowledge(peer, upload.asker, result, upload.kind)

    def on_mission_clear_all(self, peer: Address, message: Any) -> None:
        """Delete the items of one type, or of all; a mission not while it is flown."""
        for kind in self._kept:
            if message.mission_type in (kind, ALL):
                self._kept[kind] = []
                if kind == FENCE:
                    self._fence.keep([])
        if message.mission_type in (MISSION, ALL):
            if self.state == ACTIVE:
                self._acknowledge(peer, _from(message), DENIED, message.mission_type)
                return
            self._replace([])
        self._acknowledge(peer, _from(message), ACCEPTED, message.mission_type)

    def _acknowledge(self, peer: Address, asker: tuple[int, int], result: int, kind: int = MISSION) -> None:
        self._send(self.mav.mission_ack_encode(*asker, result, kind), peer)


def _scale(item: Any) -> float:
    """Return the integer of an item's x and y for one, as ArduPilot converts items; those of cameras are no places."""
    return 1.0 if item.command in (202, 203) else 1e7


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
