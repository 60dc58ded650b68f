"""The table of packings, which convert messages to bytes and back. Adding a packing takes one line here.

Receivers get the unpacked message, not the original, so anything omitted or rounded is lost.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from typing import Any, NamedTuple

from uwsim.channels import Channel
from uwsim.channels.ros.cdr import encode
from uwsim.channels.ros.messages import from_bytes
from uwsim.link.packing import panels, pings, poses, short_panel, thumbnails
from uwsim.scenario.spec.link import ModemModel


class Packing(NamedTuple):
    """The packing of messages for one kind of channel.

    pack: converts a message to bytes; may raise ValueError. unpack: converts bytes back to a message of the channel.
    may_replace: returns whether a newer message of the channel may replace a waiting message. usual_bytes: typical
    size, for channels whose messages are costly to create.
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
"""ROS's serialisation, for links that have capacity for everything."""
PACKINGS: dict[str, Packing] = {
    "deflate": Packing(_deflated, _inflated),
    "key": Packing(poses.pack_key, poses.unpack_key, may_replace=poses.is_plain_key),
    "pose": Packing(poses.pack_pose, poses.unpack_pose),
    "twist": Packing(poses.pack_twist, poses.unpack_twist),
    "state": Packing(panels.pack_state, panels.unpack_state),
    "telemetry": Packing(panels.pack_telemetry, panels.unpack_telemetry),
    "telemetry_short": Packing(short_panel.pack, short_panel.unpack),
    "sensor_gauges": Packing(panels.pack_sensors, panels.unpack_sensors),
    "depths": Packing(pings.pack_depths, pings.unpack_depths),
    "scan": Packing(pings.pack_scan, pings.unpack_scan),
    "placed": Packing(pings.pack_placed, pings.unpack_placed),
    "thumbnail": Packing(thumbnails.pack, thumbnails.unpack, usual_bytes=thumbnails.USUAL_BYTES),
}


SHORT_BYTES = 64
"""Modems with smaller packets use the packing NAME_short, if there is one."""


def packing_of(channel: Channel, modem: ModemModel) -> Packing | None:
    """Return the packing for a channel's messages, or None if the modem cannot carry them.

    Links other than modems carry all messages unabridged.
    """
    if modem.kind != "modem":
        return WHOLE
    name = "" if channel.over_link is None else channel.over_link.packing
    short = PACKINGS.get(f"{name}_short") if modem.packet_bytes < SHORT_BYTES else None
    return short or PACKINGS.get(name)
