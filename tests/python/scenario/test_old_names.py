"""Cameras and sonars share the names of what they share; the names of an earlier version are read, with a warning."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import pytest

from uwsim import Simulator
from uwsim.campaigns.sweeps.vary import varied
from uwsim.flight.saved_flight import StateFile, read_state
from uwsim.recording.capsule import SCENARIO, pack, unpack
from uwsim.scenario import Scenario, ScenarioError, load, packaged_scenarios
from uwsim.scenario.fingerprint import scenario_fingerprint
from uwsim.scenario.read.assets import assets_folder
from uwsim.scenario.read.old_keys import OldNameWarning, of_an_earlier_version
from uwsim.scenario.read.validated import validated
from uwsim.scenario.schema import PARTS, schema
from uwsim.scenario.spec.camera import CameraMount
from uwsim.scenario.spec.sensor import SensorMount

SONAR = "{model: em2040-04, %s, tilt_deg: 40}"
POOL = (assets_folder() / "scenarios" / "pool.yaml").read_text()


def read(folder: Path, sonar: str) -> Scenario:
    (folder / "small.yaml").write_text(POOL.replace("{model: 2, tilt_deg: 30}", sonar))
    return load(folder / "small.yaml")


def test_old_keys_are_read_with_one_warning_each_that_gives_the_new_one(tmp_path: Path) -> None:
    with pytest.warns(OldNameWarning) as issued:
        old = read(tmp_path, SONAR % "frequency_khz: 400, range_m: 30")
    texts = sorted(str(each.message).split(";")[0] for each in issued)
    assert texts == ["frequency_khz: is now frequency_hz, which is 1000 times the value", "range_m: is now range_max_m"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        new = read(tmp_path, SONAR % "frequency_hz: 400000, range_max_m: 30")
    assert old == new
    assert scenario_fingerprint(old) == scenario_fingerprint(new)


def test_a_fingerprint_counts_renamed_fields_under_their_first_name() -> None:
    """States and checkpoints of earlier versions contain it: this is the one by the code before the renaming."""
    with Simulator("pool", sonar_model="em2040-04", sonar_frequency_hz=400e3) as sim:
        assert scenario_fingerprint(sim.scenario) == "1e1d502e057a763b"


@pytest.mark.parametrize(
    ("sonar", "message"),
    [
        ("frequency_khz: 450", "frequency_hz = 450000 Hz: em2040-04 works at"),
        ("frequency_khz: fast", "frequency_hz = 'fast': must be a number"),
        (
            "frequency_khz: 400, frequency_hz: 400000",
            "frequency_khz: is the old name of frequency_hz: give one of them",
        ),
    ],
)
def test_what_is_wrong_under_an_old_key_is_refused(tmp_path: Path, sonar: str, message: str) -> None:
    with pytest.raises(ScenarioError) as error, warnings.catch_warnings():
        warnings.simplefilter("ignore", OldNameWarning)
        read(tmp_path, SONAR % sonar)
    assert message in str(error.value)


def test_a_camera_has_its_old_name_in_python_too() -> None:
    with pytest.warns(OldNameWarning, match="is now field_of_view_deg"):
        camera = CameraMount(position_m=(0, 0, 0), horizontal_fov_deg=70.0)  # type: ignore[call-arg]
    with pytest.warns(OldNameWarning, match="is now field_of_view_deg"):
        assert camera.horizontal_fov_deg == camera.field_of_view_deg == 70.0  # type: ignore[attr-defined]


def test_old_parameters_and_arguments_are_set_with_a_warning() -> None:
    with pytest.warns(DeprecationWarning, match="sonar_frequency_hz"):
        sim = Simulator("pool", sonar_model="em2040-04", sonar_frequency_khz=400)
    with pytest.warns(OldNameWarning, match=r"rov\.sonar\.range_max_m"):
        sim.parameters["rov.sonar.range_m"] = 12
    assert sim.rov.sonar.model.range_max_m == 12.0
    assert sim.parameters.changes == {"rov.sonar.range_max_m": 12}
    with pytest.warns(OldNameWarning, match="frequency_hz, which is 1000 times"):
        changed = varied(sim.scenario, {"rov.sonar.frequency_khz": 300})
    assert changed.vehicles[0].sonar.frequency_hz == 300e3
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # a saved state is no file of the user's
        sim.parameters.restore({"rov.sonar.range_m": 20})
    assert sim.rov.sonar.model.range_max_m == 20.0


def test_recordings_and_saved_flights_of_an_earlier_version_are_read_without_a_warning(tmp_path: Path) -> None:
    scenario = read(tmp_path, SONAR % "frequency_hz: 400000")
    contents = pack(scenario)
    old = contents[SCENARIO].replace(b'"frequency_hz": 400000', b'"frequency_khz": 400')
    assert old != contents[SCENARIO]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert unpack({**contents, SCENARIO: old}, tmp_path) == scenario
    asked: dict[str, Any] = {"sonar_frequency_khz": 400.0}
    state = StateFile.model_validate({"request": asked, "tick": 1, "state_digest": "", "files": {}})
    assert read_state(state.sealed()).request.sonar_frequency_hz == 400e3


@pytest.mark.parametrize("name", packaged_scenarios())
def test_packaged_scenarios_use_the_current_names(name: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", OldNameWarning)
        load(name)


def test_no_schema_has_two_names_for_a_field_of_view_a_frequency_or_a_range() -> None:
    """Those of all instruments: the alarm `warnings.range_m` is none."""
    found = {key for part in PARTS for key in _keys(schema(part), exclude="WarningLimits")}
    assert {"field_of_view_deg", "frequency_hz", "range_max_m"} <= found
    of_instruments = {"fov", "field_of_view", "frequency"}
    assert {key for key in found if any(part in key for part in of_instruments) and key != "frequencies"} == {
        "field_of_view_deg", "frequency_hz",
    }  # fmt: skip
    assert {key for key in found if key.startswith("range_m")} == {"range_max_m", "range_min_m"}


def _keys(part: Any, exclude: str) -> set[str]:
    if isinstance(part, list):
        return {key for item in part for key in _keys(item, exclude)}
    if not isinstance(part, dict):
        return set()
    own = set(part["properties"]) if isinstance(part.get("properties"), dict) else set()
    return own.union(*(_keys(item, exclude) for name, item in part.items() if name != exclude))


def test_packaged_files_have_no_old_names() -> None:
    texts = [path.read_text() for path in assets_folder().rglob("*.yaml")]
    assert len(texts) > 30
    assert not [text for text in texts if "frequency_khz" in text or "horizontal_fov" in text]


@pytest.mark.parametrize(
    ("mount", "refused"),
    [
        (
            {"kind": "imu", "noise": {"std": 0.1}},
            "angular_velocity [rad/s], linear_acceleration [m/s2], orientation [rad]",
        ),
        ({"kind": "dvl", "noise_std": 0.1}, "beam_velocity [m/s], beam_range [m]"),
        ({"kind": "usbl", "noise": {"std": 0.1}, "channels": {"range": {"std": 1.0}}}, ""),
        ({"kind": "depth", "noise_std": 0.1}, ""),
        ({"kind": "dvl", "noise_std": 0.0}, ""),
    ],
)
def test_one_noise_for_several_units_is_refused(mount: dict[str, Any], refused: str) -> None:
    if not refused:
        validated(SensorMount, mount)
        return
    with pytest.raises(ScenarioError) as error:
        validated(SensorMount, mount)
    assert f"has no single unit: give channels, each with its noise, for {refused}" in str(error.value)
    with of_an_earlier_version():
        validated(SensorMount, mount)
