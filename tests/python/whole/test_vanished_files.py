"""Folders and files deleted while uwsim writes them: data still in memory are rewritten, other losses are reported."""

import json
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import uwsim
import uwsim.recording
from uwsim import Simulator
from uwsim.campaigns.workers.ledger import Ledger
from uwsim.missions import OwnVehicle, wait
from uwsim.recording import Recorder


def dive_while(call: Callable[[], object]) -> Callable[..., Iterator[object]]:
    """Return a mission that calls a function during its dive."""

    def mission(vehicle: OwnVehicle) -> Iterator[object]:
        vehicle.undock()
        yield wait(1.0)
        call()
        yield wait(1.0)
        vehicle.log("looked")

    return mission


def test_a_flight_whose_folder_is_deleted_has_all_results_in_a_new_one(tmp_path: Path) -> None:
    out = tmp_path / "out"
    flown = uwsim.fly(dive_while(lambda: shutil.rmtree(out)), "pool", out, map=True, report="json")
    events = [json.loads(line)["event"] for line in (out / "log.jsonl").read_text().splitlines()]
    assert events == [event.name for event in flown.events]
    assert events[-2:] == ["looked", "ended"]
    assert {"map.bt", "summary.json", "track-rov.csv"} <= {path.name for path in out.iterdir()}


def test_a_flight_whose_recording_is_deleted_keeps_its_other_results(tmp_path: Path) -> None:
    out, recording = tmp_path / "out", tmp_path / "run.mcap"
    with pytest.raises(FileNotFoundError, match=r"run.mcap': is lost: it was deleted during recording"):
        uwsim.fly(dive_while(recording.unlink), "pool", out, map=True, record=recording, report="json")
    assert {"map.bt", "summary.json", "track-rov.csv", "log.jsonl"} <= {path.name for path in out.iterdir()}


def test_a_recording_that_is_renamed_meanwhile_is_whole(tmp_path: Path) -> None:
    with Simulator("pool") as sim:
        with Recorder(sim, tmp_path / "run.mcap", topics=["odom"]):
            sim.advance(0.5)
            (tmp_path / "run.mcap").rename(tmp_path / "other.mcap")
            sim.advance(0.5)
        assert uwsim.recording.open(tmp_path / "other.mcap").complete


def test_a_deleted_ledger_ends_the_work_at_once(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path)
    ledger.begin({"plan": 1})
    ledger.add(0, {"value": 1})
    ledger.path.unlink()
    with pytest.raises(OSError, match="was deleted during the run, with all finished results"):
        ledger.add(1, {"value": 2})
    ledger.close()
