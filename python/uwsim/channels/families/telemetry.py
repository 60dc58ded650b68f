"""The values on a vehicle's panel, as measured aboard (see `gauges`): /telemetry, and those of further sensors."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.channels.channel import PANEL, Channel, OverLink
from uwsim.channels.families.estimate import has_estimate
from uwsim.channels.families.gauges import gauge_sensors, gauges, read_sensors, values_by_name
from uwsim.channels.ros import build
from uwsim.channels.ros.own_types import ALL_STOPPED, SENSOR_GAUGES, TELEMETRY
from uwsim.channels.source import Source
from uwsim.navigation.estimation import Navigator
from uwsim.simulator.simulator import Simulator
from uwsim.simulator.vehicle import Vehicle

RATE_HZ = 10.0
NAN = math.nan


def telemetry_channels(source: Source, sim: Simulator, *, truth: bool) -> list[Channel]:
    """Return the channels of a vehicle's panel. truth: whether its true position is published."""
    panel = Channel(
        source.topic("telemetry"), TELEMETRY, "out", "the vehicle's panel, position, commands and warnings",
        rate_hz=RATE_HZ, frame_id=source.frame("odom"), over_link=OverLink(PANEL, "telemetry"),
        read=lambda sim: read(sim, source, truth=truth),
    )  # fmt: skip
    more = Channel(
        source.topic("sensor_gauges"),
        SENSOR_GAUGES,
        "out",
        "the readings of sensors that packages add",
        rate_hz=RATE_HZ,
        frame_id=source.frame("base_link"),
        over_link=OverLink(packing="sensor_gauges"),
        read=lambda sim: read_sensors(sim, source),
    )
    return [panel, more] if gauge_sensors(source.of(sim).sensors) else [panel]


def plain_panel(sim: Simulator, source: Source) -> dict[str, Any]:
    """Return all values on the panel, without the truth, as plain values by name."""
    return values_by_name(read(sim, source, truth=False)) | values_by_name(read_sensors(sim, source))


def read(sim: Simulator, source: Source, *, truth: bool) -> Any:
    """Return the current telemetry message."""
    vehicle = source.of(sim)
    failsafe = vehicle.failsafe
    panel, warnings = vehicle.telemetry(), sim.parameters.scenario.warnings
    estimate = vehicle.navigation.shown if has_estimate(source) else None
    measured = gauges(sim, source, estimate)
    values = dict(measured.values)
    position_m, std_m = values.pop("position"), values.pop("position_std")
    return build.message(
        TELEMETRY,
        header=build.header(sim.time_ns, source.frame("odom")),
        position=position_m + source.origin_m,
        position_std=np.asarray(std_m, np.float32),
        true_position=source.position_odom_m(sim) if truth else np.full(3, NAN),
        orientation=_orientation(vehicle, estimate, truth=truth),
        is_truth=truth,
        **{name: np.asarray(value, np.float32) if np.ndim(value) else float(value) for name, value in values.items()},
        mission_time=panel.mission_time_s,
        battery=panel.battery_percent,
        tilt=vehicle.sonar.elevation_rad if vehicle.sonars else NAN,
        thrusters=np.array([thruster.command for thruster in vehicle.thrusters.values()], np.float32),
        efforts=np.asarray(vehicle.effort, np.float32),
        lamps=np.array([lamp.on for lamp in vehicle.lamps.values()], bool),
        released=vehicle.released,
        range_warning=bool(values["distance_to_station"] > warnings.range_m),
        proximity_warning=bool(values["distance_to_seabed"] < warnings.proximity_m),
        collision_warning=panel.collision_warning,
        collisions=vehicle.collisions,
        failsafe="" if failsafe is None else failsafe.state,
        failsafe_cause="" if failsafe is None else failsafe.cause,
        gauges=list(measured.ages_s),
        gauge_ages=np.array(list(measured.ages_s.values()), np.float32),
        **hold_fields(vehicle, estimate),
        alarms=[*([ALL_STOPPED] if vehicle.all_stopped else []), *(() if failsafe is None else failsafe.alarms)],
    )


def _orientation(vehicle: Vehicle, estimate: Navigator | None, *, truth: bool) -> NDArray[np.float32]:
    if estimate is None and not truth:
        return np.full(4, NAN, np.float32)
    return np.asarray((estimate or vehicle).pose.orientation_xyzw, np.float32)


def hold_fields(vehicle: Vehicle, estimate: Navigator | None) -> dict[str, Any]:
    """Return the names of the active holds, their targets, and a note about the last hold that was lost.

    A depth hold keeps a height; its target is shown below the surface, like the depth gauge, as far as it is estimated.
    """
    holds = vehicle.holds
    if holds is None:
        return {"holds": [], "hold_targets": np.empty(0, np.float32), "hold_note": ""}
    targets = [_number(name, target, estimate) for name, target in holds.targets.items()]
    return {"holds": list(holds.targets), "hold_targets": np.array(targets, np.float32), "hold_note": holds.note}


def _number(name: str, target: list[float] | None, estimate: Navigator | None) -> float:
    if target is None:
        return math.nan
    if name == "position":
        return math.nan if estimate is None else math.dist(target, estimate.pose.position_world_m[:2])
    if name == "depth":
        return (0.0 if estimate is None else estimate.surface_m[0]) - target[0]
    return target[0]
