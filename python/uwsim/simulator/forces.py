"""Forces on a body: by name, a push from outside, and the water's on a wet hull; and a thruster's state."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from uwsim.base.arguments import number, read_only
from uwsim.base.arrays import Floats
from uwsim.base.named import Named
from uwsim.base.short_repr import ShortRepr

TOTAL = "total"


@dataclass(frozen=True, eq=False, repr=False)
class Wrench(ShortRepr):
    """A force and a torque about the body's origin, in body axes: force_body_n (3,), torque_body_nm (3,)."""

    force_body_n: Floats
    torque_body_nm: Floats


def forces_by_name(terms: list[tuple[str, Floats]], owner: str) -> Named[Wrench]:
    """Return the native terms, each (6,), as wrenches by name, and their sum as `total`."""
    values = dict(terms)
    values[TOTAL] = np.sum(list(values.values()), axis=0)
    return Named(
        {name: Wrench(read_only(value[:3]), read_only(value[3:])) for name, value in values.items()}, f"{owner}.forces"
    )


AXES_OF_WRENCHES = ("body", "world")


class Push(NamedTuple):
    """The core's arguments, wrench (6,) [N, N m], and those of the command as the journal keeps them."""

    wrench: Floats
    in_world_axes: bool
    duration_s: float
    noted: dict[str, Any]


def push(
    force_n: Sequence[float] | Floats, torque_nm: Sequence[float] | Floats, axes: str, duration_s: float | None
) -> Push:
    """Check a push. Raises ValueError, naming the argument."""
    parts = six_numbers(force_n=(force_n, "N"), torque_nm=(torque_nm, "N m"))
    if axes not in AXES_OF_WRENCHES:
        raise ValueError(f"axes = {axes!r}: must be one of {', '.join(AXES_OF_WRENCHES)}")
    duration = None if duration_s is None else number(duration_s, "duration_s", "s")
    noted = {"force_n": parts[:3], "torque_nm": parts[3:], "axes": axes, "duration_s": duration}
    return Push(np.array(parts), axes == "world", math.inf if duration is None else duration, noted)


def six_numbers(**parts: tuple[Sequence[float] | Floats, str]) -> list[float]:
    """Return the numbers of a force and a torque, each (3,) with its unit. Raises ValueError, naming the number."""
    found: list[float] = []
    for name, (part, unit) in parts.items():
        if np.shape(part) != (3,):
            raise ValueError(f"{name}.shape = {np.shape(part)}: expected (3,)")
        found += [number(value, f"{name}[{k}]", unit) for k, value in enumerate(part)]
    return found


@dataclass(frozen=True, eq=False, repr=False)
class WetTriangles(ShortRepr):
    """The part of a hull's surface that is under water, as triangles that wind outward, in body axes.

    corners_body_m: (n, 3, 3), triangle by corner by x, y, z, from the body's origin; triangles at the surface are cut
    at it. forces_body_n: (n, 3), the water's pressure at the centroid times the area, along the inward normal. In still
    water of one density they sum to the weight of the displaced water (Archimedes); in waves, and in layered water,
    they approximate the `buoyancy` of `forces`, which is an integral over the volume.
    """

    corners_body_m: Floats
    forces_body_n: Floats

    def __len__(self) -> int:
        return len(self.forces_body_n)

    @property
    def areas_m2(self) -> Floats:
        """The area of each triangle, (n,)."""
        a, b, c = self.corners_body_m.transpose(1, 0, 2)
        return np.asarray(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))

    @property
    def area_m2(self) -> float:
        """The wetted area."""
        return float(self.areas_m2.sum())


@dataclass(frozen=True)
class Thruster:
    """A thruster's state: its command in [-1, 1], and its still-water thrust, which follows the command with a lag.

    current_a: current drawn from the battery; 0 if the battery is modelled as a mission time.
    """

    command: float
    thrust_n: float
    current_a: float = 0.0
