"""--verify-map compares the map with that of stock OctoMap byte for byte."""

import itertools
import signal
from pathlib import Path

import pytest

from command_line import start_survey, uwsim, wait_for
from uwsim.flight.request import FlightRequest
from uwsim.flight.survey import resume_survey, run_survey
from uwsim.mapping import OccupancyMap


@pytest.fixture
def no_results(monkeypatch: pytest.MonkeyPatch) -> None:
    """Skip the results: they take longer than the flights and are tested elsewhere."""
    monkeypatch.setattr("uwsim.flight.engine.write_results", lambda flown, *arguments, **more: flown)


@pytest.mark.usefixtures("no_results")
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


class Forgetful(OccupancyMap):
    """A map that omits one scan."""

    seen = itertools.count(1)

    def insert_scan(self, *scan: object) -> None:
        if next(self.seen) != 20:
            super().insert_scan(*scan)  # type: ignore[arg-type]


@pytest.mark.usefixtures("blank_figures")
def test_a_map_that_differs_from_stock_exits_with_1(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FlightRequest, "new_reference", lambda request: Forgetful(resolution_m=request.voxel_m))
    result = uwsim("survey", "pool", "--out", tmp_path, "--mission-time", "8", "--verify-map")
    assert result.returncode == 1, result.stderr
    assert "map.bt DIFFERS from that of stock OctoMap" in result.stdout
    assert (tmp_path / "report.html").is_file()
