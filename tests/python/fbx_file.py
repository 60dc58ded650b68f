"""Writes binary FBX 7.4 files as Blender exports them: arrays deflated, in centimetres, turned by the node to y up."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

END = bytes(13)  # of a list of nodes
BLENDER = {"UpAxis": 1, "UpAxisSign": 1, "FrontAxis": 2, "FrontAxisSign": 1, "CoordAxis": 0, "CoordAxisSign": 1}


def write_blender_fbx(
    path: Path, name: str, points_m: NDArray[np.float64], quads: NDArray[np.int32], diffuse: tuple[float, ...] = ()
) -> Path:
    """Write a mesh of one node. points_m: (n, 3), z up, as in Blender; quads: (m, 4). diffuse: its colour."""
    corners = quads.copy()
    corners[:, 3] = -corners[:, 3] - 1  # marks a face's end
    axes = [_node("P", key, "int", "Integer", "", np.int32(value)) for key, value in BLENDER.items()]
    unit = _node("P", "UnitScaleFactor", "double", "Number", "", 1.0)
    turn = [
        _node("P", f"Lcl {key}", f"Lcl {key}", "", "A", *values)
        for key, values in (("Rotation", (-90.0, 0.0, 0.0)), ("Scaling", (100.0, 100.0, 100.0)))
    ]
    mesh = [_node("Vertices", points_m.ravel()), _node("PolygonVertexIndex", corners.ravel())]
    if diffuse:
        all_of_it = (_node("MappingInformationType", "AllSame"), _node("ReferenceInformationType", "IndexToDirect"))
        used = _node("Materials", np.zeros(1, np.int32))
        mesh.append(_node("LayerElementMaterial", np.int32(0), nodes=[*all_of_it, used]))
        layer = (_node("Type", "LayerElementMaterial"), _node("TypedIndex", np.int32(0)))
        mesh.append(_node("Layer", np.int32(0), nodes=[_node("LayerElement", nodes=layer)]))
    geometry = _node("Geometry", 1000, f"{name}\0\1Geometry", "Mesh", nodes=mesh)
    model = _node("Model", 2000, f"{name}\0\1Model", "Mesh", nodes=[_node("Properties70", nodes=turn)])
    links = [_node("C", "OO", 2000, 0), _node("C", "OO", 1000, 2000)]
    objects = [geometry, model]
    if diffuse:
        colour = _node("P", "DiffuseColor", "Color", "", "A", *diffuse)
        objects.append(_node("Material", 3000, "Own\0\1Material", "", nodes=[_node("Properties70", nodes=[colour])]))
        links.append(_node("C", "OO", 3000, 2000))
    nodes = [
        _node("FBXHeaderExtension", nodes=[_node("FBXVersion", np.int32(7400))]),
        _node("GlobalSettings", nodes=[_node("Version", np.int32(1000)), _node("Properties70", nodes=[*axes, unit])]),
        _node("Objects", nodes=objects),
        _node("Connections", nodes=links),
    ]
    content = b"Kaydara FBX Binary  \0\x1a\0" + struct.pack("<I", 7400)
    for node in nodes:
        content += node(len(content))
    path.write_bytes(content + END)
    return path


def _node(name: str, *values, nodes=()):
    """Return the function from a node's offset in the file to its bytes."""

    def written(at: int) -> bytes:
        properties = b"".join(map(_property, values))
        head = len(name) + 13
        content = b""
        for node in nodes:
            content += node(at + head + len(properties) + len(content))
        end = at + head + len(properties) + len(content) + (len(END) if nodes else 0)
        start = struct.pack("<IIIB", end, len(values), len(properties), len(name)) + name.encode()
        return start + properties + content + (END if nodes else b"")

    return written


def _property(value) -> bytes:
    if isinstance(value, str):
        return b"S" + struct.pack("<I", len(value)) + value.encode()
    if isinstance(value, np.ndarray):
        kind, packed = {"float64": b"d", "int32": b"i"}[str(value.dtype)], zlib.compress(value.tobytes())
        return kind + struct.pack("<III", value.size, 1, len(packed)) + packed
    if isinstance(value, np.int32):
        return b"I" + struct.pack("<i", value)
    return b"D" + struct.pack("<d", value) if isinstance(value, float) else b"L" + struct.pack("<q", value)
