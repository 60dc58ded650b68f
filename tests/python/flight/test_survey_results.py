"""The extent of a survey's results: everything, values as JSON only, or just the map."""

import json
from pathlib import Path

import pytest

from uwsim.flight.survey import run_survey
from uwsim.scoring.score_map_file import score_map_file, write_score_json

FLOWN = {"map.bt", "track.npz", "track-rov.csv", "log.jsonl"}


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_json_holds_the_flight_and_the_score_of_the_map_file(tmp_path: Path) -> None:
    record = run_survey("pool", tmp_path / "out", seed=5, mission_time_s=6.0, report="json")
    assert names(tmp_path / "out") == FLOWN | {"summary.json"}
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["seed"] == 5
    assert summary["pings"] == record.ping_count > 0
    assert any("ended early" in warning for warning in summary["warnings"])
    write_score_json(
        tmp_path / "score.json", score_map_file(tmp_path / "out" / "map.bt", "pool", None, (0.0, 0.0, 0.0))
    )
    score = json.loads((tmp_path / "score.json").read_text())
    assert score["precision"] == pytest.approx(1.0, abs=0.05)
    assert {name: summary["map"][name] for name in score} == pytest.approx(score)


def test_none_leaves_the_map_and_the_track(tmp_path: Path) -> None:
    run_survey("pool", tmp_path, seed=5, mission_time_s=1.0, report="none")
    assert names(tmp_path) == FLOWN


def test_another_report_is_refused_before_the_flight(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="report = 'pdf': must be one of full, json, none"):
        run_survey("pool", tmp_path / "out", report="pdf")
    assert not (tmp_path / "out").exists()
