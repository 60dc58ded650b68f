"""`uwsim compare`: one table of the flights' values over missions and seeds."""

import csv
import json
import shlex
from dataclasses import replace
from pathlib import Path

import pytest

from command_line import error_line
from command_line import uwsim as run_uwsim
from uwsim.base.sockets import registered
from uwsim.flight.benchmark import load_benchmark
from uwsim.flight.compare import Row, compare
from uwsim.flight.paired import paired, without_randomness
from uwsim.missions import goto, wait
from uwsim.scenario.read.assets import packaged_names

GUIDE = (Path(__file__).parents[3] / "docs/guides/compare.md").read_text()


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


def test_a_resumed_comparison_flies_only_what_is_missing_and_gives_the_same_table(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("uwsim.figures.comparison.draw_comparison", lambda *_: None)
    flown: list[int] = []

    def counted(vehicle):
        flown.append(1)
        vehicle.undock()
        yield wait(1.0)

    missions = {"near": counted, "again": counted}
    once = compare(missions, "pool", tmp_path / "once", seeds=(1, 2), voxel_m=0.5)
    compare(missions, "pool", tmp_path / "twice", seeds=(1,), voxel_m=0.5)
    flown.clear()
    twice = compare(missions, "pool", tmp_path / "twice", seeds=(1, 2), voxel_m=0.5, resume=True)
    assert len(flown) == 2
    assert repr(twice.rows) == repr(once.rows)
    assert (tmp_path / "twice/compare.csv").read_bytes() == (tmp_path / "once/compare.csv").read_bytes()
    assert without_randomness(twice.rows) == ["near", "again"]  # still water, steered by the truth


ROW = Row("a", 0, "end", 1.0, 1.0, 1.0, 1.0, 0, 0.0, 1.0, 1.0, 1.0, 0.5, 0.1, float("nan"))


def test_pairs_share_their_seed_and_the_interval_is_that_of_order_statistics() -> None:
    offsets = [3.0, 1.0, 2.0, -1.0, 5.0, 4.0, 6.0]
    rows = [replace(ROW, seed=seed, time_s=100.0 * seed) for seed in range(7)]
    rows += [replace(ROW, mission="b", seed=s, time_s=100.0 * s + d) for s, d in reversed(list(enumerate(offsets)))]
    (found,) = paired(rows, ["time_s"])
    # with n = 7, P(all on one side of the median) = 2^-6 < 5 %, and P(all but one) = 16 2^-7 > 5 %: lowest and highest
    assert (found.median, found.low, found.high, found.wins, found.losses) == (3.0, -1.0, 6.0, 1, 6)
    (five,) = paired([row for row in rows if row.seed < 5], ["time_s", "off_target_m"])  # unknown
    assert five.seeds == 5 and five.low != five.low  # 2 (1/2)^5 > 5 %: no interval exists
    assert without_randomness(rows) == []


@pytest.mark.parametrize(
    ("less", "wins"),
    [
        ({"seen_m2": 0.0}, 0),  # it did nothing
        ({"ended_early": True}, 0),
        ({"seen_m2": 49.0}, 2),  # as much, but for 2 %
        ({"off_target_m": 4.0}, 0),
        ({"off_target_m": 0.5, "seen_m2": 0.0}, 2),  # what it saw is not its task
    ],
)
def test_a_flight_that_achieved_less_does_not_win_by_its_haste(less: dict[str, float], wins: int) -> None:
    whole = replace(ROW, seen_m2=50.0, time_s=100.0, off_target_m=0.5 if "off_target_m" in less else float("nan"))
    rows = [replace(whole, seed=seed) for seed in (1, 2)]
    hasty = {"mission": "b", "time_s": 5.0, "path_m": 0.5, "effort_s": 0.1, "collisions": 0} | less
    rows += [replace(row, **hasty) for row in rows]
    for ordered, of in ((rows, "wins"), (rows[2:] + rows[:2], "losses")):
        found = {pair.value: pair for pair in paired(ordered)}
        for value in ("time_s", "path_m", "effort_s"):
            other = "losses" if of == "wins" else "wins"
            assert (getattr(found[value], of), getattr(found[value], other)) == (wins, 0), value
        assert found["time_s"].median == (-95.0 if of == "wins" else 95.0)


def test_a_benchmark_is_flown_under_its_conditions_and_makes_one_file(tmp_path: Path) -> None:
    for name in packaged_names("benchmarks"):
        task = load_benchmark(name)
        assert task.name == name and f"`{name}`" in GUIDE
        assert task.baseline == "survey" or task.baseline in registered("uwsim.kinds.planner")
        one, two = task.scenario_of(1), task.scenario_of(2)
        assert (one.terrain.seed != two.terrain.seed) == task.seeds_terrain and two.seed == 2
    mine = tmp_path / "mine.yaml"
    mine.write_text(
        "{name: mine, version: 3, task: sink, scenario: pool, baseline: keep_place, voxel_m: 0.5, time_limit_s: 2,"
        " target_m: [-6, 0, -2], last_s: 1, values: [off_target_m]}"
    )
    options = ("--held-out", "--seeds", "1003-1003", "--out", tmp_path)
    done = run_uwsim("compare", "--benchmark", mine, *options)
    assert done.returncode == 0, done.stderr
    found = json.loads((tmp_path / "submission.json").read_text())
    assert (found["benchmark"], found["version"], found["held_out"]) == ("mine", 3, True)
    assert found["missions"] == {"keep_place": "packaged"} and found["rows"][0]["seed"] == 1003
    assert 0.0 < found["rows"][0]["off_target_m"] < 5.0  # it has just left the dock


def test_flights_by_the_estimate_and_with_faults_say_so_and_show_their_error(tmp_path: Path) -> None:
    stuck = {"kind": "sensor", "sensor": "dvl", "mode": "off", "at_s": 1.0}
    compare({"far": far}, "pool", tmp_path, seeds=(1,), voxel_m=0.5, estimate="filter", faults=[stuck])
    values = json.loads((tmp_path / "compare.json").read_text())
    assert values["estimate"] == "filter" and values["faults"] == [stuck]
    assert 0.0 < values["rows"][0]["estimate_rms_m"] < 2.0


def test_the_command_flies_files_and_prints_the_table(tmp_path: Path) -> None:
    mission = tmp_path / "sink.py"
    words = ("compare", mission, "--scenario", "pool", "--seeds", "5-5", "--out", tmp_path / "out")
    text = "from uwsim.missions import wait\ndef mission(vehicle):\n    vehicle.undock()\n    yield wait(2)\n"
    mission.write_text(text)
    done = run_uwsim(*words)
    assert done.returncode == 0, done.stderr
    assert "sink" in done.stdout and "map coverage [%]" in done.stdout
    assert "sink, seed 5: 2 s" in done.stdout  # a line after each flight, before the table
    mission.write_text(text.replace("wait(2)", "wait(3)"))
    changed = run_uwsim(*words, "--resume")
    assert changed.returncode != 0 and "mission, scenario, options or build have changed" in error_line(changed)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("mow_the_moon", "mission 'mow_the_moon': must be a file, or one of unknown_water, frontier"),
        ("--seeds 1,x", "--seeds 1,x: must be how many, such as 30, or a list"),
        ("--seeds 1,1", "must not contain duplicates"),
        ("frontier frontier", "there is another 'frontier'"),
        ("--by guess", "--by = 'guess': must be one of truth, estimate"),
        ("--fault thruster", "--fault thruster: must be written as in a scenario"),
        ("--fault 'kind: sensor, sensor: dvl, mode: of'", "mode"),
        ("--set bound_km=3 --seeds 1", "bound_km"),
        ("--held-out", "--held-out: needs --benchmark"),
        ("--benchmark moon", "unknown benchmark 'moon': expected one of cave-next-best-view, dock-in-current"),
        ("--benchmark pipe-follow --by truth", "--by: is set by the benchmark pipe-follow"),
        ("--benchmark pipe-follow --seeds 1000-1002", "held-out seeds are 1000 to 1029, and only with"),
        ("--benchmark pipe-follow --held-out --seeds 5", "held-out seeds are 1000 to 1029, and only with"),
    ],
)
def test_mistakes_are_told_before_anything_flies(arguments: str, message: str, tmp_path: Path) -> None:
    done = run_uwsim("compare", *shlex.split(arguments), "--out", tmp_path / "out")
    assert done.returncode != 0 and message in error_line(done)
    assert not list(tmp_path.glob("out/*-*"))
