"""Checks, suites and the command of the validation. The suites that take long are run by tools/docs alone."""

import json
import math
import subprocess
import time
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from command_line import UWSIM
from uwsim.cli.program import app
from uwsim.evidence import validate
from uwsim.evidence.validate.check import Check, along, relative, within
from uwsim.evidence.validate.report import print_checks
from waiting import until


def test_errors_are_relative_to_their_scale_and_a_nan_is_a_miss() -> None:
    assert relative("g", "n", 2.0, 2.1, 0.04).error == pytest.approx(0.05)
    assert not relative("g", "n", 2.0, 2.1, 0.04).passed
    assert within("g", "n", 0.0, 0.1, 10.0, 0.02).passed
    worst = along("g", "n", [1.0, 2.0, 3.0], [1.0, 2.5, 3.1], 2.0, 0.3)
    assert (worst.expected, worst.got, worst.error, worst.passed) == (2.0, 2.5, 0.25, True)
    assert not relative("g", "n", 1.0, math.nan, 1.0).passed
    assert not along("g", "n", [1.0, 2.0], [1.0, math.nan], 1.0, 1.0).passed


def test_in_a_pipe_each_check_is_one_line_with_its_group(capsys: pytest.CaptureFixture[str]) -> None:
    quantity = "a quantity whose name and conditions together are longer than a narrow terminal's line, at 20 deg C"
    print_checks([relative("group", f"{quantity}, {k}", 1.0, 1.0, 0.1) for k in range(3)], "suite")
    lines = capsys.readouterr().out.splitlines()
    for k in range(3):
        assert sum("group" in line and f"{quantity}, {k}" in line and "ok" in line for line in lines) == 1


@pytest.fixture
def extra(monkeypatch: pytest.MonkeyPatch) -> list[Check]:
    """Replace all suites by two that yield one passing check each; return a list of further checks for both."""
    extra: list[Check] = []

    def run() -> list[Check]:
        return [along("g", "good", [1.0, 1.0], [1.0, 1.0], 1.0, 0.1, x=[0.0, 1.0]), *extra]

    monkeypatch.setattr(validate, "SUITES", {name: validate.SUITES[name] for name in ("dynamics", "link")})
    monkeypatch.setattr("uwsim.evidence.cli.validate.BY_DEFAULT", list(validate.SUITES))
    for module in validate.SUITES.values():
        monkeypatch.setattr(f"{module}.run", run)
    return extra


def test_the_command_prints_a_table_draws_curves_and_fails_on_a_miss(extra: list[Check], tmp_path: Path) -> None:
    passed = CliRunner().invoke(app, ["validate", "--jobs", "1", "--out", str(tmp_path / "new")])
    assert passed.exit_code == 0
    assert "good" in passed.output and "all within tolerance" in passed.output
    assert (tmp_path / "new" / "dynamics.png").exists()
    page = (tmp_path / "new" / "index.md").read_text()
    assert (
        "## dynamics" in page
        and "## link" in page
        and "| g | good | 1 | 1 | 0.0e+00 | 1e-01 | ok |" in page
        and "(dynamics.png)" in page
    )
    extra.append(relative("g", "bad", 1.0, 2.0, 0.1))
    missed = CliRunner().invoke(app, ["validate", "dynamics", "--out", str(tmp_path)])
    assert missed.exit_code == 1
    assert "MISS" in missed.output and "1 missed" in missed.output
    as_json = CliRunner().invoke(app, ["validate", "dynamics", "--out", str(tmp_path), "--json"])
    assert as_json.exit_code == 1
    rows = json.loads(as_json.stdout)["dynamics"]
    assert [row["passed"] for row in rows] == [True, False] and "curve" not in rows[0]


def test_an_unknown_suite_is_refused_with_a_list_of_the_known_ones() -> None:
    with pytest.raises(ValueError, match="'optics': unknown; there are: dynamics"):
        validate.run_suite("optics")


QUICK = ("dynamics", "tether", "imaging", "camera", "link", "sound")
WIDE = {"sun's light on a bed": 0.2, "sonar equation": 0.25, "checkerboard": 0.1, "BELLHOP": 0.5}
"""Groups of rows whose tolerance is wider than 5 %, and the tolerance: dB, pixels, or a number of arrivals."""


@pytest.mark.parametrize("suite", QUICK)
def test_a_quick_suite_passes_and_each_of_its_rows_is_a_miss_5_percent_off(suite: str) -> None:
    """A limit is missed by 5 % more than it, a row of WIDE by more than its tolerance."""
    checks = validate.run_suite(suite)
    assert checks and [check for check in checks if not check.passed] == []
    for check in checks:
        wide = next((share for group, share in WIDE.items() if check.group.startswith(group)), 0.05)
        off = 1.05 if check.name.endswith(" at most") else 1.001 * wide
        assert not replace(check, error=off).passed and not replace(check, error=math.nan).passed, check


def test_a_suite_in_a_process_of_its_own_has_the_same_checks() -> None:
    here, there = (dict(validate.run_suites(["link"], None, jobs)) for jobs in (1, 2))
    assert there == here


def test_sigterm_ends_the_processes_of_all_suites() -> None:
    command = subprocess.Popen([*UWSIM, "validate", "control", "estimation", "--jobs", "2"], stderr=subprocess.DEVNULL)
    children = Path(f"/proc/{command.pid}/task/{command.pid}/children")
    while len(pids := children.read_text().split()) < 3:  # two workers, and the process that cleans up after them
        assert command.poll() is None
        time.sleep(0.05)
    command.terminate()
    assert command.wait(timeout=600) == 130
    until(lambda: not any(Path(f"/proc/{pid}").exists() for pid in pids))
