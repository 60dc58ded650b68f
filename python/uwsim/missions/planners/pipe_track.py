"""The track of a pipe that a vehicle follows, from sonar and camera observations.

The sonar sees where the pipe crosses its fan, a few metres ahead; the camera sees the pipe below. Each new point beyond
the track's end, from either instrument, extends the track. If the camera sees the pipe to the side of the track laid
out by the sonar, the vehicle's position estimate has drifted by that offset since then: the part of the track ahead is
shifted by a fraction of the offset, the gain of a scalar Kalman filter.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import median_filter

from uwsim.base.arrays import Floats
from uwsim.missions.planners.pipe_view import SeenPipe

STANDS_OUT = 0.35  # minimum height of a bump above the bed, in diameters
NARROWEST, WIDEST = 0.3, 3.0  # width of a bump, in diameters
BED_WINDOW = 6.0  # width of the running median, in diameters
FEWEST_BEAMS = 20
FIRST_REACH_M = 4.0  # maximum distance of the first sighting from the path
JUMP_M = 1.5  # maximum distance of a sighting from the extrapolated track
STEEPEST = math.cos(math.radians(50.0))  # cosine of the maximum angle between the pipe in the picture and the track
NEW_M = 0.3  # minimum distance past the track's end of a point added by the camera
PURSUED_M = 3.0  # distance ahead on the track that the vehicle aims for
TRACK_M = 6.0  # length of the final part of the track that determines its direction
BESIDE_M = 2.0  # distance along the track within which its points are compared with the camera's sighting
SONAR_M, CAMERA_M = 0.25, 0.15  # across-pipe standard deviations of a sighting
DRIFT = 0.03  # drift of the vehicle's position estimate, relative to the distance travelled


class PipeTrack:
    """The points of a pipe in order, (2,) each, and its direction. length_m: length of the track."""

    def __init__(self, start_m: Floats, heading_rad: float, diameter_m: float) -> None:
        self._end = start_m
        self._direction = np.array([math.cos(heading_rad), math.sin(heading_rad)])
        self._diameter_m = diameter_m
        self._variance_m2 = SONAR_M**2  # variance of the offset between track and pipe
        self._seen_before = False
        self.places: list[Floats] = []
        self.length_m = 0.0

    def beyond_m(self, position: Floats) -> float:
        """Return how far a position is past the track's end, along the track's direction."""
        return float((position - self._end) @ self._direction)

    def ahead(self, position: Floats) -> Floats:
        """Return the point to aim for, PURSUED_M ahead on the track or on its extension."""
        for place in self.places[-50:]:
            away = place - position
            if float(away @ self._direction) > 0.0 and float(np.linalg.norm(away)) >= PURSUED_M:
                return place
        along_m = max(self.beyond_m(position), 0.0) + PURSUED_M
        return self._end + along_m * self._direction

    def add_ping(self, echoes_world_m: Floats) -> bool:
        """Add the point where the pipe crosses a ping; return whether the pipe is seen."""
        bumps = crossings(echoes_world_m, self._diameter_m)
        if not len(bumps):
            return False
        nearest = bumps[int(np.argmin(self._aside_m(bumps)))]
        if not self._fits(nearest) or self.beyond_m(nearest) <= 0.1:
            return False
        self._add(nearest)
        return True

    def add_picture(self, pipe: SeenPipe | None) -> bool:
        """Correct and extend the track from the pipe in a picture (None if none is seen); return whether it fits.

        Two consecutive pictures must show the pipe, since caustics in a single picture may look like one.
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
        """Return the lateral distances (n,) of the points (n, 2) from the extrapolated track."""
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
        """Shift the part of the track ahead of a point by the filter gain times an offset."""
        gain = self._variance_m2 / (self._variance_m2 + CAMERA_M**2)
        self._variance_m2 *= 1.0 - gain
        moved = [
            place + gain * offset_m if float((place - since) @ self._direction) > -BESIDE_M else place
            for place in self.places
        ]
        self.places, self._end = moved, moved[-1]


def crossings(echoes_world_m: Floats, diameter_m: float) -> Floats:
    """Return the positions (k, 2) where echoes (n, 3), in beam order, show a bump on the bed as wide as a pipe.

    The fan hits the bed along a line across the direction of travel. The bed is the running median; after subtracting
    it, a pipe appears as a bump.
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
    """Return the direction of the line through points (n, 2), oriented like `before`."""
    _, _, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    return np.asarray(axes[0] if float(axes[0] @ before) >= 0.0 else -axes[0])
