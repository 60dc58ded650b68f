"""The wind over a scenario's water, and what a vehicle offers it."""

from __future__ import annotations

from typing import Annotated, Literal, TypeVar

from uwsim.scenario.spec.fields import Degrees, InRange, Model

PartT = TypeVar("PartT", bound=Model)
OPTICS_MOST_M_S, LINK_MOST_M_S = 14.0, 40.0
"""The strongest wind in the models of ripples and of noise."""
Area = Annotated[float, InRange(0, 1e5, "m2")]


class Wind(Model):
    """The wind over the water, which pushes vehicles with a `windage`, ripples the surface and is heard by modems.

    speed_m_s: mean over an hour, 10 m above the water. heading_deg: direction towards which it blows, counter-clockwise
    from east. gusts: along the wind, by a spectrum: `npd`, ISO 19901-1 (2005, A.7.4; the Norwegian Petroleum
    Directorate's); `davenport`, Davenport 1961 (Q. J. R. Meteorol. Soc. 87:194) with the drag coefficient
    surface_drag; by default none. They depend on the scenario's seed alone. surface_drag: of the sea, 0.001 to 0.003,
    for `davenport`. Waves are `water.surface`. The optics and the link have this wind unless they have their own.
    """

    speed_m_s: Annotated[float, InRange(0, 60, "m/s")]
    heading_deg: Degrees = 20.0
    gusts: Literal["npd", "davenport"] | None = None
    surface_drag: Annotated[float, InRange(0.0005, 0.01)] = 0.0015


def in_wind(part: PartT, limit_m_s: float, wind: Wind) -> PartT:
    """Return a copy of optics or a link with this wind, where its own is not given; up to the speed of its model."""
    own = {"wind_m_s": min(wind.speed_m_s, limit_m_s), "wind_heading_deg": wind.heading_deg}
    update = {key: value for key, value in own.items() if key in type(part).model_fields.keys() - part.model_fields_set}
    given = part.model_fields_set
    return type(part).model_construct(_fields_set=given, **{**part.__dict__, **update})


class Windage(Model):
    """A floating hull in the wind, symmetric fore and aft: its forces.

    By Fossen 2011, "Handbook of Marine Craft Hydrodynamics and Motion Control", sec. 8.1.
    frontal_area_m2, lateral_area_m2: above the water, seen from ahead and from abeam. length_m: overall. height_m: of
    their centre above the body's origin. surge, sway, yaw: coefficients c_x, c_y, c_n; experiments gave 0.5 to 0.9, 0.7
    to 0.95 and 0.05 to 0.2. They shrink as the hull dives.
    """

    frontal_area_m2: Area
    lateral_area_m2: Area
    length_m: Annotated[float, InRange(0.01, 500, "m")]
    height_m: Annotated[float, InRange(0.01, 100, "m")]
    surge: Annotated[float, InRange(0, 2)] = 0.7
    sway: Annotated[float, InRange(0, 2)] = 0.8
    yaw: Annotated[float, InRange(0, 1)] = 0.1
