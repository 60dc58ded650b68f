"""What surfaces are made of, as light and as sound see it."""

from __future__ import annotations

from typing import Annotated

from pydantic import BeforeValidator

from uwsim import _core
from uwsim.scenario.camera_spec import Colour
from uwsim.scenario.fields import InRange, Model, OneOf

Strength = Annotated[float, InRange(-100, 30, "dB")]
Relief = Annotated[float, InRange(0, 2)]


class Backscatter(Model):
    """A surface that scatters sound by Lambert's law.

    strength_db: what a square metre sends back at normal incidence. relief: rms slope of what is rougher than the mesh
    shows, across a footprint; it spreads the echo in range.
    """

    strength_db: Strength
    relief: Relief = 0.0

    def core_material(self) -> _core.BottomMaterial:
        """Return it as the core takes it."""
        return _core.BottomMaterial(self.strength_db, self.relief)


ROCK = Backscatter(strength_db=-30.0, relief=0.1)
"""BS = -30 dB as the manufacturer's coverage table of the EM 2040 has it (the seed paper's Fig. 8); relief assumed."""

# Assumed, all: rock's figure is the only one with a source. Weaker the softer, as every text orders bottoms; metal and
# concrete hard and smooth, and paint as what it is on.
BACKSCATTER = {
    "rock": ROCK,
    "gravel": Backscatter(strength_db=-32.0, relief=0.06),
    "sand": Backscatter(strength_db=-36.0, relief=0.03),
    "mud": Backscatter(strength_db=-44.0, relief=0.01),
    "concrete": Backscatter(strength_db=-30.0),
    "steel": Backscatter(strength_db=-26.0),
    "paint": Backscatter(strength_db=-26.0),
    "land": ROCK,
    "plain": ROCK,
}

MaterialName = Annotated[str, OneOf(_core.material_names())]


class Material(Model):
    """What a surface is made of.

    colour: its albedo, red, green and blue; strength_db, relief: how it scatters sound, as in Backscatter. Each instead
    of the material's own.
    """

    kind: MaterialName
    colour: Colour | None = None
    strength_db: Strength | None = None
    relief: Relief | None = None

    @property
    def backscatter(self) -> Backscatter:
        """What sonars hear of it."""
        return _with_own(BACKSCATTER[self.kind], self.strength_db, self.relief)


def _named(value: object) -> object:
    return {"kind": value} if isinstance(value, str) else value


MaterialSpec = Annotated[Material, BeforeValidator(_named)]
"""A material's name, or kind and what differs."""


class Ground(Model):
    """What the terrain is made of: under water, where it is steep, and above the water.

    strength_db, relief: how all of it scatters sound, as in Backscatter, instead of the bed's own.
    """

    bed: MaterialName = "sand"
    steep: MaterialName = "rock"
    land: MaterialName = "land"
    strength_db: Strength | None = None
    relief: Relief | None = None

    @property
    def backscatter(self) -> Backscatter:
        """What sonars hear of it."""
        return _with_own(BACKSCATTER[self.bed], self.strength_db, self.relief)


def _with_own(usual: Backscatter, strength_db: float | None, relief: float | None) -> Backscatter:
    return Backscatter(
        strength_db=usual.strength_db if strength_db is None else strength_db,
        relief=usual.relief if relief is None else relief,
    )
