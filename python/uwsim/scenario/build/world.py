"""The core's world, for physics and ray casting: terrain, obstacles, station and water; and a simulation's settings."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.quaternions import about_z
from uwsim.scenario.build.cover import add_cover, add_life, add_plumes
from uwsim.scenario.build.earth import gravity_m_s2
from uwsim.scenario.build.hull import rigid_body, vehicle_hull
from uwsim.scenario.build.loose_bodies import object_points
from uwsim.scenario.build.scale import require_fits, require_solid_fits
from uwsim.scenario.build.solids import obstacle_solid
from uwsim.scenario.build.station import carrier_index, dock_position, start_pose, station_mesh
from uwsim.scenario.build.terrain import Terrain, build_terrain
from uwsim.scenario.build.vehicle import vehicle_errors_at
from uwsim.scenario.build.water import build_water
from uwsim.scenario.build.wind import set_wind
from uwsim.scenario.georeference import georeference
from uwsim.scenario.read.errors import Collected, ScenarioError
from uwsim.scenario.spec.loose_body import LooseBody
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.vehicle_entry import VehicleEntry

FRESH_KG_M3 = 1000.0


def beyond_terrain(world: _core.World, scenario: Scenario, x_m: float, y_m: float, z_m: float) -> str | None:
    """Return as text the terrain's bounds, or its height there, if a position is outside or below it; else None."""
    bed_m = float(world.height_at([[x_m, y_m]])[0])
    if np.isfinite(bed_m):
        return None if z_m >= bed_m else f"whose height there is {bed_m:.2f} m"
    return build_terrain(scenario.terrain).window(scenario.terrain.window_m).extent_text


def build_world(scenario: Scenario) -> _core.World:
    """Return the world of a scenario: terrain, obstacles, the station (named "station"), cover and water.

    Raises a ScenarioError that lists all mistakes.
    """
    errors_at = scenario.source_file.errors_at
    with errors_at("terrain"):
        terrain = build_terrain(scenario.terrain)
        part = terrain.window(scenario.terrain.window_m)
    found = Collected()
    _require_inside(scenario, part, found)
    world = _core.World()
    world.set_terrain(part.heights_m, part.spacing_m, part.origin_m)
    for index, obstacle in enumerate(scenario.obstacles):
        with found.noted(), errors_at("obstacles", index):
            solid = obstacle_solid(obstacle, terrain)
            if obstacle.has_own_unit:
                require_solid_fits(obstacle.name, solid.vertices, terrain)
            world.add_solid(obstacle.name, *solid)
    if scenario.station.mesh is not None:
        with found.noted(), errors_at("station", "mesh"):
            vertices, triangles = station_mesh(scenario.station)
            require_solid_fits("station", vertices, terrain)
            world.add_solid("station", vertices, triangles)
    for index, layer in enumerate(scenario.cover):
        with found.noted(), errors_at("cover", index):
            add_cover(world, layer)
    for index, animals in enumerate(scenario.life or ()):
        with found.noted(), errors_at("life", index):
            add_life(world, terrain, animals)
    _require_free_starts(world, terrain, scenario, found)
    for index, body in enumerate(scenario.objects):
        with found.noted(), errors_at("objects", index):
            _require_free(world, terrain, body)
    with found.noted():
        fill_with_water(world, scenario)
    with found.noted():
        add_plumes(world, terrain, scenario)
    found.raise_any()
    return world


def _require_free_starts(world: _core.World, terrain: Terrain, scenario: Scenario, found: Collected) -> None:
    """Note the vehicles that do not fit into a world whose solids are complete, or that start in one of them."""
    errors_at = scenario.source_file.errors_at
    for index, vehicle in enumerate(scenario.vehicles):
        with found.noted(), vehicle_errors_at(scenario, index):
            require_fits(vehicle.model.name, _hull(vehicle), terrain, vehicle.model.mesh_scale)
        point_m, _ = start_pose(scenario, vehicle)
        if (name := world.solid_around(point_m)) is not None:
            with found.noted(), errors_at("vehicles", index, *(("start", "position_m") if vehicle.start else ())):
                at = ", ".join(f"{x:g}" for x in point_m)
                raise ScenarioError(f"vehicle '{vehicle.name}' starts at ({at}) m: must be outside '{name}'")


def _require_free(world: _core.World, terrain: Terrain, body: LooseBody) -> None:
    """Raise ScenarioError for a body that cannot be where it starts or where its path leads, or is no solid."""
    for index, (x, y, z) in enumerate(object_points(body, terrain).tolist()):
        does = "starts with its middle" if index == 0 else "is on its path"
        _require_above(terrain, (x, y, z), f"object '{body.name}' {does} at")
        if (name := world.solid_around((x, y, z))) is not None:
            raise ScenarioError(
                f"object '{body.name}' {does} at ({x:.4g}, {y:.4g}, {z:.4g}) m: must be outside '{name}'"
            )


def _hull(vehicle: VehicleEntry) -> NDArray[np.float64]:
    """Return a hull's vertices, or a single zero vertex if the hull is invalid; the error is reported later."""
    try:
        rigid_body(vehicle.model, FRESH_KG_M3)
        return vehicle_hull(vehicle.model)[0]
    except ScenarioError:
        return np.zeros((1, 3))


def fill_with_water(world: _core.World, scenario: Scenario) -> None:
    """Set the world's water from the scenario, with waves and gusts from its seed. Raises ScenarioError."""
    world.water = scenario_water(scenario, world)


def scenario_water(scenario: Scenario, world: _core.World) -> _core.Water:
    """Return the scenario's water for a world that already has its terrain. Raises ScenarioError."""
    with scenario.source_file.errors_at("water"):
        return build_water(
            scenario.water, bottom_depth_m=-world.lowest_m, seed=scenario.seed,
            gravity_m_s2=gravity_m_s2(scenario.earth), place=partial(georeference, scenario),
        )  # fmt: skip


def _require_inside(scenario: Scenario, terrain: Terrain, found: Collected) -> None:
    """Reject a dry world; record vehicles that start outside or below the terrain, and survey corners outside it."""
    errors_at = scenario.source_file.errors_at
    if terrain.lowest_m >= 0.0:
        with errors_at("terrain"):
            raise ScenarioError(
                f"terrain: its lowest point is at z = {terrain.lowest_m:g} m: must be below the water, z = 0"
            )
    for index, vehicle in enumerate(scenario.vehicles):
        point_m, _ = start_pose(scenario, vehicle)
        with found.noted(), errors_at("vehicles", index, *(("start", "position_m") if vehicle.start else ())):
            _require_above(terrain, point_m, f"vehicle '{vehicle.name}' starts at")
    for index, corner in enumerate(scenario.survey.area_m if scenario.survey else ()):
        with found.noted(), errors_at("survey", "area_m", index):
            _require_above(terrain, (*corner, np.inf), f"survey.area_m[{index}] =")


def _require_above(terrain: Terrain, point_m: tuple[float, float, float], what: str) -> None:
    x, y, z = point_m
    bed = terrain.height_at([[x, y]])[0]
    if np.isnan(bed):
        raise ScenarioError(f"{what} ({x:g}, {y:g}) m: outside the terrain, {terrain.extent_text}")
    if z <= bed:
        raise ScenarioError(f"{what} ({x:g}, {y:g}, {z:g}) m: must be above the bed, which is at z = {bed:g} m there")


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
