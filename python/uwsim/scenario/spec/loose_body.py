"""An entry under `objects:` in a scenario: a body that is loose, or that no force moves: on a path, or fixed."""

from __future__ import annotations

from typing import Annotated, cast

from pydantic import Field, StrictBool, model_validator

from uwsim.scenario.spec.applied_wrench import AppliedWrench
from uwsim.scenario.spec.arm import Link, links_in_order
from uwsim.scenario.spec.body_path import BodyPath
from uwsim.scenario.spec.fields import InRange, Model, Name, broken
from uwsim.scenario.spec.obstacle import ObstacleSpec, Placed
from uwsim.scenario.spec.scatter import Scatter
from uwsim.scenario.spec.tether import Tether

LOOSE_KINDS = ("box", "cylinder", "mesh", "sphere")
Speed = Annotated[float, InRange(-100, 100, "m/s")]


class LooseBody(Model):
    """A loose body of uniform density. It starts where its shape is, at `velocity_m_s`.

    shape: a box, sphere, cylinder or mesh as under `obstacles`, with its name, place and material. density_kg_m3,
    mass_kg: one of them; the mass fills the shape, so that the centre of mass is that of its volume. drag_coefficient:
    of the area that faces the flow; by default by shape and axis, such as 1.05 for a cube and 1.17 for a plate, of a
    sphere by the Reynolds number at which it sinks or rises, and 1 for a mesh (uwsim.scenario.build.bluff_drag).
    munk_share: how much is left of the Munk moment of its added mass, by which a long body turns broadside: none of one
    with fins that balance it. friction, restitution: as for vehicles. velocity_m_s: along the world's axes. wrenches:
    what pushes it from outside, by schedule.
    path: what the body follows instead, such as a diver or a boat: no force moves it, so it has neither density nor
    mass, and it pushes what it meets. fixed: it stands where its shape is, like an obstacle. links: of a fixed body,
    what joints hold on it, by name, as in a vehicle's `arm` but without motors: a valve's handle, a pin, a door.
    scatter: many of it at random places, such as debris; by default there is one.
    tether: a cable from it to anything else; by default none.
    """

    shape: ObstacleSpec
    density_kg_m3: Annotated[float, InRange(1, 25_000, "kg/m3")] | None = None
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
