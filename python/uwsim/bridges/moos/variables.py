"""The publications of a vehicle to its MOOS community: the variables of uSimMarine, and its instruments."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping.files.georeference import Georeference
from uwsim.simulator.vehicle import Vehicle

Value = tuple[str, float | str]


def depth_m(vehicle: Vehicle, *, from_truth: bool) -> float:
    """Return the depth of a vehicle's origin below the surface [m], in truth or as estimated below the tide."""
    return float(vehicle.telemetry().depth_m if from_truth else vehicle.estimate.depth_m)


def navigation(vehicle: Vehicle, place: Georeference, *, from_truth: bool) -> list[Value]:
    """Return NAV_X and the like, from the vehicle's estimate or its true motion.

    X and Y [m]: the world's east and north. HEADING [deg]: clockwise from true north. PITCH [rad]: nose up; ROLL: port
    side up. YAW [rad]: minus the heading, in [-pi, pi). SPEED: horizontal, over ground. Must be called on the
    simulator's thread.
    """
    known: Any = vehicle if from_truth else vehicle.navigation.shown
    pose, position_m = known.pose, np.asarray(known.pose.position_world_m)
    rotation = pose.world_from_body[:3, :3]
    east, north, up = rotation @ known.velocity.linear_body_m_s
    nose = rotation[:, 0]
    north_rad = place.north_rad(position_m) if place.crs is not None else 0.0
    heading_rad = math.atan2(nose[0], nose[1]) + north_rad
    found: list[Value] = [
        ("NAV_X", float(position_m[0])),
        ("NAV_Y", float(position_m[1])),
        ("NAV_Z", float(position_m[2])),
        ("NAV_DEPTH", depth_m(vehicle, from_truth=from_truth)),
        ("NAV_HEADING", math.degrees(heading_rad) % 360),
        ("NAV_YAW", (-heading_rad + math.pi) % (2 * math.pi) - math.pi),
        ("NAV_PITCH", math.asin(max(-1.0, min(1.0, float(nose[2]))))),
        ("NAV_ROLL", math.atan2(float(rotation[2, 1]), float(rotation[2, 2]))),
        ("NAV_SPEED", math.hypot(east, north)),
        ("NAV_SPEED_OVER_GROUND", math.hypot(east, north)),
        ("NAV_HEADING_OVER_GROUND", math.degrees(math.atan2(east, north) + north_rad) % 360),
        ("NAV_VZ", float(up)),
    ]
    if place.crs is not None:
        latitude_deg, longitude_deg = place.degrees(position_m).tolist()
        found += [("NAV_LAT", latitude_deg), ("NAV_LONG", longitude_deg)]
    for altimeter in [each for each in vehicle.sensors.values() if each.kind == "altitude" and each.on][:1]:
        sample: Any = altimeter.sample()
        if sample.valid and math.isfinite(sample.value):
            found.append(("NAV_ALTITUDE", float(sample.value)))
    return found


def instruments(vehicle: Vehicle) -> Iterator[Value]:
    """Yield each sensor with a single number as UWSIM_NAME; NaN without a valid sample, as behind a fault."""
    for name, sensor in vehicle.sensors.items():
        if not sensor.on:
            continue
        sample: Any = sensor.sample()
        if isinstance(sample.value, (bool, int, float, np.number)):
            value = float(sample.value) if sample.valid else math.nan
            yield f"UWSIM_{name.upper()}", value


def ping_summary(ranges_m: NDArray[np.float64], bearings_rad: NDArray[np.float64], stamp_s: float) -> str:
    """Return a ping in MOOS's way of text: how many beams, how many with an echo, nearest, mean and nadir [m]."""
    has_echo = np.isfinite(ranges_m)
    echoes_m = ranges_m[has_echo]
    parts: list[str] = [f"stamp={stamp_s:.3f}", f"beams={len(ranges_m)}", f"echoes={len(echoes_m)}"]
    if len(echoes_m):
        parts += [f"min={echoes_m.min():.3f}", f"mean={echoes_m.mean():.3f}"]
        middle = int(np.argmin(np.abs(bearings_rad)))
        if has_echo[middle]:
            parts.append(f"nadir={ranges_m[middle]:.3f}")
    return ",".join(parts)


def number(value: float | bytes) -> float | None:
    """Return the number of a notification, also if it was written as text; None if it is not finite."""
    try:
        found = float(value)
    except ValueError:
        return None
    return found if math.isfinite(found) else None


def is_true(value: float | bytes) -> bool:
    """Return whether a notification means yes, in MOOS's ways of writing it."""
    return value.strip().lower() == b"true" if isinstance(value, bytes) else value == 1.0


def latest(messages: Iterable[Any]) -> dict[str, float | bytes]:
    """Return the last value of each variable in some notifications."""
    return {each.name: each.value for each in messages}
