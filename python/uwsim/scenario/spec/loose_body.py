"""An entry under `objects:` in a scenario: a body that is loose, or that no force moves: on a path, or fixed."""

from __future__ import annotations

from itertools import pairwise
from math import dist
from typing import Annotated, Literal, cast

import numpy as np
from pydantic import Field, StrictBool, model_validator

from uwsim.scenario.spec.arm import Link, links_in_order
from uwsim.scenario.spec.fields import InRange, Model, Name, Point3, broken
from uwsim.scenario.spec.obstacle import Bed, ObstacleSpec, Placed
from uwsim.scenario.spec.tether import Tether

Newtons = Annotated[float, InRange(-1e9, 1e9, "N")]
NewtonMetres = Annotated[float, InRange(-1e9, 1e9, "N m")]


class AppliedWrench(Model):
    """A force and torque that act on a body from outside, at its origin, in an interval of simulated time.

    force_n, torque_nm: along the axes. axes: `body`, which turn with the vehicle, or `world`. until_s: by default the
    end of the run.
    """

    force_n: tuple[Newtons, Newtons, Newtons] = (0.0, 0.0, 0.0)
    torque_nm: tuple[NewtonMetres, NewtonMetres, NewtonMetres] = (0.0, 0.0, 0.0)
    axes: Literal["body", "world"] = "body"
    from_s: Annotated[float, InRange(0, 1e9, "s")] = 0.0
    until_s: Annotated[float, InRange(0, 1e9, "s")] | None = None

    @model_validator(mode="after")
    def _ends_after_it_begins(self) -> AppliedWrench:
        if self.until_s is not None and self.until_s <= self.from_s:
            raise broken(f"must be after from_s, {self.from_s:g} s", at=("until_s",), value=self.until_s, unit="s")
        return self


class BodyPath(Model):
    """A smooth line through the place of the body's shape and then points_m, along which the body looks.

    points_m: the points that the shape's place passes, in order. speed_m_s: along the line; an open path begins and
    ends with a slow 2 s. times_s: instead, when the body is at each point, from 0 on; a closed path has one more time,
    that of its return. closed: it returns to its start and begins again; otherwise it stays at the end. climbs: it
    also looks up and down along the line; otherwise it stays level, like a boat. turns: false keeps it as its shape is
    turned, so that a boat at anchor may heave in place; only such a path leads straight up and down, or back.
    """

    points_m: Annotated[tuple[Point3, ...], Field(min_length=1, max_length=1000)]
    speed_m_s: Annotated[float, InRange(1e-3, 30, "m/s")] | None = None
    times_s: Annotated[tuple[Annotated[float, InRange(1e-3, 1e7, "s")], ...], Field(max_length=1001)] | None = None
    closed: StrictBool = False
    climbs: StrictBool = False
    turns: StrictBool = True

    @model_validator(mode="after")
    def _is_timed(self) -> BodyPath:
        if (self.speed_m_s is None) == (self.times_s is None):
            raise broken("give one of speed_m_s and times_s", at=("speed_m_s",), value=self.speed_m_s)
        for index, (a, b) in enumerate(pairwise(self.points_m), start=1):
            if dist(a, b) < 1e-3:
                raise broken("must differ from the point before", at=("points_m", index), value=list(b))
        if self.closed and self.turns and len(self.points_m) < 2:
            raise broken("a closed path must have two points or more", at=("points_m",), value=len(self.points_m))
        if self.climbs and not self.turns:
            raise broken("must be false for a body that does not turn", at=("climbs",), value=True)
        if self.times_s is None:
            return self
        count = len(self.points_m) + self.closed
        if len(self.times_s) != count:
            rule = f"must be {count} times, one for each point" + (" and one for the return" if self.closed else "")
            raise broken(rule, at=("times_s",), value=len(self.times_s))
        for index, (before, after) in enumerate(pairwise(self.times_s), start=1):
            if after <= before:
                raise broken("must be later than the time before", at=("times_s", index), value=after)
        return self


TRIES = 1000
Side = Annotated[float, InRange(0.1, 1e5, "m")]


class Scatter(Model):
    """Copies of a loose body, with the names NAME_1, NAME_2 and so on, in a rectangle about its position.

    per_100_m2: how many per 100 square metres, in all rounded to whole bodies. area_m: edges of the rectangle along the
    world's x and y. apart_m: least distance between two positions; by default, that at which they cannot meet whatever
    their headings. seed: of places and headings, which do not depend on the scenario's seed.
    """

    per_100_m2: Annotated[float, InRange(1e-4, 1e4)]
    area_m: tuple[Side, Side]
    apart_m: Annotated[float, InRange(0, 1e4, "m")] | None = None
    seed: Annotated[int, InRange(0, 2**63 - 1)] = 0

    @property
    def count(self) -> int:
        """How many bodies there are."""
        return round(0.01 * self.per_100_m2 * self.area_m[0] * self.area_m[1])

    def places(self, shape: Placed) -> list[tuple[float, float, float]]:
        """Return x, y [m] and heading [deg] of each copy of an obstacle; none if they do not fit."""
        random = np.random.default_rng(self.seed)
        apart_m = 2.0 * _radius_m(shape) if self.apart_m is None else self.apart_m
        half_m = 0.5 * np.array(self.area_m)
        places = np.empty((self.count, 3))
        for index in range(self.count):
            for _ in range(TRIES):
                at_m = shape.position_m[:2] + random.uniform(-half_m, half_m)
                if (np.linalg.norm(places[:index, :2] - at_m, axis=1) >= apart_m).all():
                    break
            else:
                return []
            places[index] = *at_m, random.uniform(0.0, 360.0)
        return [(x_m, y_m, heading_deg) for x_m, y_m, heading_deg in places.tolist()]


def _radius_m(shape: Placed) -> float:
    """Return how far an obstacle extends horizontally from its position."""
    vertices = shape.solid(cast(Bed, None)).vertices  # a shape that is placed uses no terrain
    return float(np.linalg.norm(vertices[:, :2] - np.asarray(shape.position_m)[:2], axis=1).max())


LOOSE_KINDS = ("box", "cylinder", "mesh", "sphere")
Speed = Annotated[float, InRange(-100, 100, "m/s")]


class LooseBody(Model):
    """A loose body of uniform density. It starts where its shape is, at `velocity_m_s`.

    shape: a box, sphere, cylinder or mesh as under `obstacles`, with its name, place and material. density_kg_m3,
    mass_kg: one of them; the mass fills the shape, so that the centre of mass is that of its volume. drag_coefficient:
    of the area that faces the flow; by default by shape and axis, such as 1.05 for a cube and 1.17 for a plate, of a
    sphere by the Reynolds number at which it sinks or rises, and 1 for a mesh (uwsim.scenario.build.hydrodynamics).
    munk_share: how much is left of the Munk moment of its added mass, by which a long body turns broadside: none of one
    with fins that balance it. friction, restitution: as for vehicles. velocity_m_s: along the world's axes. wrenches:
    what pushes it from outside, by schedule.
    path: what the body follows instead, such as a diver or a boat: no force moves it, so it has neither density nor
    mass, and it pushes what it meets. fixed: it stands where its shape is, like an obstacle. links: of a fixed body,
    what joints hold on it, by name, as in a vehicle's `arm` but without motors: a valve's handle, a pin, a door.
    scatter: many of it at random places, such as debris; by default there is one.
    tether: a cable from it to anything else; by default none.
    """

    one_of = ("density_kg_m3", "mass_kg")

    shape: ObstacleSpec
    density_kg_m3: Annotated[float, InRange(1, 25_000, "kg/m3")] | None = Field(None, examples=[1100])
    mass_kg: Annotated[float, InRange(1e-3, 1e7, "kg")] | None = None
    drag_coefficient: Annotated[float, InRange(0, 10)] | None = None
    munk_share: Annotated[float, InRange(0, 1)] = 1.0
    friction: Annotated[float, InRange(0, 10)] = 0.5
    restitution: Annotated[float, InRange(0, 1)] = 0.1
    velocity_m_s: tuple[Speed, Speed, Speed] = (0.0, 0.0, 0.0)
    wrenches: Annotated[tuple[AppliedWrench, ...], Field(max_length=1000)] | None = None
    path: BodyPath | None = None
    fixed: StrictBool = False
    links: Annotated[dict[Name, Link], Field(min_length=1, max_length=64)] | None = None
    scatter: Scatter | None = None
    tether: Tether | None = None

    @property
    def name(self) -> str:
        """The name of its shape."""
        return self.shape.name

    @model_validator(mode="after")
    def _has_one_mass(self) -> LooseBody:
        if self.shape.kind not in LOOSE_KINDS:
            raise broken(f"must be one of {', '.join(LOOSE_KINDS)}", at=("shape", "kind"), value=self.shape.kind)
        if self.links is not None and not self.fixed:
            raise broken("must be left out for a body that is not fixed", at=("links",))
        if self.path is not None or self.fixed:
            return self._is_not_pushed(
                "must be left out for a body " + ("that is fixed" if self.fixed else "on a path")
            )
        if (self.density_kg_m3 is None) == (self.mass_kg is None):
            raise broken("give one of density_kg_m3 and mass_kg", at=("density_kg_m3",), value=self.density_kg_m3)
        return self

    def _is_not_pushed(self, rule: str) -> LooseBody:
        for name in ("density_kg_m3", "mass_kg", *(("path",) if self.fixed else ())):
            if getattr(self, name) is not None:
                raise broken(rule, at=(name,), value=getattr(self, name))
        if self.wrenches:
            raise broken(rule, at=("wrenches",))
        if any(self.velocity_m_s):
            raise broken(rule, at=("velocity_m_s",), value=self.velocity_m_s)
        return self

    @model_validator(mode="after")
    def _can_be_scattered(self) -> LooseBody:
        if self.scatter is not None and self.path is not None:
            raise broken("must be left out for a body on a path", at=("scatter",))
        return self

    def scattered(self) -> list[LooseBody]:
        """Return the bodies that the entry stands for: itself, or its copies; none if these do not fit."""
        if self.scatter is None:
            return [self]
        bodies, shape = [], cast(Placed, self.shape)  # as LOOSE_KINDS are
        for number, (x_m, y_m, heading_deg) in enumerate(self.scatter.places(shape), start=1):
            moved = shape.placed(f"{self.name}_{number}", (x_m, y_m, shape.position_m[2]), (heading_deg, 0.0, 0.0))
            bodies.append(self.model_copy(update={"shape": moved, "scatter": None}))
        return bodies

    @model_validator(mode="after")
    def _has_own_links(self) -> LooseBody:
        for name, link in (self.links or {}).items():
            for joint in ("hinge", "slide"):
                for key, rule in (("motor", "nothing commands it"), ("errors", "nothing measures it")):
                    if getattr(getattr(link, joint), key, None) is not None:
                        raise broken(f"must be left out: {rule}", at=("links", name, joint, key))
        links_in_order(self.links or {}, "links")
        return self
