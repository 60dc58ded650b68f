"""The sonar: depth map and ranges, the manufacturer's table, and a ping (Figs. 6, 8 and 9)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

from uwsim.base.arrays import Floats
from uwsim.evidence.reproduce.figure import Figure
from uwsim.evidence.reproduce.scenes import BEFORE_THE_GATE, CLEAR, Place, eye_of, place, project
from uwsim.evidence.validate.sonars.instrument import half_detected_m
from uwsim.evidence.validate.sonars.table import COVERAGE_M, DEPTH_M, FREQUENCIES_KHZ, Cell
from uwsim.figures.sonar_fan import beam_ends_m
from uwsim.figures.style import ACCENT, FAINT_INK, INK, label_axes, new_figure, save_figure
from uwsim.instruments.cameras.camera import Camera
from uwsim.instruments.sonars.depth_map import DepthMap, difference, ranges_m
from uwsim.mapping import ranging
from uwsim.scenario.spec.camera import CameraMount
from uwsim.simulator.simulator import Simulator

OVER_THE_BED = (42.0, -110.0, -31.5), -28.0
BESIDE = CameraMount(
    position_m=(51.5, 35.7, -34.4), yaw_pitch_roll_deg=(-45.0, 38.0, 0.0), width=1280, height=720, field_of_view_deg=80
)
"""A camera behind the vehicle over the bed, above and to port, in the frame of the station."""
DRAWN_BEAM = 12
HIDDEN_M = 0.15  # a point no farther behind a picture's surface is on it


def depth_image(sim: Simulator, path: Path, where: Place = BEFORE_THE_GATE) -> Figure:
    """Draw Fig. 6, a depth map from a place, and the sonar ranges read from it."""
    place(sim, where)
    frame = sim.rov.cameras["front"].capture("off", geometry_only=True)
    ping = sim.rov.sonar.ping()
    around, model = sim.around(sim.rov.name), sim.rov.sonar.model
    method = DepthMap(field_of_view_rad=model.field_of_view_rad, range_max_m=model.range_max_m)
    found = ranges_m(around, ping.world_from_sonar, ping.angles_rad, method)
    errors = difference(found, ping.ranges_m)
    figure = new_figure(9.0, 7.2)
    upper, lower = figure.add_axes((0.0, 0.5, 0.85, 0.5)), figure.add_axes((0.0, 0.0, 0.85, 0.36))
    shown = upper.imshow(np.minimum(frame.depth_m, 55.0), cmap="gray")
    upper.set_axis_off()
    upper.set_title("The front camera's depth map", loc="left", fontsize=11, fontweight="bold", color=INK)
    figure.colorbar(shown, ax=upper, shrink=0.9, label="depth [m]")
    angles = np.degrees(ping.angles_rad)
    lower.plot(angles, ping.ranges_m, color=INK, linewidth=1.0, label="one ray a beam")
    lower.plot(angles, found, color=ACCENT, linewidth=1.0, linestyle="--", label="from a depth image")
    lower.invert_xaxis()
    lower.legend(fontsize=9, frameon=False)
    label_axes(lower, "The sonar's ranges", "angle to port [deg]", "range [m]")
    save_figure(figure, path)
    return Figure(
        6, "The depth map",
        "Distance along the front camera's axis as grey, nearest darkest; below, the sonar's ranges at the same pose, "
        "by one ray a beam and from a depth map as in the paper.",
        "Theirs is made by a shader, ours by rays.",
        values={name: _plain(value) for name, value in vars(errors).items()},
        columns=("angle [deg]", "range [m]", "from a depth image [m]"),
        rows=[(float(a), float(r), float(d)) for a, r, d in zip(angles, ping.ranges_m, found, strict=True)][::16],
    )  # fmt: skip


def coverage(path: Path) -> Figure:
    """Draw Fig. 8, the coverage."""
    simulated: dict[Cell, float] = {cell: half_detected_m(cell) for cell in DEPTH_M}
    rows = [_beside("depth", cell, simulated[cell], DEPTH_M) for cell in DEPTH_M]
    rows += [_beside("coverage", cell, cell.coverage().width_m, COVERAGE_M) for cell in COVERAGE_M]
    errors = [abs(row[-1]) for row in rows]
    _draw_table(rows, path)
    return Figure(
        8, "The coverage of the EM 2040",
        "Depth and coverage over rock in metres, ours / table: depths in physics mode, coverages by sonar equation.",
        f"Theirs is the manufacturer's table, with {len(DEPTH_M)} depths and {len(COVERAGE_M)} coverages. The assumed "
        "source levels and bandwidths of ours are chosen to agree with the table as a whole; the second receiver's "
        "gain follows from its tilt: 1.06, a miss at 300 kHz, where the table has 1.13 to 1.155.",
        {"compared": len(errors), "largest_error_percent": max(errors)},
        ("column", "array", "kHz", "water", "receivers", "table [m]", "ours [m]", "error [%]"), rows,
    )  # fmt: skip


def _beside(column: str, cell: Cell, ours_m: float, table: dict[Cell, float]) -> tuple[Any, ...]:
    """Return a row with the table's value, ours and the difference in per cent."""
    error = round(100.0 * (ours_m / table[cell] - 1.0), 1)
    head = column, cell.array, cell.frequency_khz, cell.water, cell.receivers
    return *head, table[cell], round(ours_m, 1), error


def _draw_table(rows: list[tuple[Any, ...]], path: Path) -> None:
    """Draw the rows as a table by frequency: our value / the table's."""
    lines: dict[tuple[Any, ...], dict[int, str]] = {}
    for column, array, khz, water, receivers, known_m, ours_m, _ in rows:
        name = column if column == "depth" else f"{column}, {'one receiver' if receivers == 1 else 'two receivers'}"
        lines.setdefault((array, name, f"cold {water}"), {})[khz] = f"{ours_m:.0f} / {known_m:g}"
    order = sorted(lines, key=lambda line: (line[0], line[1] != "depth", line[1], line[2] != "cold ocean"))
    figure = new_figure(11.0, 5.2)
    axes = figure.add_axes((0.01, 0.01, 0.98, 0.98))
    axes.set_axis_off()
    table = axes.table(
        [[*line, *(lines[line].get(khz, "") for khz in FREQUENCIES_KHZ)] for line in order],
        colLabels=("instrument", "ours / table [m]", "water", *(f"{khz} kHz" for khz in FREQUENCIES_KHZ)),
        colWidths=(0.12, 0.22, 0.11, *5 * (0.11,)), bbox=Bbox.unit(), cellLoc="left",
    )  # fmt: skip
    table.auto_set_font_size(False)
    table.set_fontsize(9.5)
    for cell in table.get_celld().values():
        cell.set_edgecolor(FAINT_INK)
        cell.set_linewidth(0.4)
    save_figure(figure, path)


def ping(sim: Simulator, path: Path) -> Figure:
    """Draw Fig. 9, the scene with the fan of one ping. The simulator must have the camera `beside`."""
    place(sim, OVER_THE_BED)
    ping, model = sim.rov.sonar.ping(), sim.rov.sonar.model
    camera = sim.cameras["beside"]
    frame = camera.capture(CLEAR)
    ends_m, echo = beam_ends_m(ping, model.range_max_m)
    height, width = frame.rgb.shape[:2]
    figure = new_figure(12.8, 7.2)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.imshow(frame.rgb, interpolation="antialiased")
    for end_m in ends_m[::DRAWN_BEAM]:
        line_m = np.linspace(ping.world_from_sonar[:3, 3], end_m, 200)
        line = np.where(_in_front(camera, frame.depth_m, line_m)[:, None], project(camera, line_m), np.nan)
        axes.plot(*line.T, color="white", linewidth=0.7, alpha=0.7)
    hits_m = ends_m[echo]
    axes.plot(*project(camera, hits_m)[_in_front(camera, frame.depth_m, hits_m)].T, ".", color=ACCENT, markersize=4)
    axes.set_xlim(0, width)
    axes.set_ylim(height, 0)
    save_figure(figure, path)
    text = ranging.encode_depth_string(ping.ranges_m, model)
    scan = ranging.to_laser_scan(ranging.decode_depth_string(text, model), model, sim.time_s)
    points = ranging.to_point_cloud(scan)
    return Figure(
        9, "The forward-facing sonar",
        f"The scene with the fan of one ping, its head {-np.degrees(sim.rov.sonar.elevation_rad):.0f} degrees down: "
        f"every {DRAWN_BEAM}th of {len(echo)} beams as a line from the vehicle, and all hits on bed, pipeline and "
        "rocks. Beams are drawn where nothing hides them.",
        "Theirs casts its rays in Unity, ours in Embree, at the triangles that collide. The water's veil is left out.",
        values={"beams": len(ping.ranges_m), "echoes": len(points), "depth_string_characters": len(text),
                "angle_increment_rad": float(scan.angle_increment), "range_max_m": float(scan.range_max)},
        columns=("x [m]", "y [m]", "z [m]"), rows=[tuple(map(float, point)) for point in points[::16]],
    )  # fmt: skip


def _in_front(camera: Camera, depth_m: NDArray[np.float32], points_m: Floats) -> NDArray[np.bool_]:
    """Return which points (n, 3) lie in a picture with depths (height, width) and no farther than these; (n,)."""
    ahead_m = (points_m - eye_of(camera)) @ camera.world_from_camera[:3, 0]
    pixels = np.nan_to_num(project(camera, points_m), nan=-1.0)
    height, width = depth_m.shape
    column, row = np.clip(pixels.astype(int), 0, (width - 1, height - 1)).T
    inside = np.all((pixels >= 0) & (pixels < (width, height)), axis=1)
    return np.asarray(inside & (ahead_m < depth_m[row, column] + HIDDEN_M))


def _plain(value: object) -> object:
    return float(value) if isinstance(value, float | np.floating) else value
