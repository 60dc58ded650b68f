"""`uwsim survey` as a user runs it: files written, interruptions, and one-line errors."""

import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from command_line import (
    BLANK,
    error_line,
    files_limited_to,
    hears_ctrl_c,
    start_survey,
    uwsim,
    uwsim_process,
    wait_for,
)
from uwsim.mapping import OccupancyMap
from uwsim.scenario.read.assets import assets_folder


def test_a_survey_writes_a_map_a_report_and_figures(tmp_path: Path) -> None:
    out = tmp_path / "out"
    result = uwsim("survey", "pool", "--out", str(out), "--seed", "5", "--sonar-model", "1")
    assert result.returncode == 0, result.stderr
    for words in ("simulated time", "real-time factor", "pings", "echoes", "occupied voxels", "coverage", "95th"):
        assert words in result.stdout
    assert len(OccupancyMap.read(out / "map.bt").occupied_voxels()) > 100
    scored = uwsim("map", "score", str(out / "map.bt"), "--scenario", "pool")
    assert scored.returncode == 0, scored.stderr
    shares = [
        next(line for line in text.splitlines() if "coverage" in line).split("│")[2].split(" of ")[0].strip()
        for text in (result.stdout, scored.stdout)
    ]  # the number of voxels to see may differ by those that only a beam between two poses has met
    assert shares[0] == shares[1], "the map file scores as it did in the survey"
    report = (out / "report.html").read_text()
    assert "data:image/png;base64," in report
    assert "seed" in report
    assert {path.suffix for path in out.iterdir()} == {".bt", ".html", ".json", ".jsonl", ".csv", ".npz", ".png"}


def test_sigint_ends_the_command_with_a_valid_map(tmp_path: Path) -> None:
    text = (assets_folder() / "scenarios" / "pool.yaml").read_text()
    slow = text.replace("line_spacing_m: 2", "line_spacing_m: 0.5").replace("speed_m_s: 0.5", "speed_m_s: 0.05")
    (tmp_path / "slow.yaml").write_text(slow.replace("mission_time_s: 600", "mission_time_s: 36000"))
    process = start_survey(tmp_path / "out", str(tmp_path / "slow.yaml"), "--report", "json")
    wait_for(tmp_path / "out" / "checkpoint" / "flight.json", process)
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate(timeout=90)
    assert process.returncode == 130, errors
    assert "Traceback" not in errors
    assert "interrupted" in output
    assert len(OccupancyMap.read(tmp_path / "out" / "map.bt").occupied_voxels()) > 0
    assert (tmp_path / "out" / "summary.json").is_file()


@pytest.mark.parametrize("after_s", [0.01, 0.05, 0.1, 0.3, 0.5, 0.7])
def test_ctrl_c_before_the_flight_ends_the_program_at_once(after_s: float, tmp_path: Path) -> None:
    program = (
        "from uwsim import cli; install = cli.exit_on_signals\n"
        "cli.exit_on_signals = lambda: (install(), print(flush=True))\n"
        "cli.main()"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", program, "survey", "lake", "--out", str(tmp_path / "out")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=hears_ctrl_c,
    )
    process.stdout.readline()  # until main installs its own handler, Python's is in force
    time.sleep(after_s)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert (process.returncode, errors) == (130, "uwsim: interrupted\n")


def test_ctrl_c_while_a_module_is_half_imported_ends_the_program() -> None:
    code = (
        "import os, signal, sys, types; from uwsim.cli import main, program\n"
        "for name in ('uwsim._core', 'uwsim.base.atomic_file'): sys.modules[name] = types.ModuleType(name)\n"
        "program.app = lambda **_: os.kill(os.getpid(), signal.SIGINT)\n"
        "main()"
    )
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    assert (ended.returncode, ended.stderr) == (130, "uwsim: interrupted\n")


def test_a_reader_that_stops_reading_does_not_prevent_the_report(tmp_path: Path) -> None:
    command = shlex.join([*BLANK, "survey", "pool", "--out", str(tmp_path), "--mission-time", "5"])
    subprocess.run(f"{command} | true", shell=True, timeout=600, check=True)
    assert {"map.bt", "report.html"} <= {path.name for path in tmp_path.iterdir()}


@pytest.mark.usefixtures("blank_figures")
def test_a_simulation_that_diverges_leaves_the_map_so_far(tmp_path: Path) -> None:
    vehicle = (assets_folder() / "vehicles" / "rov.yaml").read_text()
    start = vehicle.index("linear_damping:")
    end = vehicle.index("\n", start)
    (tmp_path / "stiff.yaml").write_text(
        vehicle[:start] + "linear_damping: [1.0e6, 1.0e6, 1.0e6, 1.0e6, 1.0e6, 1.0e6]" + vehicle[end:]
    )
    scenario = (assets_folder() / "scenarios" / "pool.yaml").read_text().replace("model: rov", "model: stiff.yaml")
    (tmp_path / "stiff_pool.yaml").write_text(scenario)
    line = error_line(uwsim("survey", str(tmp_path / "stiff_pool.yaml"), "--out", str(tmp_path / "out")))
    assert "diverged" in line
    assert (tmp_path / "out" / "map.bt").is_file()


def test_an_output_folder_that_cannot_be_written_is_refused_before_the_flight(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    assert "is not a folder" in error_line(uwsim("survey", "pool", "--out", str(tmp_path / "file")))
    assert "cannot write there" in error_line(uwsim("survey", "pool", "--out", "/proc/uwsim"))


def test_a_full_disk_gives_one_line_and_no_partial_file(tmp_path: Path) -> None:
    arguments = ("survey", "pool", "--out", str(tmp_path), "--mission-time", "5")
    line = error_line(uwsim_process(*arguments, command=BLANK, preexec_fn=files_limited_to(100)))
    assert "map.bt" in line
    assert not any(tmp_path.iterdir())


def test_a_disk_that_is_full_after_the_map_gives_the_summary_and_says_so(tmp_path: Path) -> None:
    arguments = ("survey", "pool", "--out", str(tmp_path), "--mission-time", "5")
    result = uwsim_process(*arguments, command=BLANK, preexec_fn=files_limited_to(20_000))
    assert "is complete" in error_line(result)
    assert "coverage" in result.stdout
    assert {path.name for path in tmp_path.iterdir()} >= {"map.bt", "track.npz", "summary.json", "checkpoint"}
    assert "--resume makes the report" in result.stderr
