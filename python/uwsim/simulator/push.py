"""A push from outside, on a vehicle or a loose body: its checked values, for the core and for the journal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from uwsim.base.arguments import number
from uwsim.base.arrays import Floats

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
