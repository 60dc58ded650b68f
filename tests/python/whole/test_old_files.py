"""Files of earlier builds are read, or refused because of their version. data/v1 has the first version of each format.

A later build may compute slightly different results, so equality is not required. A v1 file may become unreadable
only if its version is raised: then the test that reads it is removed, and the one that checks the version stays.
"""

import io
import shutil
import struct
import warnings
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer

from uwsim import Simulator
from uwsim.flight import saved_flight
from uwsim.flight.fly import resume
from uwsim.flight.survey import resume_survey
from uwsim.mapping import OccupancyMap
from uwsim.recording.reader import Recording
from uwsim.recording.replay import replay
from uwsim.scenario.fingerprint import BuildWarning, build_fingerprint, scenario_fingerprint
from uwsim.scoring.survey_track import SurveyTrack

V1 = Path(__file__).parents[1] / "data" / "v1"
pytestmark = pytest.mark.filterwarnings("ignore::uwsim.scenario.fingerprint.BuildWarning")


@pytest.fixture
def v1(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A writable copy, used as the working directory."""
    shutil.copytree(V1, tmp_path / "v1")
    monkeypatch.chdir(tmp_path / "v1")
    return tmp_path / "v1"


def test_a_saved_state_is_restored(v1: Path) -> None:
    with Simulator("scenario.yaml") as sim:
        sim.restore_state((v1 / "simulator.state").read_bytes())
        assert sim.time_s == 2.0
        assert sim.rov.effort[0] == 0.6
        before = sim.rov.pose.position_world_m.copy()
        sim.advance(1.0)
        assert np.linalg.norm(sim.rov.pose.position_world_m - before) > 0.05, "it goes on"


def test_a_saved_estimate_is_restored_and_goes_on(v1: Path) -> None:
    with Simulator("scenario.yaml") as sim:
        sim.restore_state((v1 / "estimate.state").read_bytes())
        estimate = sim.rov.estimate
        assert estimate.time_s == 2.0
        # As when the file was written, by a first-order filter without a vertical field component.
        saved_m, std_m = [-1.52161272, 0.07169189, -2.01342177], [0.06634749, 0.05744256, 0.01897241]
        np.testing.assert_allclose(estimate.pose.position_world_m, saved_m, atol=1e-5)
        np.testing.assert_allclose(estimate.position_std_m, std_m, atol=1e-6)
        sim.advance(1.0)
        error_m = estimate.pose.position_world_m - sim.rov.pose.position_world_m
        assert (np.abs(error_m) < 5.0 * estimate.position_std_m).all()


def test_a_survey_that_was_saved_before_surveys_were_flights_is_refused(v1: Path) -> None:
    with pytest.raises(ValueError, match=r"survey.state': was saved by an earlier uwsim.*fly it again"):
        resume_survey(v1 / "survey", report="none")


def test_a_flight_is_resumed(v1: Path) -> None:
    saved = v1 / "flight" / "checkpoint" / "flight.json"
    saved.write_text(saved.read_text().replace("/srv/v1", str(v1)))
    flown = resume(v1 / "flight", report="none")
    assert flown.ended_because == "the mission is complete"
    assert flown.simulated_s == pytest.approx(10.0)


def test_fields_that_later_builds_append_are_nan_or_empty_in_a_recording() -> None:
    recording = Recording(V1 / "live.mcap")
    messages = [each.message for each in recording.messages("telemetry")]
    assert messages
    for message in messages:
        assert np.isnan([*message.linear_acceleration, *message.angular_acceleration]).all()
        assert np.isfinite([message.depth, message.speed]).all()
        assert list(message.alarms) == list(message.gauges) == list(message.gauge_ages) == []


@pytest.mark.parametrize("name", ["live.mcap", "survey.mcap"])
def test_a_recording_is_read_and_replayed(name: str) -> None:
    recording = Recording(V1 / name)
    assert recording.complete
    assert len(list(recording.messages("odom"))) == pytest.approx(51 if name == "live.mcap" else 150, abs=3)
    assert list(recording.commands())
    assert replay(recording, until_s=0.05).messages


def test_a_recorded_survey_gives_its_map(tmp_path: Path) -> None:
    from uwsim.recording.survey_from import survey_from

    assert survey_from(Recording(V1 / "survey.mcap"), tmp_path / "map.bt", None) == 30
    assert OccupancyMap.read(tmp_path / "map.bt").to_bytes("bt")


def test_a_map_and_a_track_are_read() -> None:
    assert len(OccupancyMap.read(V1 / "map.ot").occupied_voxels()) > 0
    assert len(SurveyTrack.read(V1 / "track.npz").path_world_m) > 0


def test_a_state_of_another_build_is_restored_with_a_warning() -> None:
    with Simulator("pool") as sim:
        of_another = sim._core.save_state(scenario_fingerprint(sim.scenario), "another", sim_notes(sim))
        with pytest.warns(BuildWarning, match=f"another build of uwsim .another, this is {build_fingerprint()}"):
            sim.restore_state(of_another)
        with warnings.catch_warnings():
            warnings.simplefilter("error", BuildWarning)
            sim.restore_state(sim.save_state())


def sim_notes(sim: Simulator) -> str:
    from uwsim import _core

    return _core.saved_notes(sim.save_state(), scenario_fingerprint(sim.scenario), build_fingerprint())


def test_a_state_of_another_version_is_refused_by_its_version(v1: Path) -> None:
    state = bytearray((v1 / "simulator.state").read_bytes())
    at = len(b"uwsim state\n") + 16
    assert struct.unpack_from("<Q", state, at) == (1,)
    struct.pack_into("<Q", state, at, 7)
    struct.pack_into("<Q", state, at - 8, fnv1a(bytes(state[at:])))
    with Simulator("scenario.yaml") as sim, pytest.raises(ValueError, match=r"state.version = 7: must be 1: another"):
        sim.restore_state(bytes(state))


def fnv1a(data: bytes) -> int:
    total = 14695981039346656037
    for byte in data:
        total = (total ^ byte) * 1099511628211 % 2**64
    return total


def test_a_flight_of_another_version_is_refused_by_its_version(v1: Path) -> None:
    path = v1 / "flight" / "checkpoint" / "flight.json"
    path.write_text(path.read_text().replace('"version":1', '"version":99', 1))
    with pytest.raises(ValueError, match=f"json': has version 99: this uwsim reads up to {saved_flight.VERSION}"):
        resume(v1 / "flight")


def test_a_recording_of_another_version_is_refused_by_its_version(tmp_path: Path) -> None:
    buffer = io.BytesIO()
    writer = Writer(buffer)
    writer.start(profile="ros2", library="uwsim")
    with (V1 / "live.mcap").open("rb") as file:
        start = next(each for each in make_reader(file).iter_metadata() if each.name == "uwsim")
    writer.add_metadata("uwsim", {**start.metadata, "version": "99"})
    writer.finish()
    (tmp_path / "new.mcap").write_bytes(buffer.getvalue())
    with pytest.raises(ValueError, match=r"new.mcap': has version 99: this uwsim reads 1"):
        Recording(tmp_path / "new.mcap")


def test_a_field_with_its_default_is_no_part_of_a_scenarios_fingerprint() -> None:
    """Fields added in later versions therefore leave the fingerprints of saved states unchanged."""
    with Simulator("pool") as sim:
        scenario = sim.scenario
    field = next(name for name, info in type(scenario).model_fields.items() if name == "mission_time_s")
    as_default = scenario.model_copy(update={field: type(scenario).model_fields[field].default})
    other = scenario.model_copy(update={field: 1234.5})
    assert scenario_fingerprint(as_default) != scenario_fingerprint(other)
    added = type("Later", (type(scenario),), {"__annotations__": {"later_m": float}, "later_m": 1.5})
    later = added.model_construct(**dict(as_default))
    assert scenario_fingerprint(later) == scenario_fingerprint(as_default)
