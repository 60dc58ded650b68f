"""score_team: many runs of a team's program, in processes at the same time, and one digest over the results."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

from uwsim.base.atomic_file import write_atomically
from uwsim.base.folder_lock import alone_in
from uwsim.base.own_files import remove_own_file
from uwsim.base.signing import signed
from uwsim.campaigns.workers import Campaign, Ledger, RetriedOptions
from uwsim.exercises import Exercise
from uwsim.exercises.certified import digest_of
from uwsim.exercises.seed_table import mean_interval
from uwsim.exercises.sheet_text import sheet_lines
from uwsim.flight.folder import made_folder
from uwsim.league.referee import Run, fly_run
from uwsim.league.team import Team, load_course, load_team
from uwsim.scenario.fingerprint import build_fingerprint

RESULT = "result.json"
VERSION = 1


@dataclass(frozen=True, eq=False)
class Scored:
    """A team's runs. result: the content of result.json; empty if runs are missing, which `resume=True` flies.

    finished, count: runs, of how many. failed: the reasons of those that failed, without a fault of the program.
    """

    out: Path
    result: Mapping[str, Any]
    finished: int
    count: int
    failed: Sequence[str] = ()


def score_team(
    folder: str | Path,
    seeds: Sequence[int],
    out: str | Path,
    *,
    course: str | None = None,
    user: str | None = None,
    key: str | Path | None = None,
    **options: Any,
) -> Scored:
    """Fly a team's program over a course once for each seed; write result.json, and sheets and recordings.

    folder: the team's. course: by default the one in the team's file. user: another user of this machine as whom the
    program runs, so that it can read nothing of the referee's; takes root. key: the referee's, which signs the result
    (see uwsim.base.signing). options: as for uwsim.campaigns.sweeps.run_sweep. The result depends on neither the
    workers nor the wall clock, unless the program does. Raises ScenarioError, ValueError or OSError.
    """
    campaign = Campaign(RetriedOptions, **options)
    if key is not None:
        signed({}, Path(key))  # a mistake is met before the runs
    team = load_team(folder)
    exercise = load_course(team.course if course is None else course, folder)
    team.require_rate(exercise.made_scenario())
    names = (f"seed-{seed}{end}" for seed in seeds for end in (".log", ".mcap", ".json", ".txt"))
    into = made_folder(Path(out), (RESULT, *names), 0o700).resolve()
    if user is not None and into.stat().st_mode & 0o077:
        raise PermissionError(f"--out {out}: the program's user could read it: must be closed, as by chmod 700")
    runs = {
        number: Run(exercise, seed, team, Path(folder).resolve(), into, user, campaign.job_threads)
        for number, seed in enumerate(seeds)
    }
    plan = {
        "team": team.name, "program": folder_digest(Path(folder), into), "course": course_digest(exercise),
        "seeds": list(seeds), "build": build_fingerprint(),
    }  # fmt: skip
    with (
        alone_in(into),
        Ledger.opened(into, plan, resume=campaign.options.resume, what="score", jobs="runs") as ledger,
    ):
        campaign.run(ledger, fly_run, runs, result_of=lambda each: each.result or {"error": each.error})
        results = ledger.results
        failed = [each["error"] for each in results.values() if each["error"]]
        if failed or len(results) < len(runs):
            return Scored(into, {}, len(results) - len(failed), len(runs), failed)
        found = _result(team, exercise, plan, [results[number] for number in runs])
        found = found if key is None else signed(found, Path(key))
        _keep(runs, results, found)
        write_atomically(into / RESULT, (json.dumps(found, indent=1) + "\n").encode())
    return Scored(into, found, len(runs), len(runs))


def _result(
    team: Team, exercise: Exercise, plan: Mapping[str, Any], results: Sequence[Mapping[str, Any]]
) -> dict[str, Any]:
    """Return the content of result.json."""
    sheets = [each["sheet"] for each in results]
    mean, half = mean_interval([sheet["score"] if sheet["is_valid"] else 0.0 for sheet in sheets])
    found = {
        "version": VERSION, **plan, "title": exercise.title, "points": exercise.points,
        "pass_points": exercise.pass_points, "mean": mean, "low": max(mean - half, 0.0),
        "high": min(mean + half, exercise.points), "passed": sum(bool(sheet["has_passed"]) for sheet in sheets),
        "runs": [_run(each) for each in results], "uwsim": metadata.version("uwsim"),
    }  # fmt: skip
    return {**found, "digest": digest_of(found)}


def _run(result: Mapping[str, Any]) -> dict[str, Any]:
    sheet = result["sheet"]
    return {
        "seed": sheet["seed"], "score": sheet["score"] if sheet["is_valid"] else 0.0, "valid": sheet["is_valid"],
        "passed": sheet["has_passed"], "time_s": sheet["time_s"], "lost": sheet["lost"],
        "goals": {goal["name"]: goal["scored"] for goal in sheet["goals"]}, "ended_because": sheet["ended_because"],
        "why": result["why"],
    }  # fmt: skip


def _keep(runs: Mapping[int, Run], results: Mapping[int, Mapping[str, Any]], found: dict[str, Any]) -> None:
    """Write a sheet for each run, and keep the recordings of the best and of the worst."""
    order = sorted(runs, key=lambda number: (found["runs"][number]["score"], -number))
    for number, run in runs.items():
        sheet = results[number]["sheet"]
        write_atomically(run.file(".json"), (json.dumps(sheet, indent=1) + "\n").encode())
        lines = [*sheet_lines(sheet), "", *results[number]["why"]]
        write_atomically(run.file(".txt"), ("\n".join(lines) + "\n").encode())
        if number not in (order[0], order[-1]):
            remove_own_file(run.file(".mcap"))


def course_digest(exercise: Exercise) -> str:
    """Return a digest of a course's rules and of its scenario without a seed, by which results are compared."""
    scenario = exercise.model_copy(update={"seed": 0}).made_scenario()
    text = exercise.model_dump_json(exclude={"seed"}) + scenario.model_dump_json()
    return hashlib.blake2b(text.encode(), digest_size=16).hexdigest()


def folder_digest(folder: Path, without: Path) -> str:
    """Return a digest of all files of a team's folder, but hidden ones, compiled ones and results."""
    digest = hashlib.blake2b(digest_size=16)
    for path in sorted(folder.resolve().rglob("*")):
        inside = path.relative_to(folder.resolve()).parts
        if not path.is_file() or path.is_relative_to(without) or any(p[0] == "." or p == "__pycache__" for p in inside):
            continue
        content = path.read_bytes()
        digest.update(f"{'/'.join(inside)}\0{len(content)}\0".encode() + content)
    return digest.hexdigest()
