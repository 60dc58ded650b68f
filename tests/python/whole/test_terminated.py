"""SIGTERM, or a closed terminal: the current flight ends with its map and log, without a report."""

import os
import pty
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from command_line import UWSIM
from uwsim.base.stoppable import ending_signals
from uwsim.mapping import OccupancyMap

LAKE = ["survey", "lake", "--mission-time", "120", "--voxel", "0.4"]
PLACES = {
    "the flight begins": [".uwsim.lock"],
    "the map is saved": [".uwsim-*.tmp"],
    "in flight, after a save": ["map.bt"],
    "the map is scored, the report drawn": ["track.npz"],
}


@pytest.mark.parametrize("place", PLACES)
def test_a_survey_that_is_terminated_leaves_its_map(place: str, tmp_path: Path) -> None:
    for attempt in range(5):  # a fast machine may pass the place before it is seen
        out = tmp_path / str(attempt)
        command = [*UWSIM, *LAKE, "--out", str(out), "--autosave", "0.05", "--min-coverage", "0"]
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        while process.poll() is None and not any(path for name in PLACES[place] for path in out.glob(name)):
            time.sleep(0.002)
        process.send_signal(signal.SIGTERM)
        _, errors = process.communicate(timeout=600)
        if process.returncode != 0:
            break
    assert process.returncode == 130, errors
    assert "Traceback" not in errors
    assert not (out / "report.html").exists()
    if (out / "map.bt").exists():
        OccupancyMap.read(out / "map.bt")
    else:
        assert place == next(iter(PLACES)), "nothing flown is lost"
    assert not list(out.glob(".uwsim-*.tmp")), "no leftovers"


def test_a_mission_that_never_waits_is_ended(tmp_path: Path) -> None:
    mission, out = tmp_path / "busy.py", tmp_path / "out"
    busy = tmp_path / "busy"
    mission.write_text(
        f"def mission(vehicle):\n    yield from ()\n    open({str(busy)!r}, 'w').close()\n    while True: pass\n"
    )
    command = [*UWSIM, "run", str(mission), "--scenario", "pool", "--out", str(out)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while process.poll() is None and not busy.exists():
        time.sleep(0.01)
    process.send_signal(signal.SIGTERM)
    output, errors = process.communicate(timeout=600)
    assert process.returncode == 130, errors
    assert "interrupted" in output
    assert not (out / "report.html").exists()


def test_a_closed_terminal_loses_nothing(tmp_path: Path) -> None:
    """The flight ends at its last pause, as after SIGTERM, although nothing can be printed any more."""
    out, flies, mission = tmp_path / "out", tmp_path / "flies", tmp_path / "endless.py"
    mission.write_text(
        "import time\nfrom pathlib import Path\nfrom uwsim.missions import wait\ndef mission(vehicle):\n"
        f"    while True:\n        yield wait(0.02)\n        time.sleep(0.02)\n        Path({str(flies)!r}).touch()\n"
    )  # no faster than the clock: it would have ended before the terminal is closed
    words = [*UWSIM, "run", str(mission), "--scenario", "pool", "--map", "--out", str(out), "--autosave", "3600"]
    process, terminal = pty.fork()
    if process == 0:
        os.execv(words[0], words)
    while not flies.exists():
        time.sleep(0.01)
    os.close(terminal)
    _, status = os.waitpid(process, 0)
    assert os.waitstatus_to_exitcode(status) == 130
    OccupancyMap.read(out / "map.bt")


WRITES = """
import os, signal, sys
from uwsim.base.stoppable import outliving_terminal

signal.signal(signal.SIGHUP, signal.SIG_IGN)
output = outliving_terminal(sys.stdout)
try:
    while os.ttyname(1):
        print("it flies", file=output, flush=True)
except OSError:
    print("it was closed", file=output, flush=True)
os._exit(0 if os.fstat(1).st_rdev == os.stat(os.devnull).st_rdev else 2)
"""


def test_a_write_that_finds_the_terminal_closed_before_the_signal_is_discarded() -> None:
    process, terminal = pty.fork()
    if process == 0:
        os.execv(sys.executable, [sys.executable, "-c", WRITES])
    os.read(terminal, 1)
    os.close(terminal)
    _, status = os.waitpid(process, 0)
    assert os.waitstatus_to_exitcode(status) == 0


def test_a_program_that_ignores_hangups_goes_on() -> None:
    """As under nohup."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    try:
        assert signal.SIGHUP in ending_signals()
        signal.signal(signal.SIGHUP, signal.SIG_IGN)
        assert signal.SIGHUP not in ending_signals()
    finally:
        signal.signal(signal.SIGHUP, before)
