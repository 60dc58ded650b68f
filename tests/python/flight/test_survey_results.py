"""The extent of a survey's results, how its map grows in flight, and how it is verified."""

import itertools
import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import uwsim
from command_line import uwsim as run_uwsim
from uwsim import Simulator
from uwsim.flight.coverage import FIRST_S, growth_row
from uwsim.flight.request import FlightRequest
from uwsim.flight.survey import run_survey
from uwsim.mapping import OccupancyMap
from uwsim.missions import goto
from uwsim.scoring.score_map_file import score_map_file, write_score_json

FLOWN = {"map.bt", "track.npz", "track-rov.csv", "log.jsonl"}


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_json_holds_the_flight_and_the_score_of_the_map_file_and_none_neither(tmp_path: Path) -> None:
    record = run_survey("pool", tmp_path / "out", seed=5, mission_time_s=6.0, report="json")
    assert names(tmp_path / "out") == FLOWN | {"summary.json"}
    run_survey("pool", tmp_path / "none", seed=5, mission_time_s=1.0, report="none")
    assert names(tmp_path / "none") == FLOWN
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["seed"] == 5
    assert summary["pings"] == record.ping_count > 0
    assert any("ended early" in warning for warning in summary["warnings"])
    write_score_json(
        tmp_path / "score.json", score_map_file(tmp_path / "out" / "map.bt", "pool", None, (0.0, 0.0, 0.0))
    )
    score = json.loads((tmp_path / "score.json").read_text())
    assert score["precision"] == pytest.approx(1.0, abs=0.05)
    assert {name: summary["map"][name] for name in score} == pytest.approx(score)


class Forgetful(OccupancyMap):
    """A map that omits one scan."""

    seen = itertools.count(1)

    def insert_scan(self, *scan: object) -> None:
        if next(self.seen) != 20:
            super().insert_scan(*scan)  # type: ignore[arg-type]


@pytest.mark.usefixtures("blank_figures")
def test_a_map_that_differs_from_stock_exits_with_1(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FlightRequest, "new_reference", lambda request: Forgetful(resolution_m=request.voxel_m))
    result = run_uwsim("survey", "pool", "--out", tmp_path, "--mission-time", "4", "--verify-map")
    assert result.returncode == 1, result.stderr
    assert "map.bt DIFFERS from that of stock OctoMap" in result.stdout
    assert (tmp_path / "report.html").is_file()


def there(vehicle):
    vehicle.undock()
    yield from goto(vehicle, (0.0, 3.0), altitude_m=2.0)


def test_rows_are_of_the_map_as_it_was_then(tmp_path: Path) -> None:
    sim = Simulator("pool")
    flown = uwsim.fly(there, sim, tmp_path, map=True, voxel_m=0.5, time_limit_s=FIRST_S, report="json")
    assert flown.occupancy is not None
    (row,) = flown.map_growth
    assert row == growth_row(flown.occupancy, sim, FIRST_S), "the flight ends as the row is measured"
    assert json.loads((tmp_path / "summary.json").read_text())["map_growth"] == [row._asdict()]


def test_more_of_the_bed_is_in_the_map_later() -> None:
    flown = uwsim.fly(there, "pool", map=True, voxel_m=0.5, time_limit_s=12.0)
    assert len(flown.map_growth) > 2
    assert all(later.time_s > row.time_s for row, later in pairwise(flown.map_growth))
    assert flown.map_growth[-1].area_m2 > flown.map_growth[0].area_m2
    assert uwsim.fly(there, "pool", time_limit_s=6.0).map_growth == ()


def test_a_row_measures_distances_from_the_true_surface() -> None:
    sim, occupancy = Simulator("pool"), OccupancyMap(resolution_m=0.5)
    assert growth_row(occupancy, sim, 1.0) is None
    x, y = (part.ravel() for part in np.mgrid[-2:2:0.25, 4:8:0.25] + 0.1)
    above_m = 1.0 + sim.world.height_at(np.column_stack([x, y]))
    occupancy.insert_scan(np.column_stack([x, y, above_m]).astype(np.float32), (0.0, 6.0, -0.5))
    row = growth_row(occupancy, sim, 1.0)
    assert row is not None
    assert row.distance_mean_m == pytest.approx(1.0, abs=0.25), "half a voxel"
    assert row.area_m2 == pytest.approx(16.0, rel=0.3)
