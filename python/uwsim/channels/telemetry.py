"""/telemetry: the panel of a vehicle in one message, for operators."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.channels import build
from uwsim.channels.channel import PANEL, Channel
from uwsim.channels.own_types import TELEMETRY
from uwsim.channels.source import Source
from uwsim.simulator import Simulator
from uwsim.vehicle import Vehicle

RATE_HZ = 10.0
NAN = math.nan


def telemetry_channel(source: Source, *, truth: bool) -> Channel:
    """Return a vehicle's channel. truth: whether its true position may be seen."""
    return Channel(
        source.topic("telemetry"), TELEMETRY, "out", "the vehicle's panel, position, commands and warnings",
        rate_hz=RATE_HZ, frame_id=source.frame("odom"), over_link=True, priority=PANEL, packing="telemetry",
        read=lambda sim: read(sim, source, truth=truth),
    )  # fmt: skip


def read(sim: Simulator, source: Source, *, truth: bool) -> Any:
    """Return the message of this moment."""
    vehicle = source.of(sim)
    panel, sensors, water = vehicle.telemetry(), vehicle.sensors, sim.world.water
    attitude = vehicle.pose if truth else _reading(vehicle, "imu")
    orientation = np.full(4, NAN) if attitude is None else attitude.orientation_xyzw
    return build.message(
        TELEMETRY,
        header=build.header(sim.time_ns, source.frame("odom")),
        position=source.position_odom_m(sim) if truth else np.full(3, NAN),
        estimate=_estimate_odom_m(sim, source),
        orientation=np.asarray(orientation, np.float32),
        is_truth=truth,
        speed=panel.speed_m_s,
        angular_speed=panel.angular_speed_rad_s,
        temperature=panel.temperature_deg_c,
        pressure=panel.pressure_pa,
        depth=panel.depth_m,
        distance_to_station=panel.distance_to_station_m,
        distance_to_seabed=panel.distance_to_seabed_m,
        distance_to_port=float(sensors["proximity_port"].read()) if "proximity_port" in sensors else NAN,
        mission_time=panel.mission_time_s,
        battery=panel.battery_percent,
        link_delay=panel.distance_to_station_m / water.sound_speed_m_s(min(-0.5 * panel.depth_m, 0.0)),
        tilt=vehicle.sonar.elevation_rad if vehicle.sonars else NAN,
        thrusters=np.array([thruster.command for thruster in vehicle.thrusters.values()], np.float32),
        efforts=np.asarray(vehicle.effort, np.float32),
        lamps=np.array([lamp.on for lamp in vehicle.lamps.values()], bool),
        released=vehicle.released,
        range_warning=panel.range_warning,
        proximity_warning=panel.proximity_warning,
        collision_warning=panel.collision_warning,
        collisions=vehicle.collisions,
    )


def _estimate_odom_m(sim: Simulator, source: Source) -> NDArray[np.float64]:
    """Return where the vehicle's own instruments have it, (3,): by the newest USBL fix, and its depth sensor."""
    vehicle = source.of(sim)
    fix = _reading(vehicle, "usbl")
    if fix is None or fix.range_m <= 0.0:  # out of range
        return np.full(3, NAN)
    position = np.asarray(fix.position_m, np.float64) + sim.scenario.station.position_m
    depth_m = _reading(vehicle, "depth")
    if depth_m is not None:
        position[2] = -depth_m
    return position + source.origin_m


def _reading(vehicle: Vehicle, kind: str) -> Any:
    """Return what the vehicle's first sensor of a kind reads, or None if there is none."""
    return next((sensor.read() for sensor in vehicle.sensors.values() if sensor.kind == kind), None)
