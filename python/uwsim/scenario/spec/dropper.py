"""A dropper or launcher on a vehicle: loose bodies that it carries until it lets go of them."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from uwsim.scenario.spec.fields import InRange, Model, Name, Point3, YawPitchRoll, broken


class Dropper(Model):
    """A dropper of markers, or a launcher of torpedoes, with a magazine.

    position_m, yaw_pitch_roll_deg: its frame in the body; bodies leave along its x, turned in it as their shapes
    are in the world. holds: names of the scenario's objects that it carries, in the order in which it lets go of
    them; their own places in the scenario do not count. spacing_m: from each to the next one, in its frame.
    spring_j: energy of the spring that pushes a body out; 0: it is dropped. jet_n, jet_s: thrust of the body's own
    jet along its x, and how long it lasts.
    """

    position_m: Point3
    yaw_pitch_roll_deg: YawPitchRoll = (0.0, 0.0, 0.0)
    holds: Annotated[tuple[Name, ...], Field(min_length=1, max_length=20)]
    spacing_m: Point3 = (0.0, 0.0, 0.0)
    spring_j: Annotated[float, InRange(0, 1e5, "J")] = 0.0
    jet_n: Annotated[float, InRange(0, 1e5, "N")] = 0.0
    jet_s: Annotated[float, InRange(0, 1000, "s")] = 0.0

    @model_validator(mode="after")
    def _jet_has_a_duration(self) -> Dropper:
        if (self.jet_n > 0) != (self.jet_s > 0):
            raise broken("give both jet_n and jet_s, or none", at=("jet_s",), value=self.jet_s, unit="s")
        return self
