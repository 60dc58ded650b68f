"""Lines and tables about a vehicle, the same in a terminal and on an HTML page, which adds pictures."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from uwsim.base.atomic_file import write_atomically
from uwsim.base.axes import AXES
from uwsim.evidence.vehicle.figures import VehicleFigures
from uwsim.evidence.vehicle.linear_motion import Mode
from uwsim.evidence.vehicle.report import VehicleReport
from uwsim.evidence.vehicle.surprises import attitude_text, straight_text
from uwsim.evidence.vehicle.trials import RUN_S, Slip
from uwsim.exchange.hulls.draft import SLIP_M_S, SLIP_SHORT_S
from uwsim.exchange.hulls.hull_drag import ACROSS
from uwsim.scenario.build.craft import floating_text
from uwsim.scenario.build.scale import size_text

LIKELY = (1.0 / 3.0, 3.0)
"""Ratios of a coefficient to its estimate outside which it is marked; published vehicles lie within them."""
NONE = "-"
CIRCLES = "Free flight without control, from rest."
Rows = Sequence[tuple[str, ...]]


class Table(NamedTuple):
    """A titled table of texts; the first column names the rows."""

    title: str
    head: tuple[str, ...]
    rows: Rows
    note: str = ""


def vehicle_lines(figures: VehicleFigures) -> Iterator[str]:
    """Yield lines about a vehicle's derived properties."""
    yield (
        f"{size_text(np.array(figures.size_m))}, {figures.volume_m3:.4g} m3, {figures.mass_kg:.4g} kg, in the mean "
        f"{figures.density_kg_m3:.4g} kg/m3; in water of {figures.water_density_kg_m3:.4g} kg/m3 "
        f"{floating_text(figures.net_buoyancy_n)}"
    )
    rests = attitude_text(figures.nose_down_deg or 0.0, figures.roll_to_starboard_deg or 0.0)
    if figures.metacentric_m is not None:
        roll_m, pitch_m = figures.metacentric_m
        yield (
            f"trim: floats {rests}; its metacentre is {roll_m:.3g} m above its centre of mass in roll, {pitch_m:.3g} m "
            "in pitch"
        )
    elif figures.nose_down_deg is None or figures.roll_to_starboard_deg is None:
        yield "trim: centres of mass and buoyancy coincide: nothing rights it in pitch and roll"
    elif figures.righting_lever_m < 0.0:
        yield (
            f"trim: turns over: its centre of buoyancy is {-figures.righting_lever_m:.3g} m below its centre of mass; "
            f"rests {rests}"
        )
    else:
        yield (
            f"trim: rests {rests}; its centre of buoyancy is {figures.righting_lever_m:.3g} m above its centre of "
            f"mass, which rights it with {figures.righting_nm_rad:.3g} N m/rad"
        )
    steers = f"drives {', '.join(figures.drives) or 'nothing'}"
    growth = figures.course_growth_1_s
    if growth is not None:
        steers += f"; its course under way {'dies out' if growth < 0.0 else 'grows'} at {abs(growth):.2g} /s"
    yield steers
    if figures.slip is not None:
        yield slip_text(figures.slip)
    if figures.straight is not None:
        yield f"straight run, {RUN_S:g} s at full surge without control: {straight_text(figures.straight)}"
    farthest = max(figures.mounts, key=lambda mount: mount.away_m, default=None)
    if farthest is not None:
        where = "all in the box round its hull"
        if farthest.away_m > 0.0:
            where = f"{farthest.label} is the farthest from its hull, by {farthest.away_m:.2f} m"
        yield f"mounts: {len(figures.mounts)}; {where}"


def slip_text(slip: Slip) -> str:
    """Return how long a side slip lasts, and what that means for a survey."""
    text = f"no sway: a side slip of {SLIP_M_S:g} m/s halves in {slip.time_s:.1f} s and {slip.distance_m:.1f} m"
    if slip.time_s < SLIP_SHORT_S:
        return f"{text}; a survey flies it from lane to lane in curves"
    return f"{text}; a survey stops for its turns where it slips: thrusters for sway would make it faster"


def report_lines(report: VehicleReport) -> Iterator[str]:
    """Yield the lines of a vehicle's report for a terminal: its properties, then each table."""
    yield from vehicle_lines(report.figures)
    for table in tables(report):
        yield from ("", table.title)
        rows = [*([table.head] if any(table.head) else []), *table.rows]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        for first, *others in rows:
            cells = [first.ljust(widths[0]), *(cell.rjust(w) for cell, w in zip(others, widths[1:], strict=True))]
            yield "  " + "  ".join(cells)
        if table.note:
            yield table.note


def write_page(path: Path, report: VehicleReport, warnings: Sequence[str] = ()) -> None:
    """Write the report as one self-contained HTML page with pictures. warnings: shown first. Raises OSError."""
    from uwsim.figures.html_page import data_uri, filled_page

    with tempfile.TemporaryDirectory() as folder:
        pictures = []
        for title, caption, draw in _pictures(report):
            draw(picture := Path(folder) / "picture.png")
            pictures.append((title, caption, data_uri(picture)))
    lines = Table("At a glance", (), [(line,) for line in vehicle_lines(report.figures)])
    page = filled_page(
        Path(__file__).with_name("page.html.j2"), model=report.model, warnings=list(warnings), pictures=pictures,
        tables=[lines, *tables(report)],
    )  # fmt: skip
    write_atomically(path, page.encode())


def _pictures(report: VehicleReport) -> Iterator[tuple[str, str, Callable[[Path], None]]]:
    """Yield title, caption and what draws each picture as a PNG."""
    from uwsim.figures.vehicle import draw_circles, draw_eigenvalues, draw_vehicle

    fields: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
    for view in report.views:
        fields.setdefault(view.label, []).append((view.position_m, view.rays))
    centres = report.figures.centre_of_mass_m, report.figures.centre_of_buoyancy_m
    caption = "Body frame: x ahead, y to port, z up."
    yield "Hull, actuators and fields of view", caption, lambda path: draw_vehicle(path, report.model, *centres, fields)
    tracks = {_efforts(circle.surge): circle.track_m for circle in report.circles}
    if tracks:
        yield "Turning circles", CIRCLES, lambda path: draw_circles(path, tracks)
    values = {
        f"{speed:g} m/s": np.array([complex(mode.growth_1_s, mode.frequency_rad_s) for mode in own])
        for speed, own in report.motions.items()
    }
    caption = "Eigenvalues at rest and at full speed ahead."
    yield "Linear motion", caption, lambda path: draw_eigenvalues(path, values)


def tables(report: VehicleReport) -> Iterator[Table]:
    """Yield the tables of a report, in the order in which a new vehicle is checked."""
    found, own = report.estimates, report.allocation
    if report.beside_makers:
        note = "Here: in fresh, still water, without a tether; a glider in the sea. Endurance is not computed: "
        note += "computers, lamps and payload are not modelled."
        head: tuple[str, ...] = ("quantity", "here", "stated", "year", "source")
        yield Table("Beside what is stated", head, report.beside_makers, note)
    each = zip(AXES, report.added_mass, found.lamb, found.mesh, strict=True)
    rows: Rows = [(axis, _n(file), _n(lamb), _n(mesh), _mark(file, mesh, lamb)) for axis, file, lamb, mesh in each]
    note = "Lamb: the ellipsoid with the hull's volume and ratios of inertia. Mesh: panels in ideal flow, about the "
    note += "origin; an open frame has less."
    yield Table("Added mass [kg, kg m2]", ("axis", "file", "Lamb", "mesh", ""), rows, note)
    drags = zip(AXES, report.quadratic_damping, found.streamlined, found.bluff, report.linear_damping, strict=True)
    rows = [
        (axis, _n(file), _n(smooth), _n(bluff), "" if axis == "roll" else _mark(file, smooth, bluff), _n(linear))
        for axis, file, smooth, bluff, linear in drags
    ]
    note = f"Hoerner: streamlined from friction at {found.speed_m_s:.2f} m/s; bluff from the hull's silhouettes, "
    note += f"C_D {ACROSS:g}. Drag of fins and struts is extra. In roll, a hull that is round about x has none."
    head = ("axis", "file", "streamlined", "bluff", "", "linear [N s/m, N m s/rad]")
    yield Table("Quadratic drag [N s2/m2, N m s2/rad2]", head, rows, note)
    head = ("axis", "terminal speed", "wrench", "from rest")
    note = "Terminal speed: that axis alone free, as in a towing tank."
    yield Table("Full effort, ahead / astern", head, [_full_effort(report, k) for k in range(6)], note)
    if own.rank is None:
        rows = [("forces along the axes", "no thrusters")]
    else:
        without = own.rank_without.items()
        rows = [("rank of the thrusters", f"{own.rank} of 6"), *((f"without {t}", f"{r} of 6") for t, r in without)]
    idle = ", ".join(axis for axis in AXES if axis not in own.driven)
    yield Table("Allocation", ("", ""), [*rows, ("nothing drives", idle or "no axis is left out")])
    if report.circles:
        rows = [(_efforts(c.surge), f"{c.radius_m:.2f} m" + ("" if c.is_steady else " (unsteady)"),
                 f"{c.speed_m_s:.2f} m/s", f"{np.degrees(c.turn_rad_s):.1f} deg/s", f"{c.climb_m:+.1f} m",
                 f"{c.tilt_deg:.0f} deg") for c in report.circles]  # fmt: skip
        head = ("efforts", "radius", "speed", "turn", "climb in 2 min", "largest tilt")
        yield Table("Turning circle", head, rows, CIRCLES)
    for speed_m_s, modes in report.motions.items():
        title, note = f"Linear motion at {speed_m_s:g} m/s ahead", ""
        if speed_m_s == 0.0:
            title = "Linear motion at rest"
            note = "Without control, fins amidships. Neutral: only quadratic drag, which vanishes at rest."
        head = ("moves mainly", "eigenvalue [1/s]", "behaviour", "damping ratio")
        yield Table(title, head, [_mode(mode) for mode in modes], note)
    if report.views:
        reached = [NONE if np.isinf(view.nearest_m) else f"{view.nearest_m:.2f} m" for view in report.views]
        rows = [
            (view.label, f"{len(view.rays)}", f"{100.0 * view.share:.1f} %", nearest)
            for view, nearest in zip(report.views, reached, strict=True)
        ]
        note = "Share of the rays in the field of view that meet the hull from outside. In the simulator, a vehicle's "
        note += "own hull does not appear to its cameras and sonars; on a real one it does."
        yield Table("Its own hull in view", ("instrument", "rays", "on the hull", "nearest"), rows, note)


def _full_effort(report: VehicleReport, k: int) -> tuple[str, ...]:
    own, (ahead, astern) = report.allocation, report.terminal[k]
    if not np.isfinite(ahead):
        return AXES[k], "by fins, under way" if AXES[k] in own.driven else "not driven", NONE, NONE
    length, force = ("m", "N") if k < 3 else ("rad", "N m")
    return (
        AXES[k], f"{_n(ahead)} / {_n(astern)} {length}/s",
        f"{_n(own.full_ahead[k])} / {_n(own.full_astern[k])} {force}", f"{_n(own.authority[k])} {length}/s2",
    )  # fmt: skip


def _mode(mode: Mode) -> tuple[str, ...]:
    swings, ratio, value = bool(mode.frequency_rad_s), NONE, f"{0.0 if mode.is_neutral else mode.growth_1_s:.3g}"
    if swings:
        ratio, value = f"{mode.damping_ratio:.2f}", f"{value} +- {mode.frequency_rad_s:.3g}i"
    if mode.is_neutral:
        return mode.moves, value, "oscillates undamped" if swings else "neutral", ratio
    time_s = np.log(2.0) / abs(mode.growth_1_s)
    change = f"{'GROWS: doubles' if mode.growth_1_s > 0.0 else 'halves'} in {time_s:.3g} s"
    period = f"period {2.0 * np.pi / mode.frequency_rad_s:.3g} s, " if swings else ""
    return mode.moves, value, period + change, ratio


def _efforts(surge: float) -> str:
    return f"surge {surge:g}, yaw 1"


def _n(value: float) -> str:
    return NONE if np.isnan(value) else f"{value:.3g}"


def _mark(value: float, *estimates: float) -> str:
    """Return a mark for a coefficient that is far from all of its estimates."""
    known = [estimate for estimate in estimates if np.isfinite(estimate) and estimate > 0.0]
    if not known or LIKELY[0] * min(known) <= value <= LIKELY[1] * max(known):
        return ""
    return "low?" if value < min(known) else "high?"
