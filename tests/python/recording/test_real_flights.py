"""Logs of real flights: what is written is read again, and a model beside it errs as much as it differs."""

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from command_line import uwsim as command
from flight_logs import COLUMNS, DENSITY_KG_M3, ROWS, VEHICLE, bag, dataflash, flown, table, telemetry
from uwsim import Simulator
from uwsim.cli.program import app
from uwsim.evidence.identification import identify
from uwsim.exchange.logs.motion_log import read_flown
from uwsim.recording import Recording
from uwsim.recording.real_flights.beside import fly_beside
from uwsim.recording.real_flights.flight_log import FlightLog
from uwsim.recording.real_flights.motion import motion_of
from uwsim.recording.real_flights.read import read_flight
from uwsim.recording.timeline import Timeline
from uwsim.scenario import load_vehicle
from uwsim.scenario.read.note import Note

pytest.importorskip("pymavlink", reason="needs the extra mavlink")
FILES = {"BIN": dataflash, "tlog": telemetry, "csv": table}


def written(kind: str, folder: Path, **options: Any) -> Path:
    if kind == "bag":
        return bag(flown(), folder / "bag")
    path = folder / "dive.log"  # readers go by content
    path.write_bytes(FILES[kind](flown(), **options))
    return path


def read(kind: str, path: Path) -> FlightLog:
    return read_flight(path, COLUMNS if kind == "csv" else None)


@pytest.mark.parametrize("kind", ["BIN", "tlog", "csv", "bag"])
def test_a_flight_that_is_written_is_read_again_and_its_model_flies_it_alike(kind: str, tmp_path: Path) -> None:
    flight, model = flown(), load_vehicle(VEHICLE)
    log = read(kind, written(kind, tmp_path))
    outputs = "1=-{1},2={2},3={3},4={4},5={5},6={6},7={7},8={8}" if kind == "csv" else None
    if outputs is not None:  # a table has no parameters: the map is stated
        from uwsim.recording.real_flights.frames import servo_motors

        motors = sorted(servo_motors("vectored_6dof", model.thrusters, VEHICLE), key=lambda each: each.output)
        sign = {True: "-", False: ""}
        outputs = ",".join(
            f"{k + 1}={sign[(each.direction < 0) != (k == 0)]}{each.thruster}" for k, each in enumerate(motors)
        )
    motion, notes = motion_of(log, model, outputs)
    assert len(motion.times_s) == ROWS
    assert (Note("known", "ArduSub's frame vectored_6dof from FRAME_CONFIG = 2") in notes) == (kind in ("BIN", "tlog"))
    np.testing.assert_allclose(np.diff(motion.times_s), np.diff(flight.times_s), atol=1e-6)
    np.testing.assert_allclose(motion.position_m, flight.position_m, atol=1e-5)
    turned = Rotation.from_quat(flight.orientation_xyzw).inv() * Rotation.from_quat(motion.orientation_xyzw)
    assert turned.magnitude().max() < 1e-5
    np.testing.assert_allclose(motion.velocity_body, flight.velocity_body, atol=1e-5)

    if kind != "BIN":  # the motion is the same, and so what a model beside it does
        return
    same = fly_beside(motion, model, density_kg_m3=DENSITY_KG_M3, horizons_s=(1.0, 5.0, 10.0))
    assert same.horizons[10.0]["place"] is not None and same.horizons[10.0]["place"].count == 1
    for errors in same.horizons.values():
        worst = {name: mean.value for name, mean in errors.items() if mean is not None}
        assert worst["place"] < 2e-3 and worst["depth"] < 2e-3 and worst["tilt"] < 0.1, worst
    draggy = model.model_copy(update={"quadratic_damping": tuple(3 * v for v in model.quadratic_damping or ())})
    other = fly_beside(motion, draggy, density_kg_m3=DENSITY_KG_M3, horizons_s=(1.0, 5.0, 10.0))
    for h in (5.0, 10.0):
        right, wrong, simplest = (e[h]["speed"] for e in (same.horizons, other.horizons, same.integrator))
        assert right is not None and wrong is not None and wrong.value > 20 * right.value
        assert simplest is not None and simplest.value > 20 * right.value
        assert other.integrator[h] == same.integrator[h]  # drag is not in it


@pytest.mark.parametrize("kind", ["BIN", "tlog"])
def test_what_the_filter_does_not_know_is_absent_rather_than_0(kind: str, tmp_path: Path) -> None:
    """Without aiding, ArduPilot's filter logs a constant place and no speed, and its status has that."""
    options = {"status" if kind == "BIN" else "flags": 0xA7}
    log = read(kind, written(kind, tmp_path, **options))
    position = log.series["position"].values
    assert np.isnan(position[:, :2]).all() and np.isfinite(position[:, 2]).all()
    assert any("position from" in note.text and note.text.endswith("without east and north") for note in log.notes())
    motion, _ = motion_of(log, load_vehicle(VEHICLE))
    beside = fly_beside(motion, load_vehicle(VEHICLE), density_kg_m3=DENSITY_KG_M3, horizons_s=(1.0,))
    assert beside.horizons[1.0]["place"] is None and beside.horizons[1.0]["heading"] is not None
    assert any(note.text.startswith("each window begins without horizontal velocity") for note in beside.notes)
    assert Note("missing", "the error of place: the log does not have what it needs") in beside.notes


@pytest.mark.parametrize(
    ("columns", "error"),
    [
        ("t = time [h]", "--columns: t = 'time [h]': must be in [s] or [ms] or [us] or [ns]"),
        ("t = time [s], h = hedding [deg]", "--columns: h = 'hedding': must be one of time, "),
        ("t = time [s], n = depth [m], d = depth [m]", "--columns: depth: is both 'n' and 'd'"),
        ("h = heading [deg]", "--columns: must name the column of the time"),
        ("t = time [ms], x = depth [m]", "dive.log: no column 'x'"),
        (None, "dive.log: a table (CSV): must be read by `--columns`"),
    ],
)
def test_a_mapping_that_cannot_be_is_refused(columns: str | None, error: str, tmp_path: Path) -> None:
    path = written("csv", tmp_path)
    with pytest.raises(ValueError, match=re.escape(error)):
        read_flight(path, columns)


def test_a_log_without_motion_says_what_it_needs(tmp_path: Path) -> None:
    path = tmp_path / "bench.tlog"
    path.write_bytes(telemetry(flown(commanded=False)))
    for words in (["replay", str(path), "--beside", VEHICLE], ["vehicle", "identify", str(path), "--vehicle", VEHICLE]):
        result = CliRunner().invoke(app, words)
        assert result.exit_code == 1
        assert "no motion: the thrusters stay at rest for all of its 20 s: needs a flight" in str(result.exception)


def test_a_model_beside_a_log_on_the_command_line(tmp_path: Path) -> None:
    path = written("tlog", tmp_path)
    words = ["replay", str(path), "--beside", VEHICLE, f"--density={DENSITY_KG_M3}"]
    shown = command(*words).stdout
    assert "known: attitude from ATTITUDE.roll, pitch, yaw [rad], 1000 rows" in shown
    assert "missing: a horizon of 30 s: the log is too short" in shown
    found = json.loads(command(*words, "--json").stdout)
    assert [row["horizon_s"] for row in found["horizons"]] == [1.0, 2.0, 5.0, 10.0]
    assert found["horizons"][0]["place_m"]["mean"] < 1e-3 and found["horizons"][0]["place_m"]["windows"] > 5
    assert found["horizons"][3]["double_integrator"]["place_m"]["mean"] > found["horizons"][3]["place_m"]["mean"]


def test_identify_finds_the_drag_from_a_dataflash_log(tmp_path: Path) -> None:
    """From a file with twice the drag. All else is held."""
    model = load_vehicle(VEHICLE)
    assert model.quadratic_damping is not None
    draggy = model.model_copy(update={"quadratic_damping": tuple(2 * v for v in model.quadratic_damping)})
    motion, notes = read_flown(written("BIN", tmp_path), draggy)
    assert Note("missing", "thrusters") not in notes
    known = (
        "mass_kg",
        "centre_of_mass_m",
        "centre_of_buoyancy_m",
        "added_mass",
        "linear_damping",
        "thrust_gain",
        "thrust_lag",
        "current_m_s",
        "command_delay",
    )
    first = np.flatnonzero(motion.times_s < motion.times_s[0] + 5.0)[::5]
    names = ("times_s", "position_m", "orientation_xyzw", "velocity_body")
    brief = replace(motion, effort_sds_s=0.0, **{name: getattr(motion, name)[first] for name in names})
    found = identify(brief, draggy, known=known, density_kg_m3=DENSITY_KG_M3)
    for axis, true in zip(("surge", "sway", "heave"), model.quadratic_damping, strict=False):
        value = found.values[f"quadratic_damping.{axis}"]
        assert value.is_determined and value.value == pytest.approx(true, rel=0.03)


def test_a_message_without_length_is_refused_rather_than_read_for_ever(tmp_path: Path) -> None:
    data = bytearray(dataflash(flown()))
    at = data.index(b"\xa3\x95\x80", 89)  # the description of the second type
    data[at + 4] = 0
    (path := tmp_path / "dive.BIN").write_bytes(data)
    with pytest.raises(ValueError, match="is damaged: a type of message has no length"):
        read_flight(path)


def test_a_log_as_a_recording_is_a_time_line_along_the_log(tmp_path: Path) -> None:
    flight = replace(flown(), position_m=flown().position_m - [0.0, 0.0, 8.0])  # 2 to 3 m deep
    (path := tmp_path / "dive.tlog").write_bytes(telemetry(flight))
    words = ["replay", str(path), "--as-recording", str(out := tmp_path / "dive.mcap"), "--scenario", "pool"]
    assert "assumed: the log's first position is that of the scenario's start" in command(*words).stdout
    line = Timeline(Recording(out))  # repeats the run, and compares its end
    times_s, poses = line.track.arrays()
    assert times_s[-1] > 19.5 and not [event for event in line.events if "place" in event.text]
    rows = np.searchsorted(flight.times_s, flight.times_s[0] + times_s - 1e-3)
    way = flight.position_m[rows] - flight.position_m[0] + [-6.0, 0.0, flight.position_m[0, 2]]
    assert np.linalg.norm(poses[:, :3] - way, axis=1).max() < 0.01 and np.ptp(way, axis=0).min() > 0.3
    turned = Rotation.from_quat(flight.orientation_xyzw[rows]).inv() * Rotation.from_quat(poses[:, 3:])
    assert turned.magnitude().max() < 0.01
    assert "exists already" in str(CliRunner().invoke(app, words).exception)

    path.write_bytes(telemetry(flight, flags=0xA7))  # the filter does not know the horizontal position
    words[3] = str(tmp_path / "still.mcap")
    assert "missing: horizontal position: the vehicle keeps that of the start" in command(*words).stdout
    path.write_bytes(telemetry(replace(flight, position_m=flight.position_m - [0.0, 0.0, 8.0])))
    refused = str(CliRunner().invoke(app, [*words[:3], f"{out}.mcap", *words[4:]]).exception)
    assert re.search(r"none of \d+ poses is possible: the first at 100.0 s, in 'pool': .*above the ground", refused)


def test_poses_under_the_bed_are_left_out_and_counted_and_the_others_recorded(tmp_path: Path) -> None:
    """A log whose median depth is that of the bed has half above it."""
    bed_m = float(Simulator("pool").world.height_at(np.array([[-6.0, 0.0]]))[0])
    flight = flown()
    flight = replace(flight, position_m=flight.position_m - [0.0, 0.0, np.median(flight.position_m[:, 2]) - bed_m])
    (path := tmp_path / "dive.tlog").write_bytes(telemetry(flight))
    words = ["replay", str(path), "--as-recording", str(out := tmp_path / "dive.mcap"), "--scenario", "pool"]
    counts = re.search(r"left out: (\d+) of (\d+) poses, the first at .* above the ground", command(*words).stdout)
    assert counts is not None
    left_out, count = map(int, counts.groups())
    times_s, poses = Timeline(Recording(out)).track.arrays()
    rows = np.searchsorted(flight.times_s, flight.times_s[0] + times_s - 1e-3)
    is_above = flight.position_m[rows, 2] > bed_m
    assert 0 < left_out < count == len(poses) and abs(left_out - int((~is_above).sum())) <= 1
    np.testing.assert_allclose(poses[is_above, 2], flight.position_m[rows, 2][is_above], atol=0.05)
    assert poses[:, 2].min() > bed_m - 0.05
