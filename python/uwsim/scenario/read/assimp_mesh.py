"""Mesh import with assimp and OpenCASCADE, in a contained process: they read much but may crash or hang."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim.base.extras import need_extra
from uwsim.scenario.read.contained import run_contained

READER = Path(__file__).with_name("assimp_process.py")
CPU_S_PER_BYTE, STEP_CPU_S_PER_BYTE = 1e-6, 1e-5
STEP_SUFFIXES = (".step", ".stp")
"""Exact surfaces, which become triangles while they are read."""


class NodeMesh(NamedTuple):
    """A mesh of a file's node: points (n, 3) in the node's frame, triangles (m, 3), the transform to the file's.

    colour: its material's diffuse colour (3,), as the file has it, nan without one.
    """

    name: str
    points: NDArray[np.float64]
    triangles: NDArray[Any]
    file_from_node: NDArray[np.float64]
    colour: NDArray[np.float64] = np.full(3, np.nan)

    def placed(self, to_other: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[Any]]:
        """Return points and triangles after a transform (4, 4), with the outside of a mirrored mesh outside."""
        mirrored = np.linalg.det(to_other[:3, :3]) < 0
        triangles = self.triangles[:, ::-1] if mirrored else self.triangles
        return self.points @ to_other[:3, :3].T + to_other[:3, 3], triangles


def read_by_assimp(path: Path) -> list[tuple[NDArray[np.float64], NDArray[Any]]]:
    """Return points (n, 3) and triangles (m, 3) of each part. Raises ValueError with the reason, or ImportError."""
    return [mesh.placed(mesh.file_from_node) for mesh in nodes_by_assimp(path)]


def nodes_by_assimp(path: Path) -> list[NodeMesh]:
    """Return the meshes of all nodes in a file. Raises ValueError with the reason, or ImportError."""
    step = path.suffix.lower() in STEP_SUFFIXES
    need_extra("cascadio" if step else "assimp_py", "this format")
    reader, per_byte = ("OpenCASCADE", STEP_CPU_S_PER_BYTE) if step else ("assimp", CPU_S_PER_BYTE)
    arrays = run_contained(READER, reader, str(path), reads=[path], cpu_s_per_byte=per_byte)
    parts = [arrays[name] for name in arrays if name != "names"]
    return [NodeMesh(name, *parts[4 * k : 4 * k + 4]) for k, name in enumerate(arrays["names"].tolist())]
