"""The life `school`: fish that swim together."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import model_validator

from uwsim.scenario.build.cover_meshes import fish
from uwsim.scenario.spec.cover import LifeModel, Mesh
from uwsim.scenario.spec.fields import InRange, Name, broken
from uwsim.scenario.spec.material import Material, MaterialSpec

PHASES = 8
SIZES = 3
STRIDE = 0.7
"""Body lengths swum per beat of the tail, as of many fish at steady speed (Bainbridge 1958, J. Exp. Biol. 35:109)."""
FISH_DB = -23.0
"""At normal incidence, per square metre. TS = 20 log10 L - 67.4 dB with L in cm (Foote 1987, J. Acoust. Soc. Am.
82:981, physoclists), of a side of 0.25 L^2; it is the same for each length."""


class FishSchool(LifeModel):
    """A school of fish of one form.

    form: deep as a damselfish, or slender as a sardine. Tail beats follow the speed.
    """

    kind: Literal["school"]
    name: Name
    material: MaterialSpec = Material.model_construct(kind="plain", colour=(0.33, 0.36, 0.38), strength_db=FISH_DB)
    form: Literal["deep", "slender"] = "slender"
    flatness: Annotated[float, InRange(0.2, 1)] = 0.5

    @model_validator(mode="after")
    def _turns_gently(self) -> FishSchool:
        low, high = self.size_m
        if low > high:
            raise broken("its first value must not exceed its second", at=("size_m",), value=[low, high])
        if self.spread_m[1] > 0.5 * self.round_m:
            raise broken(
                "its width must be at most half of round_m, so that the inner fish swim forwards", at=("spread_m", 1),
                value=self.spread_m[1],
            )  # fmt: skip
        return self

    def shapes(self, random: np.random.Generator) -> list[list[Mesh]]:
        """See LifeModel."""
        depth = {"deep": 0.42, "slender": 0.22}[self.form] * random.uniform(0.95, 1.05)
        sizes = np.linspace(*self.size_m, SIZES)
        return [[fish(size, depth, self.flatness, k / PHASES) for k in range(PHASES)] for size in sizes]

    def stroke_hz(self) -> float:
        """See LifeModel."""
        return self.speed_m_s / (STRIDE * float(np.mean(self.size_m)))
