"""Saved files carry a version: those of another version are refused by it, those of another build are read."""

import io
import json
import struct
import warnings
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap.writer import Writer

from uwsim import Simulator, _core
from uwsim.recording import Recorder
from uwsim.recording.glance import glance
from uwsim.recording.mcap_sink import START, VERSION
from uwsim.recording.reader import Recording
from uwsim.scenario.fingerprint import BuildWarning, build_fingerprint, scenario_fingerprint


def test_a_state_of_another_build_is_restored_with_a_warning() -> None:
    with Simulator("pool") as sim:
        of_another = sim._core.save_state(scenario_fingerprint(sim.scenario), "another", notes_of(sim))
        with pytest.warns(BuildWarning, match=f"another build of uwsim .another, this is {build_fingerprint()}"):
            sim.restore_state(of_another)
        with warnings.catch_warnings():
            warnings.simplefilter("error", BuildWarning)
            sim.restore_state(sim.save_state())


def notes_of(sim: Simulator) -> str:
    return _core.saved_notes(sim.save_state(), scenario_fingerprint(sim.scenario), build_fingerprint())


def test_a_state_of_another_version_is_refused_by_its_version() -> None:
    with Simulator("pool") as sim:
        state = bytearray(sim.save_state())
        at = len(b"uwsim state\n") + 16
        assert struct.unpack_from("<Q", state, at) == (1,)
        struct.pack_into("<Q", state, at, 7)
        struct.pack_into("<Q", state, at - 8, fnv1a(bytes(state[at:])))
        with pytest.raises(ValueError, match=r"state.version = 7: must be 1: another"):
            sim.restore_state(bytes(state))


def fnv1a(data: bytes) -> int:
    total = 14695981039346656037
    for byte in data:
        total = (total ^ byte) * 1099511628211 % 2**64
    return total


def test_an_estimate_of_another_version_is_refused_by_its_version() -> None:
    with Simulator("pool") as sim:
        sim.rov.undock()
        _ = sim.rov.estimate  # the first access starts the filter
        sim.advance(0.5)
        notes = json.loads(notes_of(sim))
        (name,) = notes["estimates"]
        estimate = json.loads(notes["estimates"][name])
        version = estimate["version"]
        notes["estimates"][name] = json.dumps({**estimate, "version": version - 1})
        other = sim._core.save_state(scenario_fingerprint(sim.scenario), build_fingerprint(), json.dumps(notes))
        with pytest.raises(ValueError, match=rf"state.version = {version - 1}: must be {version}: another version"):
            sim.restore_state(other)


@pytest.mark.parametrize("version", ["99", None])
def test_a_recording_of_another_version_is_refused_by_its_version(version: str | None, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with Simulator("pool") as sim, Recorder(sim, path, topics=["odom"]):
        sim.advance(0.1)
    buffer = io.BytesIO()
    writer = Writer(buffer)
    writer.start()
    with path.open("rb") as file:
        for each in make_reader(file).iter_metadata():
            of_version = {"version": version} if version else {}
            unversioned = {key: value for key, value in each.metadata.items() if key != "version"}
            writer.add_metadata(each.name, unversioned | of_version if each.name == START else each.metadata)
    writer.finish()
    other = tmp_path / "other.mcap"
    other.write_bytes(buffer.getvalue())
    for read in (Recording, glance):
        with pytest.raises(
            ValueError, match=rf"other.mcap': has version {version or 'none'}: this uwsim reads {VERSION}"
        ):
            read(other)


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
