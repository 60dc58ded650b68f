"""LAS files, using laspy: version 1.2, point format 0, which every LAS reader supports; with a place on Earth, 1.4."""

from __future__ import annotations

import io
import struct
from datetime import date

import numpy as np
from numpy.typing import NDArray

from uwsim.base.extras import need_extra
from uwsim.mapping.files.formats import CloudFormat, begins
from uwsim.mapping.files.georeference import Georeference

SCALE_M = 0.001
NO_DATE = date(1970, 1, 1)  # a fixed date, so that the same points give the same bytes on any day


def encode(points_m: NDArray[np.floating], *, compresses: bool = False) -> bytes:
    """Return a LAS file of the points, in whole millimetres from a corner of the cloud.

    Raises ValueError if the cloud extends over more than 2,147 km.
    """
    return _encoded(np.asarray(points_m, np.float64), None, compresses)


def encode_at(points_m: NDArray[np.floating], place: Georeference, *, compresses: bool = False) -> bytes:
    """Return a LAS file of the points in the place's coordinate system, whose WKT it has. Raises ValueError."""
    assert place.crs is not None
    points = np.array(points_m, np.float64)
    points[:, :2] = points[:, :2] * place.units_per_m + place.origin
    return _encoded(points, place.crs.to_wkt(), compresses)


def _encoded(points: NDArray[np.float64], wkt: str | None, compresses: bool) -> bytes:
    if compresses:
        need_extra("lazrs", "a LAZ file")
    import laspy
    from laspy.vlrs.known import WktCoordinateSystemVlr

    header = laspy.LasHeader(point_format=0, version="1.2")
    if wkt is not None:  # LAS 1.4 requires WKT for formats from 6 on
        header = laspy.LasHeader(point_format=6, version="1.4")
        header.vlrs.append(WktCoordinateSystemVlr(wkt))
        header.global_encoding.wkt = True
    header.scales = np.full(3, SCALE_M)
    header.offsets = np.floor(points.min(axis=0))
    reach_m = float((points - header.offsets).max())
    if reach_m / SCALE_M > np.iinfo(np.int32).max:
        raise ValueError(f"points_m: {reach_m:g} m across: LAS holds at most {np.iinfo(np.int32).max * SCALE_M:g} m")
    header.creation_date = NO_DATE
    header.system_identifier, header.generating_software = "SIMULATION", "uwsim"
    las = laspy.LasData(header)
    las.x, las.y, las.z = points.T
    file = io.BytesIO()
    las.write(file, do_compress=compresses, laz_backend=laspy.LazBackend.Lazrs)
    return file.getvalue()


def decode(data: bytes) -> NDArray[np.float64]:
    """Return the points of an uncompressed LAS file of any version."""
    import laspy

    _require_records(data)
    header = laspy.LasHeader.read_from(io.BytesIO(data))
    expected = header.offset_to_point_data + header.point_count * header.point_format.size
    if expected > len(data):
        raise ValueError(f"{len(data)} bytes, expected {expected} for its {header.point_count} points")
    las = laspy.read(io.BytesIO(data))
    return np.stack([np.asarray(axis, np.float64) for axis in (las.x, las.y, las.z)], axis=1).reshape(-1, 3)


def _require_records(data: bytes) -> None:
    """Raise ValueError if the header lists more variable-length records than fit: laspy would try to read them all.

    Byte offsets, as in laspy: 94 for the header size and the start of the points, 100 for the number of records, 243
    for the number of extended records.
    """
    if not data.startswith(b"LASF") or len(data) < 227:
        raise ValueError("no LAS header")
    header_size, points_at, records = struct.unpack_from("<HII", data, 94)
    extended = struct.unpack_from("<I", data, 243)[0] if data[25] >= 4 and len(data) >= 247 else 0
    if header_size + 54 * records > points_at or points_at > len(data) or 60 * extended > len(data):
        raise ValueError(f"{len(data)} bytes do not hold the {records + extended} records of the header")


LAS = CloudFormat("LAS file", begins(rb"LASF.{100}[\0-\x7f]"), decode, encode=encode, encode_at=encode_at)
