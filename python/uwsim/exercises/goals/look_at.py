"""The goal `look_at`: a camera keeps a place, or something that moves, in view."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from uwsim.base import lens_model
from uwsim.exercises.goal import Duration, GoalModel, Within
from uwsim.exercises.moment import Floats, Moment
from uwsim.scenario.spec.fields import InRange, Name, Point3, broken
from uwsim.simulator.simulator import Simulator


class Sight(GoalModel):
    """The fields of goals that cameras meet.

    within_m: distance from the camera. for_s: uninterrupted time. cameras: names, by default all that move with the
    vehicle's body. clear_m: surfaces this close to the place do not count as hiding it.
    """

    within_m: Within = 3.0
    for_s: Duration = 2.0
    cameras: list[Name] = Field(default_factory=list)
    clear_m: Annotated[float, InRange(0, 10, "m")] = 0.3

    def is_in_view(self, moment: Moment, place: Floats) -> bool:
        """Return whether a camera sees a place (3,) in the world, unobstructed."""
        if float(np.linalg.norm(moment.position_world_m - place)) > self.within_m + 5.0:
            return False  # no camera is farther from the vehicle's centre
        cameras = moment.vehicle.cameras
        names = self.cameras or [name for name, one in cameras.items() if one.mount.follows == "body"]
        return any(self._sees(moment, cameras[name], place) for name in names)

    def _sees(self, moment: Moment, camera: Any, place: Floats) -> bool:
        world_from_camera = camera.world_from_camera
        eye = world_from_camera[:3, 3]
        ray = place - eye
        distance_m = float(np.linalg.norm(ray))
        if not camera.mount.on or not 1e-6 < distance_m <= self.within_m:
            return False
        ahead, left, up = (world_from_camera[:3, :3].T @ ray).tolist()
        if ahead <= 0.0:
            return False
        info, x, y = camera.info, np.array(-left / ahead), np.array(-up / ahead)
        size, pixel = np.array([info.width, info.height]), np.array(lens_model.project(info.k, info.d, x, y))
        if not lens_model.shows(info.d, x, y) or (np.abs(pixel - 0.5 * (size - 1)) > 0.5 * size).any():
            return False
        hit_m = float(moment.sim.scene.cast(eye[None], ray[None], distance_m).ranges_m[0])
        return hit_m >= distance_m - self.clear_m


class LookAt(Sight):
    """Keep a place, or a body that moves, in view of one of the vehicle's cameras.

    position_m: position in the world; object: instead, the name of one of the scenario's `objects`, whose middle is
    looked at. See Sight.
    """

    one_of = ("position_m", "object")

    kind: Literal["look_at"]
    position_m: Point3 | None = None
    object: Name | None = None

    @model_validator(mode="after")
    def _has_one_aim(self) -> LookAt:
        if (self.position_m is None) == (self.object is None):
            raise broken("give one of position_m and object", at=("position_m",), value=self.position_m)
        return self

    def is_met_at(self, moment: Moment) -> bool:
        """See GoalModel."""
        return self.is_in_view(moment, self.place(moment.sim))

    def require(self, sim: Simulator) -> None:
        """See GoalModel."""
        known = list(sim.objects)
        if self.object is not None and self.object not in known:
            raise ValueError(f"object = '{self.object}': must be one of {', '.join(known) or 'none: there are none'}")

    def place(self, sim: Simulator) -> Floats:
        """Return the place to be looked at now, (3,)."""
        if self.object is not None:
            return np.asarray(sim.objects[self.object].pose.position_world_m, np.float64)
        return np.array(self.position_m)
