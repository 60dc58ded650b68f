"""A survey that the scenario's vehicle cannot fly is refused with all that is missing, before anything is written."""

import re
from pathlib import Path

import pytest
import trimesh
import yaml

from command_line import error_line, uwsim
from uwsim.scenario.read.assets import find_yaml

BLIND = {"sensors": {"imu": {"kind": "imu"}}, "sonar": None}
FORCES = {"max_force_n": [0, 10, 0], "max_torque_nm": [0, 0, 0]}
NEAR = {"sensors": {"sounder": {"kind": "altitude", "range_max_m": 1, "noise": {"std": 0.01}}}}


def pool_with(folder: Path, name: str, change) -> Path:
    """Write the scenario `pool` with a changed copy of a packaged vehicle."""
    vehicle = yaml.safe_load(find_yaml(name, "vehicles").read_text())
    change(vehicle)
    (folder / "mine.yaml").write_text(yaml.safe_dump(vehicle))
    scenario = yaml.safe_load(find_yaml("pool", "scenarios").read_text())
    scenario["vehicles"][0] = {"name": "rov", "model": "mine.yaml", "start": "station"}
    path = folder / "pool_of_mine.yaml"
    path.write_text(yaml.safe_dump(scenario))
    return path


@pytest.mark.parametrize(
    ("name", "parts", "missing"),
    [
        (
            "remus100",
            {"sonar": None, "fins": {}, "control": {}},
            ["no sonar", "drives its heave or pitch", "drives its yaw"],
        ),
        ("rov", BLIND | FORCES, ["no sonar", "no sensor of kind 'altitude'", "its surge", "heave or pitch", "its yaw"]),
        ("rov", NEAR, ["its altimeter, by which it keeps its height above the bed, reaches 1 m, not 2 m"]),
    ],
)
@pytest.mark.parametrize("command", [("scenario", "check"), ("survey",), ("fleet", "--tile", "20", "--workers", "0")])
def test_all_that_is_missing_is_reported_and_nothing_written(tmp_path, name, parts, missing, command):
    path = pool_with(tmp_path, name, lambda vehicle: vehicle.update(parts))
    out = () if command[0] == "scenario" else ("--out", str(tmp_path / "out"))
    refused = uwsim(*command, str(path), *out)
    line = error_line(refused)
    assert refused.returncode == 1
    assert re.search(rf"{path}:\d+: vehicle 'rov(_0)?' cannot fly the survey's lanes: ", line)
    assert all(each in line for each in missing)
    assert not (tmp_path / "out").exists()


def test_the_vehicle_and_the_area_are_refused_at_once(tmp_path):
    path = pool_with(tmp_path, "rov", lambda vehicle: vehicle.update(sonar=None))
    path.write_text(re.sub(r"bed_depth_m: \S+", "bed_depth_m: 3", path.read_text()))
    refused = uwsim("scenario", "check", str(path))
    assert [line.split(": ")[3][:11] for line in refused.stderr.splitlines()] == ["vehicle 'ro", "survey.area"]


def test_after_an_error_no_library_complains_of_a_repaired_mesh(tmp_path):
    """manifold3d prints 24 lines at a program's end if an object of it is alive, which an error's frames may keep."""
    parts = [trimesh.creation.box((1.0, 0.6, 0.4)), trimesh.creation.box((0.5, 0.5, 0.5))]
    parts[1].apply_translation((0.4, 0.1, 0.1))
    trimesh.util.concatenate(parts).export(tmp_path / "overlapping.stl")

    def change(vehicle):
        vehicle["mesh"] = str(tmp_path / "overlapping.stl")
        del vehicle["sonar"]

    refused = uwsim("survey", str(pool_with(tmp_path, "rov", change)), "--out", str(tmp_path / "out"))
    assert "united 2 parts that overlapped" in refused.stderr and "it carries no sonar" in refused.stderr
    assert "nanobind" not in refused.stderr
