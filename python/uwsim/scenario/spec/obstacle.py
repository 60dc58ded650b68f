"""Fixed obstacles in the water, selected by `kind`, and what is on them. All of them collide and produce echoes.

Kinds are registered in the entry point group `uwsim.kinds.obstacle`; docs/inside/extend.md adds one from another
package. For round obstacles except rings, rays intersect the exact shapes; contacts and map scores use meshes, see
build/solids.py.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple, Protocol, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, StrictBool, model_validator

from uwsim import _core
from uwsim.base import quaternions
from uwsim.base.arrays import Floats
from uwsim.scenario.read.mesh_file import Triangles, Vertices
from uwsim.scenario.read.textures import Texture
from uwsim.scenario.spec.fields import InRange, Model, Point3, broken
from uwsim.scenario.spec.kinds import Kinds
from uwsim.scenario.spec.material import Material, MaterialSpec


class Part(NamedTuple):
    """A part of an obstacle. kind: such as anode, damage or hole. place_m (3,): its middle, in the world."""

    kind: str
    place_m: Floats


def places_by_kind(parts: Iterable[Part]) -> dict[str, Floats]:
    """Return the places (n, 3) of parts, by kind."""
    found: dict[str, list[Floats]] = {}
    for part in parts:
        found.setdefault(part.kind, []).append(part.place_m)
    return {kind: np.array(places) for kind, places in found.items()}


BUBBLES = Material.model_construct(kind="plain", colour=(0.80, 0.86, 0.88), strength_db=-11.0)
"""How bubbles look and echo. A bubble that is large compared with the wavelength has a^2 / 4 of backscattering cross
section (Medwin and Clay 1998, "Fundamentals of Acoustical Oceanography", 8.2), of pi a^2 of area: -11 dB."""


@dataclass(frozen=True, eq=False)
class BubblePlume:
    """A plume of bubbles. source_m (3,): where they leave the obstacle. rate_l_min: volume of gas, at its pressure."""

    source_m: NDArray[np.float64]
    rate_l_min: float


class GrowthKind(NamedTuple):
    """The look of growth: its lumps' size [m] and deviation, as a share of the thickness, and two albedos."""

    lump_m: float
    roughness: float
    material: str
    albedos: tuple[tuple[float, float, float], tuple[float, float, float]]


# Assumed, by eye, from pictures of inspections; the mean thickness has a source (build/solids.py).
GROWTHS = {
    "mussel": GrowthKind(0.10, 0.35, "coral", ((0.035, 0.035, 0.05), (0.16, 0.13, 0.10))),
    "barnacle": GrowthKind(0.06, 0.20, "coral", ((0.42, 0.40, 0.35), (0.22, 0.20, 0.16))),
    "anemone": GrowthKind(0.20, 0.45, "coral", ((0.50, 0.24, 0.10), (0.55, 0.50, 0.42))),
    "weed": GrowthKind(0.25, 0.50, "leaf", ((0.07, 0.10, 0.03), (0.14, 0.10, 0.04))),
}


class Growth(Model):
    """Growth that covers an obstacle, so that rays and contacts meet it outside the obstacle's own surface.

    age_years: since the obstacle was put into the water; the growth is full after 2 years. kind: what grows, which sets
    roughness, colour and backscatter. latitude_deg: on which the thickness depends, see build/solids.py. seed: of its
    lumps.
    """

    age_years: Annotated[float, InRange(0, 200, "years")]
    kind: Literal["mussel", "barnacle", "anemone", "weed"] = "mussel"
    latitude_deg: Annotated[float, InRange(56, 72, "deg")] = 57.0
    seed: Annotated[int, InRange(0, 2**63 - 1)] = 0

    @property
    def material(self) -> Material:
        """Its material."""
        about = GROWTHS[self.kind]
        return Material(kind=about.material, colour=about.albedos[0])


FeatureKind = Literal["damage", "span", "burial", "debris", "leak"]
Along = Annotated[float, InRange(0, 1e6, "m")]
Length = Annotated[float, InRange(0.1, 1000, "m")]
Count = Annotated[int, InRange(0, 100)]
USUAL_M: dict[FeatureKind, float] = {"damage": 0.8, "span": 8.0, "burial": 8.0, "debris": 0.8, "leak": 0.3}


class PipeFeature(Model):
    """A place on a pipeline where something is the matter.

    kind: damage (the coating is missing, down to the steel), span (the pipe hangs above the bed), burial (it vanishes
    in the bed), debris (a bottle, can, tyre, plank or brick lies across it) or leak (bubbles of gas rise from a rusty
    place). at_m: the distance of its middle from the first point, along the line on the chart. length_m: by default
    0.8 m for damage and debris, 0.3 m for a leak, 8 m for the others. height_m: of a span's middle above the pipe's
    usual place. clock_h: where damage or a leak is on the circumference, as on a clock seen along the line: 12 is on
    top. rate_l_min: volume of gas that leaks, at the pressure there.
    """

    kind: FeatureKind
    at_m: Along
    length_m: Length | None = None
    height_m: Annotated[float, InRange(0, 5, "m")] = 0.4
    clock_h: Annotated[float, InRange(0, 12, "h")] = 12.0
    rate_l_min: Annotated[float, InRange(0.01, 10_000, "l/min")] | None = None

    @property
    def extent_m(self) -> float:
        """Its length, or what is usual."""
        return self.length_m if self.length_m is not None else USUAL_M[self.kind]


class PipeCondition(Model):
    """Joints and anodes of a pipeline, and its features: those of the list, and others at places drawn from a seed.

    joint_m: distance between field joints, where lengths of 12.2 m (40 feet) were welded together. anode_m: distance
    between bracelet anodes; of pipelines at most 300 m (DNV-RP-F103, 2010, 5.6.3), here by default every other length.
    features: at places that are given. damages, spans, burials, debris, leaks: how many more, at random places that do
    not overlap. seed: of those.
    """

    joint_m: Annotated[float, InRange(1, 1000, "m")] = 12.2
    anode_m: Annotated[float, InRange(1, 1000, "m")] = 24.4
    features: Annotated[tuple[PipeFeature, ...], Field(max_length=1000)] = ()
    damages: Count = 0
    spans: Count = 0
    burials: Count = 0
    debris: Count | None = None
    leaks: Count | None = None
    seed: Annotated[int, InRange(0, 2**63 - 1)] = 0

    @model_validator(mode="after")
    def _is_not_overlapping(self) -> PipeCondition:
        taken = sorted((one.at_m - one.extent_m / 2, one.at_m + one.extent_m / 2) for one in self.features)
        for (_, end), (start, _) in pairwise(taken):
            if start < end:
                raise broken(f"two features overlap at {start:g} m", at=("features",), value=start, unit="m")
        return self


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

    on_bed: StrictBool = Field(False, examples=[True])
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
