"""Telemetry logs (.tlog): MAVLink packets, each after its time of arrival, as ground stations write them.

Format: 8 bytes of microseconds since 1970, big-endian, then a packet (mavlink.io, "File formats"). pymavlink decodes
the packets; those of other components, and those with a wrong check sum, are left out.
"""

from __future__ import annotations

import re
import struct
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.extras import need_extra
from uwsim.base.texts.text_file import read_limited
from uwsim.exchange.logs.autopilot import EVENTS_MAX, TELEMETRY, fields_of, flight_of
from uwsim.recording.real_flights.flight_log import MOST_BYTES, MOST_ROWS, FlightLog

KIND = "a telemetry log (.tlog)"
STAMP = 8
V1, V2 = 0xFE, 0xFD
AROUND = {V1: 8, V2: 12}
"""Bytes of a packet around its payload, by its first byte; one of version 2 may be signed by 13 more."""
MAGIC = re.compile(b"[\xfd\xfe]")
SIGNED, SIGNATURE = 1, 13
AUTOPILOT = 1  # MAV_COMP_ID
PERIOD_S = 2**32 * 1e-6  # of time_usec where it has 32 bits
FIRST_US, LAST_US = 946_684_800 * 10**6, 4_102_444_800 * 10**6  # 2000 to 2100: a stamp, rather than chance
LATE_S = 5.0  # a message whose time differs more from its arrival is of another start of the autopilot
AT_REST_S = 30 * 86400.0  # time_usec is the time since boot, or that since 1970


def is_telemetry(path: Path, head: bytes) -> bool:
    """Return whether a file begins with a stamp and a packet, or a simulator's stamp near 0."""
    if len(head) <= STAMP or head[STAMP] not in AROUND:
        return False
    stamp = int.from_bytes(head[:STAMP])
    return FIRST_US <= stamp <= LAST_US or stamp < AT_REST_S * 1e6


def read_telemetry(path: Path) -> FlightLog:
    """Read a telemetry log. Raises ValueError."""
    need_extra("pymavlink", f"{path}: {KIND}")
    from pymavlink.dialects.v20 import ardupilotmega

    data = read_limited(path, str(path), MOST_BYTES)
    codes = {each.msgname: code for code, each in ardupilotmega.mavlink_map.items()}
    fields = fields_of(TELEMETRY)
    wanted = {codes[name]: name for name in (*fields, "PARAM_VALUE", "STATUSTEXT") if name in codes}
    decoder = ardupilotmega.MAVLink(None)
    decoder.robust_parsing = False
    rows: dict[str, list[list[float]]] = defaultdict(list)
    parameters: dict[str, float] = {}
    events: list[tuple[float, str]] = []
    systems = Counter(system for _, _, system, _ in _packets(data, wanted))
    if not systems:
        raise ValueError(f"{path}: {KIND}: has no packet of an autopilot's motion")
    chosen, wrong = systems.most_common(1)[0][0], 0
    for stamp_s, code, system, packet in _packets(data, wanted):
        if system != chosen:
            continue
        try:
            message = decoder.decode(bytearray(packet))
        except ardupilotmega.MAVError:
            wrong += 1
            continue
        name = wanted[code]
        if name == "PARAM_VALUE":
            parameters[str(message.param_id)] = float(message.param_value)
        elif name == "STATUSTEXT":
            if len(events) < EVENTS_MAX:
                events.append((stamp_s, str(message.text)))
        elif not getattr(message, "port", 0):
            if len(rows[name]) >= MOST_ROWS:
                raise ValueError(f"{path}: more than {MOST_ROWS} rows of {name}: cut the log")
            rows[name].append([stamp_s, _own_s(message), *(float(getattr(message, each)) for each in fields[name])])
    tables = {name: np.array(table, np.float64) for name, table in rows.items()}
    attitude = tables.get("ATTITUDE", np.zeros((1, 2)))
    delay_s = float(np.median(attitude[:, 0] - attitude[:, 1]))  # how much later messages arrive than they state
    timed = {name: (_times_s(table, delay_s), table[:, 2:]) for name, table in tables.items()}
    moved = [(time_s - delay_s, text) for time_s, text in events]
    found = flight_of(path, KIND, TELEMETRY, timed, parameters, moved)
    notes = [f"{wrong} packets with a wrong check sum are left out"] if wrong else []
    notes += [f"system {chosen} of {len(systems)} is the vehicle"] if len(systems) > 1 else []
    return FlightLog(path, KIND, found.series, found.parameters, found.events, (*found.assumed, *notes))


def _packets(data: bytes, wanted: dict[int, str]) -> Iterator[tuple[float, int, int, bytes]]:
    """Yield arrival [s], message ID, system and bytes of an autopilot's packets; pass bytes that are no packet."""
    at = 0
    while at + STAMP + 8 <= len(data):
        magic = data[at + STAMP]
        stamp = struct.unpack_from(">Q", data, at)[0]
        if magic not in AROUND or not (FIRST_US <= stamp <= LAST_US or stamp < AT_REST_S * 1e6):
            found = MAGIC.search(data, at + STAMP + 1)
            if found is None:
                return
            at = found.start() - STAMP
            continue
        begin = at + STAMP
        size = AROUND[magic] + data[begin + 1] + (SIGNATURE if magic == V2 and data[begin + 2] & SIGNED else 0)
        packet = data[begin : begin + size]
        if len(packet) < size:
            return
        if magic == V1:
            code, system, component = packet[5], packet[3], packet[4]
        else:
            code, system, component = int.from_bytes(packet[7:10], "little"), packet[5], packet[6]
        if component == AUTOPILOT and code in wanted:
            yield 1e-6 * stamp, code, system, packet
        at = begin + size


def _own_s(message: Any) -> float:
    """Return the time that a message states [s], NaN if none."""
    if hasattr(message, "time_boot_ms"):
        return 1e-3 * float(message.time_boot_ms)
    return 1e-6 * float(message.time_usec) if hasattr(message, "time_usec") else np.nan


def _times_s(table: Floats, delay_s: float) -> Floats:
    """Return the times that messages state, as time since boot, or else those of their arrival."""
    arrived_s, own_s = table[:, 0] - delay_s, table[:, 1]
    own_s = np.where(own_s > AT_REST_S, own_s - delay_s, own_s)
    own_s = own_s + PERIOD_S * np.round((arrived_s - own_s) / PERIOD_S)
    return np.where(np.abs(own_s - arrived_s) < LATE_S, own_s, arrived_s)  # also false for NaN
