"""Pipeline following: it steers by what the sonar sees stand out of the bed, and the camera takes pictures of it.

The tilted fan meets the bed in a line across the way. Less its running median, which is the bed, a pipe is a bump of
about its own width: the middle of it is where the pipe crosses the fan. The crossings of the last pings are the pipe's
track ahead of the vehicle, and it pursues that track (Coulter, "Implementation of the pure pursuit path tracking
algorithm", CMU-RI-TR-92-01, 1992). Neither chart nor label is used. A pipe that crosses the way at more than about 60
degrees fills the fan and is not seen as a bump: begin roughly along it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.planners.lookout import Lookout
from uwsim.missions.planners.unknown_water import find_bed
from uwsim.missions.steps import Steps
from uwsim.missions.stopped import StoppedError

Floats = NDArray[np.float64]
STANDS_OUT = 0.35  # of the diameter, above the bed
NARROWEST, WIDEST = 0.3, 3.0  # of the diameter: width of a bump
BED_WINDOW = 6.0  # diameters: of the running median
FIRST_REACH_M = 4.0  # how far aside of the way the first crossing may be
JUMP_M = 1.5  # how far from the track, drawn on, a crossing may be
PURSUED_M = 3.0  # distance ahead on the track at which the vehicle aims
TRACK_M = 6.0  # length of the track's end that gives its direction
PING_PERIOD_S = 0.5
FEWEST_BEAMS = 20


@dataclass(frozen=True, eq=False)
class PipelineTrack:
    """crossings_m: (n, 2), where the sonar saw the pipe, in order. pictures: how many were taken, of length_m."""

    crossings_m: Floats
    length_m: float
    pictures: int


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
    """Go to start_m (2,), look for a pipe along heading_rad, and follow it until it is not seen for search_m.

    camera: takes a picture every picture_every_m; None for none. Logs `pipe_found`, `picture` with the mean brightness
    and the contrast of its grey levels in 0..255, and `pipe_lost`. Raises StoppedError if no pipe is found in search_m;
    ValueError.
    """
    for name, value in (("diameter_m", diameter_m), ("search_m", search_m), ("picture_every_m", picture_every_m)):
        if not 0.0 < value < math.inf:
            raise ValueError(f"{name} = {value} m: must be positive")
    eye = None if camera is None else vehicle.cameras[camera]
    lookout = Lookout(vehicle, altitude_m, speed_m_s)
    yield from lookout.tilt()
    yield from find_bed(vehicle)
    if not (yield from lookout.go_to(start_m)):
        raise StoppedError(f"no way led to the pipe's start ({start_m[0]:.1f}, {start_m[1]:.1f}) m")
    for lamp in vehicle.lamps.values() if eye is not None else ():
        lamp.on = True
    track = _Track(np.asarray(start_m, np.float64), heading_rad, diameter_m)
    pictures, pictured_m, next_s = 0, -math.inf, -math.inf
    while True:
        position = np.asarray(vehicle.pose.position_world_m[:2], np.float64)
        if track.beyond_m(position) > search_m or lookout.must_stop:
            break
        yield from lookout.towards(track.ahead(position))
        if vehicle.time_s < next_s:
            continue
        next_s = vehicle.time_s + PING_PERIOD_S
        if track.add(lookout.echoes_world_m) and len(track.crossings) == 1:
            vehicle.log("pipe_found", position_m=track.crossings[0].tolist())
        flown_m = track.length_m - max(-track.beyond_m(position), 0.0)
        if eye is not None and track.crossings and flown_m >= pictured_m + picture_every_m:
            pictured_m, pictures = max(flown_m, 0.0), pictures + 1
            vehicle.log("picture", number=pictures, at_m=pictured_m, **_seen(eye.capture()))
    if not track.crossings:
        raise StoppedError(f"no pipe was found within {search_m:g} m")
    vehicle.log("pipe_lost", position_m=track.crossings[-1].tolist(), length_m=track.length_m)
    return PipelineTrack(np.array(track.crossings), track.length_m, pictures)


class _Track:
    """The crossings so far, and where they lead."""

    def __init__(self, start_m: Floats, heading_rad: float, diameter_m: float) -> None:
        self._end = start_m
        self._direction = np.array([math.cos(heading_rad), math.sin(heading_rad)])
        self._diameter_m = diameter_m
        self.crossings: list[Floats] = []
        self.length_m = 0.0

    def beyond_m(self, position: Floats) -> float:
        """How far past the track's end a position is, along its direction."""
        return float((position - self._end) @ self._direction)

    def ahead(self, position: Floats) -> Floats:
        """The point to aim at: on the track PURSUED_M ahead, or as far beyond its end."""
        for crossing in self.crossings[-50:]:
            away = crossing - position
            if float(away @ self._direction) > 0.0 and float(np.linalg.norm(away)) >= PURSUED_M:
                return crossing
        along_m = max(self.beyond_m(position), 0.0) + PURSUED_M
        return self._end + along_m * self._direction

    def add(self, echoes_world_m: Floats) -> bool:
        """Add where the pipe crosses a ping; return whether it is seen."""
        bumps = crossings(echoes_world_m, self._diameter_m)
        if not len(bumps):
            return False
        away = bumps - self._end
        aside = np.abs(away @ (-self._direction[1], self._direction[0]))
        best = int(np.argmin(aside))
        along_m = float(away[best] @ self._direction)
        reach_m = JUMP_M + 0.5 * max(along_m, 0.0) if self.crossings else FIRST_REACH_M
        if aside[best] > reach_m or along_m <= 0.1:
            return False
        if self.crossings:
            self.length_m += float(np.linalg.norm(away[best]))
        self.crossings.append(bumps[best])
        self._end = bumps[best]
        near = [c for c in self.crossings[-60:] if float(np.linalg.norm(c - self._end)) < TRACK_M]
        if len(near) > 2:
            self._direction = _direction(np.array(near), self._direction)
        return True


def crossings(echoes_world_m: Floats, diameter_m: float) -> Floats:
    """Where in a ping, (n, 3) in the order of its beams, something of a pipe's width stands out of the bed: (k, 2)."""
    if len(echoes_world_m) < FEWEST_BEAMS:
        return np.empty((0, 2))
    step_m = float(np.median(np.linalg.norm(np.diff(echoes_world_m[:, :2], axis=0), axis=1)))
    window = min(round(BED_WINDOW * diameter_m / max(step_m, 1e-3)) | 1, len(echoes_world_m) | 1)
    heights = echoes_world_m[:, 2]
    stands_out = heights - median_filter(heights, window, mode="nearest") > STANDS_OUT * diameter_m
    edges = np.flatnonzero(np.diff(np.concatenate([[False], stands_out, [False]]).astype(np.int8)))
    found = []
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        width_m = float(np.linalg.norm(echoes_world_m[last - 1, :2] - echoes_world_m[first, :2]))
        inside = first > 0 and last < len(heights)
        if inside and NARROWEST * diameter_m <= width_m <= WIDEST * diameter_m:
            found.append(echoes_world_m[first:last, :2].mean(axis=0))
    return np.array(found).reshape(-1, 2)


def _direction(points: Floats, before: Floats) -> Floats:
    """The direction of the line through points (n, 2), the way that `before` points."""
    _, _, axes = np.linalg.svd(points - points.mean(axis=0))
    return np.asarray(axes[0] if float(axes[0] @ before) >= 0.0 else -axes[0])


def _seen(frame: Any) -> dict[str, float]:
    grey = np.asarray(frame.rgb, np.float64).mean(axis=2)
    return {"brightness": round(float(grey.mean()), 1), "contrast": round(float(grey.std()), 1)}
