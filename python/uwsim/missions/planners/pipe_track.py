"""The track of a pipe that a vehicle follows, from what its sonar and its camera see of it.

The sonar sees where the pipe crosses its fan, some metres ahead; the camera sees the pipe below. Each new place beyond
the track's end, by whichever of both, makes the track longer. Where the camera sees the pipe beside the track that the
sonar has laid out, both differ by what the vehicle's position has drifted since: all of the track that lies ahead is
shifted by a share of it, the gain of a Kalman filter for that one offset.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from uwsim.missions.planners.pipe_view import SeenPipe

Floats = NDArray[np.float64]
STANDS_OUT = 0.35  # of the diameter, above the bed
NARROWEST, WIDEST = 0.3, 3.0  # of the diameter: width of a bump
BED_WINDOW = 6.0  # diameters: of the running median
FEWEST_BEAMS = 20
FIRST_REACH_M = 4.0  # how far aside of the way the first sight may be
JUMP_M = 1.5  # how far from the track, drawn on, a sight may be
STEEPEST = math.cos(math.radians(50.0))  # of a pipe in the picture towards the track
NEW_M = 0.3  # beyond the track's end: a new place by the camera
PURSUED_M = 3.0  # distance ahead on the track at which the vehicle aims
TRACK_M = 6.0  # length of the track's end that gives its direction
BESIDE_M = 2.0  # along the track: the places that what the camera sees is compared with
SONAR_M, CAMERA_M = 0.25, 0.15  # standard deviations of a place across the pipe
DRIFT = 0.03  # of the vehicle's position, of the way


class PipeTrack:
    """The places of a pipe in their order, (2,) each, and where they lead. length_m: of the track."""

    def __init__(self, start_m: Floats, heading_rad: float, diameter_m: float) -> None:
        self._end = start_m
        self._direction = np.array([math.cos(heading_rad), math.sin(heading_rad)])
        self._diameter_m = diameter_m
        self._variance_m2 = SONAR_M**2  # of the offset between track and pipe
        self._seen_before = False
        self.places: list[Floats] = []
        self.length_m = 0.0

    def beyond_m(self, position: Floats) -> float:
        """How far past the track's end a position is, along its direction."""
        return float((position - self._end) @ self._direction)

    def ahead(self, position: Floats) -> Floats:
        """The point to aim at: on the track PURSUED_M ahead, or as far beyond its end."""
        for place in self.places[-50:]:
            away = place - position
            if float(away @ self._direction) > 0.0 and float(np.linalg.norm(away)) >= PURSUED_M:
                return place
        along_m = max(self.beyond_m(position), 0.0) + PURSUED_M
        return self._end + along_m * self._direction

    def add_ping(self, echoes_world_m: Floats) -> bool:
        """Add where the pipe crosses a ping; return whether it is seen."""
        bumps = crossings(echoes_world_m, self._diameter_m)
        if not len(bumps):
            return False
        nearest = bumps[int(np.argmin(self._aside_m(bumps)))]
        if not self._fits(nearest) or self.beyond_m(nearest) <= 0.1:
            return False
        self._add(nearest)
        return True

    def add_picture(self, pipe: SeenPipe | None) -> bool:
        """Take what a picture shows, None for nothing: correct the track, and add what is new; return whether it fits.

        Two pictures in a row must show the pipe: one of caustics alone may look like it.
        """
        before, self._seen_before = self._seen_before, False
        if pipe is None or abs(along := float(pipe.direction @ self._direction)) < STEEPEST:
            return False
        direction = pipe.direction if along > 0.0 else -pipe.direction
        farthest = pipe.point_world_m + (pipe.reach_m[1] if along > 0.0 else -pipe.reach_m[0]) * direction
        beside = [c for c in self.places[-60:] if abs(float((c - pipe.point_world_m) @ direction)) < BESIDE_M]
        across = np.array([-direction[1], direction[0]])
        off_m = float(np.mean([(pipe.point_world_m - place) @ across for place in beside])) if beside else 0.0
        self._seen_before = abs(off_m) <= JUMP_M if beside else self._fits(farthest)
        if not (before and self._seen_before):
            return False
        if beside:
            self._shift(off_m * across, pipe.point_world_m)
        if self.beyond_m(farthest) > NEW_M:
            self._add(farthest)
        return bool(self.places)

    def _aside_m(self, points: Floats) -> Floats:
        """How far (n,) points (n, 2) are aside of the track, drawn on."""
        return np.asarray(np.abs((points - self._end) @ (-self._direction[1], self._direction[0])))

    def _fits(self, place: Floats) -> bool:
        reach_m = JUMP_M + 0.5 * max(self.beyond_m(place), 0.0) if self.places else FIRST_REACH_M
        return float(self._aside_m(place[None])[0]) <= reach_m

    def _add(self, place: Floats) -> None:
        if self.places:
            step_m = float(np.linalg.norm(place - self._end))
            self.length_m += step_m
            self._variance_m2 += DRIFT**2 * step_m * TRACK_M
        self.places.append(place)
        self._end = place
        near = [c for c in self.places[-60:] if float(np.linalg.norm(c - self._end)) < TRACK_M]
        if len(near) > 2:
            self._direction = _direction(np.array(near), self._direction)

    def _shift(self, offset_m: Floats, since: Floats) -> None:
        """Move what lies ahead of a place by the share of an offset that the filter's gain gives."""
        gain = self._variance_m2 / (self._variance_m2 + CAMERA_M**2)
        self._variance_m2 *= 1.0 - gain
        moved = [
            place + gain * offset_m if float((place - since) @ self._direction) > -BESIDE_M else place
            for place in self.places
        ]
        self.places, self._end = moved, moved[-1]


def crossings(echoes_world_m: Floats, diameter_m: float) -> Floats:
    """Where in a ping, (n, 3) in the order of its beams, something of a pipe's width stands out of the bed: (k, 2).

    The fan meets the bed in a line across the way. Less its running median, which is the bed, a pipe is a bump.
    """
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
    _, _, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    return np.asarray(axes[0] if float(axes[0] @ before) >= 0.0 else -axes[0])
