"""Variation: the values (a range or choices) that a scenario key takes in a study, and how they are drawn."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from statistics import NormalDist
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from uwsim.scenario.spec.fields import InRange, Model, broken

Bound = Annotated[float, InRange(-1e12, 1e12)]
LOGARITHMIC, BELL, BELL_SHAPE = ("log", "lognormal"), ("normal", "lognormal"), NormalDist()


class Variation(Model):
    """The values of one key: numbers from low to high, or choices.

    low: the smallest number, in the unit of the key. high: the largest. steps: number of grid points, including both
    ends. scale: linear, or log for equal density per decade; normal and lognormal: as likely as in a distribution of
    which low and high are the 95 % interval, without its tails. whole: whole numbers only. choices: any values that the
    scenario file accepts; if they are named, tables show the names.
    """

    low: Bound | None = None
    high: Bound | None = None
    steps: Annotated[int, InRange(2, 100_000)] | None = None
    scale: Literal["linear", "log", "normal", "lognormal"] = "linear"
    whole: bool = False
    choices: Annotated[tuple[Any, ...] | dict[str, Any], Field(min_length=1, max_length=10_000)] | None = None

    @model_validator(mode="after")
    def _is_a_range_or_choices(self) -> Variation:
        is_range = self.low is not None and self.high is not None
        if is_range == (self.choices is not None) or (self.low is None) != (self.high is None):
            raise broken("must have low and high, or choices")
        if self.choices is not None:
            for key in ("steps", "scale", "whole"):
                if key in self.model_fields_set:
                    raise broken("is for low and high, not for choices", at=(key,), value=getattr(self, key))
        elif self.low is not None and self.high is not None:
            if self.low >= self.high:
                raise broken(f"must be greater than low ({self.low:g})", at=("high",), value=self.high)
            for key, value in (("low", self.low), ("high", self.high)):
                if self.whole and not value.is_integer():
                    raise broken("must be a whole number for `whole: true`", at=(key,), value=value)
            if self.scale in LOGARITHMIC and self.low <= 0.0:
                raise broken(f"must be positive for `scale: {self.scale}`", at=("low",), value=self.low)
        return self


@dataclass(frozen=True)
class Level:
    """One value of a variation. shown: its form in tables: a number, or the name of a choice."""

    shown: Any
    value: Any


def choices(variation: Variation) -> list[Level]:
    """Return the levels of a variation with choices."""
    given = variation.choices
    if isinstance(given, Mapping):
        return [Level(name, value) for name, value in given.items()]
    return [Level(value if _is_plain(value) else f"choice {k}", value) for k, value in enumerate(given or ())]


def extremes(variation: Variation) -> list[Level]:
    """Return the levels to check before a study (both ends, or all choices); if they are valid, so are all others."""
    return choices(variation) if variation.choices is not None else [level_at(variation, u) for u in (0.0, 1.0)]


def level_at(variation: Variation, u: float) -> Level:
    """Return the level of a variation at u in [0, 1]; choices are equally likely."""
    if variation.choices is not None:
        levels = choices(variation)
        return levels[min(int(u * len(levels)), len(levels) - 1)]
    low, high = variation.low or 0.0, variation.high or 0.0
    if variation.scale in BELL:
        u = 0.5 + 0.5 * BELL_SHAPE.inv_cdf(0.025 + 0.95 * u) / BELL_SHAPE.inv_cdf(0.975)
    if variation.scale in LOGARITHMIC:
        value = low * (high / low) ** u
    elif variation.whole:  # all numbers are equally likely
        value = math.floor(low + u * (high - low + 1))
    else:
        value = low + u * (high - low)
    value = min(max(value, low), high)
    if variation.whole:
        value = round(value)
    return Level(value, value)


def _is_plain(value: Any) -> bool:
    return value is None or isinstance(value, bool | int | float | str)
