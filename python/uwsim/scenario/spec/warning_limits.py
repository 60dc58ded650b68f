"""Limits beyond which the operator's panel issues warnings."""

from __future__ import annotations

from typing import Annotated

from uwsim.scenario.spec.fields import InRange, Model


class WarningLimits(Model):
    """Limits beyond which the panel issues warnings.

    range_m: largest distance from the station. proximity_m: smallest height above the bed.
    """

    range_m: Annotated[float, InRange(0, 1e5, "m")] = 110.0
    proximity_m: Annotated[float, InRange(0, 1e3, "m")] = 10.0
