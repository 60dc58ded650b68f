"""Surface materials: how they reflect light and scatter sound; and the marks that are painted on a board.

Kinds are registered in the entry point group `uwsim.kinds.material`; docs/inside/extend.md adds one.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Annotated, Any, Literal, get_args

from pydantic import BeforeValidator, Field, model_validator

from uwsim import _core
from uwsim.base.sockets import load
from uwsim.scenario.spec.camera import Colour
from uwsim.scenario.spec.fields import Degrees, InRange, Model, OneOf, broken
from uwsim.scenario.spec.kinds import KindName

SEABEDS = _core.seabeds()
SeabedName = Annotated[str, OneOf(tuple(SEABEDS))]
Strength = Annotated[float, InRange(-100, 30, "dB")]
Relief = Annotated[float, InRange(0, 2)]


class Backscatter(Model):
    """A surface that scatters sound according to Lambert's law, or by angle as a seabed does.

    strength_db: backscattering strength per square metre at normal incidence. relief: RMS slope, across a footprint, of
    roughness that is finer than the mesh; it spreads the echo in range. seabed: for imaging sonars, and a multibeam in
    physics mode, one of _core.seabeds(), whose backscatter by angle replaces Lambert's law. fluid: density and speed
    relative to water, attenuation [dB per wavelength], by which the surface reflects sound that bounces more than once.
    ripples_deg: see Ground.
    """

    strength_db: Strength
    relief: Relief = 0.0
    seabed: SeabedName | None = None
    fluid: tuple[float, float, float] = SEABEDS["rock"]
    ripples_deg: float | None = None


ROCK = Backscatter.model_construct(strength_db=-30.0, relief=0.1)
"""BS = -30 dB as in the manufacturer's coverage table of the EM 2040 (the seed paper's Fig. 8); relief assumed."""

# All assumed, except rock's strength, which has a source. Softer bottoms are weaker, as in textbooks; metal and
# concrete are hard and smooth; paint is as strong as the surface it covers. They reflect as the most similar seabed of
# APL-UW TR 9407, concrete as rock, steel as a fluid of its density and speed (5,890 m/s in the table of the Olympus
# 45MG ultrasonic gauge).
STEEL = (7.8, 3.9, 0.1)
BACKSCATTER = {
    "rock": ROCK,
    "gravel": Backscatter.model_construct(strength_db=-32.0, relief=0.06, fluid=SEABEDS["cobble"]),
    "sand": Backscatter.model_construct(strength_db=-36.0, relief=0.03, fluid=SEABEDS["medium_sand"]),
    "mud": Backscatter.model_construct(strength_db=-44.0, relief=0.01, fluid=SEABEDS["sandy_mud"]),
    "concrete": Backscatter.model_construct(strength_db=-30.0),
    "steel": Backscatter.model_construct(strength_db=-26.0, fluid=STEEL),
    "coral": Backscatter.model_construct(strength_db=-28.0, relief=0.2),
    "leaf": Backscatter.model_construct(strength_db=-40.0, relief=0.2, fluid=SEABEDS["sandy_mud"]),
    "paint": Backscatter.model_construct(strength_db=-26.0, fluid=STEEL),
    "land": ROCK,
    "plain": ROCK,
}

TETHER = BACKSCATTER["leaf"]
"""A cable's jacket, soft and about as dense as water; assumed."""

GROUP = "uwsim.kinds.material"


@dataclass(frozen=True)
class MaterialKind:
    """A kind of material: how it scatters sound, and which of _core.material_names() it looks like."""

    backscatter: Backscatter
    looks: str


OWN = SimpleNamespace(**{name: MaterialKind(own, name) for name, own in BACKSCATTER.items()})


def _fitting(name: str, found: Any) -> MaterialKind:
    if not isinstance(found, MaterialKind):
        raise TypeError(f"{type(found).__name__}: must be a MaterialKind")
    if found.looks not in _core.material_names():
        raise ValueError(f"looks = '{found.looks}': must be one of {', '.join(_core.material_names())}")
    return found


def material_kind(name: str) -> MaterialKind:
    """Return the kind that is registered under a name. Raises ValueError."""
    return load(GROUP, name, _fitting)  # type: ignore[no-any-return]


MaterialName = Annotated[str, KindName(GROUP, _fitting)]


class Material(Model):
    """The material of a surface.

    kind: its name. colour: its albedo, red, green and blue; strength_db, relief, seabed: its backscatter, as in
    Backscatter. Each overrides the material's default.
    """

    kind: MaterialName
    colour: Colour | None = None
    strength_db: Strength | None = None
    relief: Relief | None = None
    seabed: SeabedName | None = None

    @property
    def backscatter(self) -> Backscatter:
        """The backscatter of the surface."""
        return _with_own(material_kind(self.kind).backscatter, self)

    @property
    def looks(self) -> str:
        """The core's material that it looks like."""
        return material_kind(self.kind).looks


def _named(value: object) -> object:
    return {"kind": value} if isinstance(value, str) else value


MaterialSpec = Annotated[Material, BeforeValidator(_named, json_schema_input_type=MaterialName | Material)]
"""A material's name, or its kind and the values that differ."""


class Ground(Model):
    """The materials of the terrain: under water, on steep slopes, and above the water.

    bed: material under water. steep: material on steep slopes. land: material above the water. strength_db, relief,
    seabed: the backscatter of the whole terrain, as in Backscatter; they override those of the bed's material.
    ripples_deg: direction across the crests of the ripples that a bed of sand has, from east to north; with it, imaging
    sonars and a multibeam in physics mode meet the slopes of the ripples that cameras see.
    """

    bed: MaterialName = "sand"
    steep: MaterialName = "rock"
    land: MaterialName = "land"
    strength_db: Strength | None = None
    relief: Relief | None = None
    seabed: SeabedName | None = None
    ripples_deg: Annotated[float, InRange(-360, 360, "deg")] | None = None

    @model_validator(mode="after")
    def _has_ripples_of_sand(self) -> Ground:
        if self.ripples_deg is not None and self.bed != "sand":
            raise broken("only a bed of sand has ripples", at=("ripples_deg",), value=self.ripples_deg, unit="deg")
        return self

    @property
    def backscatter(self) -> Backscatter:
        """The backscatter of the terrain."""
        found = _with_own(material_kind(self.bed).backscatter, self)
        return found if self.ripples_deg is None else found.model_copy(update={"ripples_deg": self.ripples_deg})


def _with_own(usual: Backscatter, own: Material | Ground) -> Backscatter:
    return Backscatter(
        strength_db=usual.strength_db if own.strength_db is None else own.strength_db,
        relief=usual.relief if own.relief is None else own.relief,
        seabed=own.seabed,
        fluid=usual.fluid if own.seabed is None else SEABEDS[own.seabed],
    )


Shape = Literal["disc", "ring", "square", "triangle", "cross", "star", "arrow", "stripes", "fish", "text"]
SHAPES: tuple[str, ...] = get_args(Shape)
Place = Annotated[float, InRange(-100, 100, "m")]


class Mark(Model):
    """A mark on a board's front. Later ones cover earlier ones.

    shape: what it is. text: capital letters, figures and spaces, for shape `text`. at_m: its middle, to the right and
    up from the board's as one looks at the front. size_m: its width, and a letter's height. turned_deg:
    counter-clockwise as one looks at the front; an arrow points up before. colour: its albedo.
    """

    shape: Shape
    text: Annotated[str, Field(pattern=r"^[A-Z0-9 ]{1,12}$")] | None = None
    at_m: tuple[Place, Place] = (0.0, 0.0)
    size_m: Annotated[float, InRange(0.005, 100, "m")]
    turned_deg: Degrees = 0.0
    colour: Colour

    @model_validator(mode="after")
    def _has_its_text(self) -> Mark:
        if (self.text is not None) != (self.shape == "text"):
            raise broken("belongs to shape `text`, and only to it", at=("text",), value=self.text)
        return self
