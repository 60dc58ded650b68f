"""A checkout of a Unity project: what an identifier means, documents of scenes and prefabs, materials; and its bed."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.texts.text_file import require_regular
from uwsim.base.texts.yaml_document import yaml_document

GUID = re.compile(r"^guid: ([0-9a-f]{32})", re.MULTILINE)
DOCUMENT = re.compile(r"^--- !u!(\d+) &(-?\d+)( stripped)?\n(.*?)(?=^--- |\Z)", re.DOTALL | re.MULTILINE)
"""A document's class, its identifier in the file, whether it only refers to a prefab's, and its YAML."""
META_MAX = 10_000
COMPONENTS = re.compile(r"^  m_Component:\n(  - .*\n)*", re.MULTILINE)
"""An object's list of components, which also name it; old prefabs have numbers as keys in it."""
CLASSES = {1, 4, 21, 23, 33, 54, 224, 1001}
"""GameObject, Transform, Material, MeshRenderer, MeshFilter, Rigidbody, RectTransform, PrefabInstance (in Unity)."""
COLOURS, PICTURES = ("_BaseColor", "_Color"), ("_BaseColorMap", "_MainTex")
"""Fields of the shaders of Unity's render pipelines, the newer ones first."""
SIDE = 64  # of the picture whose mean is taken


class Document(NamedTuple):
    """An object of a scene. kind: its class, such as Transform. values: its fields."""

    kind: str
    values: dict[str, Any]
    stripped: bool


class Project:
    """A project in a folder that contains Assets. Raises ValueError."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        if not (folder / "Assets").is_dir():
            raise ValueError(f"'{folder}': has no folder Assets: must be the checkout of a Unity project")

    @cached_property
    def _paths(self) -> dict[str, Path]:
        found = {}
        for meta in sorted((self.folder / "Assets").rglob("*.meta")):
            if not self._contains(meta) or not self._contains(meta.with_suffix("")) or not meta.is_file():
                continue
            with meta.open(errors="replace") as file:
                guid = GUID.search(file.read(META_MAX))
            if guid is not None:
                found[guid[1]] = meta.with_suffix("")
        return found

    def _contains(self, path: Path) -> bool:
        """Return whether a path is in the checkout, rather than a link to elsewhere."""
        return path.resolve().is_relative_to(self.folder.resolve())

    def path(self, guid: str) -> Path | None:
        """Return the file of an identifier, which may be missing, or None if no .meta file has it."""
        return self._paths.get(guid)

    def named(self, path: Path) -> str:
        """Return a path as seen from the project."""
        return path.relative_to(self.folder).as_posix()

    def documents(self, path: Path) -> dict[int, Document]:
        """Return the documents of a scene or prefab by their identifiers. Raises ValueError or OSError."""
        text = require_regular(path).read_text(errors="replace")
        if not text.startswith("%YAML"):
            raise ValueError(f"'{path}': must be YAML (Unity: Asset Serialization, Force Text)")
        found = {}
        for number, identifier, stripped, body in DOCUMENT.findall(text):
            if int(number) not in CLASSES:
                continue
            values = yaml_document(COMPONENTS.sub("", body), f"{path}, object {identifier}").values
            if len(values) != 1:
                raise ValueError(f"'{path}': object {identifier}: must have one class, not {len(values)}")
            ((kind, fields),) = values.items()
            found[int(identifier)] = Document(kind, fields, bool(stripped))
        return found


class Material(NamedTuple):
    """colour: (3,), sRGB from 0 to 1. has_picture: whether a picture's mean is part of it."""

    colour: Floats
    has_picture: bool


def read_material(project: Project, guid: str) -> Material | None:
    """Return a material file's content; None if the checkout has none that can be read."""
    file = project.path(guid)
    if file is None or file.suffix != ".mat" or not file.is_file():
        return None
    try:
        (material,) = (each.values for each in project.documents(file).values() if each.kind == "Material")
        saved = material["m_SavedProperties"]
        colours, pictures = (
            {k: v for each in saved[key] for k, v in each.items()} for key in ("m_Colors", "m_TexEnvs")
        )
        name = next(name for name in COLOURS if name in colours)
        colour = np.array([float(colours[name][band]) for band in "rgb"])
        picture = next((pictures[name]["m_Texture"].get("guid") for name in PICTURES if name in pictures), None)
    except (ValueError, LookupError, TypeError, AttributeError, StopIteration, OSError):
        return None
    mean = None if picture is None else _mean(project, picture)
    return Material(np.clip(colour if mean is None else colour * mean, 0.0, 1.0), mean is not None)


def _mean(project: Project, guid: str) -> Floats | None:
    """Return the mean colour (3,) of a picture; None if it cannot be read."""
    file = project.path(guid)
    if file is None or not file.is_file():
        return None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Pillow's, about a large picture
            with Image.open(file) as picture:
                pixels = np.asarray(picture.convert("RGB").resize((SIDE, SIDE)), np.float64)
    except Exception:  # Pillow raises errors of any type for malformed files
        return None
    return np.asarray(pixels.mean(axis=(0, 1)) / 255.0)


SPACING_M, ABOVE_M, DEEP_M, BED_MAX_M = 0.5, 1e3, 1e4, 2000.0


@dataclass(frozen=True)
class Bed:
    """heights_m: (rows, columns), from north to south and from west to east, about the origin.

    fill_m: the height where the scene has no bed.
    """

    heights_m: Floats
    fill_m: float

    @property
    def reach_m(self) -> float:
        """The greatest x and y with a height."""
        return SPACING_M * (len(self.heights_m) - 1) / 2.0

    @property
    def text(self) -> bytes:
        """An ESRI grid."""
        count, edge = len(self.heights_m), -SPACING_M * len(self.heights_m) / 2.0
        head = f"ncols {count}\nnrows {count}\nxllcorner {edge}\nyllcorner {edge}\ncellsize {SPACING_M}\n"
        row_text = " ".join(["%.3f"] * count) + "\n"
        return (head + "".join(row_text % tuple(row) for row in self.heights_m.tolist())).encode()

    def reaches(self, x_m: float, y_m: float) -> bool:
        """Return whether there is a height at a place."""
        return bool(max(abs(x_m), abs(y_m)) <= self.reach_m)

    def is_under(self, x_m: float, y_m: float) -> bool:
        """Return whether there is water over the bed at a place."""
        if not self.reaches(x_m, y_m):
            return False
        row, column = np.rint((self.reach_m + np.array([-y_m, x_m])) / SPACING_M).astype(int)
        return bool(self.heights_m[row, column] < 0.0)

    def open_water(self) -> tuple[float, float, float]:
        """Return the bed's point next to the origin among those with half of the greatest depth or more.

        Raises ValueError for a bed that is above the water everywhere.
        """
        if (lowest_m := float(self.heights_m.min())) >= 0.0:
            raise ValueError(f"the bed's lowest point is {lowest_m:.1f} m above the water: it must be below")
        rows, columns = np.nonzero(self.heights_m <= 0.5 * lowest_m)
        x_m, y_m = SPACING_M * columns - self.reach_m, self.reach_m - SPACING_M * rows
        near = int(np.argmin(x_m**2 + y_m**2))
        return float(x_m[near]), float(y_m[near]), float(self.heights_m[rows[near], columns[near]])


def read_bed(surface: tuple[Floats, NDArray[np.int64]], size_m: float | None = None) -> Bed:
    """Return the highest surface of vertices (n, 3) in uwsim's world [m] and triangles (m, 3). Raises ValueError.

    size_m: the largest edge of the grid, about the origin; by default it reaches as far as the surface.
    """
    if size_m is not None and size_m > BED_MAX_M:
        raise ValueError(f"--size = {size_m:g} m: must be at most {BED_MAX_M:g} m for the bed of a Unity project")
    vertices, triangles = surface
    world = _core.World()
    world.add_solid("bed", vertices, triangles.astype(np.uint32))
    wide_m = 2.0 * float(np.abs(vertices[:, :2]).max())
    if size_m is not None:
        wide_m = min(wide_m, size_m)
    if wide_m > BED_MAX_M:
        raise ValueError(
            f"the bed needs a grid about the origin {wide_m:.0f} m wide: must be at most {BED_MAX_M:g} m; "
            "--size makes a part of it the bed"
        )
    half = SPACING_M * np.ceil(0.5 * wide_m / SPACING_M)
    places = np.arange(-half, half, SPACING_M) + SPACING_M / 2.0
    east, north = np.meshgrid(places, places[::-1])
    above = np.stack([east.ravel(), north.ravel(), np.full(east.size, vertices[:, 2].max() + ABOVE_M)], axis=1)
    ranges = _core.RayScene(world).cast(above, np.array([[0.0, 0.0, -1.0]]).repeat(len(above), 0), DEEP_M).ranges_m
    heights = above[:, 2] - ranges
    if not np.isfinite(heights).any():
        raise ValueError("the bed has no surface that can be seen from above")
    fill_m = float(heights[np.isfinite(heights)].min())
    return Bed(np.where(np.isfinite(heights), heights, fill_m).reshape(east.shape), fill_m)
