"""The history of ratios is complete, and a comparison knows which direction is better."""

import json
from pathlib import Path

import pytest
from tools import history
from tools.history import FOLDER, RATIOS, TRIES, WORSE, entries, machine, table


def test_each_entry_names_its_commit_and_load_and_the_newest_has_all_ratios() -> None:
    for entry in entries(FOLDER):
        assert len(entry["commit"]) == 40
        assert entry["load"].keys() == {"before", "after"}
        assert entry["ratios"].keys() <= RATIOS.keys()
        assert all(value > 0 for value in entry["ratios"].values())
    assert entries(FOLDER)[-1]["ratios"].keys() == RATIOS.keys()


@pytest.mark.parametrize("factor", [0.98 * WORSE, 1.02 * WORSE])
@pytest.mark.parametrize("name", ["step_bullet", "ping_bent"])  # more is better; less is better
def test_the_check_fails_where_a_ratio_is_worse_than_allowed(
    name: str, factor: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    kept = dict.fromkeys(RATIOS, 2.0)
    entry = {"commit": "0" * 40, "date": "2026-01-01", "machine": machine(), "ratios": kept}
    (tmp_path / "0.json").write_text(json.dumps(entry))
    measured = []
    now = kept | {name: 2.0 / factor if RATIOS[name].more_is_better else 2.0 * factor}
    monkeypatch.setattr(history, "FOLDER", tmp_path)
    monkeypatch.setattr(history, "ratios", lambda *wanted: measured.append(wanted) or now)
    if factor < WORSE:
        history.check()
        assert len(measured) == 1
        return
    with pytest.raises(SystemExit):
        history.check()
    assert len(measured) == TRIES and name in capsys.readouterr().err


def test_a_commit_that_is_twice_as_fast_is_better_by_two_in_every_ratio() -> None:
    old = dict.fromkeys(RATIOS, 1.0)
    new = {name: 2.0 if ratio.more_is_better else 0.5 for name, ratio in RATIOS.items()}
    _, *lines = table([old] * 3, [new] * 3, "old", "new")
    assert len(lines) == len(RATIOS)
    assert all(line.endswith("2.00 (2.00 to 2.00)") for line in lines)
    assert "one of the commits does not measure it" in table([{}], [new], "old", "new")[1]
