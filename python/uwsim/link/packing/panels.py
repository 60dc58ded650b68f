"""Packings of the panel: the nine published values, and /telemetry."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable
from typing import Any

import numpy as np

from uwsim.base.commands import HOLDS
from uwsim.channels import Channel
from uwsim.channels.families.published import join
from uwsim.channels.ros import build
from uwsim.channels.ros.own_types import SENSOR_GAUGES, TELEMETRY
from uwsim.instruments.gauges import NUMBERS, VECTORS, Gauge
from uwsim.simulator.failures.alarms import FAILSAFE_CAUSES

STATE = struct.Struct("<HHhIHHHIB")
STATE_QUANTA = (0.01, 0.001, 0.01, 0.01, 0.1, 0.1, 0.1, 0.1, 0.5)
"""Quanta of the nine values, in m/s, rad/s, deg C, kPa, m, m, m, s and %."""
LIMITS = {"B": (0, 254), "H": (0, 65534), "h": (-32767, 32766), "I": (0, 2**32 - 2), "i": (1 - 2**31, 2**31 - 2),
          "b": (-127, 126)}  # fmt: skip
NONE = {"B": 255, "H": 65535, "h": 32767, "I": 2**32 - 1, "i": 2**31 - 1, "b": 127}
"""Values that represent nan and infinity."""


def quantised(value: float, quantum: float, code: str) -> int:
    """Round a value to a whole number of quanta, saturated at the limits of the struct format code."""
    if not math.isfinite(value):
        return NONE[code]
    low, high = LIMITS[code]
    return int(min(max(round(value / quantum), low), high))


def pack_state(message: Any) -> bytes:
    """Pack the nine values of `stateData` into 21 bytes."""
    values = [float(text) for text in message.data.replace("Infinity", "inf").split("a")[:-1]]
    codes = STATE.format[1:]
    return STATE.pack(*(quantised(*each) for each in zip(values, STATE_QUANTA, codes, strict=True)))


def unpack_state(data: bytes, channel: Channel) -> Any:
    """Return a message with the nine values as text."""
    codes = STATE.format[1:]
    values = zip(STATE.unpack(data), STATE_QUANTA, codes, strict=True)
    return build.text(join(math.inf if whole == NONE[code] else whole * quantum for whole, quantum, code in values))


FLAGS = ("is_truth", "released", "range_warning", "proximity_warning", "collision_warning")
HEAD = struct.Struct("<q3i3i3H4b6hBH3B")
FIGURES = struct.Struct("<" + "".join(gauge.packed[1] for gauge in NUMBERS))
DOES = ("", "hold", "surface", "return", "go_on")
CAUSES = ("", *FAILSAFE_CAUSES)


def pack_telemetry(message: Any) -> bytes:
    """Pack /telemetry into about 110 bytes: positions in cm, accelerations in mm/s2, commands in %, alarms as text."""
    stamp_ns = build.ns_of(message.header.stamp)
    flags = sum(bool(getattr(message, name)) << bit for bit, name in enumerate(FLAGS))
    lamps = np.asarray(message.lamps, bool)
    places = [quantised(x, 0.01, "i") for x in (*message.position, *message.true_position)]
    places += [quantised(x, 0.01, "H") for x in message.position_std]
    turn = [quantised(x, 1 / 126, "b") for x in message.orientation]
    commands = [quantised(x, 0.01, "b") for x in (*message.efforts, *message.thrusters)]
    return (
        HEAD.pack(stamp_ns, *places, *turn, *_packed(message, VECTORS), flags, min(message.collisions, 65535),
                  len(lamps), len(message.efforts), len(message.thrusters))
        + FIGURES.pack(*_packed(message, NUMBERS))
        + np.packbits(lamps).tobytes()
        + struct.pack(f"<{len(commands)}b", *commands)
        + _pack_notices(message)
    )  # fmt: skip


def _packed(message: Any, gauges: Iterable[Gauge]) -> list[int]:
    return [quantised(x, *gauge.packed) for gauge in gauges for x in np.atleast_1d(getattr(message, gauge.name))]


def unpack_telemetry(data: bytes, channel: Channel) -> Any:
    """Return the telemetry message."""
    stamp_ns, *rest, flags, collisions, lamps, efforts, thrusters = HEAD.unpack_from(data)
    places, stds = [value_of(x, 0.01, "i") for x in rest[:6]], [value_of(x, 0.01, "H") for x in rest[6:9]]
    turn = np.array([value_of(x, 1 / 126, "b") for x in rest[9:13]])
    figures: dict[str, Any] = {
        gauge.name: value_of(whole, *gauge.packed, gauge.missing)
        for gauge, whole in zip(NUMBERS, FIGURES.unpack_from(data, HEAD.size), strict=True)
    }
    wholes = iter(rest[13:])
    for gauge in VECTORS:
        figures[gauge.name] = np.array([value_of(next(wholes), *gauge.packed) for _ in range(gauge.width)], np.float32)
    at = HEAD.size + FIGURES.size
    lit = np.unpackbits(np.frombuffer(data, np.uint8, -(-lamps // 8), at))[:lamps].astype(bool)
    commands = 0.01 * np.frombuffer(data, np.int8, efforts + thrusters, at + -(-lamps // 8)).astype(np.float32)
    return build.message(
        TELEMETRY,
        header=build.header(stamp_ns, channel.frame_id),
        position=np.array(places[:3]),
        position_std=np.array(stds, np.float32),
        true_position=np.array(places[3:]),
        orientation=(turn / (np.linalg.norm(turn) or 1.0)).astype(np.float32),
        efforts=commands[:efforts],
        thrusters=commands[efforts:],
        lamps=lit,
        collisions=collisions,
        **_unpack_notices(data[at + -(-lamps // 8) + efforts + thrusters :]),
        **{name: bool(flags >> bit & 1) for bit, name in enumerate(FLAGS)},
        **figures,
    )


STAMP_NS = 10_000_000
START = "sensor "
"""Every name of a sensor's gauge begins with this, which is not sent."""


def pack_sensors(message: Any) -> bytes:
    """Pack /sensor_gauges: names and units as text, values to six digits, ages in whole seconds."""
    stamp_ns = build.ns_of(message.header.stamp)
    rows = zip(message.names, message.units, message.values, message.ages, strict=True)
    texts = [f"{name.removeprefix(START)}\t{unit}\t{value:.6g}\t{age:.0f}" for name, unit, value, age in rows]
    return struct.pack("<I", stamp_ns // STAMP_NS) + "\n".join(texts).encode()


def unpack_sensors(data: bytes, channel: Channel) -> Any:
    """Return the message."""
    names, units, values, ages = zip(*(row.split("\t") for row in data[4:].decode().split("\n")), strict=True)
    return build.message(
        SENSOR_GAUGES,
        header=build.header(struct.unpack_from("<I", data)[0] * STAMP_NS, channel.frame_id),
        names=[START + name for name in names],
        units=list(units),
        values=np.array(values, np.float32),
        ages=np.array(ages, np.float32),
    )


def pack_failsafe(message: Any) -> int:
    """Encode the failsafe's state and its cause in one byte."""
    state = DOES.index(message.failsafe) if message.failsafe in DOES else 0
    cause = CAUSES.index(message.failsafe_cause) if message.failsafe_cause in CAUSES else 0
    return len(CAUSES) * state + cause


def unpack_failsafe(byte: int) -> dict[str, str]:
    """Decode the failsafe fields of /telemetry."""
    state, cause = divmod(byte, len(CAUSES))
    return {"failsafe": DOES[state], "failsafe_cause": CAUSES[cause]}


def pack_holds(message: Any) -> bytes:
    """Return one bit for each kind of hold, followed by the targets of the active holds in the same order."""
    bits = sum(1 << bit for bit, name in enumerate(HOLDS) if name in message.holds)
    return struct.pack(f"<B{len(message.holds)}i", bits, *(quantised(x, 0.01, "i") for x in message.hold_targets))


def unpack_holds(data: bytes) -> tuple[dict[str, Any], bytes]:
    """Return the hold fields of /telemetry, and the bytes that follow."""
    names = [name for bit, name in enumerate(HOLDS) if data[0] >> bit & 1]
    end = 1 + 4 * len(names)
    targets = [value_of(x, 0.01, "i") for x in struct.unpack(f"<{len(names)}i", data[1:end])]
    return {"holds": names, "hold_targets": np.array(targets, np.float32)}, data[end:]


def _pack_notices(message: Any) -> bytes:
    """Return the failsafe byte, the holds and, as text, the note on holds and the alarms (if any)."""
    notes = [message.hold_note, *message.alarms]
    return bytes([pack_failsafe(message)]) + pack_holds(message) + ("\n".join(notes) if any(notes) else "").encode()


def _unpack_notices(data: bytes) -> dict[str, Any]:
    holds, rest = unpack_holds(data[1:])
    note, *alarms = rest.decode().split("\n")
    return unpack_failsafe(data[0]) | holds | {"hold_note": note, "alarms": alarms}


def value_of(whole: int, quantum: float, code: str, none: float = math.nan) -> float:
    """Convert a whole number of quanta to a value, or to `none` if the number represents a missing value."""
    return none if whole == NONE[code] else whole * quantum
