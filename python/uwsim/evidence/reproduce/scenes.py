"""Pictures of the `paper` scenario: from outside, and under water (Figs. 1 and 2)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from uwsim.evidence.reproduce.figure import Figure
from uwsim.figures.contact_sheet import contact_sheet
from uwsim.figures.style import new_figure, save_figure
from uwsim.instruments.cameras.image_file import write_image
from uwsim.scenario import Scenario
from uwsim.scenario.obstacles.mesh import MeshObstacle
from uwsim.scenario.obstacles.pipeline import Pipeline
from uwsim.scenario.obstacles.ring import Ring
from uwsim.scenario.spec.camera import CameraMount
from uwsim.simulator.simulator import Simulator

BEFORE_THE_GATE = (49.7, -135.5, -18.9), 13.8
OVERVIEW = CameraMount(
    position_m=(30.2, -58.85, 55.6), yaw_pitch_roll_deg=(84.0, 40.0, 0.0), width=1280, height=720, field_of_view_deg=80
)
"""A camera above the southern shore, in the frame of the station, which is aligned with the world's."""


def place(sim: Simulator, where: tuple[tuple[float, float, float], float]) -> None:
    """Place the vehicle at a position (3,) [m] and a yaw [deg]."""
    position_m, yaw_deg = where
    sim.rov.place(position_m, Rotation.from_euler("z", yaw_deg, degrees=True).as_quat())


def with_overview(scenario: Scenario) -> Scenario:
    """Return the scenario with a camera that overlooks it."""
    cameras = {**scenario.station.cameras, "overview": OVERVIEW}
    return scenario.model_copy(update={"station": scenario.station.model_copy(update={"cameras": cameras})})


def overview(sim: Simulator, path: Path) -> Figure:
    """Draw Fig. 1, the environment with its parts named. The simulator must have the camera."""
    sim.reset()
    parts: dict[str, tuple[float, ...]] = {
        "station and its cage": (-3.0, -130.5, 14.6),
        "mountains": (-70.0, -60.0, 60.0),
    }
    parts["vehicle"] = tuple(sim.rov.pose.position_world_m)
    for item in sim.scenario.obstacles:
        if isinstance(item, MeshObstacle | Ring):
            parts[item.name.replace("_", " ")] = item.position_m
        elif isinstance(item, Pipeline):
            x, y = item.points_m[2]
            parts[item.name] = x, y, float(sim.world.height_at([[x, y]])[0])
    camera = sim.cameras["overview"]
    frame = camera.capture()
    figure = new_figure(12.8, 7.2)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.imshow(frame.rgb, interpolation="antialiased")
    height, width = frame.rgb.shape[:2]
    focal = 0.5 * width / np.tan(np.radians(0.5 * OVERVIEW.field_of_view_deg))
    rows = []
    for name, place_m in parts.items():
        ahead, left, up, _ = np.linalg.inv(camera.world_from_camera) @ (*place_m, 1.0)
        u, v = 0.5 * width - focal * left / ahead, 0.5 * height - focal * up / ahead
        rows.append((name, *(round(float(value), 2) for value in place_m)))
        if 0 < u < width and 0 < v < height:
            axes.annotate(name, (u, v), (0, 34), textcoords="offset points", color="white", fontsize=10, ha="center",
                          arrowprops={"arrowstyle": "-", "color": "white"})  # fmt: skip
    axes.set_xlim(0, width)
    axes.set_ylim(height, 0)
    save_figure(figure, path)
    return Figure(
        1, "The simulator environment",
        "Mountains, water, the station with its cage, the vehicle, gates and pipeline in one view.",
        "Terrain and meshes are our own; station, vehicle and gates stand where theirs do.",
        columns=("part", "east [m]", "north [m]", "up [m]"), rows=rows,
    )  # fmt: skip


def scene(sim: Simulator, path: Path) -> Figure:
    """Draw Fig. 2, the scene."""
    place(sim, BEFORE_THE_GATE)
    camera, water = sim.rov.cameras["front"], sim.optics.coefficients
    pair = [camera.capture(effects) for effects in ("on", "off")]
    write_image(path, contact_sheet([[frame.rgb for frame in pair]]), optimize=True)
    assert water is not None
    return Figure(
        2, "The underwater scene", "The front camera at a gate, with the water's effects and without.",
        "Theirs veils the picture with fog; ours attenuates and scatters light by its colour.",
        {"wobble_mrad": camera.mount.wobble_mrad, "sun_elevation_deg": sim.optics.sun_elevation_deg},
        ("coefficient [1/m]", "red", "green", "blue"),
        [
            ("diffuse attenuation", *water.diffuse_attenuation),
            ("absorption", *water.absorption),
            ("scattering", *water.scattering),
        ],
    )  # fmt: skip
