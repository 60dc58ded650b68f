"""`uwsim validate flights`: a model that flew a log beats the double integrator, and one that did not fails."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from flight_logs import DENSITY_KG_M3, VEHICLE, flown, telemetry
from uwsim.cli.program import app
from uwsim.evidence.validate import run_suite
from uwsim.evidence.validate.logged_flights import LIST

pytest.importorskip("pymavlink", reason="needs the extra mavlink")


def folder_with(folder: Path, *vehicles: str, **others: str) -> Path:
    (folder / "dive.tlog").write_bytes(telemetry(flown()))
    (folder / "slow.yaml").write_text(
        f"builds_on: {VEHICLE}\nname: slow\nquadratic_damping: [3000, 3000, 3000, 30, 30, 30]\n"
    )
    rows = [("dive.tlog", vehicle) for vehicle in vehicles] + list(others.items())
    lines = (f"  - {{file: {file}, vehicle: {vehicle}, density_kg_m3: {DENSITY_KG_M3}}}" for file, vehicle in rows)
    (folder / LIST).write_text("\n".join(["flights:", *lines, ""]))
    return folder


def test_the_model_that_flew_passes_and_one_with_another_drag_does_not(tmp_path: Path) -> None:
    folder = folder_with(tmp_path, VEHICLE, "slow.yaml")
    result = CliRunner().invoke(app, ["validate", "flights", "--data", str(folder), "--json"])
    passed: dict[str, list[bool]] = {}
    for check in json.loads(result.stdout)["flights"]:
        passed.setdefault(check["group"], []).append(check["passed"])
    assert all(passed[f"dive.tlog: {VEHICLE}"]) and not all(passed["dive.tlog: slow.yaml"])
    assert result.exit_code == 1


def test_what_cannot_be_compared_is_named_with_its_reason(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["validate", "flights"])
    assert result.exit_code != 0 and "needs --data FOLDER" in str(result.exception)
    folder_with(tmp_path, **{"gone.tlog": VEHICLE})
    refused = pytest.raises(ValueError, match=r"nothing in .* can be compared")
    with pytest.warns(UserWarning, match=r"gone.tlog is left out: .*No such file"), refused:
        run_suite("flights", data=tmp_path)
