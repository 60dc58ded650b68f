"""Sweeps: varied values, runs, tables and reports, all run in this process."""

import json
import math
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from command_line import error_line, uwsim
from docs_pages import page_named
from uwsim import Simulator
from uwsim.campaigns.sweeps import fly_again, plan_sweep, run_sweep
from uwsim.campaigns.sweeps.check import require_flyable
from uwsim.campaigns.sweeps.design import runs_of, saltelli
from uwsim.campaigns.sweeps.job import Job, fly_job
from uwsim.campaigns.sweeps.rows import Rows
from uwsim.campaigns.sweeps.sensitivity import sensitivity, sobol_indices_of
from uwsim.campaigns.sweeps.spec import read_sweep
from uwsim.campaigns.sweeps.table import TABLE
from uwsim.campaigns.sweeps.vary import varied
from uwsim.campaigns.workers.ledger import LEDGER
from uwsim.mapping import OccupancyMap
from uwsim.scenario import ScenarioError, load
from uwsim.scenario.fingerprint import scenario_fingerprint

MISSION = """
from uwsim.missions import wait

def mission(vehicle, effort=0.5, seconds=2.0):
    if effort > 0.9:
        raise ValueError("too much")
    vehicle.release()
    vehicle.set_effort(surge=effort)
    yield wait(seconds)
    return {"x_m": float(vehicle.pose.position_world_m[0])}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "push.py").write_text(MISSION)
    return tmp_path


def written(folder: Path, text: str) -> Path:
    path = folder / "sweep.yaml"
    path.write_text(text)
    return path


def runs(**values: object) -> list:
    return runs_of(read_sweep(values)[0])


def test_a_grid_has_all_combinations_with_all_seeds() -> None:
    found = runs(
        vary={
            "survey.altitude_m": {"low": 1, "high": 3, "steps": 3},
            "faults": {"choices": {"none": [], "leak": [{"kind": "leak", "at_s": 1, "kg_per_s": 1}]}},
        },
        seeds=[4, 5],
    )
    assert [run.number for run in found] == list(range(12))
    assert [run.seed for run in found[:2]] == [4, 5]
    shown = {(run.levels["survey.altitude_m"].shown, run.levels["faults"].shown) for run in found}
    assert shown == {(z, f) for z in (1.0, 2.0, 3.0) for f in ("none", "leak")}


@pytest.mark.parametrize("method", ["random", "latin_hypercube", "sobol", "saltelli"])
def test_samples_are_in_range_and_follow_from_the_seed(method: str) -> None:
    vary = {
        "a": {"low": 2, "high": 3},
        "b": {"low": 1, "high": 100, "scale": "log"},
        "c": {"low": 1, "high": 4, "whole": True},
        "d": {"choices": ["x", "y"]},
        "e": {"low": 3.1, "high": 16.2, "scale": "lognormal"},
    }
    first, again, other = (
        [{k: v.shown for k, v in run.levels.items()} for run in runs(vary=vary, method=method, samples=64, seed=seed)]
        for seed in (1, 1, 2)
    )
    assert first == again != other
    assert len(first) == (64 * 7 if method == "saltelli" else 64)
    assert all(2 <= s["a"] <= 3 and 1 <= s["b"] <= 100 for s in first)
    assert {s["c"] for s in first} == {1, 2, 3, 4}
    assert {s["d"] for s in first} == {"x", "y"}
    assert 0.35 < np.mean([s["b"] < 10 for s in first]) < 0.65  # about half of the samples are below 10
    deviations = np.log([s["e"] / math.sqrt(3.1 * 16.2) for s in first]) / (math.log(16.2 / 3.1) / 2 / 1.96)
    assert np.abs(deviations).max() <= 1.96 and 0.57 < np.mean(np.abs(deviations) < 1) < 0.86  # 0.683 / 0.95


def test_the_samples_of_each_method_are_laid_out_as_it_says() -> None:
    found = runs(vary={"a": {"low": 0, "high": 16}}, method="latin_hypercube", samples=16, seeds={"first": 7})
    assert sorted(int(run.levels["a"].value) for run in found) == list(range(16)), "one in each slice"
    assert [run.seed for run in found] == list(range(7, 23)), "each with a seed of its own"
    points = saltelli(np.random.default_rng(0).random((4, 6)))
    a, b, *mixed = points.reshape(5, 4, 3)
    for column, part in enumerate(mixed):  # changes one column at a time
        np.testing.assert_array_equal(part[:, column], b[:, column])
        np.testing.assert_array_equal(np.delete(part, column, 1), np.delete(a, column, 1))


def test_parameters_and_keys_give_what_the_file_would_say() -> None:
    base = load("pool")
    changed = varied(base, {"rov.drag.linear.surge": 55.0, "survey.area_m[0][1]": -3.0, "terrain.seed": 5})
    with Simulator(base) as sim:
        sim.parameters["rov.drag.linear.surge"] = 55.0
        assert changed.vehicles == sim.parameters.scenario.vehicles
    assert changed.survey is not None and changed.survey.area_m[0] == (-4.0, -3.0)
    assert changed.terrain.seed == 5
    assert scenario_fingerprint(changed) != scenario_fingerprint(base)


def test_every_mistake_is_told_with_its_line(folder: Path) -> None:
    path = written(
        folder,
        "scenario: pool\n"
        "vary:\n"
        "  survey.altitud_m: {low: 1, high: 2, steps: 2}\n"
        "  survey.altitude_m: {low: 1, high: 900, steps: 2}\n"
        "  rov.mass_kg: {choices: [280, heavy]}\n",
    )
    with pytest.raises(ScenarioError) as raised:
        run_sweep(path, folder / "out", workers=0)
    first, second, third = raised.value.mistakes
    assert "sweep.yaml:3: vary: survey.altitud_m: neither a parameter" in first
    assert "did you mean 'survey.altitude_m'?" in first
    assert "sweep.yaml:4: vary: survey.altitude_m = 900 m: must be in [0.5, 500] m" in second
    assert "sweep.yaml:5: vary: rov.mass_kg = 'heavy': must be a number" in third
    assert not (folder / "out").exists()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("method: sobol\nsamples: 100\nvary: {a: {low: 0, high: 1}}", "samples = 100: must be a power of two"),
        ("method: random\nvary: {a: {low: 0, high: 1}}", "samples: must be given for `method: random`"),
        ("samples: 3", "samples: has no effect on a grid"),
        ("vary: {a: {low: 0, high: 1}}", "vary.a.steps: must be given on a grid"),
        ("vary: {a: {low: 2, high: 1, steps: 2}}", r"high = 1: must be greater than low \(2\)"),
        ("vary: {a: {low: 2}}", "vary.a: must have low and high, or choices"),
        ("vary: {a: {choices: [1], whole: true}}", "is for low and high, not for choices"),
        ("time_limit_s: 3", "time_limit_s: is for a mission, not for a survey"),
        ("mision: a.py", "mision: unknown key; did you mean 'mission'"),
        ("retries: -1", r"retries = -1: must be in \[0, 100\]"),
    ],
)
def test_a_sweep_that_makes_no_sense_is_refused(folder: Path, text: str, message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        read_sweep(written(folder, text))


def test_a_run_that_fails_is_a_row_with_its_error(folder: Path) -> None:
    path = written(
        folder,
        "scenario: pool\nmission: push.py\nvary:\n  mission.effort: {low: 0.2, high: 1.0, steps: 3}\n"
        "  faults: {choices: {none: [], weak: [{kind: thruster, axis: surge, at_s: 0, health: 0.5}]}}\n",
    )
    flown = run_sweep(path, folder / "out", workers=0, report=False)
    table = pd.read_parquet(folder / "out" / TABLE)
    assert len(table) == 6 and flown.failed == 2
    failed = table[table["mission.effort"] == 1.0]
    assert failed["error"].str.contains(r"push.py:6: too much \(in mission\)").all()
    good = table[table["error"].isna()].set_index(["mission.effort", "faults"])["result.x_m"]
    assert good[0.6, "none"] > good[0.2, "none"]  # a larger effort pushes the vehicle farther
    assert good[0.6, "weak"] != good[0.6, "none"]
    assert (table["scenario_digest"].nunique(), table["build"].nunique()) == (2, 1)


def test_a_mission_that_hangs_is_ended(folder: Path) -> None:
    (folder / "hang.py").write_text("def mission(vehicle):\n    while True: pass\n    yield\n")
    flown = run_sweep(
        {"scenario": "pool", "mission": str(folder / "hang.py"), "wall_limit_s": 0.2}, folder / "out", workers=0,
        report=False,
    )  # fmt: skip
    assert flown.rows.rows[0]["error"] == "took longer than wall_limit_s = 0.2 s"


@pytest.mark.usefixtures("blank_figures")
def test_a_report_links_the_worst_run_flown_again(folder: Path) -> None:
    path = written(
        folder,
        "scenario: pool\nmission: push.py\nmap: true\nvoxel_m: 0.5\n"
        "vary: {mission.effort: {choices: [0.8, 0.1, 0.3, 1.0]}}\n"
        "objective: {metric: result.x_m, best: high}\nworst: 1\nrequire: {collisions: {high: 0}, coverage: {low: 2}}\n",
    )
    flown = run_sweep(path, folder / "out", workers=0)
    assert flown.missed == {"collisions": 1, "coverage": 4}  # the failed run has neither value, so counts in both
    page = (folder / "out" / "report.html").read_text()
    for name in ("report.html", "run.mcap", "map.bt", "scenario.yaml"):
        assert (folder / "out" / "worst" / "000001" / name).exists()
        assert f'href="worst/000001/{name}"' in page
    assert "too much" in page and "1 runs failed" in page
    assert page.count("data:image/png") == 2  # three successful runs are too few for sensitivities


def test_a_run_of_a_survey_flown_again_has_the_same_map(folder: Path) -> None:
    path = written(
        folder,
        "scenario: pool\nvary: {survey.altitude_m: {choices: [2.0, 2.5]}, mission_time_s: {choices: [8]}}\n"
        "seeds: {first: 3}\nvoxel_m: 0.5\n",
    )
    run_sweep(path, folder / "out", workers=0, report=False)
    row = pd.read_parquet(folder / "out" / TABLE).iloc[1]
    assert fly_again(path, 1, folder / "again", report="none") == []
    assert scenario_fingerprint(load(folder / "again" / "scenario.yaml")) == row["scenario_digest"]
    assert OccupancyMap.read(folder / "again" / "map.bt").statistics().occupied_voxels == row["occupied_voxels"]
    assert row["seed"] == 4 and row["occupied_voxels"] > 0


def test_resuming_flies_what_is_missing_and_no_more(folder: Path) -> None:
    sweep = {
        "scenario": "pool", "mission": str(folder / "push.py"), "vary": {"mission.effort": {"choices": [0.1, 0.2, 0.3]}}
    }  # fmt: skip
    whole = run_sweep(sweep, folder / "whole", workers=0, report=False)
    out, seen = folder / "out", []
    part = run_sweep(
        sweep, out, workers=0, report=False, tell=lambda done, *_: seen.append(done), stop_requested=lambda: 1 in seen
    )
    assert part.interrupted and len(pd.read_parquet(out / TABLE)) == 1
    with (out / LEDGER).open("ab") as ledger:
        ledger.write(b'{"job": 1, "metr')  # a partial line, as left by a kill
    with pytest.raises(ValueError, match="holds a sweep already, 1 runs of it finished: --resume"):
        run_sweep(sweep, out, workers=0)
    with pytest.raises(ValueError, match=r"--resume: .*sweep is .*: was begun with"):
        run_sweep({**sweep, "time_limit_s": 5.0}, out, workers=0, resume=True)
    lines = (out / LEDGER).read_text().splitlines()
    done = run_sweep(sweep, out, workers=0, report=False, resume=True)
    assert (out / LEDGER).read_text().splitlines()[:2] == lines[:2]
    wall = ["run_wall_s", "flight_wall_s"]
    one, other = (pd.DataFrame(each.rows.rows).drop(columns=wall) for each in (done, whole))
    assert one.equals(other)


def test_a_metric_that_does_not_exist_is_refused_after_one_run(folder: Path) -> None:
    text = (
        "scenario: pool\nmission: push.py\nvary: {mission.effort: {low: 0.1, high: 0.5, steps: 50}}\n"
        "objective: {metric: result.y_m, best: high}\nrequire: {colisions: {high: 0}}\nshow: [simulated_s, time_s]\n"
    )
    lines = (
        r"sweep.yaml:5: require = colisions: run 0 has no such metric; did you mean 'collisions'",
        r"sweep.yaml:6: show = time_s: run 0 has no such metric",
        r"sweep.yaml:4: objective.metric = result.y_m: run 0 has no such metric; did you mean 'result.x_m'",
    )
    path, out = written(folder, text), folder / "out"
    with pytest.raises(ScenarioError) as refused:
        plan_sweep(path)
    assert all(re.search(line, "\n".join(refused.value.mistakes)) for line in lines)
    with pytest.raises(ScenarioError) as refused:
        run_sweep(path, out, workers=0)
    assert all(re.search(line, "\n".join(refused.value.mistakes)) for line in lines)
    assert len((out / LEDGER).read_text().splitlines()) == 2  # the plan, and one run
    with pytest.raises(ScenarioError, match="colisions"):  # before another run
        run_sweep(path, out, workers=0, resume=True)
    assert len((out / LEDGER).read_text().splitlines()) == 2
    text = text.replace("result.y_m", "result.x_m").replace("colisions", "collisions").replace(", time_s", "")
    seen: list[int] = []
    part = run_sweep(
        written(folder, text), out, workers=0, report=False, resume=True, tell=lambda done, *_: seen.append(done),
        stop_requested=lambda: seen[-1:] == [3],
    )  # fmt: skip
    assert seen == [1, 2, 3] and [row["run"] for row in part.rows.rows] == [0, 1, 2]


def test_a_plan_estimates_the_cost_of_all_runs(folder: Path) -> None:
    path = written(
        folder,
        "scenario: pool\nmission: push.py\nvary: {mission.effort: {low: 0.2, high: 1.0}}\nmethod: latin_hypercube\n"
        "samples: 10000\n",
    )
    plan = plan_sweep(path)
    assert plan.runs == 10_000 and plan.tried == (0, 5000, 9999) and not (folder / "out").exists()
    assert plan.total_s == pytest.approx(10_000 * sum(plan.processor_s) / 3) and plan.total_s > 1.0
    assert "result.x_m" in plan.metrics and 100 < plan.row_bytes < 10_000 and plan.memory_bytes > 1e7


def test_what_failed_may_be_tried_again(folder: Path) -> None:
    fails = folder / "fails.py"
    flag = folder / "mended"
    fails.write_text(
        "from pathlib import Path\nfrom uwsim.missions import wait\n"
        f"def mission(vehicle):\n    yield wait(0.1)\n    if not Path({str(flag)!r}).exists(): raise ValueError('no')\n"
    )
    sweep = {"scenario": "pool", "mission": str(fails)}
    assert run_sweep(sweep, folder / "out", workers=0, report=False).failed == 1
    flag.touch()
    assert run_sweep(sweep, folder / "out", workers=0, report=False, resume=True).failed == 1
    assert run_sweep(sweep, folder / "out", workers=0, report=False, resume=True, retry_failed=True).failed == 0


def test_a_jobs_values_do_not_depend_on_what_was_flown_before() -> None:
    job = Job("pool", 3, {"survey.altitude_m": 1.5, "mission_time_s": 8.0}, voxel_m=0.5)
    first = fly_job(job)
    fly_job(Job("pool", 4, {"terrain.bed_depth_m": 6.0, "mission_time_s": 8.0}, voxel_m=0.5))
    assert first["error"] is None
    assert fly_job(job)["metrics"] == first["metrics"]


def rows_of(function, **vary: object) -> tuple[Rows, object]:
    spec = read_sweep({"vary": vary, "method": "saltelli", "samples": 4096})[0]
    every = runs_of(spec)
    results = {
        run.number: {"metrics": {"y": function(**{k: v.value for k, v in run.levels.items()})}, "error": None}
        for run in every
    }
    return Rows.of(every, results, {"build": ""}), spec


def test_sobol_indices_are_those_of_the_ishigami_function() -> None:
    """Ishigami and Homma (1990), a = 7, b = 0.1: S1 = 0.314, 0.442, 0; ST = 0.558, 0.442, 0.244."""
    angle = {"low": -np.pi, "high": np.pi}
    rows, spec = rows_of(
        lambda a, b, c: np.sin(a) + 7.0 * np.sin(b) ** 2 + 0.1 * c**4 * np.sin(a), a=angle, b=angle, c=angle
    )
    found = sobol_indices_of(spec, rows, ["y"])
    np.testing.assert_allclose([index.first_order for index in found], [0.314, 0.442, 0.0], atol=0.06)
    np.testing.assert_allclose([index.total_order for index in found], [0.558, 0.442, 0.244], atol=0.06)


def test_rank_correlation_and_share_of_what_decides_alone() -> None:
    rows, _ = rows_of(
        lambda a, b: -(a**3) if b == "x" else -(a**3) + 1e-9, a={"low": 1, "high": 2}, b={"choices": ["x", "y"]}
    )
    found = sensitivity(rows, ["y"])
    assert found.kinds == ["rank", "share"]
    assert found.values[0, 0] == pytest.approx(-1.0, abs=1e-6)
    assert found.values[0, 1] < 0.05


def test_the_sweeps_of_the_page_are_accepted(folder: Path) -> None:
    page = page_named("sweeps").read_text()
    (folder / "mow.py").write_text(page.split("```python\n# mow.py\n")[1].split("```")[0])
    for name in ("overlap", "nightly"):
        text = page.split(f"```yaml\n# {name}.yaml\n")[1].split("```")[0]
        require_flyable(*read_sweep(written(folder, text)))


def test_the_command_says_what_it_did(folder: Path) -> None:
    (folder / "stop.py").write_text(
        "from uwsim.missions import StoppedError, wait\n"
        "def mission(vehicle, far=1):\n    yield wait(1.0)\n    if far > 2: raise ValueError('too much')\n"
        "    if far > 1: raise StoppedError('no way on')\n    return 1.0\n"
    )
    text = "scenario: pool\nmission: stop.py\nvary: {mission.far: {choices: [1, 2, 2, 3]}}\n"
    path = written(folder, f"{text}objective: {{metric: result, best: high}}\nshow: [result]\nworst: 0\n")
    words = ("sweep", path, "--out", folder / "out", "--workers", "0")
    done = uwsim(*words)
    assert done.returncode == 1
    assert "4 of 4 runs, 1 failed, 2 ended early" in done.stdout
    assert "run 1 ended early: no way on" in done.stderr
    assert "run 3: " in done.stderr and "too much" in done.stderr and "Traceback" not in done.stderr
    assert "2 runs have no result, the objective" in done.stderr
    page = (folder / "out/report.html").read_text()
    assert "2 runs have no result: figures and ranking are of the others." in page
    assert "2 x, first run 1" in page and "no way on" in page
    assert "holds a sweep already, 4 runs of it finished" in error_line(uwsim(*words))
    plan, *results = [json.loads(line) for line in (folder / "out" / LEDGER).read_text().splitlines()]
    assert len(results) == 4 and "sweep" in plan["plan"]


def test_a_result_that_a_mission_does_not_always_return_is_looked_for_in_the_next_run(folder: Path) -> None:
    mission = "def mission(vehicle, which=0):\n    yield from ()\n    return {'x_m': 1.0} if which else None\n"
    (folder / "some.py").write_text(mission)
    vary = {"mission.which": {"choices": [0, 1, 1, 1]}}
    sweep = {"scenario": "pool", "mission": str(folder / "some.py"), "vary": vary}
    run_sweep({**sweep, "show": ["result.x_m"]}, folder / "good", workers=0, report=False)
    with pytest.raises(ScenarioError, match=r"show = result\.y_m: run 1 has no such metric"):
        run_sweep({**sweep, "show": ["result.y_m"]}, folder / "bad", workers=0, report=False)
