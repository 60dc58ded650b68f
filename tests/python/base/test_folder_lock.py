"""The lock that allows only one run at a time in an output folder."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from command_line import error_line, uwsim
from uwsim.base.folder_lock import LOCK, alone_in

HOLD = (
    "import sys, pathlib, time; from uwsim.base.folder_lock import alone_in\nwith alone_in(pathlib.Path(sys.argv[1])): "
)
SWEEP = "scenario: pool\nvary: {survey.altitude_m: {choices: [1.5]}}\n"


@pytest.mark.parametrize(
    "command", ["survey pool", "run MISSION --scenario pool", "sweep SWEEP", "fleet lake --tile 50"]
)
def test_a_second_run_into_one_folder_is_refused(command: str, tmp_path: Path) -> None:
    mission, sweep, out = tmp_path / "mission.py", tmp_path / "sweep.yaml", tmp_path / "out"
    mission.write_text("def mission(vehicle):\n    yield from ()\n")
    sweep.write_text(SWEEP)
    out.mkdir()
    words = command.replace("MISSION", str(mission)).replace("SWEEP", str(sweep)).split()
    with alone_in(out):
        message = error_line(uwsim(*words, "--out", str(out)))
        assert {path.name for path in out.iterdir()} == {LOCK}, "nothing is written"
    assert "another run is using it (process " in message
    assert str(out) in message
    assert not list(out.iterdir())


def test_the_lock_of_a_killed_process_does_not_hinder(tmp_path: Path) -> None:
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLD + "print('held', flush=True); time.sleep(100)", str(tmp_path)],
        stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert holder.stdout is not None
    holder.stdout.readline()
    with pytest.raises(OSError, match="another run is using it"), alone_in(tmp_path):
        pass
    holder.send_signal(signal.SIGKILL)
    holder.communicate()
    assert (tmp_path / LOCK).exists()
    with alone_in(tmp_path):
        pass
    assert not (tmp_path / LOCK).exists()


def test_a_folder_that_vanishes_meanwhile_is_no_error(tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    with alone_in(out):
        out.rename(tmp_path / "gone")
