"""`uwsim survey` as a user runs it: files written, interruptions, and one-line errors."""

import re
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
from uwsim.cli.exit_codes import INCOMPLETE
from uwsim.mapping import OccupancyMap
from uwsim.scenario.read.assets import assets_folder

SHORT = ("survey", "pool", "--mission-time", "3", "--out")


def test_a_survey_writes_a_map_and_a_report_and_its_exit_code_says_that_it_is_incomplete(
    tmp_path: Path,
) -> None:
    out = tmp_path / "out"
    words = ("survey", "pool", "--out", str(out), "--seed", "5", "--sonar-model", "1", "--mission-time", "10")
    result = uwsim(*words)
    assert result.returncode == INCOMPLETE, result.stderr
    assert "the survey is incomplete: coverage is" in result.stderr
    assert "it ended early: the battery is used up" in result.stderr
    for words_shown in ("simulated time", "real-time factor", "pings under 10 m above the bed", "echoes", "95th"):
        assert words_shown in result.stdout
    assert len(OccupancyMap.read(out / "map.bt").occupied_voxels()) > 100
    scored = uwsim("map", "score", str(out / "map.bt"), "--scenario", "pool")
    assert scored.returncode == 0, scored.stderr
    shares = [
        next(line for line in text.splitlines() if "coverage" in line).split("│")[2].split(" of ")[0].strip()
        for text in (result.stdout, scored.stdout)
    ]  # the number of voxels to see may differ by those that only a beam between two poses has met
    assert shares[0] == shares[1], "the map file scores as it did in the survey"
    report = (out / "report.html").read_text()
    assert "data:image/png;base64," in report and "seed" in report
    assert {path.suffix for path in out.iterdir()} == {".bt", ".html", ".json", ".jsonl", ".csv", ".npz", ".png"}
    assert uwsim(*words, "--min-coverage", "0", "--report", "json").returncode == 0


def test_sigint_ends_the_command_with_a_valid_map(tmp_path: Path) -> None:
    text = (assets_folder() / "scenarios" / "pool.yaml").read_text()
    for usual, slow in (
        ("line_spacing_m: 2", "line_spacing_m: 0.5"),
        ("speed_m_s: 0.5", "speed_m_s: 0.05"),
        ("mission_time_s: 600", "mission_time_s: 36000"),
    ):
        text = text.replace(usual, slow)
    (tmp_path / "slow.yaml").write_text(text)
    process = start_survey(tmp_path / "out", str(tmp_path / "slow.yaml"), "--report", "json")
    wait_for(tmp_path / "out" / "map.bt", process)
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate(timeout=180)
    assert process.returncode == 130, errors
    assert "Traceback" not in errors
    assert "interrupted" in output
    assert len(OccupancyMap.read(tmp_path / "out" / "map.bt").occupied_voxels()) > 0
    assert (tmp_path / "out" / "summary.json").is_file()


@pytest.mark.parametrize("after_s", [0.01, 0.1, 0.3, 0.6])
def test_ctrl_c_before_the_flight_ends_the_program_at_once(after_s: float, tmp_path: Path) -> None:
    program = (
        "from uwsim import cli; install = cli.exit_on_signals\n"
        "cli.exit_on_signals = lambda: (install(), print(flush=True))\n"
        "cli.main()"
    )
    words = [sys.executable, "-c", program, "survey", "lake", "--out", str(tmp_path / "out")]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(words, text=True, preexec_fn=hears_ctrl_c, **pipes) as process:
        process.stdout.readline()  # until main installs its own handler, Python's is in force
        time.sleep(after_s)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=180)
    assert (process.returncode, errors) == (130, "uwsim: interrupted\n")


def test_ctrl_c_while_a_module_is_half_imported_ends_the_program() -> None:
    code = (
        "import os, signal, sys, types; from uwsim.cli import main, program\n"
        "for name in ('uwsim._core', 'uwsim.base.atomic_file'): sys.modules[name] = types.ModuleType(name)\n"
        "program.app = lambda **_: os.kill(os.getpid(), signal.SIGINT)\n"
        "main()"
    )
    ended = uwsim_process(command=[sys.executable, "-c", code])
    assert (ended.returncode, ended.stderr) == (130, "uwsim: interrupted\n")


def test_a_reader_that_stops_reading_does_not_prevent_the_report(tmp_path: Path) -> None:
    subprocess.run(f"{shlex.join([*BLANK, *SHORT, str(tmp_path)])} | true", shell=True, timeout=600, check=True)
    assert {"map.bt", "report.html"} <= {path.name for path in tmp_path.iterdir()}


@pytest.mark.usefixtures("blank_figures")
def test_a_simulation_that_diverges_leaves_the_map_so_far(tmp_path: Path) -> None:
    vehicle, scenario = (assets_folder() / name for name in ("vehicles/rov.yaml", "scenarios/pool.yaml"))
    stiff = re.sub(r"linear_damping:.*", f"linear_damping: {[1e6] * 6}", vehicle.read_text(), count=1)
    (tmp_path / "stiff.yaml").write_text(stiff)
    (tmp_path / "stiff_pool.yaml").write_text(scenario.read_text().replace("model: rov", "model: stiff.yaml"))
    line = error_line(uwsim("survey", str(tmp_path / "stiff_pool.yaml"), "--out", str(tmp_path / "out")))
    assert "diverged" in line
    assert (tmp_path / "out" / "map.bt").is_file()


def test_a_full_disk_gives_one_line_and_no_partial_file(tmp_path: Path) -> None:
    line = error_line(uwsim_process(*SHORT, str(tmp_path), command=BLANK, preexec_fn=files_limited_to(100)))
    assert "map.bt" in line
    assert not any(tmp_path.iterdir())


def test_a_disk_that_is_full_after_the_map_gives_the_summary_and_says_so(tmp_path: Path) -> None:
    result = uwsim_process(*SHORT, str(tmp_path), command=BLANK, preexec_fn=files_limited_to(20_000))
    assert "is complete" in error_line(result)
    assert "coverage" in result.stdout
    assert {path.name for path in tmp_path.iterdir()} >= {"map.bt", "track.npz", "summary.json"}
