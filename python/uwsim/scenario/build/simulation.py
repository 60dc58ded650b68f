"""A scenario's clock, seed, mission time and warning limits as the core's SimulationSpec."""

from __future__ import annotations

import math

from uwsim import _core
from uwsim.base.quaternions import about_z
from uwsim.scenario.build.station import carrier_index, dock_position
from uwsim.scenario.build.wind import set_wind
from uwsim.scenario.spec.scenario import Scenario

ENGINES = {"uwsim": _core.DynamicsEngine.UWSIM, "bullet": _core.DynamicsEngine.BULLET}


def simulation_spec(scenario: Scenario) -> _core.SimulationSpec:
    """Return all settings of the core's simulation except the world and the vehicles."""
    spec = _core.SimulationSpec()
    spec.step_s = scenario.step_s
    spec.seed = scenario.seed
    spec.engine = ENGINES[scenario.dynamics.engine]
    spec.mission_time_s = scenario.mission_time_s
    spec.station_world_m = scenario.station.position_m
    spec.range_warning_m = scenario.warnings.range_m
    spec.proximity_warning_m = scenario.warnings.proximity_m
    set_wind(spec, scenario)
    if (carrier := carrier_index(scenario)) is not None:
        station = scenario.station
        docked = dock_position(station), about_z(math.radians(station.yaw_deg))
        spec.carry_station(carrier, station.position_m, *docked)
    return spec
