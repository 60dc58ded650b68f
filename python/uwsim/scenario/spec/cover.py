"""Cover: many small pieces that lie or grow on the bed, as layers; and life, which swims. Both are selected by `kind`.

Kinds are registered in the entry point groups `uwsim.kinds.cover` and `uwsim.kinds.life`; docs/inside/extend.md adds
one from another package. All that casts rays meets cover; bodies and tethers touch the solid kinds, plants add drag.
Where animals are is a function of seed and time, so that nothing of it is saved. Instruments meet them as they meet
vehicles; nothing else does.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from uwsim.scenario.read.mesh_file import Triangles, Vertices
from uwsim.scenario.read.textures import Texture
from uwsim.scenario.spec.fields import InRange, Model, Point3, broken
from uwsim.scenario.spec.kinds import Kinds
from uwsim.scenario.spec.material import MaterialSpec

PieceSize = Annotated[float, InRange(0.002, 50, "m")]
Depth = Annotated[float, InRange(0, 12_000, "m")]
Slope = Annotated[float, InRange(0, 90, "deg")]
ANYWHERE_M = 100_000.0
Clearance = Annotated[float, InRange(0, ANYWHERE_M, "m")]
LeansAt = Annotated[float, InRange(0.001, 100, "m/s")] | None
Mesh = tuple[Vertices, Triangles]


class CoverModel(Model):
    """A layer of pieces of one kind on the bed. A kind also has the fields `kind`, `name` and `material`.

    density_per_m2: mean number of pieces per square metre of the horizontal plane, where the layer grows. size_m:
    the smallest and largest extent of a piece: height of plants, diameter of others. size_exponent: the density of
    sizes D is proportional to D^-(size_exponent + 1): 0 is even over their logarithm, -1 even over sizes, 2 to 3 as
    of broken rock (Turcotte 1986, J. Geophys. Res. 91(B2):1921). depth_m, slope_deg: depth below z = 0 and slope of
    the bed where it grows. obstacles_m: distance from the nearest obstacle or station; up to 100,000 m: anywhere.
    patch_m: size of the patches in which it grows; 0: everywhere. patch_share: share of the area that they take.
    seed: of its places, which do not depend on the scenario's seed. leans_at_m_s: the speed of a steady current in
    which a plant leans by 45 degrees, its drag as large as its buoyancy; plants lean with currents and sway with waves.
    Without it, pieces stand still.
    """

    if TYPE_CHECKING:
        kind: str
        name: str
        material: MaterialSpec

    surface_class: ClassVar[str] = ""
    """Its class in labelled frames; its kind if empty."""
    stance: ClassVar[Literal["upright", "on_bed", "tumbled"]] = "upright"
    """How pieces stand: upright, along the bed's normal, or turned at random."""
    sunk: ClassVar[float] = 0.03
    """How deep the meshes' origin lies below the bed, as a fraction of the size."""
    drag_coefficient: ClassVar[float] = 0.0
    """C_d of plants, by which they brake what moves through them; 0: they do not.

    The drag per volume is 1/2 rho C_d a |u| u (Nepf 1999, Water Resour. Res. 35(2):479), where u is the velocity
    relative to the water and a [1/m] the frontal area per volume, that of the meshes seen from the side.
    """

    density_per_m2: Annotated[float, InRange(0, 1000, "1/m2")] = Field(examples=[0.3])
    size_m: tuple[PieceSize, PieceSize] = Field(examples=[[0.2, 0.5]])
    size_exponent: Annotated[float, InRange(-10, 10)] = 0.0
    depth_m: tuple[Depth, Depth] = (0.0, 12_000.0)
    slope_deg: tuple[Slope, Slope] = (0.0, 90.0)
    obstacles_m: tuple[Clearance, Clearance] = (0.3, ANYWHERE_M)
    patch_m: Annotated[float, InRange(0, 1000, "m")] = 0.0
    patch_share: Annotated[float, InRange(0.01, 1)] = 1.0
    seed: Annotated[int, InRange(0, 2**63 - 1)] = 0
    leans_at_m_s: LeansAt = None

    def meshes(self, random: np.random.Generator) -> list[Mesh]:
        """Return the shapes, of which each piece has one: their origin on the bed, z up, the largest extent 1.

        Raises ScenarioError.
        """
        raise NotImplementedError

    def is_solid(self) -> bool:
        """Return whether vehicles, loose bodies, arms and tethers touch the pieces, if those are 5 cm or larger.

        Otherwise, they move through them, braked by plants.
        """
        return self.drag_coefficient == 0

    def texture(self) -> Texture | None:
        """Return the colours of the only mesh's triangles; None for those of the material."""
        return None

    @model_validator(mode="after")
    def _ascends(self) -> CoverModel:
        for name in ("size_m", "depth_m", "slope_deg", "obstacles_m"):
            low, high = getattr(self, name)
            if low > high:
                raise broken("its first value must not exceed its second", at=(name,), value=[low, high])
        return self


COVERS = Kinds("uwsim.kinds.cover", CoverModel, needs=("name", "material"))
CoverSpec = Annotated[CoverModel, COVERS]
Cover = Annotated[tuple[CoverSpec, ...], Field(max_length=100)]


Distance = Annotated[float, InRange(0.05, 500, "m")]
BodyLength = Annotated[float, InRange(0.01, 5, "m")]


class LifeModel(Model):
    """Animals of one kind that swim together. A kind also has the fields `kind`, `name` and `material`.

    count: how many. size_m: the shortest and the longest. position_m: the middle of the round that they swim. round_m:
    its radius. speed_m_s: along it. spread_m: half of the school's length, width and height. clear_m: their distance
    from bed and surface, which press them aside. seed: of their places, which do not depend on the scenario's seed.
    """

    if TYPE_CHECKING:
        kind: str
        name: str
        material: MaterialSpec

    surface_class: ClassVar[str] = "fish"
    """Its class in labelled frames."""

    count: Annotated[int, InRange(1, 2000)] = Field(examples=[20])
    size_m: tuple[BodyLength, BodyLength] = Field(examples=[[0.2, 0.3]])
    position_m: Point3
    round_m: Annotated[float, InRange(0.5, 1000, "m")] = 5.0
    speed_m_s: Annotated[float, InRange(0.01, 10, "m/s")] = 0.5
    spread_m: tuple[Distance, Distance, Distance] = (1.5, 0.8, 0.5)
    clear_m: Annotated[float, InRange(0.05, 20, "m")] = 0.4
    seed: Annotated[int, InRange(0, 2**63 - 1)] = 0

    def shapes(self, random: np.random.Generator) -> list[list[Mesh]]:
        """Return, for each of some sizes, an animal in each phase of a stroke: x ahead, z up, origin in its middle."""
        raise NotImplementedError

    def stroke_hz(self) -> float:
        """Return how often the tail beats at the speed."""
        raise NotImplementedError


LIFE = Kinds("uwsim.kinds.life", LifeModel, needs=("name", "material"))
LifeSpec = Annotated[LifeModel, LIFE]
Life = Annotated[tuple[LifeSpec, ...], Field(max_length=20)]
