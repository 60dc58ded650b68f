"""A scenario's terrain, whose heights come from a source: noise, a raster, an image ... Each is one file in `terrains`.

Sources are registered in the entry point group `uwsim.kinds.terrain`; docs/inside/extend.md adds one from another
package.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from uwsim.mapping.files.georeference import Georeference
from uwsim.scenario.spec.fields import InRange, Model, Point2, broken
from uwsim.scenario.spec.kinds import Kinds

MAX_NODES = 16_000_000
"""4,000 x 4,000 nodes: 64 MB of heights, and some 3 GB of triangles for ray casting."""
LOCAL = "local"
"""The coordinate system of plain metres."""

Spacing = Annotated[float, InRange(0.02, 100, "m")]


class TerrainModel(Model):
    """The fields common to all terrains: a grid whose centre is the world's origin.

    size_m: extent along x (east) and y (north), a whole number of spacings. spacing_m: distance between neighbouring
    heights. source: source of the heights; each source has its own keys. window_m: corners (x, y), south-west and
    north-east, of the part that is built, extended to whole cells; the heights and the world's origin are those of the
    whole terrain. It allows parts of a very large survey to be flown in separate processes, none of which holds the
    whole terrain.
    """

    spacing_m: Spacing = 0.5
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
        return self

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
        """Return z (ny, nx) at the nodes of the whole grid, from south to north and west to east.

        It must depend on the fields and their files alone. Raises ScenarioError.
        """
        raise NotImplementedError


TERRAINS = Kinds("uwsim.kinds.terrain", TerrainModel, key="source")
TerrainSpec = Annotated[TerrainModel, TERRAINS]
