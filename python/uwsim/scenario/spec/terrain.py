"""A scenario's terrain, whose heights come from a source: noise, a raster, an image ... Each is one file in `terrains`.

Sources are registered in the entry point group `uwsim.kinds.terrain`; docs/inside/extend.md adds one from another
package.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from uwsim.mapping.files.georeference import Georeference
from uwsim.scenario.spec.fields import InRange, Model, Point2, Size, broken
from uwsim.scenario.spec.kinds import Kinds

MAX_NODES = 16_000_000
"""4,000 x 4,000 nodes: 64 MB of heights, and some 3 GB of triangles for ray casting."""
LOCAL = "local"
"""The coordinate system of plain metres."""

STROKES_MAX = 1000
MAX_DRAWN = 200_000_000
"""Nodes that strokes may reach, counted for each piece of their lines and once more for the whole: some 10 s."""

Spacing = Annotated[float, InRange(0.02, 100, "m")]


class Stroke(Model):
    """A stroke of a brush on the bed: a hill or a hole if its line is one point, else a ridge or a trench.

    line_m: the points (x, y) of its middle. width_m: across it, from foot to foot. height_m: of its middle above the
    bed as it was, negative below. smooth: share by which the bed under it first comes closer to its mean within
    a square of half that width; 0 leaves the bed, 1 takes its mean. Height and share fade towards the feet.
    """

    line_m: Annotated[tuple[Point2, ...], Field(min_length=1, max_length=200)]
    width_m: Size = Field(examples=[10])
    height_m: Annotated[float, InRange(-1000, 1000, "m")] = Field(0.0, examples=[2])
    smooth: Annotated[float, InRange(0, 1)] = 0.0


class TerrainModel(Model):
    """The fields common to all terrains: a grid whose centre is the world's origin.

    size_m: extent along x (east) and y (north), a whole number of spacings. spacing_m: distance between neighbouring
    heights. source: source of the heights; each source has its own keys. window_m: corners (x, y), south-west and
    north-east, of the part that is built, extended to whole cells; the heights and the world's origin are those of the
    whole terrain. It allows parts of a very large survey to be flown in separate processes, none of which holds the
    whole terrain. strokes: drawn on the source's heights, one after another.
    """

    spacing_m: Spacing = Field(0.5, examples=[1])
    strokes: Annotated[tuple[Stroke, ...], Field(max_length=STROKES_MAX)] = ()
    window_m: tuple[Point2, Point2] | None = None

    if TYPE_CHECKING:
        source: str

    @property
    def has_place(self) -> bool:
        """True if the source itself may locate the world on Earth; a scenario's `earth` is then refused."""
        return False

    def place(self) -> Georeference:
        """Return where the source locates the world on Earth. Raises ScenarioError."""
        return Georeference()

    @model_validator(mode="after")
    def _fits(self) -> TerrainModel:
        if self.window_m is not None:
            (x0, y0), (x1, y1) = self.window_m
            if x0 >= x1 or y0 >= y1:
                raise broken("its second corner must be north-east of its first", at=("window_m",))
        size_m = getattr(self, "size_m", None)  # a field of sources that have it
        if size_m is not None:
            self._check_grid(size_m)
        self._check_strokes()
        return self

    def _check_strokes(self) -> None:
        drawn = 0.0
        for k, stroke in enumerate(self.strokes):
            line_m = np.asarray(stroke.line_m)
            pieces_m = np.abs(np.diff(line_m[[0, *range(len(line_m))]], axis=0))
            sides_m = np.vstack([pieces_m, np.ptp(line_m, axis=0)]) + stroke.width_m
            drawn += float(np.minimum(np.prod(sides_m, axis=1) / self.spacing_m**2, MAX_NODES).sum())
            if drawn > MAX_DRAWN:
                rule = f"those up to this one reach more than {MAX_DRAWN} heights: make them narrower, shorter or fewer"
                raise broken(rule, at=("strokes", k, "width_m"), value=stroke.width_m, unit="m")

    def _check_grid(self, size_m: tuple[float, float]) -> None:
        cells = [size / self.spacing_m for size in size_m]
        for size, count in zip(size_m, cells, strict=True):
            if abs(count - round(count)) > 1e-6 or round(count) < 1:
                rule = f"must be a whole number of spacing_m ({self.spacing_m:g} m)"
                raise broken(rule, at=("size_m",), value=size, unit="m")
        nodes = (round(cells[0]) + 1) * (round(cells[1]) + 1)
        if nodes > MAX_NODES:
            rule = f"makes {nodes} heights, must be at most {MAX_NODES}: enlarge it or make size_m smaller"
            raise broken(rule, at=("spacing_m",), value=self.spacing_m, unit="m")

    def heights(self) -> NDArray[np.floating]:
        """Return z (ny, nx) at the nodes of the whole grid without strokes, from south to north and west to east.

        It must depend on the fields and their files alone. Raises ScenarioError.
        """
        raise NotImplementedError


TERRAINS = Kinds("uwsim.kinds.terrain", TerrainModel, key="source")
TerrainSpec = Annotated[TerrainModel, TERRAINS]
