"""The table of packings: each turns a message into bytes and back. A new one is one line here.

Anything left out or rounded is lost: listeners get the unpacked bytes, not the original.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from typing import Any, NamedTuple

from uwsim.channels import Channel
from uwsim.channels.cdr import encode
from uwsim.channels.messages import from_bytes
from uwsim.link.packing import panels, pings, poses, short_panel, thumbnails
from uwsim.scenario.spec.modem import ModemModel


class Packing(NamedTuple):
    """A way to pack the messages of a kind of channel.

    pack(message): bytes; ValueError. unpack(bytes, channel): the message. may_replace(message): whether a newer one of
    its channel may replace it while it waits. usual_bytes: for channels whose messages are costly to make.
    """

    pack: Callable[[Any], bytes]
    unpack: Callable[[bytes, Channel], Any]
    may_replace: Callable[[Any], bool] = lambda message: True
    usual_bytes: int | None = None


def _whole(message: Any) -> bytes:
    return bytes(encode(message))


def _from_whole(data: bytes, channel: Channel) -> Any:
    return from_bytes(data, channel.type)


def _deflated(message: Any) -> bytes:
    return zlib.compress(bytes(encode(message)), 9)


def _inflated(data: bytes, channel: Channel) -> Any:
    return from_bytes(zlib.decompress(data), channel.type)


WHOLE = Packing(_whole, _from_whole)
"""ROS's own bytes, for links that have capacity for everything."""
PACKINGS: dict[str, Packing] = {
    "deflate": Packing(_deflated, _inflated),
    "key": Packing(poses.pack_key, poses.unpack_key, may_replace=poses.is_plain_key),
    "pose": Packing(poses.pack_pose, poses.unpack_pose),
    "twist": Packing(poses.pack_twist, poses.unpack_twist),
    "state": Packing(panels.pack_state, panels.unpack_state),
    "telemetry": Packing(panels.pack_telemetry, panels.unpack_telemetry),
    "telemetry_short": Packing(short_panel.pack, short_panel.unpack),
    "depths": Packing(pings.pack_depths, pings.unpack_depths),
    "scan": Packing(pings.pack_scan, pings.unpack_scan),
    "placed": Packing(pings.pack_placed, pings.unpack_placed),
    "thumbnail": Packing(thumbnails.pack, thumbnails.unpack, usual_bytes=thumbnails.USUAL_BYTES),
}


SHORT_BYTES = 64
"""Modems with smaller packets use a packing NAME_short if there is one."""


def packing_of(channel: Channel, modem: ModemModel) -> Packing | None:
    """Return how a channel's messages are packed, or None if the modem cannot carry them. Other links have no limit."""
    if modem.kind != "modem":
        return WHOLE
    short = PACKINGS.get(f"{channel.packing}_short") if modem.packet_bytes < SHORT_BYTES else None
    return short or PACKINGS.get(channel.packing)
