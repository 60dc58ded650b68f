"""`growth` of an obstacle: what has settled on it, as thick as its age and its depth make it."""

from __future__ import annotations

from typing import Annotated, Literal, NamedTuple

from uwsim.scenario.spec.fields import InRange, Model
from uwsim.scenario.spec.material import Material


class GrowthKind(NamedTuple):
    """The look of growth: its lumps' size [m] and deviation, as a share of the thickness, and two albedos."""

    lump_m: float
    roughness: float
    material: str
    albedos: tuple[tuple[float, float, float], tuple[float, float, float]]


# Assumed, by eye, from pictures of inspections; the mean thickness has a source (build/growth.py).
GROWTHS = {
    "mussel": GrowthKind(0.10, 0.35, "coral", ((0.035, 0.035, 0.05), (0.16, 0.13, 0.10))),
    "barnacle": GrowthKind(0.06, 0.20, "coral", ((0.42, 0.40, 0.35), (0.22, 0.20, 0.16))),
    "anemone": GrowthKind(0.20, 0.45, "coral", ((0.50, 0.24, 0.10), (0.55, 0.50, 0.42))),
    "weed": GrowthKind(0.25, 0.50, "leaf", ((0.07, 0.10, 0.03), (0.14, 0.10, 0.04))),
}


class Growth(Model):
    """Growth that covers an obstacle, so that rays and contacts meet it outside the obstacle's own surface.

    age_years: since the obstacle was put into the water; the growth is full after 2 years. kind: what grows, which sets
    roughness, colour and backscatter. latitude_deg: on which the thickness depends, see build/growth.py. seed: of its
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
