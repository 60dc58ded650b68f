"""The tables of a vehicle's report, shared by its terminal and HTML forms."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from uwsim.base.axes import AXES
from uwsim.evidence.vehicle.linear_motion import Mode
from uwsim.evidence.vehicle.report import VehicleReport
from uwsim.exchange.hulls.hull_drag import ACROSS

LIKELY = (1.0 / 3.0, 3.0)
"""Ratios of a coefficient to its estimate outside which it is marked; published vehicles lie within them."""
NONE = "-"


@dataclass(frozen=True)
class Table:
    """A titled table of texts; the first column names the rows."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""


def tables(report: VehicleReport) -> Iterator[Table]:
    """Yield the tables of a report, in the order in which a new vehicle is checked."""
    if report.beside_makers:
        yield _makers(report)
    yield _added_mass(report)
    yield _drag(report)
    yield _axes(report)
    yield _allocation(report)
    if report.circles:
        yield _circles(report)
    yield from (_modes(speed, own) for speed, own in report.motions.items())
    if report.views:
        yield _views(report)


def _makers(report: VehicleReport) -> Table:
    note = "Here: in fresh, still water, without a tether; a glider in the sea. Endurance is not computed: computers, "
    note += "lamps and payload are not modelled."
    return Table("Beside what is stated", ("quantity", "here", "stated", "year", "source"), report.beside_makers, note)


def _added_mass(report: VehicleReport) -> Table:
    found = report.estimates
    each = zip(AXES, report.added_mass, found.lamb, found.mesh, strict=True)
    rows = tuple((axis, _n(file), _n(lamb), _n(own), _mark(file, own, lamb)) for axis, file, lamb, own in each)
    note = "Lamb: the ellipsoid with the hull's volume and ratios of inertia. Mesh: panels in ideal flow, about the "
    note += "origin; an open frame has less."
    return Table("Added mass [kg, kg m2]", ("axis", "file", "Lamb", "mesh", ""), rows, note)


def _drag(report: VehicleReport) -> Table:
    found, rows = report.estimates, []
    for k, axis in enumerate(AXES):
        file, smooth, bluff = report.quadratic_damping[k], found.streamlined[k], found.bluff[k]
        mark = "" if axis == "roll" else _mark(file, smooth, bluff)
        rows.append((axis, _n(file), _n(smooth), _n(bluff), mark, _n(report.linear_damping[k])))
    note = f"Hoerner: streamlined from friction at {found.speed_m_s:.2f} m/s; bluff from the hull's silhouettes, "
    note += f"C_D {ACROSS:g}. Drag of fins and struts is extra. In roll, a hull that is round about x has none."
    head = ("axis", "file", "streamlined", "bluff", "", "linear [N s/m, N m s/rad]")
    return Table("Quadratic drag [N s2/m2, N m s2/rad2]", head, tuple(rows), note)


def _axes(report: VehicleReport) -> Table:
    own, rows = report.allocation, []
    for k, axis in enumerate(AXES):
        unit = ("m", "N") if k < 3 else ("rad", "N m")
        if np.isfinite(report.terminal[k, 0]):
            rows.append((axis, f"{_n(report.terminal[k, 0])} / {_n(report.terminal[k, 1])} {unit[0]}/s",
                         f"{_n(own.full_ahead[k])} / {_n(own.full_astern[k])} {unit[1]}",
                         f"{_n(own.authority[k])} {unit[0]}/s2"))  # fmt: skip
        else:
            rows.append((axis, "by fins, under way" if axis in own.driven else "not driven", NONE, NONE))
    note = "Terminal speed: that axis alone free, as in a towing tank."
    return Table("Full effort, ahead / astern", ("axis", "terminal speed", "wrench", "from rest"), tuple(rows), note)


def _allocation(report: VehicleReport) -> Table:
    own = report.allocation
    if own.rank is None:
        rows: list[tuple[str, ...]] = [("forces along the axes", "no thrusters")]
    else:
        rows = [("rank of the thrusters", f"{own.rank} of 6")]
        rows += [(f"without {name}", f"{rank} of 6") for name, rank in own.rank_without.items()]
    idle = [axis for axis in AXES if axis not in own.driven]
    rows.append(("nothing drives", ", ".join(idle) or "no axis is left out"))
    return Table("Allocation", ("", ""), tuple(rows))


def _circles(report: VehicleReport) -> Table:
    rows = [(f"surge {c.surge:g}, yaw 1", f"{c.radius_m:.2f} m" + ("" if c.is_steady else " (unsteady)"),
             f"{c.speed_m_s:.2f} m/s", f"{np.degrees(c.turn_rad_s):.1f} deg/s", f"{c.climb_m:+.1f} m",
             f"{c.tilt_deg:.0f} deg") for c in report.circles]  # fmt: skip
    head = ("efforts", "radius", "speed", "turn", "climb in 2 min", "largest tilt")
    return Table("Turning circle", head, tuple(rows), "Free flight without control, from rest.")


def _modes(speed_m_s: float, modes: tuple[Mode, ...]) -> Table:
    rows = tuple((mode.moves, _eigenvalue(mode), *_behaviour(mode)) for mode in modes)
    title = "Linear motion at rest" if speed_m_s == 0.0 else f"Linear motion at {speed_m_s:g} m/s ahead"
    note = (
        "Without control, fins amidships. Neutral: only quadratic drag, which vanishes at rest."
        if speed_m_s == 0.0
        else ""
    )
    return Table(title, ("moves mainly", "eigenvalue [1/s]", "behaviour", "damping ratio"), rows, note)


def _eigenvalue(mode: Mode) -> str:
    real = 0.0 if mode.is_neutral else mode.growth_1_s
    return f"{real:.3g}" + (f" +- {mode.frequency_rad_s:.3g}i" if mode.frequency_rad_s else "")


def _behaviour(mode: Mode) -> tuple[str, str]:
    ratio = f"{mode.damping_ratio:.2f}" if mode.frequency_rad_s else NONE
    if mode.is_neutral:
        return ("oscillates undamped" if mode.frequency_rad_s else "neutral"), ratio
    time_s = np.log(2.0) / abs(mode.growth_1_s)
    change = f"{'GROWS: doubles' if mode.growth_1_s > 0.0 else 'halves'} in {time_s:.3g} s"
    return (f"period {2.0 * np.pi / mode.frequency_rad_s:.3g} s, {change}" if mode.frequency_rad_s else change), ratio


def _views(report: VehicleReport) -> Table:
    rows = [(view.label, f"{len(view.rays)}", f"{100.0 * view.share:.1f} %",
             f"{view.nearest_m:.2f} m" if np.isfinite(view.nearest_m) else NONE) for view in report.views]  # fmt: skip
    note = "Share of the rays in the field of view that meet the hull from outside. In the simulator, a vehicle's own "
    note += "hull does not appear to its cameras and sonars; on a real one it does."
    return Table("Its own hull in view", ("instrument", "rays", "on the hull", "nearest"), tuple(rows), note)


def _n(value: float) -> str:
    return NONE if np.isnan(value) else f"{value:.3g}"


def _mark(value: float, *estimates: float) -> str:
    """Return a mark for a coefficient that is far from all of its estimates."""
    known = [estimate for estimate in estimates if np.isfinite(estimate) and estimate > 0.0]
    if not known or LIKELY[0] * min(known) <= value <= LIKELY[1] * max(known):
        return ""
    return "low?" if value < min(known) else "high?"
