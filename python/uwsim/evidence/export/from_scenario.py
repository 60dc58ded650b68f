"""A scenario in the terms of the descriptions of other simulators, as their readers leave it; see `robots.robot`."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any, NamedTuple

import numpy as np

from uwsim.evidence.robots.robot import Found, Lump, Mesh, Robot, Thruster, plain_name
from uwsim.evidence.robots.xml_file import Floats, Pose, turned
from uwsim.scenario import Scenario, vehicle_hull
from uwsim.scenario.build.craft import mass_properties
from uwsim.scenario.build.gravity import gravity_m_s2
from uwsim.scenario.build.hull import rigid_body
from uwsim.scenario.build.obstacles import obstacle_solid
from uwsim.scenario.build.start_pose import start_pose
from uwsim.scenario.build.station import station_at_start, station_mesh
from uwsim.scenario.build.terrain import Terrain, build_terrain
from uwsim.scenario.build.water import steady_current_m_s, surface_density_kg_m3
from uwsim.scenario.spec.actuator import ThrusterMount
from uwsim.scenario.spec.fields import Model
from uwsim.scenario.spec.vehicle_entry import VehicleEntry
from uwsim.scenario.spec.water import UniformCurrent

COLOUR, BED_COLOUR = (0.6, 0.6, 0.6), (0.5, 0.45, 0.38)
"""Colours of bodies whose material states none, and of the bed."""
NODES_MAX = 513
"""Nodes along an edge of a bed that is written; of a larger one, every second, third ... node."""
IN_WORLD = ("name", "description", "seed", "step_s", "water", "terrain", "obstacles", "station", "vehicles")
IN_WATER = ("density_kg_m3", "salinity_psu", "current_world_m_s")
IN_VEHICLE = ("name", "model", "start", "sonar", "trim")
IN_MODEL = (
    "builds_on", "name", "description", "mesh", "mesh_scale", "mesh_up", "mesh_forward", "collision",
    "collision_pieces", "mass_kg", "density_kg_m3", "buoyancy", "volume_m3", "centre_of_buoyancy_m",
    "centre_of_mass_m", "inertia_kg_m2", "trim", "ballast_kg", "ballast_position_m", "added_mass", "added_mass_matrix",
    "linear_damping", "linear_damping_matrix", "quadratic_damping", "quadratic_damping_matrix", "thrusters", "sensors",
    "cameras", "sonar", "imaging_sonars",
)  # fmt: skip
"""The keys that are used; any other that a scenario states is noted as left out."""
IN_CAMERA = ("position_m", "yaw_pitch_roll_deg", "width", "height", "field_of_view_deg", "follows", "on")


class Fan(NamedTuple):
    """A multibeam's fan. position_m: of the head, body frame. tilt_deg: nose down. width_deg: across all beams."""

    position_m: Floats
    tilt_deg: float
    beams: int
    width_deg: float
    range_max_m: float
    rate_hz: float


class Exported(NamedTuple):
    """A scenario as found, with what the readers of descriptions do not keep.

    fans: the multibeam of a vehicle, by its name. colours: of obstacles, by their names. step_s: the scenario's.
    """

    found: Found
    fans: dict[str, Fan]
    colours: dict[str, tuple[float, ...]]
    step_s: float


def exported(scenario: Scenario) -> Exported:
    """Return a scenario's fixed bodies and vehicles, and a note for all that it states beside. Raises ScenarioError."""
    found = Found(scenario.name)
    found.density_kg_m3 = surface_density_kg_m3(scenario.water)
    found.current_m_s = steady_current_m_s(scenario.water)
    terrain = build_terrain(scenario.terrain)
    names = [each.name for each in scenario.obstacles]
    bed, dock = plain_name("bed", names), plain_name("station", names)
    found.meshes[bed] = _bed(terrain, found)
    colours = {each.name: each.material.colour for each in scenario.obstacles} | {bed: BED_COLOUR}
    for obstacle in scenario.obstacles:
        vertices, triangles, _ = obstacle_solid(obstacle, terrain)
        found.meshes[obstacle.name] = _mesh(vertices, triangles)
    station = station_at_start(scenario)
    if station.mesh is not None:
        found.meshes[dock] = _mesh(*station_mesh(station))
        colours[dock] = station.material.colour
    _note_others(found, "", scenario, IN_WORLD)
    steady = all(isinstance(each, UniformCurrent) for each in scenario.water.current)
    _note_others(found, "water.", scenario.water, (*IN_WATER, *(("current",) if steady else ())))
    fans = {}
    for vehicle in scenario.vehicles:
        robot = _robot(scenario, vehicle, found)
        found.robots.append(robot)
        if vehicle.model.sonar is not None:
            fans[robot.name] = _fan(vehicle, vehicle.model.sonar.position_m)
    known: dict[str, tuple[float, ...]] = {name: colour for name, colour in colours.items() if colour is not None}
    return Exported(found, fans, known, scenario.step_s)


def _note_others(found: Found, where: str, stated: Model, used: Collection[str]) -> None:
    """Note the keys that are stated, with a value unlike their default, and not used."""
    for key in sorted(stated.model_fields_set - {*used}):
        if getattr(stated, key) not in (None, type(stated).model_fields[key].default, (), {}):
            found.left_out(f"{where}{key}")


def _mesh(vertices: Any, triangles: Any) -> Mesh:
    return np.asarray(vertices, np.float64), np.asarray(triangles, np.int64)


def _bed(terrain: Terrain, found: Found) -> Mesh:
    """Return the bed as the world has it, each cell split along the diagonal from (i + 1, j) to (i, j + 1)."""
    every = int(np.ceil((max(terrain.heights_m.shape) - 1) / (NODES_MAX - 1)))
    if every > 1:
        found.left_out(f"terrain: between nodes {every * terrain.spacing_m:g} m apart, of {terrain.spacing_m:g} m")
    heights = terrain.heights_m[::every, ::every]
    ny, nx = heights.shape
    spacing_m = every * terrain.spacing_m
    x, y = np.meshgrid(*(start + spacing_m * np.arange(n) for start, n in zip(terrain.origin_m, (nx, ny), strict=True)))
    at = np.arange(nx * ny).reshape(ny, nx)
    a, b, c, d = (part.ravel() for part in (at[:-1, :-1], at[:-1, 1:], at[1:, :-1], at[1:, 1:]))
    triangles = np.concatenate([np.column_stack([a, b, c]), np.column_stack([b, d, c])])
    return _mesh(np.column_stack([x.ravel(), y.ravel(), heights.ravel()]), triangles)


def _robot(scenario: Scenario, vehicle: VehicleEntry, found: Found) -> Robot:
    model, density = vehicle.model, found.density_kg_m3
    assert density is not None
    position_m, yaw_rad = start_pose(scenario, vehicle)
    robot = Robot(plain_name(vehicle.name), Pose(np.array(position_m), turned(0.0, 0.0, yaw_rad)))
    where = f"vehicle '{robot.name}'"
    mass, centre_m, inertia = mass_properties(model, density, vehicle.trim or model.trim, gravity_m_s2(scenario.earth))
    robot.lumps = [Lump(mass, np.asarray(centre_m), np.asarray(inertia))]
    robot.solids = [_mesh(*vehicle_hull(model))]
    body = rigid_body(model, density)
    robot.volume_m3, robot.centre_of_buoyancy_m = body.volume_m3, np.asarray(body.centre_of_buoyancy_m)
    robot.added_mass, robot.linear = model.matrix("added_mass"), model.matrix("linear_damping")
    robot.quadratic = model.matrix("quadratic_damping")
    for name, thruster in model.thrusters.items():
        if thruster.force is None:
            robot.thrusters.append(_thruster(name, thruster))
        else:
            found.left_out(f"{where}.thrusters.{name}: moves by {thruster.force}, not by a propeller")
    for name, sensor in model.sensors.items():
        channels = sensor.channels or ({} if sensor.noise is None else {"": sensor.noise})
        robot.sensors[name] = {
            "kind": sensor.kind, "position_m": list(sensor.position_m), "turn": _turn(sensor.yaw_pitch_roll_deg),
            "rate_hz": sensor.rate_hz or 1.0 / scenario.step_s, "parameters": sensor.parameters,
            "std": {channel: _std(noise, sensor.rate_hz) for channel, noise in channels.items()},
        }  # fmt: skip
    for name, camera in model.cameras.items():
        robot.cameras[name] = {
            "at": Pose(np.array(camera.position_m), _turn(camera.yaw_pitch_roll_deg)), "width": camera.width,
            "height": camera.height, "field_of_view_deg": camera.field_of_view_deg,
        }  # fmt: skip
        _note_others(found, f"{where}.cameras.{name}.", camera, IN_CAMERA)
    for name in model.imaging_sonars:
        found.left_out(f"{where}.imaging_sonars.{name}")
    _note_others(found, f"{where}: ", vehicle, IN_VEHICLE)
    _note_others(found, f"{where}: ", model, IN_MODEL)
    return robot


def _std(noise: Any, rate_hz: float | None) -> float:
    return float(np.hypot(noise.std, noise.density * np.sqrt(rate_hz or 0.0)))


def _turn(yaw_pitch_roll_deg: Any) -> Floats:
    yaw, pitch, roll = np.radians(yaw_pitch_roll_deg)
    return turned(roll, pitch, yaw)


def _thruster(name: str, mount: ThrusterMount) -> Thruster:
    commands, thrusts = mount.model.curve_points
    axis = np.array(mount.axis, np.float64)
    return Thruster(
        name, np.array(mount.position_m, np.float64), axis / np.linalg.norm(axis),
        [(x, mount.gain * mount.health * y) for x, y in zip(commands, thrusts, strict=True)], mount.lag_s,
        mount.model.diameter_m, mount.model.bollard_coefficient, mount.spin == "clockwise",
        mount.model.zero_thrust_advance_ratio, mount.model.torque_per_thrust_m,
    )  # fmt: skip


def _fan(vehicle: VehicleEntry, mount_m: Any) -> Fan:
    sonar = vehicle.sonar
    model = sonar.loaded
    band = model.band(sonar.frequency_hz)
    at = np.add(mount_m, model.mounting.position_m)
    return Fan(at, sonar.tilt_deg, model.beams, band.field_of_view_deg, band.range_max_m, model.ping_rate_max_hz)


def without(whole: Lump, parts: list[Lump]) -> Lump:
    """Return what is left of a rigid body without some of its parts (Steiner)."""
    mass = whole.mass_kg - sum(part.mass_kg for part in parts)
    moment = whole.mass_kg * whole.centre_m - sum((part.mass_kg * part.centre_m for part in parts), start=np.zeros(3))
    centre = moment / mass
    inertia = whole.inertia_kg_m2 + whole.mass_kg * _about(whole.centre_m - centre)
    for part in parts:
        inertia = inertia - part.inertia_kg_m2 - part.mass_kg * _about(part.centre_m - centre)
    return Lump(mass, centre, inertia)


def _about(off: Floats) -> Floats:
    return np.asarray(off @ off * np.eye(3) - np.outer(off, off))


def obj(mesh: Mesh) -> bytes:
    """Return a mesh as a Wavefront OBJ file, as all simulators read it."""
    lines = [f"v {x:.7g} {y:.7g} {z:.7g}" for x, y, z in np.asarray(mesh[0]).tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (np.asarray(mesh[1]) + 1).tolist()]
    return ("\n".join(lines) + "\n").encode()


def numbers(values: Any) -> str:
    """Return numbers as the text of an attribute."""
    return " ".join(f"{value + 0.0:.9g}" for value in np.ravel(values).tolist())


def ends_n(thruster: Thruster) -> tuple[float, float]:
    """Return the lowest and the highest thrust, which include 0."""
    thrusts = [thrust for _, thrust in thruster.thrust_n]
    return min(0.0, *thrusts), max(0.0, *thrusts)


def meshes_of(world: Exported) -> Iterator[tuple[str, Mesh, tuple[float, ...]]]:
    """Yield the fixed bodies: name, mesh in the world, and colour."""
    for name, mesh in world.found.meshes.items():
        yield name, mesh, world.colours.get(name, COLOUR)
