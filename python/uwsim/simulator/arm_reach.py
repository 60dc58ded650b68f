"""Inverse kinematics of an arm: the joints' positions that bring a link to a point.

SciPy's bounded least squares (the trust region reflective method of Branch, Coleman and Li 1999, SIAM J. Sci. Comput.
21:1) with the geometric Jacobian (Siciliano and others 2009, "Robotics", 3.1), from the present positions and from
others that are spread within the stops; of the first that arrive, the nearest to the present ones. Speeds are damped
least squares of the same Jacobian (Nakamura and Hanafusa 1986, J. Dyn. Sys., Meas., Control 108:163).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats

ARRIVED_M, ARRIVED_RAD = 1e-3, math.radians(1.0)
ARM_M = 0.1  # by which an error of direction counts as one of position
STARTS = 16  # besides the present positions
ENOUGH = 3  # ways that arrive, of which the nearest is taken
NEAR = 0.1  # rad or m: a way that no other is worth being compared with
ITERATIONS = 100
DAMPING_M = 0.01  # of speeds: a joint that moves the tool less than this per radian hardly turns for it
AT_STOP = 1e-3  # rad or m: nearer to a stop, a joint does not move towards it


class Aim(NamedTuple):
    """A point, and perhaps a direction, for a link to reach, along the base's axes.

    tool_m, tool_axis: its point, and its direction, in its frame. direction: that the tool's axis is to have; None for
    any.
    """

    point_m: Floats
    direction: Floats | None
    tool_m: Floats
    tool_axis: Floats


class OutOfReachError(ValueError):
    """A point or a direction is out of an arm's reach. distance_m, angle_rad: how near it comes."""

    def __init__(self, distance_m: float, angle_rad: float) -> None:
        near = f"it comes within {distance_m:.3g} m"
        super().__init__(near if angle_rad == 0.0 else f"{near} and {math.degrees(angle_rad):.3g} deg")
        self.distance_m, self.angle_rad = distance_m, angle_rad


class Reach:
    """The inverse kinematics of one link of an arm. links: of the core, as for a vehicle; link: its index."""

    def __init__(self, links: Sequence[_core.ArmLink], link: int) -> None:
        self._links, self._link = links, link
        self._still = _core.Mechanism(list(links))
        self._water = _core.Water()
        chain: list[int] = []
        at: int | None = link
        while at is not None:
            if links[at].joint != _core.JointKind.FIXED:
                chain.insert(0, at)
            at = links[at].parent
        self.chain = chain
        """The joints that move the link, as indices, from the base on."""
        self._low = np.array([links[k].lowest for k in chain])
        self._high = np.array([links[k].highest for k in chain])

    def positions(self, present: Floats, aim: Aim) -> Floats:
        """Return the positions of the joints of `chain`. present: theirs now. Raises OutOfReachError."""
        from scipy.optimize import least_squares  # slow to import

        found: list[tuple[float, Floats]] = []
        nearest = (math.inf, 0.0)
        for start in self._starts(present):
            if len(start) == 0:
                solved = start
            else:
                solved = least_squares(
                    lambda at: self._residual(at, aim),
                    start,
                    jac=lambda at: self._jacobian(at, aim),
                    bounds=(self._low, self._high),
                    max_nfev=ITERATIONS,
                ).x
            off = self._off(solved, aim)
            nearest = min(nearest, off, key=lambda each: each[0] + ARM_M * each[1])
            if off[0] <= ARRIVED_M and off[1] <= ARRIVED_RAD:
                found.append((float(np.abs(solved - present).max(initial=0.0)), np.asarray(solved, np.float64)))
                if len(found) == ENOUGH or found[0][0] < NEAR:
                    break
        if not found:
            raise OutOfReachError(*nearest)
        return min(found, key=lambda each: each[0])[1]

    def speeds(self, present: Floats, velocity_m_s: Floats) -> dict[int, float]:
        """Return the speeds of the motors in `chain`, by index, that move the link's origin with a velocity (3,).

        present: the joints' positions. velocity_m_s: along the base's axes. Joints at a stop are left out where they
        would run into it, and all are slower alike where one cannot follow.
        """
        whole = self._jacobian(present, Aim(np.zeros(3), None, np.zeros(3), np.zeros(3)))
        free = [column for column, k in enumerate(self.chain) if self._links[k].strongest > 0.0]
        while True:
            rows = whole[:, free]
            found = rows.T @ np.linalg.solve(rows @ rows.T + DAMPING_M**2 * np.eye(3), velocity_m_s)
            ends = np.where(found < 0.0, present[free] - self._low[free], self._high[free] - present[free])
            going = [column for column, end in zip(free, ends, strict=True) if end > AT_STOP]
            if len(going) == len(free):
                break
            free = going
        fastest = np.array([self._links[self.chain[column]].fastest for column in free])
        found = found / max(1.0, float(np.max(np.abs(found) / fastest, initial=0.0)))
        moved = dict(zip(free, found.tolist(), strict=True))
        return {k: moved.get(column, 0.0) for column, k in enumerate(self.chain) if self._links[k].strongest > 0.0}

    def _starts(self, present: Floats) -> list[Floats]:
        """Return where to begin: the present positions, and points of Halton's sequence within the stops."""
        low = np.where(np.isfinite(self._low), self._low, present - math.pi)
        high = np.where(np.isfinite(self._high), self._high, present + math.pi)
        room = 1e-6 * (high - low)
        spread = np.array([[_halton(k + 1, base) for base in _primes(len(present))] for k in range(STARTS)])
        others = low + spread.reshape(STARTS, len(present)) * (high - low)
        return [np.clip(one, low + room, high - room) for one in (present, *others)]

    def _poses(self, at: Floats) -> list[Floats]:
        for k, position in zip(self.chain, at.tolist(), strict=True):
            self._still.place(k, position)
        return [self._still.world_from_link(k, self._water) for k in (*self.chain, self._link)]

    def _residual(self, at: Floats, aim: Aim) -> Floats:
        tip = self._poses(at)[-1]
        error = tip[:3, :3] @ aim.tool_m + tip[:3, 3] - aim.point_m
        if aim.direction is None:
            return np.asarray(error, np.float64)
        return np.concatenate([error, ARM_M * (tip[:3, :3] @ aim.tool_axis - aim.direction)])

    def _jacobian(self, at: Floats, aim: Aim) -> Floats:
        *poses, tip = self._poses(at)
        point, axis = tip[:3, :3] @ aim.tool_m + tip[:3, 3], tip[:3, :3] @ aim.tool_axis
        rows = np.zeros((3 if aim.direction is None else 6, len(self.chain)))
        for column, (k, pose) in enumerate(zip(self.chain, poses, strict=True)):
            own = np.asarray(self._links[k].axis, np.float64)
            along = pose[:3, :3] @ (own / np.linalg.norm(own))
            if self._links[k].joint == _core.JointKind.SLIDE:
                rows[:3, column] = along
                continue
            rows[:3, column] = np.cross(along, point - pose[:3, 3])
            if aim.direction is not None:
                rows[3:, column] = ARM_M * np.cross(along, axis)
        return rows

    def _off(self, at: Floats, aim: Aim) -> tuple[float, float]:
        """Return how far the tool is from the point [m] and the direction [rad]."""
        error = self._residual(at, aim)
        chord = 0.0 if aim.direction is None else float(np.linalg.norm(error[3:])) / ARM_M
        return float(np.linalg.norm(error[:3])), 2.0 * math.asin(min(0.5 * chord, 1.0))


def _halton(index: int, base: int) -> float:
    value, part = 0.0, 1.0 / base
    while index:
        index, digit = divmod(index, base)
        value += digit * part
        part /= base
    return value


def _primes(count: int) -> list[int]:
    found: list[int] = []
    number = 2
    while len(found) < count:
        if all(number % each for each in found):
            found.append(number)
        number += 1
    return found
