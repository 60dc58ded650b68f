"""Pictures of the `paper` scenario: vehicle, scene, screens (Figs. 1, 2, 4 and 5)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.transforms import Bbox
from scipy.spatial.transform import Rotation

from uwsim.evidence.reproduce.figure import Figure
from uwsim.figures.contact_sheet import contact_sheet
from uwsim.figures.style import FAINT_INK, INK, new_figure, save_figure
from uwsim.instruments.cameras.image_file import write_image
from uwsim.mapping import ranging
from uwsim.scenario import Scenario, load
from uwsim.scenario.spec.camera import CameraMount
from uwsim.scenario.spec.obstacle import MeshObstacle, Pipeline, Ring
from uwsim.scenario.spec.sonar import load_sonar
from uwsim.simulator.simulator import Simulator

BEFORE_THE_GATE = (49.7, -135.5, -18.9), 13.8
OVERVIEW = CameraMount(
    position_m=(30.2, -58.85, 55.6),
    yaw_pitch_roll_deg=(84.0, 40.0, 0.0),
    width=1280,
    height=720,
    horizontal_fov_deg=80,
)
"""A camera above the southern shore, in the frame of the station, which is not turned."""


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
    focal = 0.5 * width / np.tan(np.radians(0.5 * OVERVIEW.horizontal_fov_deg))
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
        "Mountains, water, the station with its cage, the vehicle, gates and pipeline in one view. Terrain and meshes "
        "are our own; station, vehicle and gates stand where theirs do.",
        True, columns=("part", "east [m]", "north [m]", "up [m]"), rows=rows,
    )  # fmt: skip


def scene(sim: Simulator, path: Path) -> Figure:
    """Draw Fig. 2, the scene."""
    place(sim, BEFORE_THE_GATE)
    camera, water = sim.rov.cameras["front"], sim.optics.coefficients
    pair = [camera.capture(effects) for effects in ("on", "off")]
    write_image(path, contact_sheet([[frame.rgb for frame in pair]]), optimize=True)
    assert water is not None
    return Figure(
        2, "The underwater scene", "The front camera at a gate, with the water's effects and without.", True,
        {"wobble_mrad": camera.mount.wobble_mrad, "sun_elevation_deg": sim.optics.sun_elevation_deg},
        ("coefficient [1/m]", "red", "green", "blue"),
        [
            ("diffuse attenuation", *water.diffuse_attenuation),
            ("absorption", *water.absorption),
            ("scattering", *water.scattering),
        ],
    )  # fmt: skip


def start_screen(path: Path) -> Figure:
    """Draw Fig. 4: the choices on the start screen."""
    scenario = load("paper")
    rows = []
    for number, model in ranging.MODELS.items():
        sonar = load_sonar(f"em2040-{number}")
        rows.append((number, sonar.description or sonar.name, model.beams, round(np.degrees(model.field_of_view_rad)),
                     round(model.range_max_m)))  # fmt: skip
    figure = new_figure(8.5, 3.4)
    axes = figure.add_axes((0.02, 0.02, 0.96, 0.96))
    axes.set_axis_off()
    axes.text(0, 0.97, "Before a mission", fontsize=13, fontweight="bold", color=INK, va="top")
    axes.text(
        0, 0.84, f"server ws://localhost:9090      mission time {scenario.mission_time_s:g} s (battery)      sonar:",
        fontsize=10, color=INK, va="top",
    )  # fmt: skip
    columns = ("model", "sonar", "beams", "field of view [deg]", "range [m]")
    cells = [[str(cell) for cell in row] for row in rows]
    table = axes.table(
        cells, colLabels=columns, bbox=Bbox.from_bounds(0.0, 0.0, 1.0, 0.68), cellLoc="left",
        colWidths=(0.08, 0.5, 0.1, 0.2, 0.12),
    )  # fmt: skip
    table.auto_set_font_size(False)
    table.set_fontsize(9.5)
    for cell in table.get_celld().values():
        cell.set_edgecolor(FAINT_INK)
        cell.set_linewidth(0.4)
    save_figure(figure, path)
    return Figure(
        4, "The start screen", "An operator's choices; `uwsim station paper` offers them on a page.",
        True, {"mission_time_s": scenario.mission_time_s}, columns, rows,
    )  # fmt: skip


def main_screen(sim: Simulator, path: Path) -> Figure:
    """Draw Fig. 5: the vehicle and station pictures next to the panel."""
    place(sim, BEFORE_THE_GATE)
    panel = sim.rov.telemetry()
    rows = [
        ("speed [m/s]", round(panel.speed_m_s, 3)), ("angular speed [rad/s]", round(panel.angular_speed_rad_s, 3)),
        ("temperature [deg C]", round(panel.temperature_deg_c, 2)),
        ("pressure [kPa]", round(1e-3 * panel.pressure_pa, 2)),
        ("depth [m]", round(panel.depth_m, 2)), ("distance to station [m]", round(panel.distance_to_station_m, 1)),
        ("distance to seabed [m]", round(panel.distance_to_seabed_m, 2)),
        ("mission time [s]", round(panel.mission_time_s, 1)), ("battery [%]", round(panel.battery_percent, 1)),
        ("range warning", panel.range_warning), ("proximity warning", panel.proximity_warning),
        ("collision warning", panel.collision_warning),
    ]  # fmt: skip
    figure = new_figure(12.0, 6.9)
    views = {
        "front": (0.0, 0.36, 0.66, 0.64), "down": (0.0, 0.0, 0.325, 0.34), "station": (0.335, 0.0, 0.325, 0.34),
    }  # fmt: skip
    for name, box in views.items():
        camera = sim.cameras["deck"] if name == "station" else sim.rov.cameras[name]
        _show(figure.add_axes(box), camera.capture().rgb, name)
    axes = figure.add_axes((0.68, 0.0, 0.32, 1.0))
    axes.set_axis_off()
    for k, (label, value) in enumerate(rows):
        y = 0.96 - 0.078 * k
        lit = {True: "#d0342c", False: "#3a9a4b"}.get(value) if isinstance(value, bool) else None
        axes.text(0.0, y, label, fontsize=10.5, color=INK)
        axes.text(0.98, y, "\u25cf" if lit else f"{value}", fontsize=10.5, color=lit or INK, ha="right")
    save_figure(figure, path)
    return Figure(
        5, "The main screen", "Front, down and station camera with the panel, at the place of Fig. 2.", True,
        columns=("panel", "value"), rows=rows,
    )  # fmt: skip


def _show(axes: Axes, rgb: np.ndarray, name: str) -> None:
    axes.set_axis_off()
    axes.imshow(rgb, interpolation="antialiased")
    axes.text(0.02, 0.95, name, transform=axes.transAxes, color="white", fontsize=10, va="top", fontweight="bold")
