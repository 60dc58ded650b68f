"""Fixed obstacles in the water, selected by `kind`. All of them collide and produce echoes.

Each kind is one file in `obstacles`, registered in the entry point group `uwsim.kinds.obstacle`; docs/inside/extend.md
adds one from another package. For round obstacles except rings, rays intersect the exact shapes; contacts and map
scores use meshes, see build/solids.py.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple, Protocol, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import StrictBool

from uwsim import _core
from uwsim.base import quaternions
from uwsim.scenario.read.mesh_file import Triangles, Vertices
from uwsim.scenario.read.textures import Texture
from uwsim.scenario.spec.bubble_plume import BubblePlume
from uwsim.scenario.spec.fields import Model, Point3
from uwsim.scenario.spec.growth import Growth
from uwsim.scenario.spec.kinds import Kinds
from uwsim.scenario.spec.material import Material, MaterialSpec
from uwsim.scenario.spec.part import Part

LEVEL: tuple[float, float, float] = (0.0, 0.0, 0.0)


class Bed(Protocol):
    """The terrain, as obstacles use it; see uwsim.scenario.Terrain."""

    @property
    def spacing_m(self) -> float:
        """Distance between neighbouring heights."""

    @property
    def extent_text(self) -> str:
        """The bounds as text for messages."""

    def height_at(self, xy_m: ArrayLike) -> NDArray[np.float64]:
        """Return z (n,) at points (n, 2); NaN outside the terrain."""


class Solid(NamedTuple):
    """A closed solid: vertices (n, 3), world frame, metres; triangles (m, 3), winding outward; and its exact shapes.

    The exact, analytic shapes exist only if the solid is round.
    """

    vertices: Vertices
    triangles: Triangles
    shapes: list[_core.RoundShape]


class ObstacleModel(Model):
    """The fields of all obstacles. A kind also has the fields `kind`, `name` and `material`.

    growth: what has grown on it.
    """

    if TYPE_CHECKING:
        kind: str
        name: str
        material: MaterialSpec
        on_bed: bool

    surface_class: ClassVar[str] = "structure"
    """Its class in labelled frames: "structure", "gate" or "pipeline"."""

    example: ClassVar[Mapping[str, Any]] = {}
    """Values with which a form for this kind begins, such as the scene editor's."""

    has_own_unit: ClassVar[bool] = False
    """True for a kind whose size comes from a file, so that a wrong unit is likely."""

    growth: Growth | None = None

    @property
    def surface(self) -> Material:
        """The material that light and sound meet: that of the growth, if there is any."""
        return self.growth.material if self.growth is not None and self.growth.age_years else self.material

    def solid(self, terrain: Bed) -> Solid:
        """Return the obstacle in the world frame. Raises ScenarioError."""
        raise NotImplementedError

    def parts(self, terrain: Bed) -> list[Part]:
        """Return what an inspection looks for, in the world. May raise."""
        return []

    @property
    def leaks(self) -> int:
        """How many plumes of bubbles rise from it."""
        return 0

    def plumes(self, terrain: Bed) -> list[BubblePlume]:
        """Return those plumes."""
        return []

    def texture(self) -> Texture | None:
        """Return the colours of its triangles; None for those of its material."""
        return None


class Placed(ObstacleModel):
    """An obstacle placed by coordinates.

    on_bed: whether it stands on the terrain: z of position_m is then the height of its lowest point above the point of
    the bed that it would touch first; a negative value sinks it into the bed. position_m: position in the world.
    """

    on_bed: StrictBool = False
    position_m: Point3

    def placed(self, name: str, position_m: Point3, turned_deg: Point3) -> Self:
        """Return a copy at another place, turned in the world by yaw, pitch and roll if it has a direction."""
        changes: dict[str, Any] = {"name": name, "position_m": position_m}
        if (own := getattr(self, "yaw_pitch_roll_deg", None)) is not None:
            changes["yaw_pitch_roll_deg"] = quaternions.turned_deg(own, turned_deg)
        return self.model_copy(update=changes)


class OnBed(ObstacleModel):
    """An obstacle that always stands on the terrain or follows it.

    on_bed: always true; may be left out.
    """

    on_bed: Literal[True] = True


OBSTACLES = Kinds("uwsim.kinds.obstacle", ObstacleModel, needs=("name", "material"))
ObstacleSpec = Annotated[ObstacleModel, OBSTACLES]
