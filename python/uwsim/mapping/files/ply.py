"""PLY files: x, y and z of the `vertex` element are read; other properties and elements are skipped.

No library is used: plyfile's licence (GPL) would extend to all of uwsim, and trimesh, which we use for meshes, rejects
PCL's output.
"""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping.files.cloud_files import rounded
from uwsim.mapping.files.formats import CloudFormat, begins

HEADER = """\
ply
format binary_little_endian 1.0
element vertex {n}
property {kind} x
property {kind} y
property {kind} z
end_header
"""
MAX_HEADER = 65_536
BYTE_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
TYPES = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"},
    **{"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"},
    **{"float": "f4", "double": "f8", "float32": "f4", "float64": "f8"},
}


def encode(points_m: NDArray[np.floating]) -> bytes:
    """Encode points as binary little-endian float32 x, y, z, as read by PCL, MeshLab and CloudCompare.

    Far from zero as float64, which these read, too.
    """
    stored = rounded(points_m)
    kind = "float" if stored.dtype == np.float32 else "double"
    return HEADER.format(n=len(stored), kind=kind).encode() + stored.tobytes()


def decode(data: bytes) -> NDArray[np.float64]:
    """Return the points in a PLY file, either text or binary in either byte order."""
    parts = re.split(rb"^end_header *\r?\n", data[:MAX_HEADER], maxsplit=1, flags=re.MULTILINE)
    if len(parts) != 2 or not data.startswith(b"ply"):
        raise ValueError("no header that ends in end_header")
    body = data[len(data[:MAX_HEADER]) - len(parts[1]) :]
    lines = [line.split() for line in parts[0].decode("ascii", errors="replace").splitlines()]
    order = next((BYTE_ORDERS.get(line[1]) for line in lines if line[0:1] == ["format"] and len(line) > 1), None)
    if order is None:
        raise ValueError(f"no format among {', '.join(BYTE_ORDERS)}")
    before, count, layout = _vertices(lines, order)
    if order == "":
        text = body.decode("ascii").splitlines()[before : before + count]
        columns = [(layout.names or ()).index(axis) for axis in "xyz"]
        points = np.loadtxt(text, np.float64, usecols=columns, ndmin=2) if text else np.empty((0, 3))
        if len(points) != count:
            raise ValueError(f"{len(points)} lines of points, expected {count}")
        # Round to the property's type first: 0.1 written as float32 differs from 0.1 in float64.
        return np.stack([points[:, k].astype(layout[axis]).astype(np.float64) for k, axis in enumerate("xyz")], axis=1)
    if len(body) < before + count * layout.itemsize:
        raise ValueError(f"{len(body)} bytes of points, expected {before + count * layout.itemsize}")
    rows = np.frombuffer(body, layout, count, before)
    return np.stack([rows[axis].astype(np.float64) for axis in "xyz"], axis=1)


def _vertices(lines: list[list[str]], order: str) -> tuple[int, int, np.dtype[np.void]]:
    """Return the size of the data before the vertices, in bytes or lines; the vertex count; and the vertex layout."""
    before, at = 0, next((k for k, line in enumerate(lines) if line[:1] == ["element"]), len(lines))
    while at < len(lines):
        if len(lines[at]) != 3 or not lines[at][2].isdigit():
            raise ValueError(f"{' '.join(lines[at])}: expected element, a name and a number")
        name, count = lines[at][1], int(lines[at][2])
        end = next((k for k in range(at + 1, len(lines)) if lines[k][:1] == ["element"]), len(lines))
        layout = _layout([line for line in lines[at + 1 : end] if line[:1] == ["property"]], order, name)
        if name == "vertex":
            missing = {"x", "y", "z"} - set(layout.names or ())
            if missing:
                raise ValueError(f"vertices have no {', '.join(sorted(missing))}")
            return before, count, layout
        before += count * layout.itemsize if order else count
        at = end
    raise ValueError("no vertices")


def _layout(properties: list[list[str]], order: str, name: str) -> np.dtype[np.void]:
    for line in properties:
        if len(line) != 3 or line[1] not in TYPES:
            raise ValueError(f"{' '.join(line)}: not a property that {name} may have in a cloud")
    return np.dtype([(line[2], f"{order or '<'}{TYPES[line[1]]}") for line in properties])


PLY = CloudFormat("PLY file", begins(rb"ply\r?\n"), decode, encode=encode, text_mark=b"format ascii")
