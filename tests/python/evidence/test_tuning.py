"""`uwsim vehicle tune`: no worse than the file's own gains; axes that nothing drives are named, not tuned."""

import json
from pathlib import Path

import pytest
import yaml
from typer.testing import CliRunner

from command_line import uwsim
from uwsim.cli.program import app
from uwsim.evidence import tuning
from uwsim.scenario import load_vehicle
from uwsim.scenario.spec.actuator import Control


@pytest.fixture(scope="module")
def lame() -> tuning.Tuned:
    """A search from weak gains: its first generation includes them, and others that are stronger."""
    weak = Control(surge={"position_1_s": 0.3, "velocity_1_s": 0.8, "integral_1_s2": 0.1})
    return tuning.tune(load_vehicle("bluerov2_wu").model_copy(update={"control": weak}), generations=0, population=1)


def test_the_gains_found_are_cheaper(lame: tuning.Tuned) -> None:
    assert lame.after.cost < lame.before.cost


def test_axes_that_nothing_drives_are_left_out(lame: tuning.Tuned) -> None:
    """The standard BlueROV2 has no thruster that pitches it."""
    assert lame.left_out == ("pitch",)
    block = yaml.safe_load(tuning.control_text(lame))["control"]
    assert set(block) == {"surge", "sway", "heave", "roll", "yaw"}
    assert Control.model_validate(block) == lame.model.control


def test_the_command_writes_the_block_and_the_figure(tmp_path: Path) -> None:
    done = uwsim("vehicle", "tune", "remus100", "--generations", "0", "--population", "1", "--out", str(tmp_path))
    assert done.returncode == 0, done.stderr
    assert "# nothing drives sway, heave: left out" in done.stdout
    assert yaml.safe_load(done.stdout) == yaml.safe_load((tmp_path / "control.yaml").read_text())
    assert (tmp_path / "steps.png").read_bytes().startswith(b"\x89PNG")


def test_json_holds_the_control_block_that_the_text_does(
    lame: tuning.Tuned, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tuning, "tune", lambda *_, **__: lame)
    done = CliRunner().invoke(app, ["vehicle", "tune", "bluerov2_wu", "--json", "--out", str(tmp_path)])
    assert done.exit_code == 0
    found = json.loads(done.stdout)
    assert found["after"]["cost"] == pytest.approx(lame.after.cost) and found["left_out"] == ["pitch"]
    assert Control.model_validate(found["control"]) == lame.model.control
