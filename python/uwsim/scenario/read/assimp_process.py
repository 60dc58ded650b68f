"""Mesh import by assimp or OpenCASCADE: the script of a contained process; to start quickly, it imports no uwsim."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

LINES = re.compile(rb"<(lines|linestrips)\b[^>]*?(/>|>.*?</\1\s*>)", re.DOTALL)
"""Lines in a Collada file, which SketchUp writes beside the triangles: assimp_py 1.1 refuses a file that has any."""

NAMED = re.compile("^Assimp error loading '[^']*': ")
"""The start of assimp_py's messages: the caller names the file itself, which is another for Collada."""

NO_MATERIAL = "DefaultMaterial"
"""assimp's name of the material of a mesh that has none."""
UNKNOWN = np.full(3, np.nan)


Array = np.ndarray[Any, Any]


def read_parts(path: str) -> tuple[list[str], list[Array]]:
    """Return the node's name of each part of a file; and its points, triangles, transform and colour.

    Points (n, 3) float64 are in the node's frame; triangles: (m, 3); the transform (4, 4) is that to the file's;
    colour: its material's diffuse (3,), nan without one.
    """
    if path.lower().endswith((".step", ".stp")):
        from uwsim.base.whole_trimesh import trimesh

        try:
            mesh = trimesh.load_scene(path, process=False).to_mesh()  # by cascadio
        except FileNotFoundError:  # for the file into which it writes triangles
            raise ValueError("OpenCASCADE finds no shape in it") from None
        return [""], [np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64), np.eye(4), UNKNOWN]
    import assimp_py

    flags = (
        assimp_py.Process_Triangulate
        | assimp_py.Process_SortByPType  # separates lines and points from triangles
        | assimp_py.Process_JoinIdenticalVertices
        | assimp_py.Process_GlobalScale  # converts the file's unit to metres
    )
    if Path(path).suffix.lower() == ".dae":
        with tempfile.NamedTemporaryFile(suffix=".dae") as plain:
            plain.write(LINES.sub(b"", Path(path).read_bytes()))
            plain.flush()
            scene = assimp_py.import_file(plain.name, flags)
    else:
        scene = assimp_py.import_file(path, flags)
    names: list[str] = []
    parts: list[Array] = []
    colours = [
        UNKNOWN if each.get("NAME") == NO_MATERIAL else np.asarray(each.get("COLOR_DIFFUSE", UNKNOWN), np.float64)[:3]
        for each in scene.materials
    ]

    def gather(node: Any, file_from_parent: Array) -> None:
        file_from_node = file_from_parent @ np.asarray(node.transformation, np.float64)
        for index in node.mesh_indices:
            mesh = scene.meshes[index]
            if mesh.num_indices != 3 * mesh.num_faces:
                continue
            points = np.asarray(mesh.vertices, np.float64).reshape(-1, 3)
            triangles = np.asarray(mesh.indices, np.int64).reshape(-1, 3)
            names.append(node.name)
            parts.extend((points, triangles, file_from_node, colours[mesh.material_index]))
        for child in node.children:
            gather(child, file_from_node)

    gather(scene.root_node, np.eye(4))
    return names, parts


def read(path: str) -> dict[str, Any]:
    """Return `names` of the nodes, and the arrays of their parts, one after the other. Raises ValueError."""
    try:
        names, parts = read_parts(path)
    except Exception as error:  # they raise errors of any type for malformed files
        raise ValueError(NAMED.sub("", " ".join(str(error).split())) or type(error).__name__) from None
    return {"names": np.array(names, str), **{f"arr_{k}": part for k, part in enumerate(parts)}}
