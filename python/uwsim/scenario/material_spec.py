"""What bottoms and obstacles are made of, as sound sees it."""

from __future__ import annotations

from typing import Annotated

from pydantic import BeforeValidator

from uwsim import _core
from uwsim.scenario.fields import InRange, Model, broken
from uwsim.scenario.paths import did_you_mean


class Material(Model):
    """A surface that scatters sound by Lambert's law.

    strength_db: what a square metre sends back at normal incidence. relief: rms slope of what is rougher than the mesh
    shows, across a footprint; it spreads the echo in range.
    """

    strength_db: Annotated[float, InRange(-100, 30, "dB")]
    relief: Annotated[float, InRange(0, 2)] = 0.0

    def core_material(self) -> _core.BottomMaterial:
        """Return it as the core takes it."""
        return _core.BottomMaterial(self.strength_db, self.relief)


ROCK = Material(strength_db=-30.0, relief=0.1)
"""BS = -30 dB as the manufacturer's coverage table of the EM 2040 has it (the seed paper's Fig. 8); relief assumed."""

# Assumed, all: rock's figure is the only one with a source. Weaker the softer, as every text orders bottoms; metal and
# concrete hard and smooth.
MATERIALS = {
    "rock": ROCK,
    "gravel": Material(strength_db=-32.0, relief=0.06),
    "sand": Material(strength_db=-36.0, relief=0.03),
    "mud": Material(strength_db=-44.0, relief=0.01),
    "concrete": Material(strength_db=-30.0, relief=0.0),
    "steel": Material(strength_db=-26.0, relief=0.0),
}


def _material(value: object) -> object:
    if not isinstance(value, str):
        return value
    if value not in MATERIALS:
        known = ", ".join(MATERIALS)
        raise broken(f"must be one of {known}, or strength_db and relief{did_you_mean(value, MATERIALS)}")
    return MATERIALS[value]


NamedMaterial = Annotated[Material, BeforeValidator(_material)]
"""A material, or the name of one of MATERIALS."""
