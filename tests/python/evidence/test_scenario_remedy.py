"""`scenario check` names all that a survey lacks, with YAML that, pasted, makes the check pass and the survey fly."""

import json
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import yaml

import uwsim as uw
from command_line import uwsim
from uwsim.evidence.scenario_check import check_file
from uwsim.flight.terminal import Silent
from uwsim.scenario.read.assets import find_yaml

MODEL, MINE = "    model: rov\n", "mine.yaml\n"
BLIND = {"sensors": {"imu": {"kind": "imu"}}, "sonar": None}
FORCES = {"max_force_n": [0, 10, 0], "max_torque_nm": [0, 0, 0]}
NEAR = {"sensors": {"sounder": {"kind": "altitude", "range_max_m": 1, "noise": {"std": 0.01}}}}
OFF = {"sensors": {"sounder": {"kind": "altitude", "on": False}}}
CASES = [
    ("rov", BLIND | FORCES, ["no sonar", "no sensor of kind 'altitude'", "its surge", "heave or pitch", "its yaw"]),
    ("rov", NEAR, ["its altimeter, by which it keeps its height above the bed, reaches 1 m, not 2 m"]),
    ("rov", OFF | {"sonar": None}, ["no sonar", "its altimeter is off"]),
    ("remus100", BLIND | {"fins": {}, "control": {}}, ["no sonar", "'altitude'", "heave or pitch", "its yaw"]),
]


def pool(folder: Path, model: str, **changes: str) -> Path:
    """Write the scenario `pool` with another value of `model:`, and other values of single keys."""
    text = find_yaml("pool", "scenarios").read_text()
    assert text.count(MODEL) == 1
    for key, value in changes.items():
        (old,) = (line for line in text.splitlines() if line.startswith(f"  {key}:"))
        text = text.replace(old, f"  {key}: {value}")
    path = folder / "mine_pool.yaml"
    path.write_text(text.replace(MODEL, model))
    return path


@pytest.mark.parametrize(("case", "in_place"), [(0, False), (1, True), (2, False), (3, True)])
def test_the_yaml_pasted_makes_the_check_pass(tmp_path: Path, case: int, in_place: bool) -> None:
    name, parts, lacks = CASES[case]
    model = yaml.safe_load(find_yaml(name, "vehicles").read_text()) | parts
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(model))
    flow = yaml.safe_dump(model, default_flow_style=True, width=10**6)
    refused = uwsim("scenario", "check", str(pool(tmp_path, f"    model: {flow if in_place else MINE}")))
    assert refused.returncode == 1 and len(refused.stderr.splitlines()) == 1
    assert all(lack in refused.stderr for lack in lacks)
    head, *lines = refused.stdout.splitlines(keepends=True)
    assert head.startswith("# proposed")
    passed = uwsim("scenario", "check", str(pool(tmp_path, "".join(lines))))
    assert passed.returncode == 0, passed.stderr


def test_what_is_pasted_flies_the_survey(tmp_path: Path) -> None:
    name, parts, _ = CASES[0]
    model = yaml.safe_load(find_yaml(name, "vehicles").read_text()) | parts
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(model))
    path = pool(tmp_path, check_file(pool(tmp_path, f"    model: {MINE}")).paste)
    flown = uw.run_survey(path, tmp_path / "out", report="json", screen=Silent())
    assert not flown.ended_early and flown.coverage is not None and flown.coverage > 0.95


@pytest.mark.parametrize(
    ("dump", "key"),
    [(partial(yaml.safe_dump, sort_keys=False), "  model: MODEL"), (json.dumps, '"model": "MODEL"')],
)
def test_the_yaml_is_written_as_the_entry_is_and_keeps_a_set_of_sensors(tmp_path: Path, dump: Any, key: str) -> None:
    scenario = yaml.safe_load(find_yaml("pool", "scenarios").read_text())
    scenario["vehicles"][0]["model"] = "MODEL"
    (tmp_path / "set.yaml").write_text("name: set\nsensors: {compass: {kind: compass}}\n")
    path = tmp_path / "mine_pool.yaml"
    path.write_text(dump(scenario).replace(key, "  model: {builds_on: rov, sonar: null, sensors: set.yaml}"))
    path.write_text(dump(scenario).replace(key, check_file(path).paste.rstrip()))
    passed = check_file(path)
    assert passed.mistakes == () and passed.simulator is not None
    assert {"compass", "altitude"} <= set(passed.simulator.rov.sensors)


def test_the_vehicle_and_the_area_are_refused_at_once(tmp_path: Path) -> None:
    report = check_file(pool(tmp_path, "    model: {builds_on: rov, sonar: null}\n", bed_depth_m="3"))
    assert [line.split(": ")[1][:20] for line in report.mistakes] == ["vehicle 'rov' cannot", "survey.area_m"]
    assert "position_m" in report.paste
