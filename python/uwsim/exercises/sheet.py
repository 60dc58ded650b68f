"""Writes the score sheet of an exercise: score.json, sheet.html with its figures, and the true track."""

from __future__ import annotations

import json
from importlib.util import find_spec
from pathlib import Path

from uwsim.base.atomic_file import write_atomically
from uwsim.exercises.course import Course

TEMPLATE = Path(__file__).with_name("sheet.html.j2")
SCORE, SHEET, TRACK = "score.json", "sheet.html", "true-track.csv"


def write_sheet(out: Path, course: Course) -> list[Path]:
    """Write the files into a folder; return their paths. Without matplotlib, sheet.html is left out. Raises OSError."""
    out.mkdir(parents=True, exist_ok=True)
    sheet = course.sheet()
    write_atomically(out / SCORE, (json.dumps(sheet, indent=1) + "\n").encode())
    rows = ["time_s,x_m,y_m,z_m,yaw_rad,altitude_m"]
    rows += [",".join(f"{value:.6g}" for value in row) for row in course.track.tolist()]
    write_atomically(out / TRACK, ("\n".join(rows) + "\n").encode())
    written = [out / SCORE, out / TRACK]
    if find_spec("matplotlib") is not None:
        write_atomically(out / SHEET, sheet_html(out, course).encode())
        written.append(out / SHEET)
    return written


def sheet_html(folder: Path, course: Course) -> str:
    """Return the self-contained page; its figures are also left in the folder. Raises OSError."""
    from uwsim.figures.exercise import draw_errors, draw_exercise_track  # here, since matplotlib takes a second
    from uwsim.figures.flight import draw_depth
    from uwsim.figures.html_page import data_uri, filled_page

    figures = []
    track, sheet = course.track, course.sheet()
    if len(track) > 1:
        path = folder / "exercise_track.png"
        draw_exercise_track(path, course.sim.world, track[:, 1:4], _places(course), _marks(sheet))
        figures.append(("Where it went", "From the circle to the square, with goals and what happened.", path))
        path = folder / "exercise_depth.png"
        draw_depth(path, track[:, 0], track[:, 3], track[:, 3] - track[:, 5], track[:, 0] < 0.0)
        figures.append(("Depth and altitude", "Its true height, and that of what lies below it.", path))
    if errors := course.errors():
        path = folder / "exercise_errors.png"
        draw_errors(path, errors)
        figures.append(("Errors", "Deviations from what was to be held.", path))
    return filled_page(
        TEMPLATE, sheet=sheet, figures=[(title, caption, data_uri(path)) for title, caption, path in figures]
    )


def _places(course: Course) -> dict[str, list[tuple[float, ...]]]:
    """Return the points of those goals that have a position, keyed by the goal's name."""
    found: dict[str, list[tuple[float, ...]]] = {}
    for goal in course.exercise.goals:
        if (place := getattr(goal, "position_m", None)) is not None:
            found[goal.name] = [place]
        elif (points := getattr(goal, "points_m", None)) is not None:
            found[goal.name] = points
    return found


def _marks(sheet: dict[str, object]) -> list[tuple[str, float, float]]:
    """Return the kind and position of each broken limit and each event."""
    log: list[dict[str, object]] = sheet["log"]  # type: ignore[assignment]
    placed = [entry for entry in log if entry["position_world_m"] and entry["kind"] in ("limit", "event")]
    return [(str(e["kind"]), *e["position_world_m"][:2]) for e in placed]  # type: ignore[index]
