"""Props: sets of obstacles and bodies from files of their own, which a scenario places as one."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field, model_validator
from pydantic_core.core_schema import ValidationInfo

from uwsim.base.quaternions import of_yaw_pitch_roll_deg, turned
from uwsim.scenario.read.spec_file import read_spec
from uwsim.scenario.spec.arm import Link
from uwsim.scenario.spec.camera import Colour
from uwsim.scenario.spec.fields import AssetName, Degrees, Model, Name, Point3, broken
from uwsim.scenario.spec.loose_body import LooseBody
from uwsim.scenario.spec.obstacle import ObstacleModel, ObstacleSpec, Placed
from uwsim.scenario.spec.pinger import Frequency, Pinger
from uwsim.scenario.spec.tether import BodyAnchor

FOLDER = "props"
IN_THE_WORLD = ("path", "scatter", "wrenches", "velocity_m_s")
"""Keys of a body that state places or directions in the world: those of a prop do without."""
PropName = Annotated[str, AssetName(FOLDER)]


class Prop(Model):
    """A set of obstacles and bodies, such as a bin with its lid, in a frame of its own: x ahead, y to the left, z up.

    source: after which rules or plans it is made, with their year, and what is assumed. obstacles, objects: as in a
    scenario; kinds with a position_m of three numbers. pingers: as in a scenario.
    """

    name: Name
    description: str
    source: str = Field(min_length=1)
    obstacles: Annotated[tuple[ObstacleSpec, ...], Field(max_length=200)] = ()
    objects: Annotated[tuple[LooseBody, ...], Field(max_length=50)] = ()
    pingers: Annotated[tuple[Pinger, ...], Field(max_length=10)] = ()

    @model_validator(mode="after")
    def _can_be_moved(self) -> Prop:
        shapes: list[tuple[tuple[str | int, ...], ObstacleModel]] = [
            (("obstacles", index), one) for index, one in enumerate(self.obstacles)
        ]
        shapes += [(("objects", index, "shape"), one.shape) for index, one in enumerate(self.objects)]
        names = [shape.name for _, shape in shapes]
        for number, (at, shape) in enumerate(shapes):
            if not isinstance(shape, Placed):
                raise broken("has no place of three numbers; it cannot be part of a prop", at=(*at, "kind"))
            if shape.name in names[:number]:
                raise broken("is already in use", at=(*at, "name"), value=shape.name)
        for index, body in enumerate(self.objects):
            for key in IN_THE_WORLD:
                if key in body.model_fields_set:
                    raise broken("must be left out in a prop", at=("objects", index, key))
        return self


def _prop(value: object, info: ValidationInfo) -> object:
    if isinstance(value, str | Path):
        return read_spec(Prop, value, FOLDER, (info.context or {}).get("folder"))
    return value


class PropEntry(Model):
    """A prop in a scenario, which stands for its obstacles and objects; their names begin with its name.

    model: the name of a packaged prop, or the path of its YAML file. position_m: the prop's origin in the world.
    yaw_deg: direction of its x, counter-clockwise from east. pitch_deg, roll_deg: how it leans then, about its y and
    its x. colour: albedo of its painted parts that state none. frequency_hz: of its pingers, instead of the file's.
    """

    name: Name
    model: Annotated[Prop, BeforeValidator(_prop, json_schema_input_type=PropName | Prop)] = Field(examples=["drum"])
    position_m: Point3
    yaw_deg: Degrees = 0.0
    pitch_deg: Degrees = 0.0
    roll_deg: Degrees = 0.0
    colour: Colour | None = None
    frequency_hz: Frequency | None = None

    def obstacles(self) -> list[ObstacleModel]:
        """Return its obstacles in the world."""
        return [self._shape(one) for one in self.model.obstacles]

    def objects(self) -> list[LooseBody]:
        """Return its bodies in the world."""
        return [self._body(one) for one in self.model.objects]

    def pingers(self) -> list[Pinger]:
        """Return its pingers in the world."""
        tone = {} if self.frequency_hz is None else {"frequency_hz": self.frequency_hz}
        return [
            one.model_copy(
                update={"name": f"{self.name}_{one.name}", "position_m": self.in_world(one.position_m), **tone}
            )
            for one in self.model.pingers
        ]

    @property
    def turn_deg(self) -> Point3:
        """Its yaw, pitch and roll."""
        return self.yaw_deg, self.pitch_deg, self.roll_deg

    def in_world(self, point_m: Point3) -> Point3:
        """Return a point of its frame in the world."""
        x, y, z = turned(of_yaw_pitch_roll_deg(self.turn_deg), np.asarray(point_m)).tolist()
        return x + self.position_m[0], y + self.position_m[1], z + self.position_m[2]

    def _shape(self, shape: ObstacleModel) -> ObstacleModel:
        assert isinstance(shape, Placed)
        moved = shape.placed(f"{self.name}_{shape.name}", self.in_world(shape.position_m), self.turn_deg)
        return self._painted(moved)

    def _painted(self, shape: ObstacleModel) -> ObstacleModel:
        material = shape.material
        if self.colour is None or material.kind != "paint" or material.colour is not None:
            return shape
        return shape.model_copy(update={"material": material.model_copy(update={"colour": self.colour})})

    def _body(self, body: LooseBody) -> LooseBody:
        changes: dict[str, Any] = {"shape": self._shape(body.shape)}
        if body.links is not None:
            changes["links"] = {name: self._link(link) for name, link in body.links.items()}
        if body.tether is not None:
            anchor = body.tether.anchor
            if isinstance(anchor, BodyAnchor):
                anchor = anchor.model_copy(update={"to": f"{self.name}_{anchor.to}"})
            elif not isinstance(anchor, str):
                anchor = self.in_world(anchor)
            changes["tether"] = body.tether.model_copy(update={"anchor": anchor})
        return body.model_copy(update=changes)

    def _link(self, link: Link) -> Link:
        return link if link.shape is None else link.model_copy(update={"shape": self._painted(link.shape)})
