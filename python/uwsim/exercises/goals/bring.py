"""The goal `bring`: a loose body lies where it is to be."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from pydantic import StrictBool

from uwsim.base.named import did_you_mean
from uwsim.exercises.goal import Duration, GoalModel, Within
from uwsim.exercises.moment import Floats, Moment
from uwsim.scenario.spec.fields import InRange, Name, Point3
from uwsim.simulator.simulator import Simulator


class Bring(GoalModel):
    """Bring a loose body to a place, and let go of it there.

    object: one of the scenario's `objects`. position_m: of the middle of its volume, in the world. within_m: distance
    from it. axis_world, within_deg: the direction that its x axis is to have, such as that of a plug in its socket; by
    default any. for_s: how long it stays. let_go: whether the vehicle must not touch it meanwhile.
    """

    kind: Literal["bring"]
    object: Name
    position_m: Point3
    within_m: Within = 0.3
    axis_world: Point3 | None = None
    within_deg: Annotated[float, InRange(0.1, 180, "deg")] = 10.0
    for_s: Duration = 2.0
    let_go: StrictBool = True

    def require(self, sim: Simulator) -> None:
        """See GoalModel."""
        require_loose(self.object, sim)

    def is_met_at(self, moment: Moment) -> bool:
        """Return whether the body is in its place and free."""
        body = moment.sim.objects[self.object]
        pose = body.pose
        if math.dist(pose.position_world_m.tolist(), self.position_m) > self.within_m:
            return False
        if self.axis_world is not None and _apart_deg(pose.world_from_body[:3, 0], self.axis_world) > self.within_deg:
            return False
        return not body.carried and not (
            self.let_go and any(contact.other == moment.vehicle.name for contact in body.contacts)
        )


def require_loose(name: str, sim: Simulator) -> None:
    """Raise ValueError unless this is the name of a loose body."""
    known = [body.name for body in sim.scenario.objects if body.path is None and not body.fixed]
    if name not in known:
        rule = f"must be one of {', '.join(known)}" if known else "no object is loose"
        raise ValueError(f"object = '{name}': {rule}{did_you_mean(name, known)}")


def _apart_deg(axis: Floats, other: Point3) -> float:
    cosine = float(axis @ np.asarray(other)) / max(math.hypot(*other), 1e-12)
    return math.degrees(math.acos(min(max(cosine, -1.0), 1.0)))
