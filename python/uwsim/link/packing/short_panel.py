"""A packing of the values that matter most to a pilot, within 32 bytes, a single packet of a slow modem."""

from __future__ import annotations

import math
import struct
from typing import Any

import numpy as np

from uwsim.channels import Channel
from uwsim.channels.ros import build
from uwsim.channels.ros.own_types import ALL_STOPPED, TELEMETRY
from uwsim.instruments.gauges import NUMBERS, VECTORS
from uwsim.link.packing.panels import FLAGS, STAMP_NS, pack_failsafe, quantised, unpack_failsafe, value_of

SLOW = sorted((gauge.slow, gauge) for gauge in NUMBERS if gauge.slow)
"""Place, quantum and struct format code of each gauge that is carried. A negative depth is sent as 0."""
HEAD = struct.Struct("<I9s3b4B" + "".join(code for (_, _, code), _ in SLOW))
TURN_RAD = math.pi / 127  # roll, pitch and yaw


def pack(message: Any) -> bytes:
    """Pack /telemetry into 31 bytes: position in cm, attitude to 1.4 degrees, and all stop as the only alarm.

    The true position and the commands are not included.
    """
    from scipy.spatial.transform import Rotation  # slow to import

    stamp_ns = build.ns_of(message.header.stamp)
    position = b"".join(_three_bytes(x) for x in message.position)
    turn = np.asarray(message.orientation, np.float64)
    angles_rad = Rotation.from_quat(turn).as_euler("ZYX") if np.linalg.norm(turn) > 0.5 else np.zeros(3)
    flags = sum(bool(getattr(message, name)) << bit for bit, name in enumerate(FLAGS))
    flags |= (ALL_STOPPED in message.alarms) << len(FLAGS)
    lamps = sum(bool(lit) << bit for bit, lit in enumerate(message.lamps[:8]))
    figures = [quantised(float(getattr(message, gauge.name)), quantum, code) for (_, quantum, code), gauge in SLOW]
    return HEAD.pack(
        stamp_ns // STAMP_NS, position, *(quantised(angle, TURN_RAD, "b") for angle in angles_rad), flags,
        pack_failsafe(message), lamps, min(len(message.lamps), 8), *figures,
    )  # fmt: skip


def unpack(data: bytes, channel: Channel) -> Any:
    """Return the telemetry message; values that were not carried are nan or empty."""
    from scipy.spatial.transform import Rotation  # slow to import

    stamp, position, yaw, pitch, roll, flags, failsafe, lamps, count, *figures = HEAD.unpack(data)
    turn = Rotation.from_euler("ZYX", np.array([yaw, pitch, roll]) * TURN_RAD).as_quat()
    states = {name: bool(flags >> bit & 1) for bit, name in enumerate(FLAGS)}
    unknown = np.full(3, np.nan)
    return build.message(
        TELEMETRY,
        header=build.header(stamp * STAMP_NS, channel.frame_id),
        position=np.array([_from_three(position[k : k + 3]) for k in (0, 3, 6)]),
        position_std=unknown.astype(np.float32),
        true_position=unknown,
        **{gauge.name: unknown.astype(np.float32) for gauge in VECTORS},
        orientation=turn.astype(np.float32),
        lamps=np.array([bool(lamps >> bit & 1) for bit in range(count)]),
        hold_targets=np.empty(0, np.float32),
        alarms=[ALL_STOPPED] if flags >> len(FLAGS) & 1 else [],
        **states | {"is_truth": False},
        **dict.fromkeys((gauge.name for gauge in NUMBERS), math.nan)
        | {
            gauge.name: value_of(whole, quantum, code, gauge.missing)
            for ((_, quantum, code), gauge), whole in zip(SLOW, figures, strict=True)
        },
        **unpack_failsafe(failsafe),
    )


def _three_bytes(value_m: float) -> bytes:
    whole = round(100.0 * value_m) if math.isfinite(value_m) else -(2**23)
    return max(-(2**23), min(whole, 2**23 - 1)).to_bytes(3, "little", signed=True)


def _from_three(data: bytes) -> float:
    whole = int.from_bytes(data, "little", signed=True)
    return math.nan if whole == -(2**23) else 0.01 * whole
