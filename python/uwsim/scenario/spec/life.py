"""An entry under `life:` in a scenario: animals that swim, selected by `kind`.

Each kind is one file in `life`, registered in the entry point group `uwsim.kinds.life`. Where they are is a function of
seed and time, so that nothing of it is saved. Instruments meet them as they meet vehicles; nothing else does.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from pydantic import Field

from uwsim.scenario.read.mesh_file import Triangles, Vertices
from uwsim.scenario.spec.fields import InRange, Model, Point3
from uwsim.scenario.spec.kinds import Kinds
from uwsim.scenario.spec.material import MaterialSpec

Distance = Annotated[float, InRange(0.05, 500, "m")]
BodyLength = Annotated[float, InRange(0.01, 5, "m")]
Mesh = tuple[Vertices, Triangles]


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

    count: Annotated[int, InRange(1, 2000)]
    size_m: tuple[BodyLength, BodyLength]
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
