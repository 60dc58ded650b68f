"""`uwsim compare`: one table of the flights' values over missions and seeds."""

import csv
import json
from pathlib import Path

import pytest

from command_line import error_line
from command_line import uwsim as run_uwsim
from uwsim.flight.compare import compare
from uwsim.missions import goto, wait


def near(vehicle):
    vehicle.undock()
    yield wait(3.0)


def far(vehicle):
    vehicle.undock()
    yield wait(3.0)
    yield from goto(vehicle, (0.0, 4.0, -2.5))


def test_the_table_holds_each_flight_and_what_one_of_them_saw_is_a_share_of_what_all_saw(tmp_path: Path) -> None:
    found = compare({"near": near, "far": far}, "pool", tmp_path, seeds=(3, 1), voxel_m=0.5)
    assert [(row.mission, row.seed) for row in found.rows] == [("near", 3), ("near", 1), ("far", 3), ("far", 1)]
    first, *_, last = found.rows
    assert first.time_s == pytest.approx(3.0)
    assert last.path_m > first.path_m + 4.0 and last.effort_s > first.effort_s
    assert first.seen_m2 < last.seen_m2 and 0.0 < first.seen_share < last.seen_share <= 1.0
    assert last.map_error_m < 0.5 and 0.0 < last.map_coverage <= 1.0
    times_s, areas_m2 = found.curves["far"][0]
    assert areas_m2 == sorted(areas_m2) and areas_m2[-1] == last.seen_m2
    assert times_s[0] == pytest.approx(1.0) and last.half_seen_s <= times_s[-1]
    with (tmp_path / "compare.csv").open() as file:
        assert [row["mission"] for row in csv.DictReader(file)] == ["near", "near", "far", "far"]
    assert json.loads((tmp_path / "compare.json").read_text())["rows"][0]["collisions"] == 0
    assert (tmp_path / "compare.png").stat().st_size > 5000
    assert (tmp_path / "far-1" / "map.bt").is_file()


def test_flights_by_the_estimate_and_with_faults_say_so_and_show_their_error(tmp_path: Path) -> None:
    stuck = {"kind": "sensor", "sensor": "dvl", "mode": "off", "at_s": 1.0}
    compare({"far": far}, "pool", tmp_path, seeds=(1,), voxel_m=0.5, estimate="filter", faults=[stuck])
    values = json.loads((tmp_path / "compare.json").read_text())
    assert values["estimate"] == "filter" and values["faults"] == [stuck]
    assert 0.0 < values["rows"][0]["estimate_rms_m"] < 2.0


def test_the_command_flies_files_and_prints_the_table(tmp_path: Path) -> None:
    mission = tmp_path / "sink.py"
    mission.write_text(
        "from uwsim.missions import wait\ndef mission(vehicle):\n    vehicle.undock()\n    yield wait(2)\n"
    )
    done = run_uwsim("compare", mission, "--scenario", "pool", "--seeds", "5", "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert "sink" in done.stdout and "map coverage [%]" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("mow_the_moon",), "mission 'mow_the_moon': must be a file, or one of unknown_water, frontier"),
        (("--seeds", "1,x"), "--seeds 1,x: must be whole numbers"),
        (("--seeds", "1,1"), "must not contain duplicates"),
        (("frontier", "frontier"), "there is another 'frontier'"),
        (("--by", "guess"), "--by = 'guess': must be one of truth, estimate"),
        (("--fault", "thruster"), "--fault thruster: must be written as in a scenario"),
        (("--fault", "kind: sensor, sensor: dvl, mode: of"), "mode"),
        (("--set", "bound_km=3", "--seeds", "1"), "bound_km"),
    ],
)
def test_mistakes_are_told_before_anything_flies(arguments: tuple[str, ...], message: str, tmp_path: Path) -> None:
    done = run_uwsim("compare", *arguments, "--out", tmp_path / "out")
    assert done.returncode != 0 and message in error_line(done)
    assert not list(tmp_path.glob("out/*-*"))
