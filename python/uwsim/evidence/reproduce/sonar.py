"""The sonar: depth map and ranges, the manufacturer's table, and a ping (Figs. 6, 8 and 9)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from uwsim.evidence.reproduce.figure import Figure
from uwsim.evidence.reproduce.scenes import BEFORE_THE_GATE, place
from uwsim.evidence.validate.sonar_curves import draw_table
from uwsim.evidence.validate.sonar_instrument import half_detected_m
from uwsim.evidence.validate.sonar_table import DEPTH_M, Cell
from uwsim.figures.sonar_fan import sonar_fan
from uwsim.figures.style import ACCENT, INK, label_axes, new_figure, save_figure
from uwsim.instruments.sonars.depth_map import DepthMap, difference, ranges_m
from uwsim.mapping import ranging
from uwsim.simulator.simulator import Simulator

IN_THE_BASIN = (20.0, -150.0, -20.0), 10.0


def depth_image(sim: Simulator, path: Path) -> Figure:
    """Draw Fig. 6, a depth map, and the sonar's ranges as read from it."""
    place(sim, BEFORE_THE_GATE)
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
        "Distance along the front camera's axis as grey, nearest darkest, cast by rays instead of a shader; below, the "
        "sonar's ranges at the same pose, by one ray a beam and from a depth map as in the paper.",
        True, values={name: _plain(value) for name, value in vars(errors).items()},
        columns=("angle [deg]", "range [m]", "from a depth image [m]"),
        rows=[(float(a), float(r), float(d)) for a, r, d in zip(angles, ping.ranges_m, found, strict=True)][::16],
    )  # fmt: skip


def coverage(path: Path) -> Figure:
    """Draw Fig. 8, the coverage."""
    simulated: dict[Cell, float] = {cell: half_detected_m(cell) for cell in DEPTH_M}
    draw_table(simulated, path)
    rows = [
        (cell.array, cell.frequency_khz, cell.water, expected, round(simulated[cell], 1),
         round(100.0 * (simulated[cell] / expected - 1.0), 1))
        for cell, expected in DEPTH_M.items()
    ]  # fmt: skip
    return Figure(
        8, "The coverage of the EM 2040", "Depth over rock: the table, the sonar equation, the instrument.",
        True, {"largest_error_percent": max(abs(row[-1]) for row in rows)},
        ("array", "kHz", "water", "table [m]", "simulated [m]", "error [%]"), rows,
    )  # fmt: skip


def ping(sim: Simulator, path: Path) -> Figure:
    """Draw Fig. 9, a ping."""
    place(sim, IN_THE_BASIN)
    ping, model = sim.rov.sonar.ping(), sim.rov.sonar.model
    sonar_fan(path, sim.world, ping, model.range_max_m)
    text = ranging.encode_depth_string(ping.ranges_m, model)
    scan = ranging.to_laser_scan(ranging.decode_depth_string(text, model), model, sim.time_s)
    points = ranging.to_point_cloud(scan)
    return Figure(
        9, "The forward-facing sonar",
        "The fan of beams from the vehicle to its hits in the walled basin, from above and from the side.",
        True,
        values={"beams": len(ping.ranges_m), "echoes": len(points), "depth_string_characters": len(text),
                "angle_increment_rad": float(scan.angle_increment), "range_max_m": float(scan.range_max)},
        columns=("x [m]", "y [m]", "z [m]"), rows=[tuple(map(float, point)) for point in points[::16]],
    )  # fmt: skip


def _plain(value: object) -> object:
    return float(value) if isinstance(value, float | np.floating) else value
