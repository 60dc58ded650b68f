"""The tide of a scenario's water, and the constituents that its height and its currents have."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from uwsim.scenario.spec.fields import Degrees, InRange, Model, broken


def _is_time(text: str) -> str:
    try:
        year = datetime.fromisoformat(text).year
    except ValueError:
        year = 0
    if not 1900 <= year <= 2100:
        raise broken("must be a time in quotes, as '2026-05-01T06:00:00Z', from 1900 to 2100", value=text[:40])
    return text


WORLD_BEGIN = "2020-01-01T00:00:00Z"
"""The time at which worlds begin, in survey files, too."""
Begin = Annotated[str, AfterValidator(_is_time)]

Constituent = Literal[
    "M2", "S2", "N2", "K2", "K1", "O1", "P1", "Q1", "M4", "MS4", "MN4", "M6", "M8", "S4", "S6", "MK3", "2MK3", "2SM2",
    "M3", "2N2", "MU2", "NU2", "LAM2", "L2", "T2", "R2", "J1", "OO1", "2Q1", "RHO", "MM", "MF", "MSF", "SSA",
]  # fmt: skip
"""NOAA's names."""


class TideConstituent(Model):
    """A constituent of the tide's height.

    constituent: M2, S2, K1, O1 or another by its name in NOAA's tables. amplitude_m, phase_deg: its harmonic constants;
    the phase is the Greenwich lag.
    """

    constituent: Constituent
    amplitude_m: Annotated[float, InRange(0, 10, "m")]
    phase_deg: Degrees = 0.0


class Tide(Model):
    """The height of the sea above z = 0, the same in the whole world.

    constituents: add up, with the nodal corrections at the beginning. begin: time of the world's beginning [UTC, ISO
    8601].
    """

    constituents: Annotated[tuple[TideConstituent, ...], Field(min_length=1, max_length=40)]
    begin: Begin = WORLD_BEGIN
