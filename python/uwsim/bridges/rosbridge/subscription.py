"""A client's subscription to one topic, which may comprise several ids with different options."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple, get_args

from uwsim.base.arguments import is_number
from uwsim.bridges.doors.waiting import Room
from uwsim.bridges.rosbridge.encoding import Compression
from uwsim.bridges.rosbridge.fragments import read_fragment_size
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.outbox import Mailbox
from uwsim.channels.ros.message_types import NEWEST_ONLY, shortened
from uwsim.channels.ros.messages import Ros

COMPRESSIONS: tuple[str, ...] = get_args(Compression)


CREDIT_MAX = 100


class Options(NamedTuple):
    """The options of one id. throttle_s: minimum time between messages. queue_length: 0 for the default.

    credit: maximum number of unacknowledged messages, or None; an extension to rosbridge. fragment_size: maximum number
    of characters in a frame of JSON, or None.
    """

    throttle_s: float
    queue_length: int
    compression: Compression
    credit: int | None = None
    fragment_size: int | None = None


def read_options(operation: dict[str, Any], limits: Limits) -> Options:
    """Read the options from a "subscribe" operation. Raises ValueError."""
    throttle_ms = operation.get("throttle_rate") or 0
    length = operation.get("queue_length") or 0
    compression: Any = operation.get("compression") or "none"
    if not is_number(throttle_ms) or not 0 <= throttle_ms <= 1e9:
        raise ValueError(f"throttle_rate = {shortened(throttle_ms)} ms: must be in [0, 1e9]")
    if not is_number(length) or length < 0:
        raise ValueError(f"queue_length = {shortened(length)}: must not be negative")
    if compression not in COMPRESSIONS:
        raise ValueError(f"compression = {shortened(compression)}: must be one of {', '.join(COMPRESSIONS)}")
    credit = operation.get("credit")
    if credit is not None and (type(credit) is not int or not 1 <= credit <= CREDIT_MAX):
        raise ValueError(f"credit = {shortened(credit)}: must be in [1, {CREDIT_MAX}]")
    length = int(min(length, limits.queue_length))
    return Options(throttle_ms / 1000.0, length, compression, credit, read_fragment_size(operation))


@dataclass
class Subscription:
    """A topic, its name as spelled by the client, and the options of each id."""

    topic: str
    ros: Ros
    ids: dict[Any, Options] = field(default_factory=dict)

    def mailbox(self, type_name: str | None, room: Room, *, png: bool) -> Mailbox:
        """Return a queue that suits all ids: the shortest throttle, the longest queue and the strongest compression."""
        options = list(self.ids.values())
        wanted = {option.compression for option in options}
        order: tuple[Compression, ...] = ("cbor-raw", "cbor", "png") if png else ("cbor-raw", "cbor")
        return Mailbox(
            self.topic,
            self.ros,
            room,
            next((compression for compression in order if compression in wanted), "none"),
            throttle_s=min(option.throttle_s for option in options),
            length=max(option.queue_length for option in options),
            large=type_name in NEWEST_ONLY,
            credit=min((option.credit for option in options if option.credit is not None), default=None),
            fragment_size=min((one.fragment_size for one in options if one.fragment_size is not None), default=None),
        )
