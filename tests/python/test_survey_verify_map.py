"""--verify-map compares the map with stock OctoMap's byte for byte."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from command_line import start_survey, wait_for
from uwsim.flight.survey import resume_survey, run_survey


@pytest.fixture(autouse=True)
def no_results(monkeypatch: pytest.MonkeyPatch) -> None:
    """Skip the results: they take longer than the flights, and other tests cover them."""
    monkeypatch.setattr("uwsim.flight.engine.write_results", lambda flown, *arguments, **more: flown)


def test_a_map_is_verified_on_request_even_when_resumed(tmp_path: Path) -> None:
    assert run_survey("pool", tmp_path / "a", mission_time_s=3.0, verify_map=True).verified is True
    assert run_survey("pool", tmp_path / "b", mission_time_s=3.0).verified is None
    out = tmp_path / "out"
    process = start_survey(out, "pool", "--verify-map")
    wait_for(out / "checkpoint" / "flight.json", process)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    assert list((out / "checkpoint").glob("reference-*.ot"))
    assert resume_survey(out).verified is True


def test_a_map_that_differs_from_stock_exits_with_1(tmp_path: Path) -> None:
    """The reference omits one scan."""
    program = (
        "from uwsim.flight.request import FlightRequest; from uwsim.mapping import OccupancyMap as M\n"
        "from uwsim.cli import main\n"
        "class Forgetful(M):\n"
        "    seen = 0\n"
        "    def insert_scan(self, *scan):\n"
        "        Forgetful.seen += 1\n"
        "        if Forgetful.seen != 20: super().insert_scan(*scan)\n"
        "FlightRequest.new_reference = lambda request: Forgetful(resolution_m=request.voxel_m)\n"
        "main()"
    )
    command = [sys.executable, "-c", program, "survey", "pool", "--out", str(tmp_path), "--mission-time", "8"]
    result = subprocess.run([*command, "--verify-map"], capture_output=True, text=True, timeout=600, check=False)
    assert result.returncode == 1, result.stderr
    assert "map.bt DIFFERS from that of stock OctoMap" in result.stdout
    assert (tmp_path / "report.html").is_file()
