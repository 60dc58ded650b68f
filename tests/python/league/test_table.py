"""A league's table: results of the same seeds side by side, and what makes a result count or not."""

import json
import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from command_line import error_line, uwsim
from signing_keys import made_keys
from uwsim.base.signing import signed
from uwsim.exercises.certified import digest_of
from uwsim.league.table import paired, read_results


def result_of(name: str, scores: Mapping[int, float], course: str = "a") -> dict[str, Any]:
    found: dict[str, Any] = {
        "version": 1, "team": name, "course": course, "title": "Gate", "points": 10.0, "passed": 0, "uwsim": "",
        "build": "", "program": "", "mean": sum(scores.values()) / len(scores), "low": 0.0, "high": 10.0,
        "runs": [{"seed": s, "score": p, "time_s": 1.0, "goals": {"gate": p}, "why": []} for s, p in scores.items()],
    }  # fmt: skip
    return {**found, "digest": digest_of(found)}


@pytest.mark.parametrize(
    ("wrong", "rule"),
    [({"runs": []}, "runs = []: must"), ({"mean": math.nan}, "mean = nan"), ({"runs": [{}]}, "runs[0].seed: missing")],
)
def test_a_result_that_no_referee_wrote_is_refused_in_one_line(tmp_path: Path, wrong: Any, rule: str) -> None:
    """Though its digest is right, as who writes it can have it."""
    found = {**result_of("one", {1: 9.0}), **wrong}
    del found["digest"]
    (path := tmp_path / "result.json").write_text(json.dumps({**found, "digest": digest_of(found)}))
    assert f"'{path}': {rule}" in error_line(uwsim("course", "table", tmp_path))
    path.unlink()
    os.mkfifo(path)
    assert "no regular file" in error_line(uwsim("course", "table", tmp_path))


def test_the_table_pairs_by_seed_and_refuses_what_was_changed(tmp_path: Path) -> None:
    good, bad = result_of("good|one", {1: 9.0, 2: 5.0, 3: 7.0}), result_of("bad", {1: 7.0, 2: 3.0, 3: 5.0, 4: 9.0})
    assert paired(good, bad) == (2.0, 0.0, 3)  # always two points behind: no spread, whatever that of the scores
    for one in (bad, good):
        (tmp_path / one["team"][:3]).mkdir()
        (tmp_path / one["team"][:3] / "result.json").write_text(json.dumps(one))
    assert uwsim("course", "table", tmp_path).returncode == 0
    assert [one["team"] for one in read_results(tmp_path)] == ["good|one", "bad"]
    assert "| 2 | bad | 6.0 | 0.0 to 10.0 | 2.0 ± 0.0 (3 seeds)" in (tmp_path / "table.md").read_text()
    assert "good\\|one" in (tmp_path / "table.md").read_text()
    key, public = made_keys(tmp_path, "referee")
    signed_by = ("course", "table", tmp_path, "--signed-by", public)
    assert "has no signature" in error_line(uwsim(*signed_by))
    for one in (bad, good):
        (tmp_path / one["team"][:3] / "result.json").write_text(json.dumps(signed(one, key)))
    assert uwsim(*signed_by).returncode == 0
    changed = tmp_path / "bad/result.json"
    changed.write_text(json.dumps({**bad, "mean": 10.0}))
    assert "has been changed since it was written" in error_line(uwsim("course", "table", tmp_path))
    changed.write_text(json.dumps(result_of("bad", {1: 1.0}, course="b")))
    assert "must be the same as that of" in error_line(uwsim("course", "table", tmp_path))
