"""Writes what was found in another format as a scenario, its vehicles' files and their meshes."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, cast

import numpy as np

from uwsim.base.atomic_file import write_atomically
from uwsim.base.axes import AXES
from uwsim.base.own_files import require_own
from uwsim.base.texts.yaml_document import yaml_document
from uwsim.exchange.hulls.draft import drafted
from uwsim.exchange.robots.floors import BED_M, grid_text, ground_heights, ground_of, plane_heights
from uwsim.exchange.robots.robot import SENSES, Description, Fin, Mesh, Robot, Thruster, plain_name, unlike_zero
from uwsim.exchange.robots.shapes import closed, joined, volume_and_centre
from uwsim.exchange.robots.xml_file import Floats, Pose, yaw_pitch_roll_deg
from uwsim.scenario.dump import yaml_text
from uwsim.scenario.read.calibration import read_calibration
from uwsim.scenario.read.note import Note
from uwsim.simulator.simulator import Simulator

ROOM_M, BED_MIN_M, BED_SPACING_M = 60.0, 20.0, 2.0
"""Assumed: the flat bed reaches this far around what was found, and is at least this deep."""
FINE_M, FINE_COUNT, BORDER, LEVEL_M = 0.5, 1000, 2, 0.05
"""Spacing of a bed that is not level, its most cells along an edge, those around them, and what counts as level."""
GUEST, GUEST_DEPTH_M, GUEST_ROOM_M = "bluerov2_heavy", 2.0, 2.0
"""The vehicle of a world without one, where it starts, and how far from objects."""
PLACES = 21
"""Odd: places tried for it along x and along y, with the middle among them."""
PRODUCTS = 0.01
"""Products of inertia beyond this share of the smallest moment are noted, since they are left out."""
BEYOND = 1.1
"""A stretched hull reaches this much farther than the centre of mass."""
STRAIGHT = 1e-3
"""Smaller components of a thruster's axis are errors of angles that a file states to three digits, such as 1.571.
As levers, they would let an allocation balance a moment by far more thrust than there is."""
ALTIMETER = {"kind": "altitude", "rate_hz": 15, "noise": {"std": 0.0024}, "range_max_m": 100.0}
"""An altimeter that is added: the range of a Ping, the errors of the packaged sensors `bluerov2`."""
STATES = ("added_mass", "linear", "quadratic")
KEYS = {"added_mass": "added_mass", "linear": "linear_damping", "quadratic": "quadratic_damping"}


def write_found(found: Description, out: Path) -> Path:
    """Write a folder: NAME.yaml, and for each vehicle its YAML file and hull. Return the scenario's path.

    Everything is checked before anything is written: what uwsim would refuse is refused here. Notes are added to
    `found.notes`. Raises ValueError or OSError.
    """
    if not found.robots:
        found.robots.append(_guest(found))
    if found.name in {robot.name for robot in found.robots}:  # each has a file
        found.name = plain_name(f"{found.name}_water")
    contents: dict[str, bytes] = {}
    vehicles, objects = [], [*found.obstacles]
    for name, mesh in found.meshes.items():
        contents[f"{name}.ply"] = _ply(mesh)
    for robot in list(found.robots):
        entry: dict[str, Any] = {"name": robot.name, "model": robot.model}
        if robot.model is None:
            try:
                hull, values, origin = _vehicle(robot, found)
            except ValueError as error:
                found.refuse(robot, error)
                continue
            entry["model"] = f"{robot.name}.yaml"
            robot.place = robot.place.then(Pose(origin, np.eye(3)))
            contents[f"{robot.name}.ply"] = _ply(hull)
            contents[f"{robot.name}.yaml"] = yaml_text(values).encode()
        entry["start"] = _start(robot, found)
        if robot.sonar is not None:
            entry["sonar"] = {"model": 2, "tilt_deg": 30}
        vehicles.append(entry)
    contents[f"{found.name}.yaml"] = yaml_text(_scenario(found, vehicles, objects, contents)).encode()
    require_simulable(found.name, contents)
    for name in contents:
        require_own(out / name)
    out.mkdir(parents=True, exist_ok=True)
    for name, content in contents.items():
        write_atomically(out / name, content)
    return out / f"{found.name}.yaml"


def _guest(found: Description) -> Robot:
    """Return a packaged vehicle for a world without one, at its clear place."""
    ground, bed_m = None, -np.inf if found.bed_z_m is None else found.bed_z_m
    if found.bed_z_m is None and found.meshes:
        middle = np.mean(_extent(found), axis=0)[:2]
        ground = ground_of(found.meshes, np.array([[*middle, BED_M]]))
    if ground is not None and (floor := ground_heights(found.meshes[ground], BED_M, *middle[:, None])) is not None:
        bed_m = float(floor[0, 0])
    at = _clear_place(found, max(-GUEST_DEPTH_M, 0.5 * bed_m), ground)
    found.assumed(f"no vehicle is in it: '{GUEST}' starts at ({', '.join(f'{value:.4g}' for value in at)}) m")
    return Robot(GUEST, Pose(at, np.eye(3)), model=GUEST)


def _clear_place(found: Description, height_m: float, ground: str | None) -> Floats:
    """Return the place nearest to the middle with nothing beside, above or close below it, else one beside all objects.

    A triangle counts for all of its box, so that a place is never within a solid. ground: the name of the body over
    which places are, if it is known.
    """
    if not found.meshes:
        return np.array([0.0, 0.0, height_m])
    (low, high), others = _extent(found), [mesh for name, mesh in found.meshes.items() if name != ground]
    corners = np.concatenate([np.zeros((0, 3, 3)), *(vertices[each] for vertices, each in others)])
    corners = corners[corners[:, :, 2].max(axis=1) > height_m - GUEST_ROOM_M]
    least, most = corners.min(axis=1)[:, :2] - GUEST_ROOM_M, corners.max(axis=1)[:, :2] + GUEST_ROOM_M
    middle = (low + high)[:2] / 2.0
    grid = np.stack(np.meshgrid(*np.linspace(low[:2], high[:2], PLACES).T), axis=-1).reshape(-1, 2)
    for place in grid[np.argsort(np.linalg.norm(grid - middle, axis=1), kind="stable")]:
        if not ((least < place) & (place < most)).all(axis=1).any():
            return np.array([*place, height_m])
    return np.array([high[0] + GUEST_ROOM_M, middle[1], height_m])


def _extent(found: Description) -> tuple[Floats, Floats]:
    """Return the lowest and the highest corner of the box around all fixed objects, (3,) each [m]."""
    corners = np.array([edge(vertices, axis=0) for vertices, _ in found.meshes.values() for edge in (np.min, np.max)])
    return corners.min(axis=0), corners.max(axis=0)


def require_simulable(name: str, contents: Mapping[str, bytes]) -> None:
    """Raise ValueError for the files of a scenario `name`.yaml if they cannot be simulated.

    The message does not name their lines: the files will not exist.
    """
    with TemporaryDirectory() as folder:
        for file, content in contents.items():
            (Path(folder) / file).write_bytes(content)
        try:
            Simulator(Path(folder) / f"{name}.yaml")
        except ValueError as error:
            lines = "|".join(map(re.escape, contents))
            raise ValueError(re.sub(rf"\b({lines}):\d+: ", "", str(error).replace(f"{folder}/", ""))) from None


def _scenario(
    found: Description, vehicles: list[dict[str, Any]], obstacles: list[dict[str, Any]], contents: dict[str, bytes]
) -> dict[str, Any]:
    """Return a scenario's values; a sloped bed is a file of its own, added to the contents."""
    places = [robot.place.position_m for robot in found.robots]
    lowest_m = 0.0
    if found.meshes:
        low, high = _extent(found)
        places += [np.array([*low[:2], 0.0]), np.array([*high[:2], 0.0])]
        lowest_m = float(low[2])
    across = 2.0 * (max(float(np.abs(place[:2]).max()) for place in places) + ROOM_M)
    deep = max(BED_MIN_M, max(-float(place[2]) for place in places) + BED_MIN_M, -lowest_m)
    across = BED_SPACING_M * float(np.ceil(across / BED_SPACING_M))
    made = _sloped_bed(found, across)
    if found.bed_z_m is not None:
        deep = -found.bed_z_m
    terrain = {"source": "noise", "size_m": [across, across], "spacing_m": BED_SPACING_M, "bed_depth_m": deep}
    if made is not None:
        heights, spacing = made
        contents[f"{found.name}_bed.asc"] = grid_text(heights, spacing)
        terrain = {
            "source": "raster", "file": f"{found.name}_bed.asc", "crs": "local", "water_level_m": 0.0,
            "size_m": [across, across], "spacing_m": spacing, "interpolation": "linear",
        }  # fmt: skip
        found.assumed(f"a bed {across:g} m wide, from {-heights.max():.4g} to {-heights.min():.4g} m deep")
    else:
        found.assumed(f"a bed {across:g} m wide" + ("" if found.bed_z_m is not None else f", flat at {deep:g} m"))
    water: dict[str, Any] = {}
    if found.density_kg_m3 is not None:
        water["density_kg_m3"] = found.density_kg_m3
    if found.current_m_s is not None and found.current_m_s.any():
        water["current_world_m_s"] = found.current_m_s.tolist()
    return {
        "name": found.name,
        "description": "made by `uwsim scenario from`",
        **({"water": water} if water else {}),
        "terrain": terrain,
        "vehicles": vehicles,
        **({"obstacles": obstacles} if obstacles else {}),
        **({"objects": found.objects} if found.objects else {}),
        **({"pingers": found.pingers} if found.pingers else {}),
        **({"station": {"position_m": found.station}} if found.station else {}),
    }


def _sloped_bed(found: Description, across_m: float) -> tuple[Floats, float] | None:
    """Return the heights of a bed that is not level, and their spacing: a plane's, or those of the body under all.

    A level ground sets `bed_z_m` instead.
    """
    places = np.array([robot.place.position_m for robot in found.robots])
    count = min(round(across_m / FINE_M), FINE_COUNT)
    spacing = across_m / count
    x = np.asarray((np.arange(count + 2 * BORDER) - 0.5 * (count + 2 * BORDER - 1)) * spacing, np.float64)
    if found.bed_plane is not None:
        heights = np.minimum(plane_heights(*found.bed_plane, x, x), BED_M)
    else:
        fixed = {each["name"]: found.meshes[each["name"]] for each in found.obstacles}
        name = None if found.bed_z_m is not None else ground_of(fixed, places)
        ground = None if name is None else ground_heights(fixed[name], BED_M, x, x)
        if ground is None:
            return None
        heights = ground
    under = heights[np.abs(x[:, None] - places[:, 1]).argmin(axis=0), np.abs(x[:, None] - places[:, 0]).argmin(axis=0)]
    if (under > places[:, 2]).any():
        return None
    if np.ptp(heights) < LEVEL_M:
        found.bed_z_m = float(heights.min())
        return None
    return heights, spacing


def _start(robot: Robot, found: Description) -> dict[str, Any]:
    yaw, pitch, roll = yaw_pitch_roll_deg(robot.place.turn)
    if abs(pitch) > 0.1 or abs(roll) > 0.1:
        found.left_out(f"vehicle '{robot.name}': it would start pitched and rolled by {pitch:.1f} and {roll:.1f} deg")
    return {"position_m": _row(robot.place.position_m), "yaw_deg": round(yaw, 4)}


def _vehicle(robot: Robot, found: Description) -> tuple[Mesh, dict[str, Any], Floats]:
    """Return a vehicle's hull, the values of its file, and its origin in the frame of the base link."""
    hull, centre = _hull(robot, found)
    whole = robot.whole()
    estimated = any(getattr(robot, key) is None for key in STATES)
    origin = centre if estimated else np.zeros(3)
    hull = (hull[0] - origin, hull[1])
    values: dict[str, Any] = {"name": robot.name, "mesh": f"{robot.name}.ply"}
    if estimated:
        what = "added mass and drag are" if robot.drag is None else "added mass is"
        found.assumed(
            f"vehicle '{robot.name}': {what} estimated from its hull, as by `uwsim vehicle --draft`, "
            f"about its centroid, ({', '.join(f'{value:.4g}' for value in centre)}) m from the base link"
        )
        found.goes_on(f"vehicle '{robot.name}': estimates of its {what.removesuffix(' are').removesuffix(' is')}")
        values |= _estimates(robot.name, hull)
        if robot.drag is not None:
            found.assumed(f"vehicle '{robot.name}': drag is as stated along and about each axis, and their sum between")
            for key in ("crossflow_length_m", "fins"):  # lift and couplings that the stated drag does not have
                values.pop(key, None)
            values["linear_damping"], values["quadratic_damping"] = map(_row, robot.drag(origin))
    else:
        for state, key in KEYS.items():
            matrix = cast(Floats, getattr(robot, state))
            full = unlike_zero(matrix)
            values[f"{key}_matrix" if full else key] = (
                [_row(row) for row in matrix] if full else _row(np.diagonal(matrix))
            )
    values["mass_kg"] = whole.mass_kg
    values["centre_of_mass_m"] = _row(whole.centre_m - origin)
    moments = np.diagonal(whole.inertia_kg_m2)
    products = float(np.abs(whole.inertia_kg_m2 - np.diag(moments)).max())
    if products > PRODUCTS * moments.min():
        found.left_out(f"vehicle '{robot.name}': its products of inertia, {products:.3g} kg m2 at most")
    values["inertia_kg_m2"] = _possible(robot.name, _row(moments), found)
    values["compressibility_1_pa"] = 0.0
    if not robot.thrusters:
        raise ValueError(f"vehicle '{robot.name}': has no thrusters, so nothing could move it")
    values["thrusters"] = {each.name: _thruster(each, origin) for each in robot.thrusters}
    if robot.fins:
        if found.density_kg_m3 is None:
            raise ValueError(f"vehicle '{robot.name}': has fins, but no density of the water is stated")
        own = {each.name: _fin(each, origin, found.density_kg_m3) for each in robot.fins}
        values["fins"] = values.get("fins", {}) | own
    _outfit(robot, found, hull[0] + origin)
    _calibrate(robot, found)
    for key in ("sensors", "cameras", "imaging_sonars"):
        if parts := getattr(robot, key):
            values[key] = {name: _moved(part, origin) for name, part in parts.items()}
    if robot.sonar is not None:
        values["sonar"] = {"position_m": _row(np.array(robot.sonar) - origin)}
    return hull, values, origin


def _outfit(robot: Robot, found: Description, vertices: Floats) -> None:
    """Add what a vehicle lacks to fly a survey, under its hull, or note the option that adds it."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    lacks = {
        "a multibeam": robot.sonar is None,
        "an altimeter": not any(sensor["kind"] == "altitude" for sensor in robot.sensors.values()),
    }
    what = " and ".join(name for name, is_absent in lacks.items() if is_absent)
    if not what:
        return
    if found.given.outfit is None:
        found.noted(Note("", f"for a survey, vehicle '{robot.name}' lacks {what}: --outfit survey adds it"))
        return
    found.assumed(f"vehicle '{robot.name}': {what} under its hull, by --outfit survey", SENSES)
    if robot.sonar is None:
        robot.sonar = [0.9 * float(high[0]), 0.0, float(low[2])]
    if lacks["an altimeter"]:
        name = plain_name("altitude", robot.sensors)
        robot.sensors[name] = ALTIMETER | {"position_m": [0.0, 0.0, float(low[2])]}


def _possible(name: str, moments: list[float], found: Description) -> list[float]:
    """Return moments of inertia of which the largest does not exceed the sum of the others, as for any rigid body."""
    most, rest = max(moments), sum(moments) - max(moments)
    if most <= rest:
        return moments
    found.assumed(
        f"vehicle '{name}': moments of inertia {', '.join(f'{value:.4g}' for value in moments)} kg m2, which no rigid "
        f"body has: the largest is {rest:.4g}, the sum of the others"
    )
    return [float(np.round(rest, 9)) if value == most else value for value in moments]


def _calibrate(robot: Robot, found: Description) -> None:
    """Give cameras the calibrations that are named as they are; a single file is that of a single camera."""
    files = found.given.calibrations
    for file in files:
        names = {plain_name(file.stem), file.stem.split(".")[0]}
        own = [name for name in robot.cameras if name in names]
        if len(files) == len(robot.cameras) == 1:
            own = list(robot.cameras)
        if not own:
            found.left_out(f"calibration '{file}': no camera has its name; a camera's key calibration takes it", SENSES)
            continue
        try:
            fields = read_calibration(file)
        except ValueError as error:
            found.left_out(f"calibration of camera '{own[0]}': {error}", SENSES)
            continue
        kept = {key: value for key, value in robot.cameras[own[0]].items() if key != "field_of_view_deg"}
        robot.cameras[own[0]] = {**kept, **fields}
        found.noted(Note("read", f"camera '{own[0]}': its calibration, '{file}'"))


def _hull(robot: Robot, found: Description) -> tuple[Mesh, Floats]:
    """Return the hull, which displaces the stated volume about the stated centre, and its centroid."""
    if not robot.solids:
        raise ValueError(f"vehicle '{robot.name}': has no solid that displaces water")
    found.goes_on(f"vehicle '{robot.name}': one hull of its {len(robot.solids)} solids")
    hull = closed(joined(robot.solids), f"vehicle '{robot.name}'")
    volume, centroid = volume_and_centre(hull)
    wanted = volume if robot.volume_m3 is None else robot.volume_m3
    centre = centroid if robot.centre_of_buoyancy_m is None else robot.centre_of_buoyancy_m
    factor = float(np.cbrt(wanted / volume))
    if abs(factor - 1.0) > 1e-3:
        found.assumed(f"vehicle '{robot.name}': its hull is scaled by {factor:.3f} to displace {wanted:.4g} m3")
    about = (hull[0] - centroid) * factor
    return (about * _stretch(robot, about, robot.whole().centre_m - centre, found) + centre, hull[1]), centre


def _stretch(robot: Robot, about: Floats, mass_m: Floats, found: Description) -> Floats:
    """Return factors by axis that keep a hull's volume, and with which it reaches beyond the centre of mass.

    Gazebo's buoyant shapes are often thin boxes of the right volume; uwsim refuses a centre of mass outside the hull's
    bounding box. about, mass_m: the hull's vertices and the centre of mass, from the centroid.
    """
    reach = np.where(mass_m < 0.0, -about.min(axis=0), about.max(axis=0))
    need = np.maximum(1.0, BEYOND * np.abs(mass_m) / reach)
    free = need == 1.0
    if free.all():
        return np.asarray(need)
    if not free.any():
        raise ValueError(f"vehicle '{robot.name}': its centre of mass is far outside the solids that displace water")
    factors: Floats = np.where(free, float(np.prod(need)) ** (-1.0 / free.sum()), need)
    by = ", ".join(f"{value:.3g}" for value in factors)
    found.assumed(f"vehicle '{robot.name}': its hull is stretched by {by}, to reach its centre of mass")
    return factors


def _estimates(name: str, hull: Mesh) -> dict[str, Any]:
    with TemporaryDirectory() as folder:
        mesh = Path(folder) / f"{name}.ply"
        mesh.write_bytes(_ply(hull))
        text = drafted(mesh, AXES, None, "metres", "x").text
    values = yaml_document(text, name).values
    kept = ("added_mass_matrix", "munk_share", "quadratic_damping", "linear_damping", "crossflow_length_m", "fins")
    return {key: values[key] for key in kept if key in values}


def _thruster(each: Thruster, origin: Floats) -> dict[str, Any]:
    model: dict[str, Any] = {
        "name": each.name,
        "thrust_n": [list(pair) for pair in each.thrust_n],
        "time_constant_s": each.time_constant_s,
        "diameter_m": each.diameter_m,
    }
    for key in ("bollard_coefficient", "zero_thrust_advance_ratio", "torque_per_thrust_m"):
        if (value := getattr(each, key)) is not None:
            model[key] = value
    spin = "clockwise" if each.clockwise else "counter-clockwise"
    axis = each.axis / np.linalg.norm(each.axis)
    axis = np.where(np.abs(axis) < STRAIGHT, 0.0, axis)
    axis = axis / np.linalg.norm(axis)
    mount = {"model": model, "position_m": _row(each.position_m - origin), "axis": _row(axis)}
    return mount | ({"spin": spin} if each.force is None else {"force": each.force})


def _fin(each: Fin, origin: Floats, density_kg_m3: float) -> dict[str, Any]:
    """Return a fin with the area that gives its lift in this water."""
    found = {
        "position_m": _row(each.position_m - origin), "span": _row(each.span),
        "area_m2": each.density_area_kg_m / density_kg_m3, "aspect_ratio": each.aspect_ratio,
        "deflection_max_deg": each.travel_deg,
    }  # fmt: skip
    return found if each.stall_deg is None else found | {"stall_angle_deg": each.stall_deg}


def _moved(part: dict[str, Any], origin: Floats) -> dict[str, Any]:
    if "position_m" not in part:
        return part
    return part | {"position_m": _row(np.array(part["position_m"]) - origin)}


def _row(values: Floats) -> list[float]:
    """Return numbers without the noise of rotations."""
    return [float(value) for value in np.round(values, 9) + 0.0]


def _ply(mesh: Mesh) -> bytes:
    from uwsim.base.whole_trimesh import trimesh

    return cast(bytes, trimesh.Trimesh(*mesh, process=False).export(file_type="ply"))
