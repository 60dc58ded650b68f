"""PCD files, in version 0.7 of PCL's format: written as binary; read as text, binary or compressed binary.

PCL's reader is not used: it is in pcl_io, which loads 73 libraries and does not validate its input.
"""

from __future__ import annotations

import io
import re
import struct

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping.files.cloud_files import rounded
from uwsim.mapping.files.formats import CloudFormat, begins

HEADER = """\
# .PCD v0.7 - Point Cloud Data file format
VERSION 0.7
FIELDS x y z
SIZE {size} {size} {size}
TYPE F F F
COUNT 1 1 1
WIDTH {n}
HEIGHT 1
VIEWPOINT 0 0 0 1 0 0 0
POINTS {n}
DATA binary
"""
KINDS = {"F": {4, 8}, "I": {1, 2, 4, 8}, "U": {1, 2, 4, 8}}
MAX_HEADER = 65_536
NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d{1,2})?")


def encode(points_m: NDArray[np.floating]) -> bytes:
    """Encode points as a binary PCD file with float32 x, y, z, or float64 far from zero."""
    stored = rounded(points_m)
    return HEADER.format(n=len(stored), size=stored.itemsize).encode("ascii") + stored.tobytes()


def decode(data: bytes) -> NDArray[np.float64]:
    """Return the points in a PCD file, from its fields x, y and z; other fields are skipped."""
    header, body = _split_header(data)
    layout = _layout(header)
    count = _whole(header, "POINTS") if "POINTS" in header else _whole(header, "WIDTH") * _whole(header, "HEIGHT")
    encoding = " ".join(header["DATA"])
    if encoding == "ascii":
        return _from_text(body, layout, count)
    if encoding == "binary":
        rows = np.frombuffer(_exactly(body, count * layout.itemsize), layout)
        return _xyz([rows[axis] for axis in "xyz"])
    if encoding == "binary_compressed":
        return _from_columns(_decompressed(body, count * layout.itemsize), layout, count)
    raise ValueError(f"DATA {encoding}: must be ascii, binary or binary_compressed")


def seen_from(data: bytes) -> NDArray[np.float64] | None:
    """Return the place of VIEWPOINT, in the points' axes as PCL's estimation of normals takes it.

    None for that of a writer that knows none, 0 0 0. Its orientation is not used. Raises ValueError if it is not seven
    numbers.
    """
    words = _split_header(data)[0].get("VIEWPOINT", ["0"] * 7)
    if len(words) != 7 or not all(NUMBER.fullmatch(word) for word in words):
        raise ValueError(f"VIEWPOINT {' '.join(words)[:60]}: must be seven numbers")
    place = np.array(words[:3], np.float64)
    return place if place.any() else None


def _split_header(data: bytes) -> tuple[dict[str, list[str]], bytes]:
    """Return the header, as a dict from the first word of each line to the other words, and the bytes after it."""
    end = re.search(rb"^DATA[^\n]*\n", data[:MAX_HEADER], flags=re.MULTILINE)
    if end is None:
        raise ValueError("no header that ends in a DATA line")
    lines = (line.split() for line in data[: end.end()].decode("ascii").splitlines() if not line.startswith("#"))
    header = {words[0]: words[1:] for words in lines if words}
    for key in ("FIELDS", "SIZE", "TYPE"):
        if key not in header:
            raise ValueError(f"no {key} in the header")
    return header, data[end.end() :]


def _layout(header: dict[str, list[str]]) -> np.dtype[np.void]:
    """Return the memory layout of the fields of a point."""
    fields, sizes, kinds = header["FIELDS"], header["SIZE"], header["TYPE"]
    counts = header.get("COUNT", ["1"] * len(fields))
    if not len(fields) == len(sizes) == len(kinds) == len(counts):
        raise ValueError("FIELDS, SIZE, TYPE and COUNT differ in length")
    names, formats = [], []
    for index, (name, size, kind, count) in enumerate(zip(fields, sizes, kinds, counts, strict=True)):
        if not (size.isdigit() and count.isdigit() and int(size) in KINDS.get(kind, ())):
            raise ValueError(f"field {name}: TYPE {kind} SIZE {size} COUNT {count} is not valid in PCD")
        if name in ("x", "y", "z") and count != "1":
            raise ValueError(f"field {name}: COUNT {count}, expected 1")
        names.append(name if name in ("x", "y", "z") else f"{index}")  # all padding fields are named _
        formats.append(f"({count},)<{kind.lower()}{size}" if count != "1" else f"<{kind.lower()}{size}")
    if sorted(set(names) & {"x", "y", "z"}) != ["x", "y", "z"]:
        raise ValueError(f"FIELDS {' '.join(fields)}: expected x, y and z among them")
    return np.dtype({"names": names, "formats": formats})


def _whole(header: dict[str, list[str]], key: str) -> int:
    words = header.get(key, [])
    if len(words) != 1 or not words[0].isdigit():
        raise ValueError(f"{key} {' '.join(words)}: expected a whole number")
    return int(words[0])


def _exactly(body: bytes, size: int) -> bytes:
    """Return the first `size` bytes; PCL's writer may append more. Raises ValueError if there are fewer."""
    if len(body) < size:
        raise ValueError(f"{len(body)} bytes of points, expected {size}")
    return body[:size]


def _from_text(body: bytes, layout: np.dtype[np.void], count: int) -> NDArray[np.float64]:
    """Parse points from text; the first column of a field is the sum of the counts of the preceding fields."""
    names = layout.names or ()
    widths = [int(np.prod(layout[name].shape, dtype=int)) for name in names]
    first = dict(zip(names, np.cumsum([0, *widths[:-1]]).tolist(), strict=True))
    text = io.StringIO(body.decode("ascii"))
    columns = tuple(first[axis] for axis in "xyz")
    points = np.loadtxt(text, np.float64, usecols=columns, ndmin=2, max_rows=count + 1) if count else np.empty((0, 3))
    if len(points) != count:
        raise ValueError(f"{len(points)} lines of points, expected {count}")
    # Round to the field's type first: 0.1 written as float32 differs from 0.1 in float64.
    return _xyz([points[:, k].astype(layout[axis]) for k, axis in enumerate("xyz")])


def _from_columns(columns: bytes, layout: np.dtype[np.void], count: int) -> NDArray[np.float64]:
    """Parse points from the layout of compressed files: all values of the first field, then all of the next."""
    found, offset = {}, 0
    for name in layout.names or ():
        found[name] = columns[offset : offset + layout[name].itemsize * count]
        offset += layout[name].itemsize * count
    return _xyz([np.frombuffer(found[axis], layout[axis]) for axis in "xyz"])


def _decompressed(body: bytes, size: int) -> bytes:
    """Decompress LZF data: compressed size, plain size, then runs of literals and back references."""
    if len(body) < 8:
        raise ValueError("file ends before its compressed points")
    compressed_size, plain_size = struct.unpack_from("<II", body)
    if plain_size != size:
        raise ValueError(f"decompresses to {plain_size} bytes, expected {size}")
    compressed, plain, at = _exactly(body[8:], compressed_size), bytearray(), 0
    while at < compressed_size and len(plain) <= size:
        control = compressed[at]
        at += 1
        if control < 32:  # a run of control + 1 literals
            plain += compressed[at : at + control + 1]
            at += control + 1
            continue
        length = control >> 5
        if length == 7:
            length += compressed[at]
            at += 1
        start = len(plain) - ((control & 31) << 8) - compressed[at] - 1
        at += 1
        if start < 0:
            raise ValueError("a back reference points before the first byte")
        length += 2
        copied = plain[start : start + length]
        plain += (copied * (length // len(copied) + 1))[:length]  # the copy may overlap its source
    if len(plain) != size or at != compressed_size:
        raise ValueError(f"decompresses to {len(plain)} bytes, expected {size}")
    return bytes(plain)


def _xyz(columns: list[NDArray[np.generic]]) -> NDArray[np.float64]:
    return np.stack([column.astype(np.float64) for column in columns], axis=1)


BEGIN = begins(rb"(#[^\n]*\n)*(VERSION|FIELDS) ")
PCD = CloudFormat("PCD file", BEGIN, decode, encode=encode, text_mark=b"DATA ascii", seen_from=seen_from)
