"""Pipeline following: steers by bumps on the bed in sonar pings and by the pipe in camera pictures.

The tilted fan crosses the pipe a few metres ahead, and the camera sees it below (`pipe_view`). The pipe's track
(`pipe_track`) is built from both, or from one alone if the other sees nothing. The vehicle follows the track by pure
pursuit (Coulter, "Implementation of the pure pursuit path tracking algorithm", CMU-RI-TR-92-01, 1992). Neither charts
nor labels are used. A pipe that crosses the path at more than about 60 degrees fills the fan and does not appear as a
bump: start roughly along it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from uwsim.base.arguments import require_positive
from uwsim.base.arrays import Floats
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.planners.pipe_track import PipeTrack
from uwsim.missions.planners.pipe_view import pipe_in_picture
from uwsim.missions.planners.unknown_water import find_bed
from uwsim.missions.planners.wayfinder import Wayfinder
from uwsim.missions.steps import Steps, StoppedError
from uwsim.missions.vehicle import PictureLike
from uwsim.navigation.sensor_choice import height_above_bed_m

PING_PERIOD_S, LOOK_PERIOD_S = 0.5, 1.0
LOOK_PIXELS = 320  # width of the pictures searched for the pipe
FARTHEST = 1.5  # in multiples of view_m; hits farther away, from too high, would leave a gap in the track
BLIND_S = 15.0  # time without a sighting after which an instrument counts as not seeing the pipe


@dataclass(frozen=True, eq=False)
class PipelineTrack:
    """The outcome of `follow_pipeline`.

    crossings_m: positions where the pipe was seen, in order, (n, 2). by_sonar, by_camera: number of sightings by each.
    pictures: number of pictures taken along length_m.
    """

    crossings_m: Floats
    length_m: float
    pictures: int
    by_sonar: int
    by_camera: int


def follow_pipeline(
    vehicle: OwnVehicle,
    start_m: Sequence[float],
    heading_rad: float,
    *,
    diameter_m: float = 0.8,
    altitude_m: float = 3.0,
    speed_m_s: float = 0.5,
    search_m: float = 12.0,
    camera: str | None = "down",
    picture_every_m: float = 5.0,
) -> Steps[PipelineTrack]:
    """Travel to start_m (2,), search for a pipe along heading_rad, and follow it until it is not seen for search_m.

    camera: a downward-looking camera, also used for steering, that takes a picture every picture_every_m; None for no
    camera. Logs `pipe_found`, `picture` with the mean and standard deviation of its grey levels (0..255) as brightness
    and contrast, `unseen` if the sonar or camera has not seen the pipe for some time, and `pipe_lost`. Raises
    StoppedError if no pipe is found within search_m, and ValueError for invalid arguments.
    """
    require_positive(diameter_m=diameter_m, search_m=search_m, picture_every_m=picture_every_m)
    eye = None if camera is None else vehicle.cameras[camera]
    lookout = Wayfinder(vehicle, altitude_m, speed_m_s)
    yield from lookout.tilt()
    yield from find_bed(vehicle)
    if not (yield from lookout.go_to(start_m)):
        raise StoppedError(f"no path led to the pipe's start ({start_m[0]:.1f}, {start_m[1]:.1f}) m")
    for lamp in vehicle.lamps.values() if eye is not None else ():
        lamp.on = True
    track = PipeTrack(np.asarray(start_m, np.float64), heading_rad, diameter_m)
    look = _Look(vehicle, lookout, eye, track, diameter_m)
    pictures, pictured_m = 0, -math.inf
    while True:
        position = np.asarray(vehicle.pose.position_world_m[:2], np.float64)
        if track.beyond_m(position) > search_m or lookout.must_stop:
            break
        yield from lookout.towards(track.ahead(position))
        look.now()
        flown_m = track.length_m - max(-track.beyond_m(position), 0.0)
        if eye is not None and track.places and flown_m >= pictured_m + picture_every_m:
            pictured_m, pictures = max(flown_m, 0.0), pictures + 1
            vehicle.log("picture", number=pictures, at_m=pictured_m, **_seen(eye.capture()))
    if not track.places:
        raise StoppedError(f"no pipe was found within {search_m:g} m")
    vehicle.log("pipe_lost", position_m=track.places[-1].tolist(), length_m=track.length_m, **look.sights)
    return PipelineTrack(
        np.array(track.places), track.length_m, pictures, look.sights["by_sonar"], look.sights["by_camera"]
    )


class _Look:
    """Looks for the pipe with sonar and camera whenever either is due. sights: number of sightings by each."""

    def __init__(self, vehicle: OwnVehicle, lookout: Wayfinder, eye: Any, track: PipeTrack, diameter_m: float) -> None:
        self._vehicle, self._lookout, self._track, self._diameter_m = vehicle, lookout, track, diameter_m
        resized = getattr(eye, "resized", None)  # a remote camera has a fixed size
        self._eye = eye if resized is None else resized(LOOK_PIXELS)
        self.sights = {"by_sonar": 0, "by_camera": 0}
        self._due_s = dict.fromkeys(self.sights, -math.inf)
        self._seen_s = dict.fromkeys(self.sights, vehicle.time_s)

    def now(self) -> None:
        """Look with the instruments that are due."""
        if self._is_due("by_sonar", PING_PERIOD_S):
            echoes = self._lookout.echoes_world_m
            away_m = np.linalg.norm(echoes[:, :2] - self._vehicle.pose.position_world_m[:2], axis=1)
            self._note("by_sonar", self._track.add_ping(echoes[away_m < FARTHEST * self._lookout.view_m]))
        if self._eye is not None and self._is_due("by_camera", LOOK_PERIOD_S):
            pose, altitude_m = self._vehicle.pose, height_above_bed_m(self._vehicle)
            pipe = pipe_in_picture(self._eye.capture(), float(pose.position_world_m[2]) - altitude_m, self._diameter_m)
            self._note("by_camera", self._track.add_picture(pipe))

    def _is_due(self, name: str, period_s: float) -> bool:
        due = self._vehicle.time_s >= self._due_s[name]
        if due:
            self._due_s[name] = self._vehicle.time_s + period_s - 1e-6
        return due

    def _note(self, name: str, seen: bool) -> None:
        now_s = self._vehicle.time_s
        if seen:
            if not any(self.sights.values()):
                self._vehicle.log("pipe_found", position_m=self._track.places[0].tolist(), **{name: True})
            self.sights[name] += 1
            self._seen_s[name] = now_s
        elif now_s - self._seen_s[name] > BLIND_S:
            self._seen_s[name] = math.inf  # logged only once until it is seen again
            self._vehicle.log("unseen", **{name: True})


def _seen(frame: PictureLike) -> dict[str, float]:
    grey = np.asarray(frame.rgb, np.float64).mean(axis=2)
    return {"brightness": round(float(grey.mean()), 1), "contrast": round(float(grey.std()), 1)}
