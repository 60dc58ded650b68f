"""From a scenario to the one native world that feeds physics and rays."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from uwsim import _core
from uwsim.scenario.errors import ScenarioError
from uwsim.scenario.material_spec import ROCK, Backscatter
from uwsim.scenario.meshes import Triangles, Vertices, load_mesh
from uwsim.scenario.obstacles import obstacle_body
from uwsim.scenario.schema import Scenario, Station, Vehicle
from uwsim.scenario.terrain import Terrain, build_terrain
from uwsim.scenario.water import build_water


def build_world(scenario: Scenario) -> _core.World:
    """Terrain, obstacles and station ("station"), and the water over them. Raises ScenarioError."""
    place = scenario.origin.place
    with place("terrain"):
        terrain = build_terrain(scenario.terrain)
    _require_inside(scenario, terrain)
    world = _core.World()
    world.set_terrain(terrain.heights_m, terrain.spacing_m, terrain.origin_m)
    for index, obstacle in enumerate(scenario.obstacles):
        with place("obstacles", index):
            world.add_solid(obstacle.name, *obstacle_body(obstacle, terrain))
    if scenario.station.mesh is not None:
        with place("station", "mesh"):
            world.add_solid("station", *_station_mesh(scenario.station))
    for index, vehicle in enumerate(scenario.vehicles):
        point_m, _ = start_pose(scenario, vehicle)
        if (name := world.solid_around(point_m)) is not None:
            with place("vehicles", index, *(("start", "position_m") if vehicle.start else ())):
                x, y, z = point_m
                raise ScenarioError(f"vehicles[{index}] starts at ({x:g}, {y:g}, {z:g}) m: must be outside '{name}'")
    with place("water"):
        world.water = build_water(scenario.water, bottom_depth_m=-terrain.lowest_m, seed=scenario.seed)
    return world


def label_names(scenario: Scenario) -> list[str]:
    """What World.label_names will say of the world that `build_world` makes."""
    station = ["station"] if scenario.station.mesh is not None else []
    return ["nothing", "terrain", *(obstacle.name for obstacle in scenario.obstacles), *station]


def backscatter_by_label(scenario: Scenario) -> list[Backscatter]:
    """How what is under each label scatters sound, in the order of `label_names`."""
    station = [scenario.station.material] if scenario.station.mesh is not None else []
    solids = [obstacle.material for obstacle in scenario.obstacles] + station
    return [ROCK, scenario.ground.backscatter, *(material.backscatter for material in solids)]


def start_pose(scenario: Scenario, vehicle: Vehicle) -> tuple[tuple[float, float, float], float]:
    """Where a vehicle's origin is at the start (world, metres) and its yaw (radians); docked or free."""
    if vehicle.start is not None:
        return vehicle.start.position_m, float(np.radians(vehicle.start.yaw_deg))
    station = scenario.station
    x, y, z = _world_from_station(station).apply(station.dock_m) + np.asarray(station.position_m)
    return (float(x), float(y), float(z)), float(np.radians(station.yaw_deg))


def _world_from_station(station: Station) -> Rotation:
    return Rotation.from_euler("z", station.yaw_deg, degrees=True)


def _station_mesh(station: Station) -> tuple[Vertices, Triangles]:
    assert station.mesh is not None
    vertices, triangles = load_mesh(station.mesh)
    return _world_from_station(station).apply(vertices) + np.asarray(station.position_m), triangles


def _require_inside(scenario: Scenario, terrain: Terrain) -> None:
    """Refuses a dry world, and vehicles and survey corners beside, or vehicles below, the terrain."""
    place = scenario.origin.place
    if terrain.lowest_m >= 0.0:
        with place("terrain"):
            raise ScenarioError(
                f"terrain: its lowest point is at z = {terrain.lowest_m:g} m: must be below the water, z = 0"
            )
    for index, vehicle in enumerate(scenario.vehicles):
        point_m, _ = start_pose(scenario, vehicle)
        with place("vehicles", index, *(("start", "position_m") if vehicle.start else ())):
            _require_above(terrain, point_m, f"vehicles[{index}] starts at")
    for index, corner in enumerate(scenario.survey.area_m if scenario.survey else ()):
        with place("survey", "area_m", index):
            _require_above(terrain, (*corner, np.inf), f"survey.area_m[{index}] =")


def _require_above(terrain: Terrain, point_m: tuple[float, float, float], what: str) -> None:
    x, y, z = point_m
    bed = terrain.height_at([[x, y]])[0]
    if np.isnan(bed):
        raise ScenarioError(f"{what} ({x:g}, {y:g}) m: outside the terrain, {terrain.extent_text}")
    if z <= bed:
        raise ScenarioError(f"{what} ({x:g}, {y:g}, {z:g}) m: must be above the bed, which is at z = {bed:g} m there")
