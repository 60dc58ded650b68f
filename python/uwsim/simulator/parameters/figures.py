"""Parameters specific to a kind of sensor or imaging sonar; see their tables."""

from __future__ import annotations

import math
from typing import Any

from uwsim.scenario.spec.imaging_sonar import DEGREES, RADIANS, STRENGTHS, ImagingMount, imaging_kind
from uwsim.scenario.spec.json_schema import SensorFigure
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.sensor import OWN_NOISE, SensorMount
from uwsim.scenario.spec.sensor_kind import sensor_kind
from uwsim.simulator.parameters.parameter import FieldType

NOISE_UNITS = {"density": "{}/sqrt(Hz)", "walk": "{}/sqrt(s)", "bias_time_s": "s"}
STRENGTHS_TYPE = FieldType("structure", meaning="Lambert's strength of single surfaces, by name [dB]")


def sensor_figures(mount: SensorMount) -> dict[str, tuple[FieldType, tuple[float, ...]]]:
    """Return the type and values of each parameter specific to a sensor's kind, by name."""
    return {
        name: (_type(figure), tuple(mount.parameters.get(name) or (figure.by_default,) * figure.width))
        for name, figure in sensor_kind(mount.kind).parameters.items()
    }


def imaging_figures(mount: ImagingMount) -> dict[str, tuple[FieldType, Any]]:
    """Return the type and value of each imaging sonar parameter, by YAML key; angles are in degrees."""
    kind = imaging_kind(mount.kind)
    model = kind.model(**mount.figures)
    figures: dict[str, tuple[FieldType, Any]] = {}
    for name, figure in kind.parameters.items():
        value, optional = getattr(model, name), not math.isnan(figure.by_default)
        if name.endswith(RADIANS):
            degrees = float(f"{math.degrees(value):.12g}")  # the value as written in the file, without rounding errors
            figures[name.removesuffix(RADIANS) + DEGREES] = _type(figure, in_degrees=True), degrees
        else:
            figures[name] = _type(figure, optional=optional), value
    figures[STRENGTHS] = STRENGTHS_TYPE, dict(getattr(model, STRENGTHS)) or None
    return figures


def _type(figure: SensorFigure, *, optional: bool = False, in_degrees: bool = False) -> FieldType:
    low, high, unit = figure.low, figure.high, figure.unit
    if in_degrees:
        low, high, unit = math.degrees(low), math.degrees(high), "deg"
    return FieldType(figure.type, unit, low, high, optional=optional, meaning=figure.meaning)  # type: ignore[arg-type]


def noise_unit(scenario: Scenario, place: tuple[str | int, ...]) -> str:
    """Return the unit of a noise value at a key path, or "" if the sensor's channels have different units."""
    at: Any = scenario
    below = list(place)
    while not isinstance(at, SensorMount):
        part = below.pop(0)
        at = at[part] if isinstance(part, int) or isinstance(at, dict) else getattr(at, str(part))
    channels = {name: unit for name, (_, unit) in sensor_kind(at.kind).channels.items()}
    shared = {unit for name, unit in channels.items() if name not in OWN_NOISE}
    units = {channels[str(below[1])]} if below[0] == "channels" else shared
    figure = next(part for part in reversed(below) if isinstance(part, str))
    if figure == "bias_time_s":
        return "s"
    return NOISE_UNITS.get(figure, "{}").format(units.pop()) if len(units) == 1 else ""
