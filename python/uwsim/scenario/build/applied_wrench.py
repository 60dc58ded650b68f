"""A scheduled push as the core's AppliedWrench."""

from __future__ import annotations

import numpy as np

from uwsim import _core
from uwsim.scenario.spec.applied_wrench import AppliedWrench

FOREVER_S = 1e12


def applied_wrench(wrench: AppliedWrench, step_s: float) -> _core.AppliedWrench:
    """Return a scheduled wrench, with its times rounded to steps, of which it lasts at least one."""
    until_s = FOREVER_S if wrench.until_s is None else wrench.until_s
    parts = np.array([*wrench.force_n, *wrench.torque_nm])
    first = round(wrench.from_s / step_s)
    return _core.AppliedWrench(parts, wrench.axes == "world", first, max(first + 1, round(until_s / step_s)))
