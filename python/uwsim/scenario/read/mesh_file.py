"""Reads triangle meshes from files such as STL, OBJ, glTF, FBX and STEP, as exported by Blender and CAD programs."""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import Any, Literal, cast

import numpy as np
from numpy.typing import NDArray

from uwsim.base.caught_warnings import warn_if_cut_short
from uwsim.base.extras import explained
from uwsim.base.texts.text_file import require_regular
from uwsim.scenario.read.assimp_mesh import STEP_SUFFIXES, read_by_assimp
from uwsim.scenario.read.disk_cache import cached_arrays
from uwsim.scenario.read.errors import ScenarioError

MAX_HEADER = 65_536
TEXT_SUFFIXES = (".obj", ".off", ".ply")
PLY_HEADER = re.compile(
    rb"ply[ \t]*\r?\nformat[ \t]+(ascii|binary_\w+)[^\n]*\n"
    rb"((?:(?:comment|obj_info|element|property)\b[^\n]*\n)*)end_header\b",
    re.IGNORECASE,
)
PLY_ELEMENT = re.compile(rb"^element[ \t]+(\w+)[ \t]+(\d+)", re.IGNORECASE | re.MULTILINE)
STL_SOLID, STL_END = re.compile(rb"\s*solid\b.*\n"), re.compile(rb"\s*endsolid\b.*")
STL_FACET = re.compile(
    rb"\s*facet[ \t]+normal(?:[ \t]+\S+){3}\s+outer[ \t]+loop\s"
    rb"(?:\s*vertex(?:[ \t]+\S+){3}[ \t\r]*\n){3}\s*endloop\s+endfacet\b"
)


def require_whole(name: str, suffix: str, content: bytes, triangles: int) -> None:
    """Raise ValueError if triangles are missing; warn if the last line of a text file has no line break.

    name: the file, for messages. suffix: one of TEXT_SUFFIXES; the glTF reader has its own check.
    """
    head = content[:MAX_HEADER]
    if suffix == ".off" and re.search(rb"[^\t\n\r -~]", re.sub(rb"#[^\n]*", b"", content)):
        raise ValueError("holds other characters than numbers")  # trimesh would guess an encoding from the whole file
    if suffix == ".off" and re.match(rb"(?:\s|#[^\n]*\n)*C?OFF\b", content) is None:
        raise ValueError("does not begin with OFF")  # trimesh would search for it in the whole file
    is_binary, faces = _ply_header(head) if suffix == ".ply" else (False, _announced_faces(suffix, head))
    if triangles < faces:
        raise ValueError(f"announces {faces} faces, but only {triangles} triangles follow: is the file cut short?")
    if not is_binary:
        warn_if_cut_short(name, content)


def require_whole_stl(name: str, text: bytes) -> None:
    """Raise ValueError unless a text STL consists entirely of solids made of facets; warn like require_whole."""
    warn_if_cut_short(name, text)  # another solid may be missing
    text, at = text.lower(), 0
    while begins := STL_SOLID.match(text, at):
        at = begins.end()
        while facet := STL_FACET.match(text, at):
            at = facet.end()
        if (ends := STL_END.match(text, at)) is None:
            break
        at = ends.end()
    rest = text[at:].lstrip()
    if b"endsolid" in rest or (rest and not begins):
        line = 1 + text.count(b"\n", 0, len(text) - len(rest))
        raise ValueError(f"line {line}: expected {'a facet with three vertices' if begins else 'solid'}")
    if begins or not at:
        raise ValueError("breaks off before its endsolid")


def _ply_header(head: bytes) -> tuple[bool, int]:
    """Return, from a PLY header, whether the file is binary and the number of faces declared. Raises ValueError.

    trimesh ignores unknown lines, and uses the last of several elements with the same name.
    """
    header = PLY_HEADER.match(head)
    if header is None:
        raise ValueError("its header is not that of a PLY file: format, comments, elements and properties")
    elements = PLY_ELEMENT.findall(header[2])
    counts = {name.lower(): int(count) for name, count in elements}
    if len(counts) < len(elements):
        raise ValueError("names one element twice")
    return header[1].lower().startswith(b"binary"), counts.get(b"face", 0)


def _announced_faces(suffix: str, head: bytes) -> int:
    """Return the number of faces declared in a header, or 0 if none are declared."""
    words = re.sub(rb"#[^\n]*", b"", head).split(maxsplit=3) if suffix == ".off" else []
    return int(words[2]) if len(words) > 2 and words[2].isdigit() else 0


Vertices = NDArray[np.float64]
Triangles = NDArray[np.uint32]
Forward = Literal["x", "-x", "y", "-y"]
Up = Literal["x", "-x", "y", "-y", "z", "-z"]

MAX_BYTES = 500_000_000
MAX_TRIANGLES = 5_000_000
TRIMESH_SUFFIXES = (".stl", ".ply", ".obj", ".off", ".glb", ".gltf")
MAX_REACH_M = 1e5
Y_UP_SUFFIXES = (".glb", ".gltf")
CACHED_SUFFIXES = (".obj", ".stl", ".ply", ".off", ".glb")
"""Formats that contain the whole mesh in one file, so its bytes can be a cache key; but see `_is_whole`."""

TURNS_UP: dict[Up, list[list[float]]] = {
    "x": [[0, 0, -1], [0, 1, 0], [1, 0, 0]],
    "-x": [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],
    "y": [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
    "-y": [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
    "z": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "-z": [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
}
"""Rotations about x or y that map an axis to z. With y up, as in glTF, z points towards the viewer, and becomes -y."""


def load_mesh(
    path: str | Path, scale: float = 1.0, up: Up | None = None, forward: Forward = "x"
) -> tuple[Vertices, Triangles]:
    """Return all triangles of a file, with node transforms applied.

    Returns vertices (n, 3) float64 in metres, and triangles (m, 3) uint32. trimesh reads STL, PLY, OBJ, OFF and glTF;
    OpenCASCADE reads STEP and assimp all other formats, mainly FBX. Both convert the file's unit to metres.

    scale: metres per unit of the file; for FBX an additional factor.

    up: the file's axis that becomes z. The default is y for glTF, as its specification requires, the declared axis for
    FBX and Collada, and z for all others; Blender's OBJ export with its default axes therefore needs up="y". For FBX
    and Collada, the axes are those after the conversion to y up.

    forward: the direction, seen with z up, that becomes x.
    """
    path = Path(path)
    _require_readable(path)
    suffix = path.suffix.lower()
    content = path.read_bytes() if suffix in CACHED_SUFFIXES else b""
    if not _is_whole(suffix, content):
        vertices, triangles = _load(path, scale, up, content)
    else:
        read = cached_arrays(lambda: _load(path, scale, up, content), "mesh", content, suffix, scale, up or "")
        vertices, triangles = cast(Vertices, read[0]), cast(Triangles, read[1])
    return turned_to_x(vertices, forward), triangles


def _is_whole(suffix: str, content: bytes) -> bool:
    """Return whether a file's bytes hold the whole mesh. The JSON text of a .glb file may name others by their URI."""
    json_end = 20 + int.from_bytes(content[12:16], "little")
    return suffix in CACHED_SUFFIXES and not (suffix == ".glb" and b"uri" in content[:json_end])


def turned_to_x(points: Vertices, forward: Forward) -> Vertices:
    """Return points (n, 3) after the turn about z that maps a direction to x."""
    if forward == "x":
        return points
    x, y, z = points.T
    return np.column_stack([*{"-x": (-x, -y), "y": (y, -x), "-y": (-y, x)}[forward], z])


def _load(path: Path, scale: float, up: Up | None, content: bytes = b"") -> tuple[Vertices, Triangles]:
    """Read a mesh. content: the bytes of the file, for CACHED_SUFFIXES. Raises ScenarioError."""
    suffix = path.suffix.lower()
    try:
        if suffix in TRIMESH_SUFFIXES:
            vertices, triangles = _read_with_trimesh(path, suffix, content)
            if suffix in TEXT_SUFFIXES:
                require_whole(f"mesh '{path}'", suffix, content or path.read_bytes(), len(triangles))
        else:
            vertices, triangles = joined(read_by_assimp(path))
    except ScenarioError:
        raise
    except MemoryError:
        raise ScenarioError(f"mesh '{path}': too large to read into memory") from None
    except ImportError as error:
        raise ScenarioError(f"mesh '{path}': {explained(error)}") from None
    except Exception as error:  # readers raise errors of any type for malformed files
        raise ScenarioError(f"mesh '{path}': not a readable {suffix[1:] or 'mesh'} file: {_reason(error)}") from None
    _require_sound(path, vertices, triangles, scale)
    if (up := up or own_up(path)) != "z":
        vertices = vertices @ np.array(TURNS_UP[up], np.float64).T
    return np.ascontiguousarray(vertices * scale), np.ascontiguousarray(triangles, np.uint32)


def own_up(path: Path) -> Literal["y", "z"]:
    """Return the axis that points up in a file as it is read: assimp converts all axes that are declared to y up."""
    suffix = path.suffix.lower()
    return "y" if suffix in Y_UP_SUFFIXES or suffix not in (*TRIMESH_SUFFIXES, *STEP_SUFFIXES) else "z"


def _require_readable(path: Path) -> None:
    try:
        size = path.stat().st_size
    except OSError as error:
        raise ScenarioError(f"mesh '{path}': {(error.strerror or 'cannot be read').lower()}") from None
    if not path.is_file():
        raise ScenarioError(f"mesh '{path}': not a regular file")
    if size == 0:
        raise ScenarioError(f"mesh '{path}': is empty")
    if size > MAX_BYTES:
        raise ScenarioError(
            f"mesh '{path}': {size} bytes, must be at most {MAX_BYTES}; simplify it in the program that created it"
        )


def _read_with_trimesh(path: Path, suffix: str, content: bytes) -> tuple[Vertices, NDArray[Any]]:
    from uwsim.base.whole_trimesh import (  # takes a second to import, and is not needed for a cached mesh
        trimesh,
    )

    if suffix == ".obj":  # comments and names may be in any encoding
        text = content.decode("utf-8", errors="replace")
        _require_indices_from_one(path, text)
        if not has_places_on_images(content):
            text = re.sub(r"^usemtl.*$", "", text, flags=re.MULTILINE)  # each would be a mesh of its own
        scene = trimesh.load_scene(io.StringIO(text), file_type="obj", process=False, skip_materials=True)
    elif suffix == ".stl":
        scene = trimesh.load_scene(io.BytesIO(_sound_stl(path, content)), file_type="stl", process=False)
    else:
        source = io.BytesIO(content) if _is_whole(suffix, content) else path
        scene = trimesh.load_scene(source, file_type=suffix[1:], process=False, resolver=files_beside(path))
    mesh = scene.to_mesh()
    return np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces)


def files_beside(path: Path) -> Any:
    """Return trimesh's finder of the files of which a mesh's file is made: regular ones in its folder."""
    from uwsim.base.whole_trimesh import trimesh

    class Beside(trimesh.resolvers.FilePathResolver):
        def get(self, name: str) -> bytes:
            file = (Path(self.parent) / name).resolve()
            if not file.is_relative_to(Path(self.parent).resolve()):
                raise ValueError(f"'{name}': must be in the folder of the file")
            return require_regular(file).read_bytes()

    return Beside(str(path))


def has_places_on_images(content: bytes) -> bool:
    """Return whether an OBJ file gives vertices places on an image."""
    return re.search(rb"^[ \t]*vt[ \t]", content, re.MULTILINE) is not None


def _require_indices_from_one(path: Path, text: str) -> None:
    """Raise ScenarioError for a face with the invalid index 0, which trimesh would map to another vertex."""
    zero = re.search(r"^[ \t]*f[ \t](?:.*[ \t])?[-+]?0+(?=[/\s]|\Z)", text, re.MULTILINE)
    if zero:
        line = text.count("\n", 0, zero.end()) + 1
        raise ScenarioError(f"mesh '{path}': line {line}: a face names vertex 0, but an OBJ file's count from 1")


def _sound_stl(path: Path, data: bytes) -> bytes:
    """Return the file's bytes, with text converted to UTF-8. Raises ValueError if trimesh would find no triangles."""
    announced = int.from_bytes(data[80:84], "little")
    if len(data) >= 84 and len(data) == 84 + 50 * announced:
        return data
    if data.lstrip()[:5].lower() != b"solid" or b"\0" in data:
        size = f", its {len(data)} bytes are not the {84 + 50 * announced} of the {announced} triangles it announces"
        raise ValueError(f"neither text that starts with 'solid' nor binary{size if len(data) >= 84 else ''}")
    require_whole_stl(f"mesh '{path}'", data)
    return data.decode("utf-8", errors="replace").encode()


def joined(parts: list[tuple[Vertices, NDArray[Any]]]) -> tuple[Vertices, NDArray[Any]]:
    """Combine several meshes into one."""
    if not parts:
        return np.empty((0, 3)), np.empty((0, 3), np.int64)
    starts = np.cumsum([0] + [len(points) for points, _ in parts[:-1]])
    triangles = [part + start for (_, part), start in zip(parts, starts, strict=True)]
    return np.concatenate([points for points, _ in parts]), np.concatenate(triangles)


def _require_sound(path: Path, vertices: Vertices, triangles: NDArray[Any], scale: float) -> None:
    if len(triangles) == 0:
        raise ScenarioError(f"mesh '{path}': holds no triangles")
    if len(triangles) > MAX_TRIANGLES:
        raise ScenarioError(f"mesh '{path}': {len(triangles)} triangles, must be at most {MAX_TRIANGLES}; reduce it")
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise ScenarioError(f"mesh '{path}': a triangle names vertex {triangles.max()} of {len(vertices)}")
    if not np.isfinite(vertices).all():
        raise ScenarioError(
            f"mesh '{path}': {np.count_nonzero(~np.isfinite(vertices).all(axis=1))} vertices are not finite"
        )
    corners = vertices[triangles]
    reach_m = float(np.abs(corners).max()) * scale
    if reach_m > MAX_REACH_M:
        raise ScenarioError(
            f"mesh '{path}': reaches {reach_m:.3g} m from its origin at scale {scale:g}, must be at most "
            f"{MAX_REACH_M:g} m: choose a smaller scale"
        )
    sides = corners[:, 1:] - corners[:, :1]
    extent = float(np.ptp(corners, axis=(0, 1)).max())
    if np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1).max() <= 1e-12 * extent**2:
        raise ScenarioError(f"mesh '{path}': none of its {len(triangles)} triangles has an area")


def _reason(error: Exception) -> str:
    return " ".join(str(error).split())[:200] or type(error).__name__
