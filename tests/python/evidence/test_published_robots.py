"""The trial of published robots: its own speeds, its flight, and, where there are checkouts, its tables."""

import os
from pathlib import Path

import pytest
from tools.robots_trial import ROBOTS, WORLDS, Trial, convert, flown, speeds, trials, try_robot

from command_line import uwsim as command

DATA = Path(__file__).parents[1] / "data" / "robots"
CHECKOUTS = "UWSIM_CHECKOUTS"
"""Names a folder with the checkouts that the trial lists."""


def test_the_speeds_of_a_text_are_where_its_drag_is_its_thrust() -> None:
    """Thrusts of 400 N by a clamp and of two times 40 N by limits, against drag of two terms."""
    sled, glider = (speeds((DATA / name).read_text(), None) for name in ("sled.urdf", "glider.sdf"))
    assert 30.0 * sled["surge"] + 150.0 * sled["surge"] ** 2 == pytest.approx(400.0)
    assert 4.0 * glider["surge"] + 20.0 * glider["surge"] ** 2 == pytest.approx(80.0)
    assert 40.0 * glider["yaw"] + 90.0 * glider["yaw"] ** 2 == pytest.approx(40.0 * 0.6)
    unbound = (DATA / "sled.urdf").read_text().replace("<clampMin>-100</clampMin><clampMax>200</clampMax>", "")
    assert speeds(unbound, 400.0)["surge"] == pytest.approx(sled["surge"])


def test_a_robot_flies_at_the_speeds_of_its_text(tmp_path: Path) -> None:
    done = command("scenario", "from", DATA / "glider.sdf", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    wanted = speeds((DATA / "glider.sdf").read_text(), None)
    found = flown(tmp_path / "glider.yaml", {axis: 1.1 * speed for axis, speed in wanted.items()})
    assert found == pytest.approx(wanted, rel=0.005)


@pytest.mark.skipif(CHECKOUTS not in os.environ, reason=f"{CHECKOUTS} must name the folder of the checkouts")
@pytest.mark.parametrize("trial", trials(ROBOTS), ids=lambda trial: f"{trial.repository}/{Path(trial.path).stem}")
def test_published_robots_move_as_their_files_state(trial: Trial, tmp_path: Path) -> None:
    try_robot(trial, Path(os.environ[CHECKOUTS]), tmp_path)
    assert trial.refusal == ""
    assert trial.ratios == pytest.approx(dict.fromkeys(trial.ratios, 1.0), abs=0.02)


@pytest.mark.skipif(CHECKOUTS not in os.environ, reason=f"{CHECKOUTS} must name the folder of the checkouts")
@pytest.mark.parametrize("trial", trials(WORLDS), ids=lambda trial: f"{trial.repository}/{Path(trial.path).stem}")
def test_published_worlds_convert(trial: Trial, tmp_path: Path) -> None:
    convert(trial, Path(os.environ[CHECKOUTS]), tmp_path)
    assert trial.refusal == ""
