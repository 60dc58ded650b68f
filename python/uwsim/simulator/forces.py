"""The forces on a body in the last step, by name, and the points at which it was pressed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from uwsim.base.arguments import read_only
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
