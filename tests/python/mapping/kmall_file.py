"""A small survey in .kmall, as tests and fuzzers read it."""

from __future__ import annotations

from typing import Any

import numpy as np

from uwsim.mapping.files import kmall_layout as layout
from uwsim.mapping.files.kmall_read import SIMULATOR, _turned


def kmall(revision: str = "I") -> bytes:
    """Return a survey in .kmall by a simulator: two pings of five beams, 10 m above a level bed.

    revision: F, or I, in which a ping has 8 bytes more and a sector 12.
    """
    more = {"F": (0, 0), "I": (8, 12)}[revision]
    place = "X=0.2000;Y=0.0000;Z=0.1000;R=0.0000;P=0.0000;H=0.0000"
    text = (
        f"OSCV:Empty,EMXV:EM2040,\nTRAI_TX1:N=0;{place};S=1.0,TRAI_RX1:N=0;V=0;W=0;{place};G=0.00,"
        "ATTI_1:X=0.000;Y=0.000;Z=0.000;R=0.000;P=0.000;H=0.000;D=0.000;M=Rotation;U=ACTIVE,\n"
    ).encode()
    levels = np.zeros(2, layout.LEVEL)
    levels["depth_m"], levels["speed_m_s"] = (0.0, 20.0), 1500.0
    angles = np.linspace(-0.9, 0.9, 5)
    transducer = (level := _turned(np.array([[0.01, -0.02, 0.0]]))[0]) @ [0.2, 0.0, 0.1]
    axes = np.column_stack([0.0 * angles, -np.sin(angles), np.cos(angles)]) @ level.T
    beams = np.zeros(5, layout.SOUNDING)
    beams["index"], beams["method"], beams["angle_deg"], beams["time_s"] = (
        np.arange(5), 1, np.degrees(angles), 20.0 / 1500.0 / axes[:, 2],
    )  # fmt: skip
    beams["x_m"], beams["y_m"], beams["z_m"] = transducer[:, None] + 10.0 * axes.T / axes[:, 2]
    beams["quality_percent"], beams["vertical_deviation_m"], beams["horizontal_deviation_m"] = 2.0, 0.02, 0.02
    found = []

    def made(kind: np.dtype[Any], **values: Any) -> bytes:
        record = np.zeros(1, kind)
        for name, value in values.items():
            record[name] = value
        return record.tobytes()

    def put(kind: str, ns: int, *parts: bytes, version: int = 1) -> None:
        size = layout.HEADER.itemsize + len(b"".join(parts)) + 4
        head = made(layout.HEADER, bytes=size, type=kind, version=version, sounder=2040, s=1_577_836_800, ns=ns)
        found.append(head + b"".join(parts) + size.to_bytes(4, "little"))

    put("#IIP", 0, made(layout.TEXT, bytes=layout.TEXT.itemsize + len(text)), text, version=0)
    put("#SVP", 0, made(layout.PROFILE, bytes=layout.PROFILE.itemsize, levels=2, format="S00"), levels.tobytes())
    for ns in (0, 10**8):
        at = {"s": 1_577_836_800, "ns": ns, "latitude_deg": 43.1, "longitude_deg": 5.9}
        put("#SPO", ns, made(layout.SENSOR, bytes=layout.SENSOR.itemsize, status=1),
            made(layout.POSITION, **at, speed_m_s=0.5, course_deg=90.0), version=0)  # fmt: skip
        attitudes = layout.ATTITUDES.itemsize, layout.ATTITUDE.itemsize
        turn = {name: np.degrees(rad) for name, rad in (("roll_deg", 0.01), ("pitch_deg", -0.02), ("heading_deg", 1.0))}
        put("#SKM", ns,
            made(layout.ATTITUDES, bytes=attitudes[0], status=1, input=1, samples=1, bytes_per_sample=attitudes[1],
                 contents=15),
            made(layout.ATTITUDE, type="#KMB", bytes=attitudes[1] - 12, version=1, **at, **turn))  # fmt: skip
        ping, sector = layout.PING.itemsize + more[0], layout.SECTOR.itemsize + more[1]
        put("#MRZ", ns, made(layout.PARTITION, of=1, number=1),
            made(layout.BODY, bytes=layout.BODY.itemsize, ping=len(found), fans=1, swaths=1, receivers=1),
            made(layout.PING, bytes=ping, detection_mode=SIMULATOR, sectors=1, bytes_per_sector=sector,
                 heading_deg=np.degrees(1.0), sound_speed_m_s=1500.0, transducer_depth_m=2.0 + transducer[2],
                 water_level_m=-2.0, latitude_deg=43.1, longitude_deg=5.9), bytes(more[0]),
            made(layout.SECTOR), bytes(more[1]),
            made(layout.RECEIVER, bytes=layout.RECEIVER.itemsize, soundings=5, valid=5,
                 bytes_per_sounding=layout.SOUNDING.itemsize), beams.tobytes(), version=3)  # fmt: skip
    return b"".join(found)
