"""The history of ratios is complete, and a comparison knows which direction is better."""

import json

from tools.history import FOLDER, RATIOS, table


def test_each_entry_names_its_commit_and_load_and_has_all_ratios() -> None:
    entries = [json.loads(path.read_text()) for path in sorted(FOLDER.glob("*.json"))]
    assert entries
    for entry in entries:
        assert len(entry["commit"]) == 40
        assert entry["load"].keys() == {"before", "after"}
        assert entry["ratios"].keys() == RATIOS.keys()
        assert all(value > 0 for value in entry["ratios"].values())


def test_a_commit_that_is_twice_as_fast_is_better_by_two_in_every_ratio() -> None:
    old = dict.fromkeys(RATIOS, 1.0)
    new = {name: 2.0 if ratio.more_is_better else 0.5 for name, ratio in RATIOS.items()}
    _, *lines = table([old] * 3, [new] * 3, "old", "new")
    assert len(lines) == len(RATIOS) == 10
    assert all(line.endswith("2.00 (2.00 to 2.00)") for line in lines)
    assert "one of the commits does not measure it" in table([{}], [new], "old", "new")[1]
