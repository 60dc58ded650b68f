"""Flights at the station: recorded unasked, found again, replayed as a session that only its time line commands."""

import errno
import json
import os
import re
import shutil
import threading
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from browser import until
from flown import fly
from station_pages import page, serving
from uwsim.live import LiveSimulator
from uwsim.operator.station.flights import flights as kept
from uwsim.operator.station.flights.flights import Bounds, Flights
from uwsim.recording import Recorder, Recording, sink
from uwsim.recording.mcap_sink import McapSink
from uwsim.recording.timeline import FROM_LOG, Timeline

KEEP = Bounds(5)
HEAD_BYTES = 50_000  # less than what precedes the first message


def full(*arguments):
    """As a disk without space."""
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@contextmanager
def undocked(folder: Path, keep=KEEP, **choice):
    """A station that records, and a page that has undocked its vehicle."""
    with serving(folder, keep_flights=keep) as (station, server), page(server) as ada:
        ada.subscribe("/station/state")
        ada.call("start", scenario="pool", **choice)
        ada.call("take_control")
        ada.call("command", name="undock", vehicle="rov")
        yield station, ada


def trouble(ada) -> str:
    """The state's reason for which a flight is no longer recorded."""
    state = ada.message("/station/state", lambda state: state["flight_trouble"])
    assert state["flight"] == ""
    return state["flight_trouble"]


@pytest.fixture(scope="module")
def flown(tmp_path_factory) -> Path:
    """A flight of 6 s."""
    return fly(tmp_path_factory.mktemp("flown") / "20260101-000000-pool.mcap")


def test_a_flight_that_was_made_from_a_log_says_so(tmp_path: Path):
    fly(tmp_path / "dive.mcap", end_s=0.5, notes={FROM_LOG: {"file": "dive.BIN", "notes": []}})
    fly(tmp_path / "other.mcap", end_s=0.5)
    assert {each["name"]: each["from_log"] for each in Flights(tmp_path).listed()} == {
        "dive.mcap": "dive.BIN",
        "other.mcap": "",
    }


@pytest.fixture
def folder(flown: Path, tmp_path: Path) -> Path:
    """A station's folder with one flight."""
    (tmp_path / "flights").mkdir()
    shutil.copy(flown, tmp_path / "flights")
    return tmp_path


def test_a_flight_is_recorded_unasked_and_listed_by_the_next_server(tmp_path: Path):
    with serving(tmp_path, keep_flights=KEEP) as (station, server), page(server) as ada:
        ada.subscribe("/station/state")
        assert ada.call("catalog")["flights"] == []
        ada.call("start", scenario="pool", seed=7)
        state = ada.message("/station/state", lambda state: state["flight"])
        assert re.fullmatch(r"\d{8}-\d{6}-\d{3}-pool\.mcap", state["flight"]) and not state["flight_trouble"]
        assert ada.call("catalog")["flights"] == []  # not before it ends
        ada.call("take_control")
        ada.call("control", action="quit")  # without a flight
        assert list((tmp_path / "flights").iterdir()) == []
        ada.call("start", scenario="pool", seed=7)
        ada.call("command", name="undock", vehicle="rov")
        for _ in range(5):
            assert ada.call("drive", vehicle="rov", surge=0.5)["success"]
        live = station.present().live
        until(lambda: live.tick > 300, "a second and a half")
        assert ada.call("control", action="restart")["success"]  # another flight
        ada.call("command", name="undock", vehicle="rov")
        until(lambda: live.tick > 100, "its first half second")
    with serving(tmp_path, keep_flights=KEEP) as (station, server), page(server) as ada:
        second, first = ada.call("catalog")["flights"]
        assert (first["scenario"], first["refused"], first["branched_from"]) == ("pool", "", "")
        assert first["duration_s"] > 1.4 and first["size_bytes"] > 10_000 and second["begun"] >= first["begun"]
        for each in (first, second):
            line = station.sessions.flights.timeline(each["name"])
            assert line.events[0].text == "undock rov"


def notes(name: str) -> dict[str, str]:
    """The notes that the station writes into a flight that it names."""
    return {**kept.RECORDED_BY, kept.NAMED: name}


@pytest.fixture(scope="module")
def unasked(tmp_path_factory) -> list[Path]:
    """Six short flights as the station records them."""
    folder = tmp_path_factory.mktemp("unasked")
    named = [f"2026010{k}-000000-pool.mcap" for k in range(6)]
    return [fly(folder / name, end_s=0.5, notes=notes(name)) for name in named]


def test_only_the_newest_within_the_bounds_are_kept(unasked: list[Path], tmp_path: Path, caplog):
    size = max(path.stat().st_size for path in unasked)
    for bounds, left in ((Bounds(3), 3), (Bounds(9, 2 * size + 10), 2), (Bounds(0), 0), (Bounds(9), 6)):
        folder = tmp_path / f"{bounds.count}-{bounds.size_bytes}"
        folder.mkdir()
        for path in unasked:
            shutil.copy(path, folder)
        other = folder / "notes.txt"
        other.write_text("not ours")
        found = Flights(folder, bounds)
        caplog.clear()
        found.make_room()
        lines = [record.getMessage() for record in caplog.records]
        assert len(lines) == 6 - left and all(f"2026010{k}" in line for k, line in enumerate(lines))
        assert [each["name"][7] for each in found.listed()] == list("543210")[:left]
        assert other.exists()
        if left == 3:
            assert found.new_path("pool").parent == folder and len(found.listed()) == 2  # room for the new one
    for text, why in (("5", "such as 50,2000"), ("-1,5", "such as"), ("3,0", "1 to 1000000 MB"), ("99999,1", "0 to")):
        with pytest.raises(ValueError, match=why):
            Bounds.of(text)
    assert Bounds.of("7,30") == Bounds(7, 30_000_000)


def test_only_recordings_that_the_station_made_unasked_are_deleted(
    flown: Path, unasked: list[Path], tmp_path: Path, caplog, monkeypatch
):
    """And only under the names that it gave them: what a user has renamed or copied is the user's."""
    for k in range(20):
        (tmp_path / f"2019-my-lake-{k:02d}.mcap").write_bytes(b"from another program")
        shutil.copy(flown, tmp_path / f"20190101-0000{k:02d}-pool.mcap")  # ours, but made with a Recorder
    for k, path in enumerate(unasked):
        shutil.copy(path, tmp_path / f"zzz-{k}.mcap")
    shutil.copy(unasked[0], tmp_path / f"{unasked[0].stem}-best.mcap")
    foreign = {path: path.read_bytes() for path in tmp_path.iterdir()}
    for path in unasked:
        shutil.copy(path, tmp_path)
    cut = tmp_path / unasked[0].name
    cut.write_bytes(cut.read_bytes()[:-100])  # after a kill
    found = Flights(tmp_path, Bounds(3))
    found.make_room()
    left = {path: path.read_bytes() for path in tmp_path.iterdir()}
    assert foreign.items() <= left.items()
    assert len(left) == len(foreign) + 3  # the others count towards no bound
    assert len(caplog.records) == 3 and f"{cut.name} is deleted: at most 3 flights" in caplog.records[0].getMessage()
    found.bounds = Bounds(0)
    monkeypatch.setattr(Flights, "_paths", lambda self: [tmp_path / "deleted-meanwhile.mcap", *sorted(left)])
    found.make_room()
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == foreign


def test_a_flight_that_another_station_records_is_not_deleted(tmp_path: Path, monkeypatch):
    monkeypatch.setattr(sink, "FLUSH_S", 0.1)
    path = tmp_path / "20260101-000000-pool.mcap"
    with LiveSimulator("pool") as live, Recorder(live, path, notes=notes(path.name), is_light=True):
        until(lambda: path.stat().st_size and Recording(path).end_tick is not None, "a chunk")
        found = Flights(tmp_path, Bounds(0))  # of another process, with the same folder
        found.make_room()
        assert path.exists()
    found.make_room()
    assert not path.exists()


def test_what_a_kill_left_is_listed_with_its_end_and_replayed_to_there(tmp_path: Path, monkeypatch):
    """A kill -9 of a station leaves whole chunks, and then the beginning of another one."""
    monkeypatch.setattr(sink, "FLUSH_S", 0.2)
    with undocked(tmp_path, seed=7) as (station, ada):
        assert ada.call("command", name="set_lamp", vehicle="rov", args={"lamp": "front", "on": True})["success"]
        live = station.present().live
        until(lambda: live.tick > 400, "two seconds")
        (growing,) = (tmp_path / "flights").iterdir()
        left = growing.read_bytes()[:-7]
    growing.unlink()
    name = "20260101-000000-pool.mcap"
    (tmp_path / "flights" / name).write_bytes(left)
    with serving(tmp_path, keep_flights=KEEP) as (station, server), page(server) as ada:
        (flight,) = ada.call("catalog")["flights"]
        assert (flight["scenario"], flight["cut_off"], flight["refused"]) == ("pool", True, "")
        assert 1.0 < flight["duration_s"] <= 2.2 and flight["begun"].startswith("20")
        assert ada.call("start", flight=name, speed=0)["success"]
        replay = ada.call("describe")["replay"]
        assert replay["end_s"] - replay["start_s"] == pytest.approx(flight["duration_s"])
        assert [event["text"] for event in replay["events"]] == ["undock rov", "set lamp rov: lamp front, on"]
        live = station.present().live
        until(lambda: live.paused and live.tick * 0.005 == pytest.approx(replay["end_s"]), "the end")
        ada.call("take_control")
        assert ada.call("control", action="helm")["success"]


def test_a_write_error_is_in_the_state_at_once(tmp_path: Path, monkeypatch):
    monkeypatch.setattr(kept, "CHECK_S", 0.2)
    with undocked(tmp_path) as (station, ada):
        assert ada.call("describe")["is_recorded"]
        assert ada.message("/station/state", lambda state: state["flight"])["flight_trouble"] == ""
        (path,) = (tmp_path / "flights").iterdir()
        until(lambda: Recording(path).end_tick is not None, "a chunk")
        monkeypatch.setattr(McapSink, "write", full)
        assert "No space left on device" in trouble(ada)
        monkeypatch.undo()
        until(lambda: station.sessions.flights.growing is None, "the end of the recording")
        assert "No space left on device" in trouble(ada)
        assert station.present().live.error is None and not station.present().live.paused  # the flight goes on
        (flight,) = ada.call("catalog")["flights"]
        assert flight["cut_off"] and flight["refused"] == ""
        station.sessions.flights.timeline(flight["name"])


def test_a_flight_that_alone_exceeds_the_bound_or_has_no_folder_is_not_recorded_and_says_so(
    tmp_path: Path, monkeypatch
):
    monkeypatch.setattr(kept, "CHECK_S", 0.1)
    with undocked(tmp_path, Bounds(5, 200_000), speed=10) as (station, ada):
        assert "has reached 0.2 MB" in trouble(ada)
        assert station.present().live.error is None and not station.present().live.paused  # the flight goes on
        (path,) = (tmp_path / "flights").iterdir()
        assert Timeline(Recording(path)).end_tick > 0
    (tmp_path / "other").mkdir()
    (tmp_path / "other/flights").write_text("a file")
    with undocked(tmp_path / "other") as (station, ada):
        assert "is not recorded" in trouble(ada)


def test_a_replay_is_a_session_that_takes_no_commands_until_the_helm_is_taken(folder: Path):
    (name,) = (path.name for path in (folder / "flights").iterdir())
    with serving(folder, keep_flights=KEEP, truth=False) as (station, server), page(server) as ada:
        assert ada.call("check", flight=name, speed=0)["success"]
        assert ada.call("start", flight=name, speed=0)["success"]
        ada.call("take_control")
        shown = ada.call("describe")
        replay = shown["replay"]
        assert (replay["flight"], replay["start_s"], replay["end_s"]) == (name, 0.0, 6.0) and shown["truth_allowed"]
        assert {"seek", "helm", "pause", "speed"} <= set(shown["controls"]) and "save" not in shown["controls"]
        live = station.present().live
        until(lambda: live.paused and live.tick == 1200, "the end")
        end = live.read(lambda sim: sim.save_state()).result()
        line = station.present().replay.timeline
        for call, args in (
            ("drive", {"vehicle": "rov", "surge": 1.0}),
            ("command", {"name": "dock", "vehicle": "rov"}),
            ("all_stop", {"vehicle": "rov"}),
            ("plan", {"action": "fly", "vehicle": "rov", "points_m": [[0.0, 0.0, -1.0]]}),
        ):
            assert "take the helm" in ada.call(call, **args)["message"], call
        for action in ("restart", "save", "record"):
            assert "must be one of" in ada.call("control", action=action)["message"]
        ada.send("call_service", service="/simulation/reset", args={}, id="other")
        assert "replay" in json.dumps(ada.next(lambda o: o.get("id") == "other")["values"])
        assert "ends here" in ada.call("control", action="step", steps=1)["message"]
        for time_s in (2.5, 5.995, -4.0, 1e9, 3.0):
            assert ada.call("control", action="seek", time_s=time_s)["success"]
            assert live.tick == round(200 * min(max(time_s, 0.0), 6.0)), time_s
        for wrong in (None, "3", True):
            assert "must be a number" in ada.call("control", action="seek", time_s=wrong)["message"]
        assert live.paused
        ada.call("control", action="resume")
        until(lambda: live.paused and live.tick == 1200, "the end again")
        assert live.read(lambda sim: sim.save_state()).result() == end  # to the bit, whatever was sought before

        ada.call("control", action="seek", time_s=3.0)
        expected = line.simulator()
        line.go_to(expected, 600)
        said = ada.call("control", action="helm")
        assert said["success"] and f"{name} at 3.00 s" in said["message"]
        shown = ada.call("describe")
        assert shown["replay"] is None and name in shown["branched_from"] and not shown["truth_allowed"]
        live = station.present().live
        assert live.paused and live.tick == 600 and not live.rov.effort.any()
        here = live.read(lambda sim: np.array(sim.rov.pose.position_world_m)).result()
        assert np.array_equal(here, expected.rov.pose.position_world_m)
        assert (
            ada.call("control", action="resume")["success"] and ada.call("drive", vehicle="rov", heave=0.5)["success"]
        )
        until(lambda: live.tick > 800, "a second of flight")
        ada.call("control", action="quit")
        branch, _ = ada.call("catalog")["flights"]
        assert name in branch["branched_from"]
        assert station.sessions.flights.timeline(branch["name"]).start_tick >= 600


def test_what_was_cut_edited_or_made_by_others_is_refused_in_one_line(folder: Path, flown: Path, monkeypatch):
    whole = flown.read_bytes()
    place = folder / "flights"
    (place / "cut.mcap").write_bytes(whole[:HEAD_BYTES])
    flipped = bytearray(whole)
    flipped[len(whole) // 2] ^= 4
    (place / "flipped.mcap").write_bytes(flipped)
    (place / "empty.mcap").touch()
    (place / "text.mcap").write_text("a flight\n" * 99)
    (place / "a flight with spaces.mcap").write_bytes(whole)
    (place / "folder.mcap").mkdir()
    with serving(folder, keep_flights=KEEP) as (station, server), page(server) as ada:
        listed = {each["name"]: each["refused"] for each in ada.call("catalog")["flights"]}
        assert set(listed) == {flown.name, "cut.mcap", "flipped.mcap", "empty.mcap", "text.mcap"}
        assert listed["cut.mcap"] == "recording 'cut.mcap': is cut off before its first message"
        assert all("was not written by uwsim" in listed[name] for name in ("empty.mcap", "text.mcap"))
        for name, why in (
            ("cut.mcap", "cut off before its first message"),
            ("flipped.mcap", "checksum|damaged"),
            ("text.mcap", "not written by uwsim"),
            ("../flights/" + flown.name, "must be one of those listed"),
            ("/etc/passwd", "must be one of those listed"),
            (["x"], "must be one of those listed"),
        ):
            answer = ada.call("start", flight=name)
            line = answer["errors"]["flight"]
            assert re.search(why, line) and "\n" not in line and str(folder) not in line, line
        assert station.sessions.phase == "idle" and station.sessions.running is None
        again = {each["name"]: each["refused"] for each in ada.call("catalog")["flights"]}
        assert re.search("checksum|damaged", again["flipped.mcap"])  # remembered
        assert ada.call("start", flight=flown.name, seed=3)["errors"] == {"seed": "is as it was recorded"}
        monkeypatch.setattr(kept, "build_fingerprint", lambda: "0" * 16)
        kept._summary.cache_clear()
        assert "another build" in {each["name"]: each["refused"] for each in ada.call("catalog")["flights"]}[flown.name]
    assert not [thread for thread in threading.enumerate() if thread.name == "uwsim-flights"]
