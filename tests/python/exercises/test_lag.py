"""A lag is the time that sound takes, both ways, and the sheets of flights at several lags are one table."""

import csv
import json
from pathlib import Path

import pytest

from command_line import error_line, uwsim
from uwsim.exercises import load_exercise
from uwsim.exercises.flight import fly_exercise
from uwsim.exercises.lag import with_lag
from uwsim.missions import wait
from uwsim.scenario import ScenarioError, load
from uwsim.simulator.simulator import Simulator

SHORT = """title: Off
brief: Move ahead.
scenario: training_pool
start: {position_m: [-3, -3, -1.5], yaw_deg: 90}
time_s: 12
pass_points: 1
goals:
  - {kind: reach, name: there, title: Get there, position_m: [-3, 0, -1.5], within_m: 1, points: 10}
"""
PILOT = """from uwsim.missions import wait

def mission(vehicle):
    vehicle.set_effort(surge=0.5)
    yield wait(11.0)
"""


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    for name, text in (("off.yaml", SHORT), ("ahead.py", PILOT)):
        (tmp_path / name).write_text(text)
    return tmp_path / "off.yaml", tmp_path / "ahead.py"


@pytest.mark.parametrize(("name", "lag_s"), [("hover", 0.5), ("gust", 3.0)])
def test_sound_takes_the_lag_from_the_station_to_the_vehicle(name: str, lag_s: float) -> None:
    sim = Simulator(load_exercise(name).model_copy(update={"lag_s": lag_s}).made_scenario())
    assert sim.link is not None
    vehicle = next(iter(sim.vehicles))
    assert sim.link.reception(vehicle, "station").delay_s == pytest.approx(lag_s, rel=2e-3)
    assert sim.link.reception("station", vehicle).delay_s == pytest.approx(lag_s, rel=2e-3)


def test_the_lag_does_not_depend_on_how_the_station_is_turned() -> None:
    scenario = load("pool")
    turned = scenario.model_copy(update={"station": scenario.station.model_copy(update={"yaw_deg": 70.0})})
    sim = Simulator(with_lag(turned, 1.0))
    assert sim.link is not None
    assert sim.link.reception("rov", "station").delay_s == pytest.approx(1.0, rel=2e-3)


def test_a_command_acts_one_lag_later_and_is_seen_to_act_two_lags_later(files: tuple[Path, Path]) -> None:
    lag_s, seen = 1.0, []

    def pilot(vehicle):  # type: ignore[no-untyped-def]
        vehicle.set_effort(surge=0.5)
        for _ in range(80):
            seen.append((vehicle.time_s, float(vehicle.pose.position_world_m[1])))
            yield wait(0.05)
        with pytest.raises(AttributeError, match="sensors: is not seen over the lag"):
            _ = vehicle.sensors

    exercise = load_exercise(files[0]).model_copy(update={"lag_s": lag_s})
    course, _ = fly_exercise(exercise, pilot)
    moved_s = {
        name: next(time_s for time_s, north_m in rows if north_m > -3.0 + 1e-4)
        for name, rows in (("true", course.track[:, [0, 2]].tolist()), ("seen", seen))
    }
    assert moved_s["true"] == pytest.approx(lag_s, abs=0.25)  # judged every 0.1 s, and the vehicle gathers way
    assert moved_s["seen"] - moved_s["true"] == pytest.approx(lag_s, abs=0.25)
    assert course.sheet()["lag_s"] == lag_s


def test_a_scenario_with_a_link_has_no_second_one() -> None:
    exercise = load_exercise("hover").model_copy(update={"scenario": "lake_boat", "lag_s": 1.0})
    with pytest.raises(ScenarioError, match="lag_s = 1 s: the scenario has a link of its own"):
        exercise.made_scenario()


def test_sheets_at_several_lags_are_one_table_and_one_figure(files: tuple[Path, Path], tmp_path: Path) -> None:
    """One command, which arrives the lag later, reaches the goal the lag later; joined again, the table is the same."""
    exercise, pilot = files
    done = uwsim(
        "exercise", exercise, "--pilot", pilot, "--lag", "0,2", "--person", "Ada L.", "--out", tmp_path / "out"
    )
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader((tmp_path / "out/lags.csv").open()))
    assert [float(row["lag_s"]) for row in rows] == [0.0, 2.0]
    assert {row["pilot"] for row in rows} == {"Ada L., script ahead.py"}
    assert float(rows[1]["time_s"]) - float(rows[0]["time_s"]) == pytest.approx(2.0, abs=0.2)  # judged every 0.1 s
    assert (tmp_path / "out/lags.png").stat().st_size > 10_000
    joined = uwsim("exercise", "--join", tmp_path / "out", "--out", tmp_path / "all", "--json")
    assert json.loads(joined.stdout) == json.loads((tmp_path / "out/lags.json").read_text())
    sheet = tmp_path / "out/lag-2/score.json"
    sheet.write_text(sheet.read_text().replace('"lag_s": 2.0', '"lag_s": 1.0'))
    assert "has been changed since it was written" in error_line(uwsim("exercise", "--join", tmp_path / "out"))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("hover", "--pilot", "PILOT", "--lag", "0,4"), r"--lag 0,4: 4 s: must be in [0, 3] s"),
        (("hover", "--pilot", "PILOT", "--lag", "soon"), "--lag soon: soon s: must be in [0, 3] s"),
        (("hover", "--pilot", "PILOT", "--lag", "1,1"), "--lag 1,1: must be different lags"),
        (("hover", "--serve", "--lag", "0,1"), "--lag 0,1: must be one lag with --serve"),
        (("--join", "EMPTY"), "must be a folder with score sheets, score.json"),
        (("hover", "--join", "EMPTY"), "has no effect with --join"),
    ],
)
def test_mistakes_are_one_line(words: tuple[str, ...], message: str, files: tuple[Path, Path], tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    named = {"PILOT": str(files[1]), "EMPTY": str(tmp_path / "empty")}
    assert message in error_line(uwsim("exercise", *(named.get(word, word) for word in words)))
