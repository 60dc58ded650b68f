"""The kinds of limits: each costs points whenever it is broken."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from uwsim.base.commands.notes import NoteCategory
from uwsim.base.named import did_you_mean
from uwsim.base.polygon import inside
from uwsim.exercises.goal import Points
from uwsim.exercises.moment import Moment
from uwsim.scenario.spec.fields import InRange, Model, Name, Point2
from uwsim.simulator.simulator import Simulator

TOUCH_M = 1.0
AGAIN_S = 3.0  # a limit broken again within this time counts only once


class LimitModel(Model):
    """The keys that all limits share.

    cost: points lost each time it is broken. ends: whether breaking it ends the exercise.
    """

    text: ClassVar[str]
    """Its title, with the values of fields in braces."""

    cost: Points = 5.0
    ends: bool = False

    if TYPE_CHECKING:
        kind: str

    def is_broken(self, moment: Moment, collisions_before: int) -> bool:
        """Return whether the limit is broken at a moment. collisions_before: the number up to the previous moment."""
        raise NotImplementedError

    def require(self, sim: Simulator) -> None:
        """Raise ValueError if the simulator's scenario lacks what the limit needs."""

    @property
    def title(self) -> str:
        """The text shown to the pilot."""
        return self.text.format_map(dict(self))


class Collisions(LimitModel):
    """No collisions.

    besides: the bodies that the task has the vehicle touch. A touch that has ended when it is judged, within 0.1 s,
    counts as theirs if the vehicle is within 1 m of one of them.
    """

    text = "No collision"

    kind: Literal["collision"]
    besides: list[Name] = Field(default_factory=list)

    def is_broken(self, moment: Moment, collisions_before: int) -> bool:
        """See LimitModel."""
        if moment.collisions <= collisions_before:
            return False
        if not self.besides:
            return True
        met = {contact.other for contact in moment.vehicle.contacts}
        places = (tuple(moment.sim.objects[name].pose.position_world_m.tolist()) for name in self.besides)
        return not met <= set(self.besides) if met else all(moment.distance_m(place) > TOUCH_M for place in places)

    def require(self, sim: Simulator) -> None:
        """See LimitModel."""
        for name in self.besides:
            if name not in sim.objects:
                known = ", ".join(sim.objects) or "none: there are none"
                raise ValueError(f"besides = '{name}': must be one of {known}{did_you_mean(name, sim.objects)}")


class Deepest(LimitModel):
    """A maximum depth.

    most_m: depth, positive down.
    """

    text = "Not deeper than {most_m:g} m"

    kind: Literal["depth"]
    most_m: Annotated[float, InRange(0, 11000, "m")] = Field(examples=[10])

    def is_broken(self, moment: Moment, collisions_before: int) -> bool:
        """See LimitModel."""
        return -float(moment.position_world_m[2]) > self.most_m


class Lowest(LimitModel):
    """A minimum altitude above the bed.

    least_m: altitude.
    """

    text = "At least {least_m:g} m above the bed"

    kind: Literal["altitude"]
    least_m: Annotated[float, InRange(0, 1000, "m")] = Field(examples=[0.5])

    def is_broken(self, moment: Moment, collisions_before: int) -> bool:
        """See LimitModel."""
        return moment.altitude_m < self.least_m


class Fastest(LimitModel):
    """A maximum speed over ground.

    most_m_s: speed.
    """

    text = "Not faster than {most_m_s:g} m/s"

    kind: Literal["speed"]
    most_m_s: Annotated[float, InRange(0.01, 100, "m/s")] = Field(examples=[1])

    def is_broken(self, moment: Moment, collisions_before: int) -> bool:
        """See LimitModel."""
        return moment.speed_m_s > self.most_m_s


class Area(LimitModel):
    """An area that the vehicle must not leave.

    area_m: a polygon, x and y.
    """

    text = "Stay within the area"

    kind: Literal["area"]
    area_m: list[Point2] = Field(min_length=3, max_length=1000)

    def is_broken(self, moment: Moment, collisions_before: int) -> bool:
        """See LimitModel."""
        point: Any = moment.position_world_m[None, :2]
        return not bool(inside(point, np.array(self.area_m))[0])


class Reports(LimitModel):
    """A maximum number of notes of a category, to discourage false reports.

    category: the notes' category. most: the largest number allowed.
    """

    text = "At most {most} notes: {category}"

    kind: Literal["reports"]
    category: NoteCategory = "defect"
    most: Annotated[int, InRange(1, 500)]

    def is_broken(self, moment: Moment, collisions_before: int) -> bool:
        """See LimitModel."""
        return len(moment.notes(self.category)) > self.most


class Tangled(LimitModel):
    """The tether of the exercise's vehicle must not go round an upright obstacle (docs/guides/tether.md).

    within_m: the distance from its anchor in which that counts; by default any.
    """

    kind: Literal["tangled"]
    within_m: Annotated[float, InRange(0.1, 1e4, "m")] | None = None

    def require(self, sim: Simulator) -> None:
        """See LimitModel."""
        require_turns(sim)

    def is_broken(self, moment: Moment, collisions_before: int) -> bool:
        """See LimitModel."""
        tether = moment.vehicle.tether
        if tether is None:
            return False
        now = tether.read()
        far_m = float(np.linalg.norm(moment.position_world_m - now.points_world_m[0]))
        return now.is_tangled and (self.within_m is None or far_m <= self.within_m)

    @property
    def title(self) -> str:
        """See LimitModel."""
        where = "" if self.within_m is None else f", within {self.within_m:g} m of its anchor"
        return f"No turn of the tether round an obstacle{where}"


def require_turns(sim: Simulator) -> None:
    """Raise ValueError unless a vehicle has a tether, and something that it could go round."""
    if all(vehicle.tether is None or not vehicle.tether.read().turns for vehicle in sim.vehicles.values()):
        raise ValueError(
            f"scenario '{sim.scenario.name}': has no tether, or no upright obstacle that it could go round"
        )


Limit = Annotated[Collisions | Deepest | Lowest | Fastest | Area | Reports | Tangled, Field(discriminator="kind")]
