"""Writes a vehicle's report as one self-contained HTML page with its pictures."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from uwsim.base.atomic_file import write_atomically
from uwsim.evidence.vehicle.report import VehicleReport
from uwsim.evidence.vehicle.surprises import attitude_text
from uwsim.evidence.vehicle.tables import tables
from uwsim.evidence.vehicle.text import vehicle_lines
from uwsim.figures.html_page import data_uri, filled_page
from uwsim.figures.vehicle import View, draw_circles, draw_eigenvalues, draw_vehicle

TEMPLATE = Path(__file__).with_name("page.html.j2")


def write_page(path: Path, report: VehicleReport, warnings: Sequence[str] = ()) -> None:
    """Write the page. warnings: likely oversights, shown first. Raises OSError."""
    with tempfile.TemporaryDirectory() as folder:
        figures = _figures(Path(folder), report)
        page = filled_page(
            TEMPLATE,
            name=report.model.name,
            description=report.model.description,
            warnings=list(warnings),
            tiles=_tiles(report),
            lines=list(vehicle_lines(report.figures)),
            figures=[(title, caption, data_uri(picture)) for title, caption, picture in figures],
            tables=list(tables(report)),
        )
    write_atomically(path, page.encode())


def _tiles(report: VehicleReport) -> list[tuple[str, str]]:
    it = report.figures
    trim = "none"
    if it.nose_down_deg is not None and it.roll_to_starboard_deg is not None:
        trim = attitude_text(it.nose_down_deg, it.roll_to_starboard_deg)
    tiles = [
        (f"{it.mass_kg:.4g} kg", f"mass; net buoyancy {it.net_buoyancy_n:+.2g} N in fresh water"),
        (trim, "attitude at rest"),
        (f"{1000.0 * it.righting_lever_m:.3g} mm", "GM: centre of buoyancy above centre of mass"),
    ]
    if np.isfinite(report.terminal[0, 0]):
        tiles.append((f"{report.terminal[0, 0]:.2f} m/s", "terminal speed ahead"))
    return tiles


def _figures(folder: Path, report: VehicleReport) -> list[tuple[str, str, Path]]:
    """Draw the pictures into a folder; return title, caption and path of each."""
    hull = folder / "hull.png"
    draw_hull(hull, report)
    found = [("Hull, actuators and fields of view", "Body frame: x ahead, y to port, z up.", hull)]
    if report.circles:
        circles = folder / "circles.png"
        draw_circles(circles, {f"surge {c.surge:g}, yaw 1": c.track_m for c in report.circles})
        found.append(("Turning circles", "Free flight without control, from rest.", circles))
    values = folder / "eigenvalues.png"
    draw_eigenvalues(
        values,
        {
            f"{speed:g} m/s": np.array([complex(mode.growth_1_s, mode.frequency_rad_s) for mode in own])
            for speed, own in report.motions.items()
        },
    )
    found.append(("Linear motion", "Eigenvalues at rest and at full speed ahead.", values))
    return found


def draw_hull(path: Path, report: VehicleReport) -> None:
    """Draw the vehicle with its actuators and fields of view as a PNG. Raises OSError."""
    fields: dict[str, list[View]] = {}
    for view in report.views:
        fields.setdefault(view.label, []).append((view.position_m, view.rays))
    draw_vehicle(path, report.model, report.figures.centre_of_mass_m, report.figures.centre_of_buoyancy_m, fields)
