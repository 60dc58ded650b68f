"""The acoustic lag between a pilot and the vehicle, as a dial: the link of the paper over a chosen time."""

from __future__ import annotations

import math

import numpy as np

from uwsim.base.quaternions import about_z, turned
from uwsim.scenario.build.water import build_water
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.scenario import Scenario

LAG_MAX_S = 3.0
"""4.5 km of water."""
LEAST_DEPTH_M = 1.0


def with_lag(scenario: Scenario, lag_s: float) -> Scenario:
    """Return a scenario whose station is so far from the first vehicle's start that sound takes lag_s for the way.

    The link is `ideal_acoustic`: commands and what the vehicle sends take distance / speed of sound each way, as in the
    published simulator, and nothing is lost. Only the transducer is moved; the lag changes by the way that the vehicle
    makes, 0.7 ms for each metre. Raises ScenarioError for a scenario with a link of its own, or a carried station.
    """
    if scenario.link is not None:
        raise ScenarioError(f"lag_s = {lag_s:g} s: the scenario has a link of its own, {scenario.link.modem.name}")
    station = scenario.station
    if station.carrier is not None:
        raise ScenarioError(f"lag_s = {lag_s:g} s: the scenario's station is carried by '{station.carrier}'")
    start, yaw_rad = scenario.vehicles[0].start, math.radians(station.yaw_deg)
    origin_m = np.asarray(station.position_m, np.float64)
    place_m = np.asarray(start.position_m) if start is not None else turned(about_z(yaw_rad), station.dock_m) + origin_m
    depth_m = max(-float(place_m[2]), LEAST_DEPTH_M)
    speed_m_s = build_water(scenario.water, bottom_depth_m=2.0 * depth_m, seed=scenario.seed).sound_speed_m_s(-depth_m)
    away_m = np.array([place_m[0] + lag_s * speed_m_s, place_m[1], -depth_m]) - origin_m
    transducer_m = turned(about_z(-yaw_rad), away_m)
    link = {"modem": "ideal_acoustic", "station_transducer_m": [round(value, 3) for value in transducer_m.tolist()]}
    return validated(Scenario, {**scenario.given(), "link": link}).read_from(scenario.source_file)
