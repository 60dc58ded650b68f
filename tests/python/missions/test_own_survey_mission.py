"""Surveys with a user-defined mission: a class or a function, from Python or by name on the command line."""

import json
from pathlib import Path
from typing import Any

import pytest

import uwsim as package
from command_line import error_line, uwsim
from uwsim.flight.record import DONE
from uwsim.missions import dive_to, wait

SPIRAL = '''
from uwsim.missions import AdaptiveLawnMower


class Short(AdaptiveLawnMower):
    """Ends after some seconds."""

    def run(self):
        self.vehicle.release()
        self.vehicle.set_effort(heave=-0.3)
        self.clock.wait(4.0)
        return "four seconds are over"


def stepped(vehicle):
    from uwsim.missions import dive_to

    vehicle.undock()
    yield from dive_to(vehicle, 2.5)
    return "it is deep"


word = 5
'''


def summary(out: Path) -> dict[str, Any]:
    read: dict[str, Any] = json.loads((out / "summary.json").read_text())
    return read


def test_a_function_and_a_class_fly_a_survey(tmp_path: Path) -> None:
    def diving(vehicle: Any) -> Any:
        vehicle.undock()
        yield from dive_to(vehicle, 2.5)
        yield wait(1.0)

    flown = package.run_survey("pool", tmp_path / "function", mission=diving, report="json")
    assert flown.ended_because == DONE
    assert flown.ping_count > 5
    assert summary(tmp_path / "function")["pings"] == flown.ping_count
    assert flown.coverage is not None and 0.0 < flown.coverage < 1.0


@pytest.mark.usefixtures("blank_figures")
def test_the_command_flies_a_mission_by_its_name(tmp_path: Path) -> None:
    (tmp_path / "spirals.py").write_text(SPIRAL)
    options = ("--mission-time", "60", "--min-coverage", "0", "--voxel", "0.5")
    done = uwsim("survey", "pool", "--mission", "spirals:Short", "--out", "out", *options, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert summary(tmp_path / "out")["ended_because"] == "four seconds are over"
    assert (tmp_path / "out" / "report.html").exists(), "summary.json is beside every report"
    done = uwsim("survey", "pool", "--mission", "spirals:stepped", "--report", "json", *options, cwd=tmp_path)
    assert (summary(tmp_path / "out")["ended_because"], summary(tmp_path / "out")["result"]) == (DONE, "it is deep")


@pytest.mark.parametrize(
    ("mission", "message"),
    [
        ("spirals", "must be MODULE:NAME"),
        ("spiral:Short", "cannot be imported: No module named 'spiral'"),
        ("spirals:Shrt", "did you mean 'Short'?"),
        ("spirals:word", "is a int, must be a class or a function"),
    ],
)
def test_a_wrong_name_is_refused_before_anything_is_written(mission: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "spirals.py").write_text(SPIRAL)
    assert message in error_line(uwsim("survey", "pool", "--mission", mission, cwd=tmp_path))
    assert not (tmp_path / "out").exists()


def test_what_makes_no_mission_is_refused() -> None:
    with pytest.raises(ValueError, match=r"must take \(vehicle, clock, plan\)"):
        package.run_survey("pool", "never", mission=lambda: None)


def test_sonar_and_camera_choose_their_vehicle(tmp_path: Path) -> None:
    done = uwsim(
        "scenario", "camera", "pair", "--vehicle", "scout", "--camera", "chase", "--effects", "off", cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    assert "scout" in error_line(uwsim("scenario", "sonar", "pair", "--vehicle", "scot", cwd=tmp_path))
