"""Pictures of the `paper` scenario: from outside, and under water (Figs. 1 and 2)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim.base.arrays import Floats
from uwsim.evidence.reproduce.figure import Figure
from uwsim.figures.contact_sheet import contact_sheet
from uwsim.figures.style import INK, new_figure, save_figure
from uwsim.instruments.cameras.camera import Camera
from uwsim.instruments.cameras.effects import EFFECTS
from uwsim.instruments.cameras.image_file import write_image
from uwsim.scenario import Scenario
from uwsim.scenario.spec.camera import CameraMount
from uwsim.simulator.simulator import Simulator

Place = tuple[tuple[float, float, float], float]
"""A position (3,) [m] and a yaw [deg]."""
BEFORE_THE_GATE = (49.7, -135.5, -18.9), 13.8
OVERVIEW = CameraMount(
    position_m=(76.2, 75.15, 65.6), yaw_pitch_roll_deg=(-117.5, 48.0, 0.0), width=1280, height=720, field_of_view_deg=80
)
"""A camera above the north-eastern shore, in the frame of the station, which is aligned with the world's."""
CLEAR = [name for name in EFFECTS if name not in ("attenuation", "backscatter")]
"""The effects of the overview: the surface and its refraction without the veil that hides the bed from above."""
WATER_INDEX = 1.33
"""Refractive index of fresh water, 20 deg C, 589 nm (Hale and Querry 1973, Applied Optics 12:555)."""
POINTS = 400  # of each part, of which the label marks one that is visible
NEAR_M = 0.5  # a ray that ends so near a point sees it


def place(sim: Simulator, where: Place) -> None:
    """Place the vehicle at a position (3,) [m] and a yaw [deg]."""
    position_m, yaw_deg = where
    sim.rov.place(position_m, Rotation.from_euler("z", yaw_deg, degrees=True).as_quat())


def with_cameras(scenario: Scenario, **added: CameraMount) -> Scenario:
    """Return the scenario with further cameras on its station."""
    cameras = {**scenario.station.cameras, **added}
    return scenario.model_copy(update={"station": scenario.station.model_copy(update={"cameras": cameras})})


def overview(sim: Simulator, path: Path) -> Figure:
    """Draw Fig. 1, the environment with its parts named. The simulator must have the camera `overview`."""
    sim.reset()
    camera = sim.cameras["overview"]
    frame = camera.capture(CLEAR)
    figure = new_figure(12.8, 7.2)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.imshow(frame.rgb, interpolation="antialiased")
    rows = []
    for name, points_m in _parts(sim).items():
        seen_m = points_m[visible(sim, camera, points_m)]
        middle = 0.5 * (points_m.min(axis=0) + points_m.max(axis=0))
        pixels = project(camera, apparent(eye_of(camera), seen_m))
        rows.append((name, *(round(value, 2) for value in middle.tolist()), len(pixels) > 0))
        if len(pixels):
            _name(axes, name, pixels[np.argmin(np.linalg.norm(pixels - pixels.mean(axis=0), axis=1))])
    height, width = frame.rgb.shape[:2]
    axes.set_xlim(0, width)
    axes.set_ylim(height, 0)
    save_figure(figure, path)
    return Figure(
        1, "The simulator environment",
        "Mountains, water, the station with its cage, the vehicle, gates, pipeline and rocks in one view, named where "
        "they are seen.",
        "Terrain and meshes are our own; station, vehicle and gates stand where theirs do. The white walls are added, "
        "for the published lawn-mower to turn at. The water's veil is left out, since it hides the bed from above.",
        columns=("part", "east [m]", "north [m]", "up [m]", "in view"), rows=rows,
    )  # fmt: skip


def _parts(sim: Simulator) -> dict[str, Floats]:
    """Return points (n, 3) of each part of the scene."""
    vertices, triangles, labels = sim.world.surface_mesh(with_terrain=False)
    corners = vertices[triangles].mean(axis=1)
    solids = {sim.world.label_names[label]: corners[labels == label] for label in np.unique(labels)}
    parts = {name.replace("_", " "): points[:: 1 + len(points) // POINTS] for name, points in solids.items()}
    parts["station and its cage"] = parts.pop("station")
    parts["vehicle"] = np.array([sim.rov.pose.position_world_m])
    shore = np.array([[x, y] for x in range(-60, 117, 4) for y in range(-196, -39, 4)], np.float64)
    bed = np.column_stack([shore, sim.world.height_at(shore)])
    parts |= {"mountains": bed[bed[:, 2] > 12.0], "seabed": bed[bed[:, 2] < -40.0]}
    return {name: points for name, points in parts.items() if len(points)}


def apparent(eye_m: Floats, points_m: Floats) -> Floats:
    """Return the points (n, 3) of the still surface, z = 0, through which an eye above sees submerged points (n, 3).

    Points above the surface are returned as they are. Snell's law, sin i = n sin r, solved by bisection.
    """
    away = points_m[:, :2] - eye_m[:2]
    level = np.linalg.norm(away, axis=1)
    low, high = np.zeros(len(level)), level.copy()
    for _ in range(50):
        middle = 0.5 * (low + high)
        steep = middle / np.hypot(middle, eye_m[2])
        far = steep > WATER_INDEX * (level - middle) / np.hypot(level - middle, np.minimum(points_m[:, 2], -1e-6))
        low, high = np.where(far, low, middle), np.where(far, middle, high)
    share = (low / np.maximum(level, 1e-9))[:, None]
    surface = np.column_stack([eye_m[:2] + share * away, np.zeros(len(level))])
    return np.where(points_m[:, 2:] < 0.0, surface, points_m)


def visible(sim: Simulator, camera: Camera, points_m: Floats) -> NDArray[np.bool_]:
    """Return which points (n, 3) a camera sees, through the surface if they are submerged; a mask (n,)."""
    eye = eye_of(camera)
    through = apparent(eye, points_m)
    found = np.ones(len(points_m), bool)
    for start, end in ((np.tile(eye, (len(through), 1)), through), (through, points_m)):
        length = np.linalg.norm(end - start, axis=1)
        ways = np.where(length[:, None] > NEAR_M, end - start, (0.0, 0.0, 1.0))
        hits = sim.scene.cast(start, ways / np.linalg.norm(ways, axis=1)[:, None], 500.0)
        found &= (length <= NEAR_M) | (hits.ranges_m > length - NEAR_M)
    width, height = camera.mount.width, camera.mount.height
    pixels = project(camera, through)
    margin = 0.06 * width  # within which a label would be cut off
    return np.asarray(found & np.all((pixels > margin) & (pixels < (width - margin, height - 10)), axis=1))


def eye_of(camera: Camera) -> Floats:
    """Return a camera's position (3,) [m], world frame."""
    return np.asarray(camera.world_from_camera[:3, 3], np.float64)


def project(camera: Camera, points_m: Floats) -> Floats:
    """Return the pixels (n, 2), column then row, of points (n, 3); nan behind the camera."""
    width, height = camera.mount.width, camera.mount.height
    focal = 0.5 * width / np.tan(np.radians(0.5 * camera.mount.field_of_view_deg))
    ahead, left, up, _ = np.linalg.inv(camera.world_from_camera) @ np.column_stack([points_m, np.ones(len(points_m))]).T
    ahead = np.where(ahead > 0.0, ahead, np.nan)
    return np.column_stack([0.5 * width - focal * left / ahead, 0.5 * height - focal * up / ahead])


def _name(axes: Axes, name: str, pixel: Floats) -> None:
    axes.annotate(
        name,
        tuple(pixel),
        (0, 30),
        textcoords="offset points",
        color="white",
        fontsize=10,
        ha="center",
        arrowprops={"arrowstyle": "-", "color": "white"},
        path_effects=[withStroke(linewidth=2.0, foreground=INK)],
    )
    axes.plot(*pixel, "o", color="white", markeredgecolor=INK, markersize=4)


def scene(sim: Simulator, path: Path, where: Place = BEFORE_THE_GATE) -> Figure:
    """Draw Fig. 2, the scene, from a place."""
    place(sim, where)
    camera, water = sim.rov.cameras["front"], sim.optics.coefficients
    pair = [camera.capture(effects) for effects in ("on", "off")]
    write_image(path, contact_sheet([[frame.rgb for frame in pair]]), optimize=True)
    assert water is not None
    return Figure(
        2, "The underwater scene", "The front camera at a gate, with the water's effects and without.",
        "Theirs veils the picture with fog; ours attenuates and scatters light by its colour.",
        {"wobble_mrad": camera.mount.wobble_mrad, "sun_elevation_deg": sim.optics.sun_elevation_deg,
         "red_left": _red(pair[0].rgb) / _red(pair[1].rgb)},
        ("coefficient [1/m]", "red", "green", "blue"),
        [
            ("diffuse attenuation", *water.diffuse_attenuation),
            ("absorption", *water.absorption),
            ("scattering", *water.scattering),
        ],
    )  # fmt: skip


def _red(picture: NDArray[np.uint8]) -> float:
    """Return the mean ratio of red to green of a picture (h, w, 3), sRGB."""
    red, green, _ = picture.reshape(-1, 3).mean(axis=0).tolist()
    return float(red / max(green, 1.0))
