"""The pose graph: estimates submap poses from temporal neighbours and from matches."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from uwsim.mapping.closure.matching import Match
from uwsim.mapping.closure.submaps import Submap

Array = NDArray[np.float64]
WALK_M, WALK_RAD = 0.02, 5e-4  # per square root of a second: the least drift of the estimate, assumed
HEADING_STD_RAD = 0.01  # standard deviation of the estimated heading, assumed, as for a compass
LEAST_STD_M = 0.05  # least standard deviation of a submap's estimated position
ROBUST = 2.0  # residuals beyond this many standard deviations lose weight (Cauchy)


def drift_std_m(maps: Sequence[Submap], first: int, second: int) -> float:
    """Return the standard deviation of the drift between two submaps, per axis, from the filter's covariance."""
    grown = maps[second].std_m ** 2 - maps[first].std_m ** 2
    return float(np.sqrt(max(grown, 0.0) + WALK_M**2 * abs(maps[second].time_s - maps[first].time_s)))


def solve(maps: Sequence[Submap], matches: Sequence[Match]) -> Array:
    """Return the corrections (n, 3) of the submaps: x, y [m] and rotation about the anchor [rad].

    A submap whose position is certain hardly moves. Uses SciPy's robust least squares with the Cauchy loss.
    """
    n = len(maps)
    anchors = np.array([submap.anchor_m for submap in maps])
    jumps = np.array([submap.jump_m for submap in maps])[1:].reshape(-1, 2)
    steps = np.diff(anchors, axis=0) - jumps  # the vehicle's own motion, without the estimate's corrections
    walked_s = np.diff([submap.time_s for submap in maps])
    step_std = np.array([drift_std_m(maps, k, k + 1) for k in range(n - 1)])
    # The errors of neighbouring submaps are correlated, so each counts less.
    held_std = np.sqrt(n) * np.maximum([submap.std_m for submap in maps], LEAST_STD_M)
    firsts, seconds = (np.array([getattr(m, name) for m in matches], int) for name in ("first", "second"))
    here, there = (np.array([getattr(m, name) for m in matches]).reshape(-1, 2) for name in ("here_m", "there_m"))
    turns = np.array([m.turn_rad for m in matches])
    roots = np.array([np.linalg.cholesky(np.linalg.inv(m.covariance)).T for m in matches]).reshape(-1, 3, 3)

    def residuals(flat: Array) -> Array:
        shift, turn = flat.reshape(n, 3)[:, :2], flat.reshape(n, 3)[:, 2]
        walked = shift[1:] - shift[:-1] + jumps - (turned(steps, turn[:-1]) - steps)
        at_first = anchors[firsts] + shift[firsts] + turned(here - anchors[firsts], turn[firsts])
        at_second = anchors[seconds] + shift[seconds] + turned(there - anchors[seconds], turn[seconds])
        off = np.column_stack([at_first - at_second, turn[seconds] - turn[firsts] - turns])
        parts = [
            (shift / held_std[:, None]).ravel(),
            (walked / step_std[:, None]).ravel(),
            np.diff(turn) / (WALK_RAD * np.sqrt(walked_s)),
            turn / HEADING_STD_RAD,
            np.einsum("nij,nj->ni", roots, off).ravel(),
        ]
        return np.concatenate(parts)

    return np.asarray(least_squares(residuals, np.zeros(3 * n), loss="cauchy", f_scale=ROBUST).x.reshape(n, 3))


def turned(vectors: Array, angle_rad: Array | float) -> Array:
    """Rotate vectors (n, 2), each by its own angle (n,) or all by the same."""
    cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    return np.column_stack([cos * vectors[:, 0] - sin * vectors[:, 1], sin * vectors[:, 0] + cos * vectors[:, 1]])
