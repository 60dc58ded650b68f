"""Writes the score sheet of an exercise: score.json, sheet.txt, sheet.html with its figures, and the true track."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Mapping
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from uwsim.base.atomic_file import write_atomically
from uwsim.base.own_files import remove_own_file, require_own
from uwsim.exercises.course import Course
from uwsim.exercises.sheet_text import sheet_lines

TEMPLATE = Path(__file__).with_name("sheet.html.j2")
SCORE, SHEET, TEXT, TRACK = "score.json", "sheet.html", "sheet.txt", "true-track.csv"
NAMES = (SCORE, SHEET, TEXT, TRACK)
TRACK_COLUMNS = "time_s,x_m,y_m,z_m,yaw_rad,altitude_m\n"
LOGGER = logging.getLogger("uwsim.exercises")


class SheetFigure(NamedTuple):
    """A figure of the page. uri: its data, or "" if it could not be drawn; the caption then gives the reason."""

    title: str
    caption: str
    uri: str = ""


def require_room(out: Path) -> None:
    """Raise FileExistsError if a folder has a file of a sheet's name that uwsim did not write."""
    for name in NAMES:
        require_own(out / name)


def remove_stale_sheet(out: Path) -> None:
    """Remove an earlier sheet from a folder, so that no file of it can be taken for the next one's. Raises OSError."""
    require_room(out)
    for name in NAMES:
        remove_own_file(out / name)


def write_sheet(out: Path, course: Course, sheet: Mapping[str, Any]) -> list[Path]:
    """Write the files into a folder; return their paths. Without matplotlib, sheet.html is left out. Raises OSError.

    sheet: the course's, certified. A figure that cannot be drawn is replaced by the reason.
    """
    out.mkdir(parents=True, exist_ok=True)
    remove_stale_sheet(out)
    text = json.dumps(sheet, indent=1)
    write_atomically(out / SCORE, f"{text}\n".encode())
    write_atomically(out / TEXT, ("\n".join(sheet_lines(sheet)) + "\n").encode())
    rows = [",".join(f"{value:.6g}" for value in row) + "\n" for row in course.track.tolist()]
    write_atomically(out / TRACK, (TRACK_COLUMNS + "".join(rows)).encode())
    written = [out / SCORE, out / TEXT, out / TRACK]
    if find_spec("matplotlib") is not None:
        write_atomically(out / SHEET, sheet_html(course, sheet).encode())
        written.append(out / SHEET)
    return written


def sheet_html(course: Course, sheet: Mapping[str, Any]) -> str:
    """Return the self-contained page of a certified sheet. Raises OSError."""
    from uwsim.figures.html_page import filled_page

    met = sum(goal["share"] >= 1.0 for goal in sheet["goals"])
    tiles = (
        (f"{sheet['score']:.1f}", f"of {sheet['points']:.1f} points"),
        (f"{met} of {len(sheet['goals'])}", "goals met"),
        (f"{sheet['lost']:.1f}", "points lost"),
        (f"{sheet['time_s']:.0f} s", f"of {sheet['limit_s']:.0f} s"),
    )
    return filled_page(TEMPLATE, sheet=sheet, tiles=tiles, figures=_figures(course))


def _figures(course: Course) -> list[SheetFigure]:
    from uwsim.figures.exercise import draw_errors, draw_exercise_track  # here, since matplotlib takes a second
    from uwsim.figures.flight import draw_depth

    track, marks = course.track, _marks(course.sheet())
    places = {goal.name: goal.places_m for goal in course.exercise.goals if goal.places_m}
    figures = []
    if len(track) > 1:
        figures.append(
            _drawn(
                "Where it went",
                "From the circle to the square, with goals and what happened.",
                lambda path: draw_exercise_track(path, course.sim.world, track[:, 1:4], places, marks),
            )
        )
        figures.append(
            _drawn(
                "Depth and altitude",
                "Its true height, and that of what lies below it.",
                lambda path: draw_depth(path, track[:, 0], track[:, 3], track[:, 3] - track[:, 5], track[:, 0] < 0.0),
            )
        )
    if errors := course.errors():
        caption = "Deviations from what was to be held."
        figures.append(_drawn("Errors", caption, lambda path: draw_errors(path, errors)))
    return figures


def _drawn(title: str, caption: str, draw: Callable[[Path], None]) -> SheetFigure:
    """Draw a figure. Any error is logged and becomes the caption, since the sheet matters more than its figures."""
    from uwsim.figures.html_page import data_uri

    try:
        with TemporaryDirectory() as folder:
            path = Path(folder, "figure.png")
            draw(path)
            return SheetFigure(title, caption, data_uri(path))
    except Exception as error:
        LOGGER.exception("the score sheet's figure '%s' could not be drawn", title)
        return SheetFigure(title, f"This figure could not be drawn: {error}")


def _marks(sheet: dict[str, object]) -> list[tuple[str, float, float]]:
    """Return the kind and position of each broken limit and each event."""
    log: list[dict[str, object]] = sheet["log"]  # type: ignore[assignment]
    placed = [entry for entry in log if entry["position_world_m"] and entry["kind"] in ("limit", "event")]
    return [(str(e["kind"]), *e["position_world_m"][:2]) for e in placed]  # type: ignore[index]
