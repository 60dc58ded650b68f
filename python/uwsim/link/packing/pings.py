"""Packings of pings: the ranges of every eighth beam, in centimetres."""

from __future__ import annotations

import math
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.channels import Channel
from uwsim.channels.families.published import join
from uwsim.channels.ros import build
from uwsim.channels.ros.own_types import PLACED_PING
from uwsim.link.packing import poses

EVERY = 8
QUANTUM_M = 0.01
NO_ECHO = 65535
DEPTHS = struct.Struct("<Hf")  # number of beams, and the range that stands for no echo
PLACED = struct.Struct("<q2f")  # stamp [ns]; first angle, increment [rad]
SCAN = struct.Struct("<q2f2f2f")  # stamp [ns]; first angle, increment [rad]; times [s]; least and greatest range [m]


def _packed(ranges_m: NDArray[np.floating[Any]], limit_m: float) -> bytes:
    kept = np.asarray(ranges_m, np.float64)[::EVERY]
    with np.errstate(invalid="ignore"):
        whole = np.where(kept < limit_m, np.clip(np.round(kept / QUANTUM_M), 0, NO_ECHO - 1), NO_ECHO)
    return whole.astype("<u2").tobytes()


def _unpacked(data: bytes, none: float) -> NDArray[np.float64]:
    whole = np.frombuffer(data, "<u2")
    return np.where(whole == NO_ECHO, none, whole * QUANTUM_M)


def pack_depths(message: Any) -> bytes:
    """Pack every eighth range of `depthArray` into two bytes: 136 bytes for 513 beams."""
    ranges_m = np.array([float(text) for text in message.data.split("a")[:-1]])
    limit_m = float(ranges_m.max(initial=0.0))
    return DEPTHS.pack(len(ranges_m), limit_m) + _packed(ranges_m, limit_m)


def unpack_depths(data: bytes, channel: Channel) -> Any:
    """Return text with all beams; beams that were not carried have no echo."""
    beams, limit_m = DEPTHS.unpack_from(data)
    ranges_m = np.full(beams, limit_m)
    ranges_m[::EVERY] = _unpacked(data[DEPTHS.size :], limit_m)
    return build.text(join(ranges_m))


def pack_scan(message: Any) -> bytes:
    """Pack every eighth range of a LaserScan into two bytes, without intensities."""
    stamp_ns = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
    return SCAN.pack(
        stamp_ns, message.angle_min, message.angle_increment, message.time_increment, message.scan_time,
        message.range_min, message.range_max,
    ) + _packed(message.ranges, message.range_max)  # fmt: skip


def unpack_scan(data: bytes, channel: Channel) -> Any:
    """Return a LaserScan with one beam in eight."""
    stamp_ns, first_rad, increment_rad, between_s, scan_s, range_min_m, range_max_m = SCAN.unpack_from(data)
    ranges_m = _unpacked(data[SCAN.size :], math.inf).astype(np.float32)
    return build.message(
        "sensor_msgs/msg/LaserScan",
        header=build.header(stamp_ns, channel.frame_id),
        angle_min=first_rad,
        angle_max=first_rad + (len(ranges_m) - 1) * EVERY * increment_rad,
        angle_increment=EVERY * increment_rad,
        time_increment=EVERY * between_s,
        scan_time=scan_s,
        range_min=range_min_m,
        range_max=range_max_m,
        ranges=ranges_m,
    )


def pack_placed(message: Any) -> bytes:
    """Pack a ping's pose into 36 bytes and every eighth range into two: 166 bytes for 513 beams."""
    stamp_ns = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
    head = PLACED.pack(stamp_ns, message.angle_min, message.angle_increment)
    return head + poses.pack_pose(message.sonar) + _packed(message.ranges, math.inf)


def unpack_placed(data: bytes, channel: Channel) -> Any:
    """Return a ping with its pose and one beam in eight."""
    stamp_ns, first_rad, increment_rad = PLACED.unpack_from(data)
    ranges_at = PLACED.size + poses.POSE.size
    return build.message(
        PLACED_PING,
        header=build.header(stamp_ns, channel.frame_id),
        sonar=poses.unpack_pose(data[PLACED.size : ranges_at], channel),
        angle_min=first_rad,
        angle_increment=EVERY * increment_rad,
        ranges=_unpacked(data[ranges_at:], math.inf).astype(np.float32),
    )
