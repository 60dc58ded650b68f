"""The vehicle with its movement vectors, and a ray that detects a collision (Figs. 3 and 7)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mpl_toolkits.mplot3d import Axes3D  # type: ignore[import-untyped]
from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from uwsim.base.arrays import Floats
from uwsim.evidence.reproduce.figure import Figure
from uwsim.figures.style import ACCENT, FAINT_INK, INK, new_figure, save_figure
from uwsim.scenario.build.hull import hull_placement, vehicle_hull
from uwsim.scenario.build.solids import obstacle_solid
from uwsim.scenario.build.terrain import build_terrain
from uwsim.scenario.obstacles.gates import Ring
from uwsim.scenario.read.mesh_file import load_mesh
from uwsim.scenario.read.textures import load_texture
from uwsim.scenario.spec.vehicle import VehicleModel
from uwsim.simulator.simulator import Simulator

MOVEMENTS = (("surge", "roll"), ("sway", "pitch"), ("heave", "yaw"))
LIGHT = np.array([0.35, -0.55, 0.76])
TARGET, AWAY_M, REACH_M = "gate_1", 9.0, 20.0


def movements(sim: Simulator, path: Path, size: float = 1.0) -> Figure:
    """Draw Fig. 3, the vehicle with its movement vectors. size: of the vehicle, relative to that of `paper`."""
    model = sim.scenario.vehicles[0].model
    vertices, triangles = vehicle_hull(model)
    figure = new_figure(8.0, 6.4)
    axes = _axes_3d(figure, elevation_deg=24, azimuth_deg=-38)
    vertices = vertices / size
    _draw_mesh(axes, vertices[triangles], _hull_colours(model, size * vertices[triangles].mean(axis=1)))
    rows: list[tuple[Any, ...]] = []
    for axis, (along, about) in enumerate(MOVEMENTS):
        direction, reach = np.eye(3)[axis], (1.15, 0.95, 0.75)[axis]
        axes.quiver(0, 0, 0, *(reach * direction), color=ACCENT, linewidth=2.2, arrow_length_ratio=0.12)
        axes.text(*(1.12 * reach * direction), along, color=ACCENT, fontsize=12, fontweight="bold")
        turn = _arc(axis, 0.72 * reach, 0.2)
        axes.plot(*turn.T, color=INK, linewidth=1.8)
        axes.quiver(*turn[-2], *(turn[-1] - turn[-2]), color=INK, arrow_length_ratio=3.0)
        axes.text(*(0.72 * reach * direction + 0.27 * np.eye(3)[(axis + 2) % 3]), about, color=INK, fontsize=11)
        force, torque = (limits and limits[axis] for limits in (model.max_force_n, model.max_torque_nm))
        rows += [(along, "xyz"[axis], force, "N"), (about, "xyz"[axis], torque, "N m")]
    _frame(axes, np.zeros(3), 0.8)
    save_figure(figure, path)
    return Figure(
        3, "The vehicle and its movements",
        "The vehicle's mesh with its axes: x ahead, y to port, z up.",
        "Theirs is a Unity model with a left-handed frame.",
        columns=("movement", "axis", "full effort", "unit"), rows=rows,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Gate:
    """A ring. middle_m: (3,). ahead, across: unit vectors (3,) through it and level along it. radius_m: to its bar."""

    name: str
    middle_m: Floats
    ahead: Floats
    across: Floats
    radius_m: float
    triangles_m: Floats


def gate_of(sim: Simulator, name: str) -> Gate:
    """Return a gate that is an obstacle of the scenario, a `ring` or the mesh of one."""
    item = next(item for item in sim.scenario.obstacles if item.name == name)
    solid = obstacle_solid(item, build_terrain(sim.scenario.terrain))
    corners_m = np.asarray(solid.vertices[solid.triangles], np.float64)
    if isinstance(item, Ring):
        ahead, across, _ = Rotation.from_euler("ZYX", item.yaw_pitch_roll_deg, degrees=True).as_matrix().T
        return Gate(name, np.asarray(item.position_m, np.float64), ahead, across, item.major_radius_m, corners_m)
    points_m = corners_m.reshape(-1, 3)
    middle = 0.5 * (points_m.min(axis=0) + points_m.max(axis=0))
    across, ahead = np.linalg.svd(points_m[:, :2] - middle[:2], full_matrices=False)[2]
    ahead = np.array([*(ahead if ahead[0] > 0.0 else -ahead), 0.0])  # as the rings' yaws, between -90 and 90 degrees
    across = np.array([-ahead[1], ahead[0], 0.0])
    from_middle = points_m - middle
    reach_m = np.linalg.norm(from_middle - np.outer(from_middle @ ahead, ahead), axis=1)
    return Gate(name, middle, ahead, across, float(0.5 * (reach_m.min() + reach_m.max())), corners_m)


def ray(sim: Simulator, path: Path, name: str = TARGET) -> Figure:
    """Draw Fig. 7, a ray that detects a collision with a gate, between rays that detect none."""
    gate = gate_of(sim, name)
    middle, ahead, across = gate.middle_m, gate.ahead, gate.across
    origin, aims_m = middle - AWAY_M * ahead, (-3.0, 0.0, 3.0, gate.radius_m, gate.radius_m + 2.4)
    ways = np.array([AWAY_M * ahead + aim * across for aim in aims_m])
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    hits = sim.scene.cast(np.tile(origin, (len(ways), 1)), ways, REACH_M)
    figure = new_figure(8.0, 6.0)
    axes = _axes_3d(figure, elevation_deg=28, azimuth_deg=-72)
    _draw_mesh(axes, gate.triangles_m - middle, np.array([0.2, 0.62, 0.7]))
    rows = []
    for aim_m, way, range_m, label in zip(aims_m, ways, hits.ranges_m.tolist(), hits.labels.tolist(), strict=True):
        found = math.isfinite(range_m)
        end = origin - middle + (range_m if found else REACH_M) * way
        axes.plot(
            *np.transpose([origin - middle, end]), color=ACCENT if found else FAINT_INK, linewidth=2.0 if found else 1.0
        )
        if found:
            axes.scatter(*end, color="#d0342c", s=70, depthshade=False, zorder=10)
            axes.text(*(end - (3.4, 0.0, -0.9)), f"{range_m:.2f} m", color=INK, fontsize=11)
        rows.append((aim_m, sim.world.label_names[label] if found else "none", range_m if found else math.inf))
    axes.text(*(origin - middle - 0.8), "origin", color=INK, fontsize=11)
    _frame(axes, np.array([1.0, 0.0, 0.0]), 9.0)
    save_figure(figure, path)
    return Figure(
        7, "A ray finds a collision",
        "One ray ends at its first hit on a gate; the others pass.",
        "Theirs is cast by Unity, ours by Embree at the triangles that collide.",
        {"origin_world_m": [round(value, 3) for value in origin.tolist()], "reach_m": REACH_M},
        ("aim beside the middle [m]", "first hit", "range [m]"), rows,
    )  # fmt: skip


def _axes_3d(figure: Any, *, elevation_deg: float, azimuth_deg: float) -> Axes3D:
    axes: Axes3D = figure.add_axes((0, 0, 1, 1), projection="3d")
    axes.view_init(elevation_deg, azimuth_deg)
    axes.set_axis_off()
    return axes


def _frame(axes: Axes3D, middle: Floats, half_m: float) -> None:
    for limit, value in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), middle, strict=True):
        limit(value - half_m, value + half_m)
    axes.set_box_aspect((1, 1, 1), zoom=1.3)


def _draw_mesh(axes: Axes3D, corners: Floats, albedo: Floats) -> None:
    """Draw triangles (n, 3, 3) in one colour (3,) or several (n, 3), shaded by their normals."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-12)[:, None]
    shade = 0.55 + 0.45 * np.clip(normals @ LIGHT, 0, 1)
    axes.add_collection3d(Poly3DCollection(corners, facecolors=np.clip(shade[:, None] * albedo, 0, 1)))


def _hull_colours(model: VehicleModel, middles_m: Floats) -> Floats:
    """Return the colour of each triangle of the hull (n, 3), by its middle (n, 3), or one (3,) for all.

    Closing the mesh may have changed its triangles: each has the colour of the nearest of the file.
    """
    texture = load_texture(model.mesh)
    if texture is None:
        return np.full(3, 0.6) if model.material.colour is None else np.sqrt(model.material.colour)
    found = _colours(texture.image, texture.corners)
    if len(found) == len(middles_m):
        return found
    factor, shift_m = hull_placement(model)
    vertices, triangles = load_mesh(model.mesh, model.mesh_scale, model.mesh_up, model.mesh_forward or "x")
    nearest = cKDTree((factor * vertices + shift_m)[triangles].mean(axis=1)).query(middles_m)[1]
    return np.asarray(found[nearest], np.float64)


def _colours(image: NDArray[np.uint8], places: NDArray[np.float32]) -> Floats:
    """Return the colour of each triangle (n, 3), read from an image at the centre of its corners there (n, 3, 2)."""
    height, width = image.shape[:2]
    across, up = places.mean(axis=1).T
    pixels = image[((1 - up) * height).astype(int), (across * width).astype(int)]
    return np.asarray(pixels / 255.0, np.float64)


def _arc(axis: int, along: float, radius: float) -> Floats:
    """Return points (n, 3) along three quarters of a right-handed turn about an axis."""
    angles = np.linspace(-0.25 * math.pi, 1.25 * math.pi, 40)
    points = np.empty((len(angles), 3))
    points[:, axis] = along
    points[:, (axis + 1) % 3] = radius * np.cos(angles)
    points[:, (axis + 2) % 3] = radius * np.sin(angles)
    return points
