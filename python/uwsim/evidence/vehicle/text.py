"""Formats a vehicle's properties as lines for a terminal."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from uwsim.evidence.vehicle.figures import VehicleFigures
from uwsim.evidence.vehicle.report import VehicleReport
from uwsim.evidence.vehicle.surprises import attitude_text, straight_text
from uwsim.evidence.vehicle.tables import Table, tables
from uwsim.evidence.vehicle.trials import RUN_S, Slip
from uwsim.exchange.hulls.draft import SLIP_M_S, SLIP_SHORT_S
from uwsim.scenario.build.control import floating_text
from uwsim.scenario.build.scale import size_text


def vehicle_lines(figures: VehicleFigures) -> Iterator[str]:
    """Yield lines about a vehicle's derived properties."""
    yield (
        f"{size_text(np.array(figures.size_m))}, {figures.volume_m3:.4g} m3, {figures.mass_kg:.4g} kg, in the mean "
        f"{figures.density_kg_m3:.4g} kg/m3; in water of {figures.water_density_kg_m3:.4g} kg/m3 "
        f"{floating_text(figures.net_buoyancy_n)}"
    )
    if figures.metacentric_m is not None:
        roll_m, pitch_m = figures.metacentric_m
        yield (
            f"trim: floats {attitude_text(figures.nose_down_deg or 0.0, figures.roll_to_starboard_deg or 0.0)}; its "
            f"metacentre is {roll_m:.3g} m above its centre of mass in roll, {pitch_m:.3g} m in pitch"
        )
    elif figures.nose_down_deg is None or figures.roll_to_starboard_deg is None:
        yield "trim: centres of mass and buoyancy coincide: nothing rights it in pitch and roll"
    elif figures.righting_lever_m < 0.0:
        yield (
            f"trim: turns over: its centre of buoyancy is {-figures.righting_lever_m:.3g} m below its centre of mass; "
            f"rests {attitude_text(figures.nose_down_deg, figures.roll_to_starboard_deg)}"
        )
    else:
        yield (
            f"trim: rests {attitude_text(figures.nose_down_deg, figures.roll_to_starboard_deg)}; its centre of "
            f"buoyancy is {figures.righting_lever_m:.3g} m above its centre of mass, which rights it with "
            f"{figures.righting_nm_rad:.3g} N m/rad"
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
    """Yield the lines of a vehicle's report: its properties, then each table."""
    yield from vehicle_lines(report.figures)
    for table in tables(report):
        yield ""
        yield table.title
        yield from _table_lines(table)
        if table.note:
            yield table.note


def _table_lines(table: Table) -> Iterator[str]:
    rows = [*([table.head] if any(table.head) else []), *table.rows]
    widths = [max(len(row[k]) for row in rows) for k in range(len(table.head))]
    for row in rows:
        yield "  " + "  ".join(
            [row[0].ljust(widths[0]), *(c.rjust(w) for c, w in zip(row[1:], widths[1:], strict=True))]
        )
