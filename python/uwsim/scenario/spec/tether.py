"""A tether of a vehicle or a loose body: its cable, where it is fastened, and its winch."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal, NamedTuple

from pydantic import Discriminator, Tag, model_validator

from uwsim.scenario.spec.fields import InRange, Model, Name, Point3, broken

Length = Annotated[float, InRange(0.1, 20_000, "m")]


class Winch(Model):
    """The winch at the tether's first end. It holds until it is commanded, in a sea of any state.

    longest_m: on the drum and out. shortest_m: that stays out; by default one element. fastest_m_s: the fastest rate.
    strongest_n: the tension at which it recovers nothing, and the greatest that it can keep.
    """

    longest_m: Length
    shortest_m: Length | None = None
    fastest_m_s: Annotated[float, InRange(0.001, 10, "m/s")] = 0.5
    strongest_n: Annotated[float, InRange(0.1, 1e7, "N")] = 500.0


class BodyAnchor(Model):
    """A tether's first end at another vehicle or body.

    to: its name. at_m: where it is fastened, in its frame.
    """

    to: Name
    at_m: Point3 = (0.0, 0.0, 0.0)


def _kind(anchor: object) -> str:
    if isinstance(anchor, str):
        return "[name]"
    return "[body]" if isinstance(anchor, Mapping | BodyAnchor) else "[point]"


Anchor = Annotated[
    Annotated[Literal["station"], Tag("[name]")]
    | Annotated[Point3, Tag("[point]")]
    | Annotated[BodyAnchor, Tag("[body]")],
    Discriminator(_kind),
]


class Tether(Model):
    """A tether of a vehicle or of a body under `objects:`, which is at its second end.

    Its defaults are a Fathom ROV tether's (docs.bluerobotics.com/fathom-r2, specifications).
    anchor: its first end: `station`, at its dock, a fixed point of the world, or another vehicle or body. at_m: where
    its second end is fastened, in the frame of its vehicle or body, whose origin is, for a body, the middle of its
    volume. length_m: out at the start, without load; at least the distance of its ends.
    elements: into which that is divided; an element that the winch pays out is as long. diameter_m, mass_kg_m: 7.6 mm
    and 0.043 kg/m by its sheet. axial_stiffness_n: EA; by default its breaking load over the 2.4 % at which aramid
    fibres break (DuPont, "Kevlar technical guide"). bending_stiffness_n_m2: EI; by default a solid polyurethane rod's
    of 50 MPa, assumed. axial_damping_n_s: tension per rate of strain; assumed. normal_drag: per area d L, 1.2 for a
    smooth cylinder at Reynolds numbers of 1e3 to 1e5 (Hoerner 1965, ch. 3). tangential_drag: per area pi d L, 0.01
    (Berteaux 1976, "Buoy Engineering": 0.005 to 0.02). normal_added_mass, tangential_added_mass: per displaced mass;
    those of a cylinder in ideal flow. friction: on the bed; assumed. breaking_load_n: by its sheet 350 lbf. winch: by
    default none.
    """

    anchor: Anchor = "station"
    at_m: Point3 = (0.0, 0.0, 0.0)
    length_m: Length
    elements: Annotated[int, InRange(1, 500)] = 40
    diameter_m: Annotated[float, InRange(1e-4, 1, "m")] = 0.0076
    mass_kg_m: Annotated[float, InRange(1e-4, 1e4, "kg/m")] = 0.043
    axial_stiffness_n: Annotated[float, InRange(1, 1e12, "N")] = 6.5e4
    bending_stiffness_n_m2: Annotated[float, InRange(0, 1e9, "N m2")] = 0.008
    axial_damping_n_s: Annotated[float, InRange(0, 1e9, "N s")] = 65.0
    normal_drag: Annotated[float, InRange(0, 10)] = 1.2
    tangential_drag: Annotated[float, InRange(0, 10)] = 0.01
    normal_added_mass: Annotated[float, InRange(0, 10)] = 1.0
    tangential_added_mass: Annotated[float, InRange(0, 10)] = 0.0
    friction: Annotated[float, InRange(0, 10)] = 0.5
    breaking_load_n: Annotated[float, InRange(0.1, 1e9, "N")] = 1557.0
    winch: Winch | None = None

    @model_validator(mode="after")
    def _winch_suits_the_length(self) -> Tether:
        if self.winch is None:
            return self
        element_m = self.length_m / self.elements
        least_m = element_m if self.winch.shortest_m is None else self.winch.shortest_m
        if self.winch.longest_m < self.length_m:
            rule = f"must be at least length_m, {self.length_m:g} m"
            raise broken(rule, at=("winch", "longest_m"), value=self.winch.longest_m, unit="m")
        if self.winch.longest_m > 1000 * element_m:
            rule = f"must be at most 1000 elements of {element_m:g} m; use fewer elements"
            raise broken(rule, at=("winch", "longest_m"), value=self.winch.longest_m, unit="m")
        if not element_m <= least_m <= self.length_m:
            rule = f"must be at least one element, {element_m:g} m, and at most length_m"
            raise broken(rule, at=("winch", "shortest_m"), value=least_m, unit="m")
        return self


class Tethered(NamedTuple):
    """A vehicle or object with a tether, at the second end of which it is.

    body: its number among the core's bodies, vehicles and then objects. keys: its place in the scenario.
    """

    body: int
    keys: tuple[str, int]
    name: str
    tether: Tether
