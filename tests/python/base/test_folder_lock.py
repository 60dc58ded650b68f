"""The lock that allows only one run at a time in an output folder."""

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


def test_a_second_run_into_one_folder_is_refused(tmp_path: Path) -> None:
    mission, sweep, out = tmp_path / "mission.py", tmp_path / "sweep.yaml", tmp_path / "out"
    mission.write_text("def mission(vehicle):\n    yield from ()\n")
    sweep.write_text(SWEEP)
    out.mkdir()
    for command in ("survey pool", f"run {mission} --scenario pool", f"sweep {sweep}", "fleet lake --tile 50"):
        with alone_in(out):
            message = error_line(uwsim(*command.split(), "--out", str(out)))
            assert {path.name for path in out.iterdir()} == {LOCK}, "nothing is written"
        assert f"{out}" in message and "another run is using it (process " in message
        assert not list(out.iterdir())
    with alone_in(out):
        out.rename(tmp_path / "gone")  # is no error


def test_the_lock_of_a_killed_process_does_not_hinder(tmp_path: Path) -> None:
    words = [sys.executable, "-c", HOLD + "print('held', flush=True); time.sleep(1000)", str(tmp_path)]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as holder:
        assert holder.stdout is not None and holder.stdout.readline()
        with pytest.raises(OSError, match="another run is using it"), alone_in(tmp_path):
            pass
        holder.kill()
    assert (tmp_path / LOCK).exists()
    with alone_in(tmp_path):
        pass
    assert not (tmp_path / LOCK).exists()
