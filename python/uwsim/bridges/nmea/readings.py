"""Sentences of what a vehicle knows at one moment: its estimate and its instruments, never the true motion."""

from __future__ import annotations

import math
from collections.abc import Callable
from datetime import datetime
from typing import Any

import numpy as np

from uwsim.bridges.nmea import sentences
from uwsim.bridges.nmea.sentences import Fix, Motion
from uwsim.instruments.sensors import Sensor
from uwsim.mapping.files.georeference import Georeference
from uwsim.simulator.vehicle import Vehicle

Clock = Callable[[float], datetime]
"""Returns the UTC of a simulated time [s]."""


def read(vehicle: Vehicle, place: Georeference, clock: Clock, time_s: float) -> list[str]:
    """Return the sentences of one moment. Must be called on the simulator's thread.

    The position is that of the vehicle's GPS, or of its estimate without one. place: of the world; without a location
    on Earth, there is no fix, and y is taken for true north.
    """
    kinds = {kind: [each for each in vehicle.sensors.values() if each.kind == kind and each.on]
             for kind in ("imu", "gps", "altitude", "depth", "usbl")}  # fmt: skip
    found = _navigation(vehicle, place, clock(time_s), kinds["gps"][:1]) if kinds["imu"] else []
    for altimeter in kinds["altitude"][:1]:
        depth = kinds["depth"][0].sample() if kinds["depth"] else None
        below_m = _valid(altimeter)
        depth_m = float(depth.value) if depth is not None and depth.valid else None
        (range_max_m,) = altimeter.spec.parameters["range_max_m"]
        found += [sentences.dpt(below_m, depth_m, range_max_m), sentences.dbt(below_m)]
    for number, usbl in enumerate(kinds["usbl"], 1):
        sample: Any = usbl.sample()
        east, north, _ = sample.value.position_m
        north_rad = place.north_rad(np.zeros(3)) if place.crs is not None else 0.0
        seen = (math.hypot(east, north), math.atan2(east, north) + north_rad) if sample.valid else None
        found.append(sentences.ttm(number, vehicle.name, clock(sample.stamp_s), seen))
    return found


def _valid(sensor: Sensor[Any]) -> float | None:
    sample = sensor.sample()
    return float(sample.value) if sample.valid and math.isfinite(sample.value) else None


def _navigation(vehicle: Vehicle, place: Georeference, time: datetime, gps: list[Sensor[Any]]) -> list[str]:
    """Return the sentences of the vehicle's own estimate, with the position of the GPS if there is one."""
    estimate = vehicle.navigation.shown
    pose = estimate.pose
    position_m = np.asarray(pose.position_world_m)
    fix, north_rad = None, 0.0
    if place.crs is not None:
        latitude_deg, longitude_deg = place.degrees(position_m).tolist()
        fix, north_rad = Fix(latitude_deg, longitude_deg, float(position_m[2])), place.north_rad(position_m)
        if gps:
            sample: Any = gps[0].sample()
            fix = None
            if sample.valid:
                at_m = sample.value.position_m
                latitude_deg, longitude_deg = place.degrees(at_m).tolist()
                fix = Fix(latitude_deg, longitude_deg, float(at_m[2]), is_measured=True)
    east, north, _ = pose.world_from_body[:3, :3] @ estimate.velocity.linear_body_m_s
    motion = Motion(math.atan2(east, north) + north_rad, math.hypot(east, north))
    heading_rad = math.pi / 2 - pose.yaw_rad + north_rad
    return [  # the date first, which readers of GGA need
        sentences.zda(time), sentences.gga(time, fix), sentences.rmc(time, fix, motion), sentences.vtg(motion),
        sentences.hdt(heading_rad),
    ]  # fmt: skip
