"""The `path` of a body under `objects:`: where it is when, whatever it meets."""

from __future__ import annotations

from itertools import pairwise
from math import dist
from typing import Annotated

from pydantic import Field, StrictBool, model_validator

from uwsim.scenario.spec.fields import InRange, Model, Point3, broken


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
