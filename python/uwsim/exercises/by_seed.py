"""The draws of an exercise by its seed: places of its props, water and light."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np
from pydantic import Field, model_validator

from uwsim.base.quaternions import within_half_turn_deg
from uwsim.scenario import Scenario
from uwsim.scenario.spec.fields import InRange, Model, Name, broken
from uwsim.scenario.spec.prop import PropEntry

Shift = Annotated[float, InRange(-1000, 1000, "m")]
Turn = Annotated[float, InRange(-180, 180, "deg")]
PLACES, TURNS = ("x_m", "y_m", "z_m"), ("yaw_deg", "pitch_deg", "roll_deg")


class PropShift(Model):
    """How far a prop may stand from its place in the scenario: from low to high, drawn evenly by the seed.

    prop: its name. x_m, y_m, z_m: along the world's axes. yaw_deg: counter-clockwise. pitch_deg, roll_deg: how it
    leans, about its own y and x.
    """

    prop: Name
    x_m: tuple[Shift, Shift] = Field((0.0, 0.0), examples=[[-0.5, 0.5]])
    y_m: tuple[Shift, Shift] = Field((0.0, 0.0), examples=[[-0.5, 0.5]])
    z_m: tuple[Shift, Shift] = (0.0, 0.0)
    yaw_deg: tuple[Turn, Turn] = (0.0, 0.0)
    pitch_deg: tuple[Turn, Turn] = (0.0, 0.0)
    roll_deg: tuple[Turn, Turn] = (0.0, 0.0)

    @model_validator(mode="after")
    def _are_ranges(self) -> PropShift:
        for key in (*PLACES, *TURNS):
            _require_range(key, getattr(self, key))
        return self

    def drawn(self, prop: PropEntry, seed: int) -> PropEntry:
        """Return the prop where the seed puts it, whatever other props there are."""
        random = _random(seed, self.prop)
        drawn = {key: random.uniform(*getattr(self, key)) for key in (*PLACES, *TURNS)}
        at_m = tuple(own + drawn[key] for own, key in zip(prop.position_m, PLACES, strict=True))
        turns = {key: within_half_turn_deg(getattr(prop, key) + drawn[key]) for key in TURNS}
        return prop.model_copy(update={"position_m": at_m, **turns})


def exchanged(props: Sequence[PropEntry], seed: int) -> dict[str, PropEntry]:
    """Return props by name, of which the seed draws who stands in whose place."""
    order = _random(seed, " ".join(one.name for one in props)).permutation(len(props))
    places = [{key: getattr(props[k], key) for key in ("position_m", *TURNS)} for k in order]
    return {one.name: one.model_copy(update=at) for one, at in zip(props, places, strict=True)}


Low = Annotated[float, InRange(0, 5, "m/s")]
Sight = Annotated[float, InRange(0.1, 1000, "m")]
Elevation = Annotated[float, InRange(-90, 90, "deg")]


class Conditions(Model):
    """The water and the light of an exercise: each from low to high, drawn evenly by the seed.

    current_m_s: the speed of the current, whose direction is drawn, too. visibility_m: how far a diver sees a dark
    object. sun_elevation_deg: the sun's height above the horizon.
    """

    current_m_s: tuple[Low, Low] | None = None
    visibility_m: tuple[Sight, Sight] | None = None
    sun_elevation_deg: tuple[Elevation, Elevation] | None = None

    @model_validator(mode="after")
    def _are_ranges(self) -> Conditions:
        for key in ("current_m_s", "visibility_m", "sun_elevation_deg"):
            if (limits := getattr(self, key)) is not None:
                _require_range(key, limits)
        return self

    def drawn(self, found: Scenario, seed: int) -> dict[str, Any]:
        """Return the values of a scenario's keys water and optics, as far as they change with the seed."""
        made: dict[str, Any] = {}
        if self.current_m_s is not None:
            random = _random(seed, "current_m_s")
            speed_m_s, turn = random.uniform(*self.current_m_s), random.uniform(0.0, 2.0 * np.pi)
            current = (float(speed_m_s * np.cos(turn)), float(speed_m_s * np.sin(turn)), 0.0)
            made["water"] = {**found.water.given(), "current_world_m_s": current}
        seen = {
            key: float(_random(seed, key).uniform(*limits))
            for key in ("visibility_m", "sun_elevation_deg")
            if (limits := getattr(self, key)) is not None
        }
        return {**made, "optics": {**found.optics.given(), **seen}} if seen else made


def _random(seed: int, name: str) -> np.random.Generator:
    """Return the draws of a seed for one name, whatever else is drawn."""
    return np.random.default_rng([seed, zlib.crc32(name.encode())])


def _require_range(key: str, limits: tuple[float, float]) -> None:
    if limits[0] > limits[1]:
        raise broken("must have the smaller number first", at=(key,), value=list(limits))
