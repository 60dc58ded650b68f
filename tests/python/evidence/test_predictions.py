"""Predictions are computed by the simulator, frozen before their data are opened, and never edited."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from rich.console import Console

from uwsim.evidence.validate.reality import predictions
from uwsim.evidence.validate.reality.predictions import (
    COMPUTED,
    FILE,
    Measured,
    Prediction,
    current_predictions,
    print_predictions,
    read_predictions,
)
from uwsim.scenario import ScenarioError

ROOT = Path(__file__).parents[3]


def git(*arguments: str) -> str:
    done = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=False)
    return done.stdout if done.returncode == 0 else ""


def key(entry: Prediction) -> tuple[str, str]:
    return entry.quantity, entry.frozen


def test_every_prediction_is_computed_by_the_simulator_as_it_was_frozen() -> None:
    current = current_predictions(read_predictions())
    assert set(current) == set(COMPUTED)
    for quantity, entry in current.items():
        low, high = entry.interval
        off = abs(COMPUTED[quantity]() - entry.value)
        assert off < 0.05 * (high - low), f"{quantity}: add an entry with a new date; do not edit the old one"


def test_the_computed_value_follows_the_simulator_not_the_file(monkeypatch: pytest.MonkeyPatch) -> None:
    before = COMPUTED["bluerov2_sinking"](), COMPUTED["bluerov2_roll_period"]()
    load = predictions.load_vehicle

    def thicker(name: str):
        model = load(name)
        return model.model_copy(
            update={
                "quadratic_damping": [2.0 * each for each in model.quadratic_damping],
                "inertia_kg_m2": [2.0 * each for each in model.inertia_kg_m2],
            }
        )

    monkeypatch.setattr(predictions, "load_vehicle", thicker)
    assert COMPUTED["bluerov2_sinking"]() < 0.8 * before[0]
    assert COMPUTED["bluerov2_roll_period"]() > 1.1 * before[1]


def test_intervals_hold_their_values_and_data_are_opened_after_the_freeze() -> None:
    entries = read_predictions()
    assert len({key(entry) for entry in entries}) == len(entries)
    for entry in entries:
        assert entry.interval[0] < entry.value < entry.interval[1]
        assert entry.measured is None or entry.measured.date >= entry.frozen


def test_printing_does_not_write_the_file_and_shows_hits_and_misses(monkeypatch: pytest.MonkeyPatch) -> None:
    before = FILE.read_bytes()
    entry = read_predictions()[0].model_copy(update={"measured": None})
    high = entry.interval[1]
    measured = [Measured(value=value, date="2030-01-01", source="made up") for value in (high, high + 1.0)]
    shown = [entry, *(entry.model_copy(update={"measured": each}) for each in measured)]
    assert [each.result for each in shown] == ["open", "hit", "MISS"]
    monkeypatch.setattr(predictions, "read_predictions", lambda: shown)
    console = Console(record=True, width=200)
    print_predictions(console)
    text = console.export_text()
    assert "1 hit, 1 missed, 1 open" in text and f"{high + 1.0:g} kgf" in text
    assert FILE.read_bytes() == before


def test_no_entry_of_an_earlier_commit_was_edited_or_removed_or_began_with_its_measurement(tmp_path: Path) -> None:
    if git("rev-parse", "--is-shallow-repository").strip() != "false":
        pytest.skip("the history is not here")
    path = FILE.relative_to(ROOT)
    commits = git("log", "--reverse", "--format=%H", "--", str(path)).split()
    now = {key(entry): entry for entry in read_predictions()}
    known: set[tuple[str, str]] = set()
    for commit in commits:
        (tmp_path / "then.yaml").write_text(git("show", f"{commit}:{path}"))
        for then in read_predictions(tmp_path / "then.yaml"):
            assert key(then) in now, f"{key(then)} of {commit[:8]} was removed"
            kept = now[key(then)]
            assert kept.model_copy(update={"measured": then.measured}) == then, (
                f"{key(then)}: edited since {commit[:8]}"
            )
            assert then.measured in (None, kept.measured), f"{key(then)}: its measured value was edited"
            assert key(then) in known or then.measured is None, f"{key(then)}: frozen with its data open"
            known.add(key(then))


def test_a_wrong_entry_is_refused_with_its_key(tmp_path: Path) -> None:
    path = tmp_path / "predictions.yaml"
    path.write_text(FILE.read_text().replace("interval: [5.85, 6.15]", "interval: [5.85]"))
    with pytest.raises(ScenarioError, match=r"predictions\[0\]\.interval"):
        read_predictions(path)
