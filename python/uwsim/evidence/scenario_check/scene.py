"""A scenario's scene in numbers: the bed, the obstacles on it, and the vehicles at their starts."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.evidence.vehicle.figures import VehicleFigures, vehicle_figures
from uwsim.scenario import Terrain, VehicleEntry, build_terrain, start_pose
from uwsim.scenario.build.camera import core_optics
from uwsim.scenario.build.hull import rigid_body, vehicle_hull
from uwsim.scenario.build.solids import obstacle_solid, surface_points
from uwsim.scenario.build.station import exit_position, station_at_start
from uwsim.scenario.build.water import build_water, surface_density_kg_m3
from uwsim.scenario.georeference import georeference
from uwsim.scenario.read.mesh_file import Triangles, Vertices
from uwsim.scenario.spec.obstacle import ObstacleModel
from uwsim.scenario.spec.water import StillSurface
from uwsim.simulator.simulator import Simulator

CONTRAST = 0.02
"""The smallest visible contrast: Duntley 1963, "Light in the sea", J. Opt. Soc. Am. 53:214."""

STILL_M_S = 0.005
"""Speed below which a current has no relevant effect on a vehicle, and is shown as 0.00 m/s."""

CURRENT_SHARE, CURRENT_TIMES = 0.9, 97
"""The current at a start: the speed not exceeded for this share of the mission, sampled at this many times."""

TOUCHING_M = 0.001


@dataclass(frozen=True)
class Bed:
    """The terrain.

    extent_m: west, south, east, north. lowest_m, highest_m: z of the lowest and highest point. dry_share: share of its
    area that is above water.
    """

    extent_m: tuple[float, float, float, float]
    lowest_m: float
    highest_m: float
    dry_share: float


@dataclass(frozen=True)
class ObstacleScene:
    """An obstacle in the scene.

    lowest_m, highest_m: z of the lowest and highest point. clearance_m: smallest height of its points above the bed;
    negative if it reaches below the bed. size_m: extent along the world's x, y and z. buried_share, above_water_share:
    shares of its surface below the bed and above the water. beside_terrain: whether any part of it is outside the
    terrain. held: whether its bounding box touches that of another obstacle.
    """

    name: str
    kind: str
    size_m: tuple[float, float, float]
    lowest_m: float
    highest_m: float
    clearance_m: float
    buried_share: float
    above_water_share: float
    beside_terrain: bool
    held: bool


@dataclass(frozen=True)
class VehicleScene:
    """A vehicle at its starting position.

    altitude_m: smallest height of its hull above the bed. beside_terrain: whether any part of the hull is outside the
    terrain. free_m: distance to the nearest surface; for a docked vehicle, from the dock's exit. radius_m: radius of a
    sphere around its hull. weight_n: weight in air. net_buoyancy_n: buoyancy minus weight, arm included, deep in still
    water; positive if the vehicle rises. lift_n: maximum downward (negative) and upward thrust. current_m_s: current at
    the start, see CURRENT_SHARE. holds_current: whether it can hold its position in that current. figures: properties
    of its model in this water.
    """

    name: str
    model: str
    position_m: tuple[float, float, float]
    yaw_deg: float
    docked: bool
    altitude_m: float
    beside_terrain: bool
    free_m: float
    radius_m: float
    weight_n: float
    net_buoyancy_n: float
    lift_n: tuple[float, float]
    current_m_s: float
    holds_current: bool
    figures: VehicleFigures


@dataclass(frozen=True)
class Scene:
    """The whole scene. sight_m: the maximum range at which cameras see a dark target, see CONTRAST.

    station_bed_m: z of the bed.
    """

    name: str
    bed: Bed
    density_kg_m3: float
    sight_m: float
    station_m: tuple[float, float, float]
    station_bed_m: float
    obstacles: tuple[ObstacleScene, ...]
    vehicles: tuple[VehicleScene, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return the scene as plain values, with None for non-finite numbers."""
        values: dict[str, Any] = plain(asdict(self))
        return values


def plain(value: Any) -> Any:
    """Return values for JSON, with None for non-finite numbers."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def measured_scene(sim: Simulator) -> Scene:
    """Return a simulator's scene at the start."""
    scenario = sim.scenario
    terrain = build_terrain(scenario.terrain)
    part = terrain.window(scenario.terrain.window_m)
    station = station_at_start(scenario).position_m
    solids = [obstacle_solid(obstacle, terrain)[:2] for obstacle in scenario.obstacles]
    boxes = np.array([(vertices.min(axis=0), vertices.max(axis=0)) for vertices, _ in solids]).reshape(-1, 2, 3)
    return Scene(
        name=scenario.name,
        bed=Bed(part.extent_m, part.lowest_m, float(part.heights_m.max()), float((part.heights_m > 0.0).mean())),
        density_kg_m3=float(sim.world.water.density_at_kg_m3(0.0)),
        sight_m=sight_m(core_optics(scenario.optics).water.beam_attenuation),
        station_m=station,
        station_bed_m=float(terrain.height_at([station[:2]])[0]),
        obstacles=tuple(
            _obstacle(obstacle, *solids[k], terrain, held=_touches_another(boxes, k))
            for k, obstacle in enumerate(scenario.obstacles)
        ),
        vehicles=tuple(_vehicle(sim, entry, terrain) for entry in scenario.vehicles),
    )


def sight_m(beam_attenuation: Floats) -> float:
    """Return the distance at which contrast, exp(-c r), falls to CONTRAST in the clearest band."""
    return float(-math.log(CONTRAST) / np.min(beam_attenuation))


def _touches_another(boxes: Floats, index: int) -> bool:
    """Return whether one of the boxes (n, 2, 3), lowest and highest corners, touches another, within 1 mm."""
    apart_m = np.maximum(boxes[:, 0] - boxes[index, 1], boxes[index, 0] - boxes[:, 1]).max(axis=1)
    return bool((np.delete(apart_m, index) <= TOUCHING_M).any())


def _obstacle(
    obstacle: ObstacleModel, vertices: Vertices, triangles: Triangles, terrain: Terrain, *, held: bool
) -> ObstacleScene:
    points = surface_points(vertices, triangles)
    beds = terrain.height_at(points[:, :2])
    beside = bool(np.isnan(beds).any())
    clear = points[:, 2] - beds
    corners = vertices[:, 2] - terrain.height_at(vertices[:, :2])
    every = np.concatenate([clear, corners])
    return ObstacleScene(
        name=obstacle.name,
        kind=obstacle.kind,
        size_m=_three(np.ptp(vertices, axis=0)),
        lowest_m=float(vertices[:, 2].min()),
        highest_m=float(vertices[:, 2].max()),
        clearance_m=float(np.nanmin(every)) if not np.isnan(every).all() else math.nan,
        buried_share=float(np.mean(clear < 0.0)),
        above_water_share=float(np.mean(points[:, 2] > 0.0)),
        beside_terrain=beside,
        held=held,
    )


def _vehicle(sim: Simulator, entry: VehicleEntry, terrain: Terrain) -> VehicleScene:
    position, yaw_rad = start_pose(sim.scenario, entry)
    hull = Rotation.from_euler("z", yaw_rad).apply(np.array(vehicle_hull(entry.model)[0])) + np.asarray(position)
    docked = entry.start is None
    radius_m = float(np.linalg.norm(vehicle_hull(entry.model)[0], axis=1).max())
    if docked:
        free_m = float(sim.scene.distance_m(exit_position(station_at_start(sim.scenario))[None])[0]) - radius_m
    else:
        free_m = float(sim.scene.distance_m(hull[:: max(1, len(hull) // 2000)]).min())
    water = sim.world.water
    control = sim.vehicles[entry.name].control.model
    current_m_s = _current_m_s(sim, position)
    net_n = sim.vehicles[entry.name].control.net_buoyancy_n - _arm_weight_n(sim, entry)
    displaced_kg = float(water.density_at_kg_m3(0.0)) * rigid_body(entry.model, 1000.0).volume_m3
    clear_m = hull[:, 2] - terrain.height_at(hull[:, :2])
    density_kg_m3 = surface_density_kg_m3(sim.scenario.water)
    return VehicleScene(
        name=entry.name,
        model=entry.model.name,
        position_m=position,
        yaw_deg=float(np.degrees(yaw_rad)),
        docked=docked,
        altitude_m=float(np.nanmin(clear_m)),
        beside_terrain=bool(np.isnan(clear_m).any()),
        free_m=free_m,
        radius_m=radius_m,
        weight_n=displaced_kg * water.gravity_m_s2 - net_n,
        net_buoyancy_n=net_n,
        lift_n=_lift_n(control),
        current_m_s=current_m_s,
        holds_current=_holds(control, current_m_s),
        figures=vehicle_figures(entry.model, control, density_kg_m3, entry.trim, water.gravity_m_s2),
    )


def _arm_weight_n(sim: Simulator, entry: VehicleEntry) -> float:
    """Return the weight in water of the vehicle's arm."""
    water = sim.world.water
    density_kg_m3 = float(water.density_at_kg_m3(0.0))
    links = (entry.model.arm or {}).values()
    return float(water.gravity_m_s2 * sum(link.mass_kg - density_kg_m3 * link.volume_m3 for link in links))


def _current_m_s(sim: Simulator, position_m: tuple[float, float, float]) -> float:
    """Return the speed of the current at a position, ignoring waves, which only move a vehicle back and forth."""
    calm = sim.scenario.water.model_copy(update={"surface": StillSurface()})
    water = build_water(
        calm, bottom_depth_m=sim.world.water.bottom_depth_m, seed=sim.scenario.seed,
        place=partial(georeference, sim.scenario),
    )  # fmt: skip
    times_s = np.linspace(0.0, sim.scenario.mission_time_s, CURRENT_TIMES).tolist()
    speeds = [float(np.linalg.norm(water.velocity_m_s([position_m], time_s))) for time_s in times_s]
    return float(np.quantile(speeds, CURRENT_SHARE))


def _three(values: Floats) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z


def _lift_n(control: _core.ControlModel) -> tuple[float, float]:
    """Return the largest downward (negative) and upward force of the thrusters."""
    down, up = (float(control.reachable((0.0, 0.0, sign * 1e5, 0.0, 0.0, 0.0))[2]) for sign in (-1.0, 1.0))
    return down, up


def _holds(control: _core.ControlModel, speed_m_s: float) -> bool:
    """Return whether the thrusters can drive the vehicle ahead at a given speed through water; always True near 0."""
    if speed_m_s < STILL_M_S:
        return True
    ahead = np.array([speed_m_s, 0.0, 0.0, 0.0, 0.0, 0.0])
    needed = float(control.wrench_body(np.eye(3), ahead, np.zeros(6))[0])
    reached = control.reachable((needed, 0.0, 0.0, 0.0, 0.0, 0.0))[0]
    return bool(reached >= 0.999 * needed)
