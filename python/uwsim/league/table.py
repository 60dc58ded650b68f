"""The table of a league: results of several teams on one course, in order, as a page and as Markdown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from uwsim.base.atomic_file import write_atomically
from uwsim.base.signing import SIGNATURE, signer_of
from uwsim.base.texts.json_text import read_json
from uwsim.exercises.certified import digest_of
from uwsim.exercises.seed_table import mean_interval
from uwsim.league.score import RESULT, VERSION
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.fields import Model

PAGE, TEXT = "table.html", "table.md"
TEMPLATE = Path(__file__).with_name("table.html.j2")
COLUMNS = ("place", "team", "points", "95 % interval", "behind the first, by seed", "passed")


class _Run(Model, extra="allow"):
    seed: int
    score: float
    time_s: float
    goals: dict[str, float]
    why: list[str]


class _Result(Model, extra="allow"):
    """The part of a result that the table uses."""

    team: str
    course: str
    title: str
    points: float
    mean: float
    low: float
    high: float
    passed: int
    runs: Annotated[list[_Run], Field(min_length=1)]


def read_results(folder: Path, key: Path | None = None) -> list[dict[str, Any]]:
    """Return the results in a folder and below, the best first.

    key: the public key that must have signed each. Raises ValueError if there is none, one was changed since it was
    written or is not signed with the key, or they are of different courses.
    """
    paths = sorted(folder.rglob(RESULT))
    if not paths:
        raise ValueError(f"'{folder}': must be a folder with results, {RESULT}")
    results = [_read(path, key) for path in paths]
    for path, one in zip(paths, results, strict=True):
        if one["course"] != results[0]["course"]:
            raise ValueError(
                f"'{path}': is of the course '{one['title']}' {one['course'][:8]}: must be the same as that of "
                f"'{paths[0]}', '{results[0]['title']}' {results[0]['course'][:8]}"
            )
        if any({*run["goals"]} != {*goal_names(results)} for run in one["runs"]):
            raise ValueError(f"'{path}': runs: must all have the goals {', '.join(goal_names(results))}")
    return sorted(results, key=lambda one: (-one["mean"], one["team"]))


def _read(path: Path, key: Path | None) -> dict[str, Any]:
    found = read_json(path)
    if not isinstance(found, dict) or found.get("version") != VERSION or not isinstance(found.get("digest"), str):
        raise ValueError(f"'{path}': is no result of `uwsim course score` of version {VERSION}")
    if digest_of({name: value for name, value in found.items() if name != SIGNATURE}) != found["digest"]:
        raise ValueError(f"'{path}': has been changed since it was written: its content does not have its digest")
    if key is not None or SIGNATURE in found:
        signer_of(found, f"'{path}'", key)
    try:
        return validated(_Result, found).model_dump()
    except ValueError as error:
        raise ValueError(f"'{path}': {error}") from None


def paired(first: Mapping[str, Any], other: Mapping[str, Any]) -> tuple[float, float, int] | None:
    """Return the mean of what one lacks to the first on the seeds that both flew, half its 95 % interval, and how many.

    None if fewer than two are common.
    """
    scores = {run["seed"]: run["score"] for run in first["runs"]}
    lacks = [scores[run["seed"]] - run["score"] for run in other["runs"] if run["seed"] in scores]
    return None if len(lacks) < 2 else (*mean_interval(lacks), len(lacks))


def table_rows(results: Sequence[Mapping[str, Any]]) -> list[list[str]]:
    """Return a row of COLUMNS for each result, and the mean points of each goal."""
    rows = []
    for place, one in enumerate(results, start=1):
        pair = paired(results[0], one) if place > 1 else None
        behind = "" if pair is None else f"{pair[0]:.1f} ± {pair[1]:.1f} ({pair[2]} seeds)"
        goals = [
            f"{sum(run['goals'][name] for run in one['runs']) / len(one['runs']):.1f}" for name in goal_names(results)
        ]
        rows.append([
            str(place), one["team"], f"{one['mean']:.1f}", f"{one['low']:.1f} to {one['high']:.1f}", behind,
            f"{one['passed']} of {len(one['runs'])}", *goals,
        ])  # fmt: skip
    return rows


def goal_names(results: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the names of the course's goals."""
    return list(results[0]["runs"][0]["goals"])


def write_league(out: Path, results: Sequence[Mapping[str, Any]]) -> list[Path]:
    """Write table.html and table.md into a folder; return their paths. Raises OSError."""
    from uwsim.figures.html_page import filled_page

    head, rows = [*COLUMNS, *goal_names(results)], table_rows(results)
    title = f"{results[0]['title']}: {len(results)} teams, of {results[0]['points']:g} points"
    cells = [[cell.replace("|", "\\|") for cell in row] for row in (head, ["---"] * len(head), *rows)]
    text = "".join(f"| {' | '.join(row)} |\n" for row in cells)
    write_atomically(out / TEXT, f"# {title}\n\n{text}".encode())
    tiles = ((str(len(results)), "teams"), (f"{results[0]['mean']:.1f}", "points of the first"))
    page = filled_page(TEMPLATE, title=title, head=head, rows=rows, results=results, tiles=tiles)
    write_atomically(out / PAGE, page.encode())
    return [out / PAGE, out / TEXT]
