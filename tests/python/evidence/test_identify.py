"""identify: known vehicles are found again, from any kind of log, with intervals that contain the truth."""

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from uwsim import Batch, Simulator
from uwsim.cli.program import app
from uwsim.evidence import identification
from uwsim.evidence.identification import MotionLog, identify, read_log
from uwsim.evidence.identification.calibrated_file import calibrated_text
from uwsim.evidence.identification.command_times import segment_of
from uwsim.evidence.identification.flown import OUTPUTS, Flown, parts_of
from uwsim.evidence.identification.solution import Identified, Value
from uwsim.evidence.identification.unknowns import DELAY, SPREADS, parameters_at, unknowns
from uwsim.evidence.validate.flights import deep_scenario
from uwsim.evidence.validate.identification import covered, true_log
from uwsim.exchange.logs.motion_log import read_mapping
from uwsim.recording import Recorder
from uwsim.recording.real_flights.motion import sampled
from uwsim.scenario import VehicleModel, load_vehicle
from uwsim.scenario.build.vehicle import completed
from uwsim.scenario.read.assets import assets_folder

NOISE = np.repeat((0.02, 0.005, 0.01, 0.005), 3)
KNOWN = ("centre_of_mass_m", "centre_of_buoyancy_m", "added_mass.roll", "added_mass.pitch", "thrust_lag")
NAMES = [
    *(f"p{a}" for a in "xyz"),
    *(f"q{a}" for a in "xyzw"),
    *(f"v{k}" for k in range(6)),
    *(f"e{k}" for k in range(6)),
]


@pytest.fixture(scope="module")
def model() -> VehicleModel:
    return load_vehicle("bluerov2_wu")


def flown(model: VehicleModel, seed: int, limits: NDArray[np.float64], duration_s: float) -> MotionLog:
    """Return the log, with noise, of a vehicle whose true values are drawn from the prior."""
    draw = np.random.default_rng(seed)
    found = unknowns(model, "body", known=(*KNOWN, DELAY))
    z = draw.standard_normal(len(found))
    bare = model.model_copy(update={"sensors": {}, "sonar": None})
    batch = Batch(deep_scenario(bare), n=1, parameters=parameters_at(found, z))
    batch.place([[0.0, 0.0, -400.0]])
    n = round(10 * duration_s) + 1
    efforts = np.repeat(draw.uniform(-1, 1, (n // 15 + 1, 6)) * limits, 15, axis=0)[:n]
    rows = np.zeros((n, 13))
    for k in range(n):
        motion = batch.observe()
        rows[k] = np.hstack([motion.position_world_m[0], motion.orientation_xyzw[0], motion.velocity_body[0]])
        batch.step(20, efforts[k : k + 1])
    noise = draw.standard_normal((n, 12)) * NOISE
    turned = (Rotation.from_quat(rows[:, 3:7]) * Rotation.from_rotvec(noise[:, 3:6])).as_quat()
    times_s = 0.1 * np.arange(n)
    return MotionLog(times_s, rows[:, :3] + noise[:, :3], turned, rows[:, 7:] + noise[:, 6:], times_s, efforts, {})


def test_intervals_contain_the_truth_of_commands_that_are_late_and_the_noise_is_found(model: VehicleModel) -> None:
    """Tables, in which a command is seen in the next row, are in the suite `identification`, which tools/docs runs."""
    true = true_log(0, model, duration_s=8.0)
    found = identify(true.log, model)
    inside = covered(found, true.values)
    assert np.mean(list(inside.values())) >= 0.8  # of up to 30, whose errors are correlated; without the times, 5 to 17
    assert all(
        found.values[name].is_determined for name in (DELAY, "mass_kg", "quadratic_damping.surge", "current_m_s.x")
    )
    assert found.values[DELAY].value == pytest.approx(true.values[DELAY], abs=0.002)
    assert found.model.mass_kg == pytest.approx(true.values["mass_kg"], rel=0.02)
    np.testing.assert_allclose(found.noise, NOISE, rtol=0.25)


def test_a_volume_and_a_centre_of_buoyancy_that_the_file_does_not_state_are_found(model: VehicleModel) -> None:
    """Held at the hull's, which is 6 % smaller here, they made most other intervals miss."""
    true = true_log(2, model, duration_s=6.0)
    found = identify(true.log, model.model_copy(update={"volume_m3": None, "centre_of_buoyancy_m": None}))
    inside = covered(found, true.values)
    assert {"volume_m3", *(f"centre_of_buoyancy_m.{axis}" for axis in "xyz")} <= found.values.keys()
    assert np.mean(list(inside.values())) > 0.7
    assert "volume_m3: identified from that of the hull's mesh: the vehicle's file states none" in found.premises


def test_the_new_file_states_a_centre_and_a_volume_that_the_old_one_did_not(tmp_path: Path) -> None:
    model, added = completed(load_vehicle("rov"), 1000.0)
    assert added == ("volume_m3", "centre_of_buoyancy_m", "inertia_kg_m2")[: len(added)]
    places = {"volume_m3": (("volume_m3",),), "centre_of_buoyancy_m.z": (("centre_of_buoyancy_m", 2),)}
    values = {name: Value(name, "m", 0.0, 0.03, 0.02, 0.04, 0.1, places=own) for name, own in places.items()}
    numbers = {place: 0.03 for own in places.values() for place in own}
    x_m, y_m, _ = model.centre_of_buoyancy_m or (0.0, 0.0, 0.0)
    model = model.model_copy(update={"centre_of_buoyancy_m": (x_m, y_m, 0.03)})
    none = np.zeros(0)
    found = Identified(values, [], none, none, none, none, model, numbers, ())
    document = model.source_file.document
    assert document is not None
    lines = calibrated_text(found, document, "a.csv", tmp_path).splitlines()
    new = {line.partition(":")[0]: line.partition(": ")[2] for line in lines}
    assert new["volume_m3"].startswith("0.03 ") and "95 %: 0.02 to 0.04 m" in new["volume_m3"]
    assert new["centre_of_buoyancy_m"].partition("]")[0] == f"[{x_m:.4g}, {y_m:.4g}, 0.03"


def test_changes_between_samples_come_at_times_that_may_shift() -> None:
    efforts = np.zeros((6, 6))
    efforts[2:, 0], efforts[4:, 5] = 0.5, -1.0
    times_s, changed, sds_s = sampled(0.1 * np.arange(6), efforts)
    np.testing.assert_allclose(times_s, [0.0, 0.15, 0.35])
    np.testing.assert_allclose(sds_s, [0.0, *[0.1 / np.sqrt(12)] * 2])
    segment = segment_of(times_s, changed, sds_s, 0.0, 0.5)
    on_time, others_later, first_later, last_later = segment.efforts(0, np.array([0, 0]), 100).transpose(1, 0, 2)
    assert [int(np.argmax(on_time[:, axis] != 0)) for axis in (0, 5)] == [30, 70]
    assert [int(np.argmax(others_later[:, axis] != 0)) for axis in (0, 5)] == [30, 70]
    assert [int(np.argmax(first_later[:, axis] != 0)) for axis in (0, 5)] == [31, 70]
    assert [int(np.argmax(last_later[:, axis] != 0)) for axis in (0, 5)] == [30, 71]
    shifted = segment.efforts(-2, np.array([3, -2]), 100)[:, 0]
    assert [int(np.argmax(shifted[:, axis] != 0)) for axis in (0, 5)] == [33, 68]
    exact_later = segment_of(times_s, changed, np.zeros(3), 0.0, 0.5).efforts(0, np.array([], np.int64), 100)[:, 1]
    assert [int(np.argmax(exact_later[:, axis] != 0)) for axis in (0, 5)] == [31, 71]
    exact = segment_of(np.array([0.0, 0.1525]), changed[:2], np.zeros(2), 0.0, 0.5)
    np.testing.assert_allclose(exact.efforts(0, np.array([], np.int64), 40)[29:33, 0, 0], [0, 0.25, 0.5, 0.5])


def test_residuals_are_continuous_where_a_delay_passes_a_step(model: VehicleModel) -> None:
    """Otherwise the solver stops there. Commands that may shift are within the step, too."""
    found = unknowns(model, "vehicle", known=("added_mass", "linear_damping", "quadratic_damping"))
    flown = Flown(model, true_log(3, model, duration_s=3.0).log, found, 60.0, 1000.0)
    z, names = np.zeros(flown.size), [each.name for each in found]
    z[len(found) + OUTPUTS :] = 0.01
    residuals = []
    for delay_s in (-1e-7, 1e-7):
        z[names.index(DELAY)] = delay_s / SPREADS[DELAY]
        residuals.append(flown.outputs(z)[0])
    assert (np.abs(residuals[1] - residuals[0]) < 0.005 * NOISE).all()


def test_a_log_without_motion_in_an_axis_says_so(model: VehicleModel) -> None:
    log = flown(model, 4, np.array([0.5, 0.0, 0.0, 0.0, 0.0, 0.0]), duration_s=5.0)
    held = (*KNOWN, "current_m_s", "mass_kg", "thrust_gain", "linear_damping")
    found = identify(log, model, known=held)
    assert found.values["quadratic_damping.surge"].is_determined
    for name in ("added_mass.sway", "quadratic_damping.sway", "quadratic_damping.yaw"):
        assert not found.values[name].is_determined
        assert any(name in parts for _, parts in found.undetermined)


def test_a_table_becomes_a_report_and_a_vehicle_file_that_differs_from_the_old_one_in_measured_lines_alone(
    model: VehicleModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Surge, sway, heave and yaw move. Drag in roll is held, so that it keeps its value, and its line the comment."""
    log = flown(model, 5, np.array([0.5, 0.5, 0.5, 0.0, 0.0, 0.3]), duration_s=8.0)
    rows = np.hstack([log.times_s[:, None], log.position_m, log.orientation_xyzw, log.velocity_body, log.efforts])
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header=",".join(["t", *NAMES]), comments="")
    (tmp_path / "map.yaml").write_text(
        "time_s: t\nposition_m: [px, py, pz]\norientation_xyzw: [qx, qy, qz, qw]\n"
        "velocity_body: [v0, v1, v2, v3, v4, v5]\neffort: [e0, e1, e2, e3, e4, e5]\n"
    )
    (tmp_path / "own").mkdir()
    old = (assets_folder() / "vehicles" / "bluerov2_wu.yaml").read_text().replace("meshes/bluerov2.glb", "hull.glb")
    (mine := tmp_path / "own" / "mine.yaml").write_text(old.replace(", spin: clockwise}", ", gain: 1.0}"))
    shutil.copy(assets_folder() / "meshes" / "bluerov2.glb", tmp_path / "own" / "hull.glb")
    kept: list[Identified] = []
    known = (*KNOWN, "added_mass", "linear_damping", "command_delay", "quadratic_damping.roll")
    words = ["vehicle", "identify", str(tmp_path / "log.csv"), f"--map={tmp_path / 'map.yaml'}", f"--vehicle={mine}"]
    words += [f"--known={name}" for name in known]

    def once(*arguments: Any, **options: Any) -> Identified:
        if not kept:
            kept.append(identify(*arguments, **options))
        return kept[0]

    monkeypatch.setattr(identification, "identify", once)
    out = tmp_path / "out"
    result = CliRunner().invoke(app, [*words, f"--out={out}"], catch_exceptions=False)
    assert result.exit_code == 0 and "quadratic_damping.surge" in result.output
    assert "volume_m3 = 0.01135 m3: held, as the vehicle's file states" in result.output
    report = (out / "report.md").read_text()
    assert "centre_of_buoyancy_m = 0 0 0.02 m: held" in report and "What the log does not determine" in report
    assert (out / "residuals.png").stat().st_size > 0

    assert CliRunner().invoke(app, [*words, f"--out={tmp_path / 'new.yaml'}"], catch_exceptions=False).exit_code == 0
    assert (out / "vehicle.yaml").read_text() == (tmp_path / "new.yaml").read_text()
    before, after = mine.read_text().splitlines(), (tmp_path / "new.yaml").read_text().splitlines()
    changed = {b.strip().partition(":")[0]: a for b, a in zip(before, after, strict=True) if a != b}
    gained = [line for line in before if "gain: 1.0" in line]
    assert len(gained) == 3 and set(changed) == {"mass_kg", "quadratic_damping", "mesh", "{model"}
    assert f'mesh: "{tmp_path / "own" / "hull.glb"}"' in changed["mesh"]
    assert "# measured in log.csv, 95 %: surge " in changed["quadratic_damping"]
    assert "; the rest: [N s2/m2, N m s2/rad2] [Wu]" in changed["quadratic_damping"]
    new, own = load_vehicle(tmp_path / "new.yaml"), load_vehicle(mine)
    assert new.quadratic_damping is not None and new.quadratic_damping[3] == 1.55 != new.quadratic_damping[4]
    assert len({mount.gain for mount in new.thrusters.values()} - {1.0}) == 1
    assert new.thrusters["front_left"].model == own.thrusters["front_left"].model

    (tmp_path / "theirs.yaml").write_text("# mine\n")
    result = CliRunner().invoke(app, [*words, f"--out={tmp_path / 'theirs.yaml'}"])
    assert "uwsim did not write it" in str(result.exception)
    assert (tmp_path / "theirs.yaml").read_text() == "# mine\n"


MAP = """time_s: t
position_m: [px, py, pz]
orientation_xyzw: [qx, qy, qz, qw]
effort: [e0, null, null, null, null, null]
noise: {position: 0.02}
"""
HEADER = "t,px,py,pz,qx,qy,qz,qw,e0"
ROWS = [f"{0.1 * k:.1f},0,0,-9,0,0,0,1,0.3" for k in range(30)]


def log_of(folder: Path, text: str, mapping: str = MAP) -> MotionLog:
    """Return the log of a table and its mapping."""
    (folder / "log.csv").write_text(text)
    (folder / "map.yaml").write_text(mapping)
    return read_log(folder / "log.csv", read_mapping(folder / "map.yaml"))


@pytest.mark.parametrize(
    ("was", "broken", "rule"),
    [
        ("time_s: t", "time_s: time", r"log\.csv: no column 'time'; there are: t, px"),
        ("e0, null", "e9, null", r"log\.csv: no column 'e9'"),
        ("e0, null", "null, null", r"map\.yaml:4: effort: must name at least one axis"),
        ("position: 0.02", "position: -1", r"map\.yaml:5: noise.position = -1: must be in"),
        ("position: 0.02", "positions: 1", r"map\.yaml:5: .*positions"),
        ("time_s: t", "time: t", r"map\.yaml:1: time: unknown key; did you mean 'time_s'"),
        ("\n0.5,0,", "\n0.5,x,", r"log\.csv:7: px = 'x': must be a finite number"),
        ("\n0.5,", "\n0.4,", r"log\.csv: time 0.4 s is followed by 0.4 s: times must increase"),
        ("\n2.9,", "\n1e9,", r"log\.csv: time 2.8 s is followed by 1000000000 s: must be within 3600 s"),
        ("1,0.3\n0.5", "1,1.3\n0.5", r"log\.csv: effort = 1.3: must be in \[-1, 1\]"),
        ("\n0.5,", '\n0.5,"' + "0" * 200_000, r"log\.csv:7: not CSV"),
    ],
)
def test_a_broken_log_or_mapping_is_refused_with_its_file_line_and_rule(
    was: str, broken: str, rule: str, tmp_path: Path
) -> None:
    with pytest.raises(ValueError, match=rule) as refused:
        log_of(tmp_path, "\n".join([HEADER, *ROWS, ""]).replace(was, broken, 1), MAP.replace(was, broken, 1))
    assert "\n" not in str(refused.value) and len(str(refused.value)) < 400


def test_a_speed_that_no_vehicle_has_is_named(tmp_path: Path) -> None:
    rows = [f"{HEADER},u", *(f"{row},{150 * row.startswith('0.5,')}" for row in ROWS), ""]
    with pytest.raises(ValueError, match=r"log\.csv: at 0.5 s, surge at 150 m/s: must be within 100"):
        log_of(tmp_path, "\n".join(rows), f"{MAP}velocity_body: [u, px, px, px, px, px]\n")


def test_rows_without_an_attitude_are_left_out(tmp_path: Path) -> None:
    text = "\n".join([HEADER, *ROWS, ""])
    for row, quaternion in (("0.5", "0,0,0,0"), ("1.5", "0,0,0,"), ("2.5", "0,0,0,1e200")):
        text = text.replace(f"\n{row},0,0,-9,0,0,0,1,", f"\n{row},0,0,-9,{quaternion},")
    log = log_of(tmp_path, text)
    assert set(log.times_s) == {k / 10 for k in range(30)} - {0.5, 1.5, 2.5}
    np.testing.assert_array_equal(np.linalg.norm(log.orientation_xyzw, axis=1), 1.0)


def test_a_log_with_a_gap_is_simulated_where_it_has_rows(model: VehicleModel, tmp_path: Path) -> None:
    rows = [*ROWS, *(f"{3000 + 0.1 * k:.1f},5,0,-9,0,0,0,1,0.3" for k in range(30))]
    log = log_of(tmp_path, "\n".join([HEADER, *rows, ""]))
    parts = parts_of(log, unknowns=29, segment_s=1.0, most=None)
    assert [part.start_s for part in parts] == pytest.approx([0.0, 1.0, 2.0, 3000.0, 3001.0, 3002.0], abs=0.11)
    assert sum(part.steps for part in parts) < 3000  # of 5 ms


def test_a_damaged_recording_is_refused_in_one_line(tmp_path: Path) -> None:
    for name, content in (("a.mcap", b"\x89MCAP0\r\n" + bytes(200)), ("a.bag", b"#ROSBAG V2.0\n" + bytes(200))):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(ValueError, match=rf"{name}'?: ") as refused:
            read_log(tmp_path / name)
        assert "\n" not in str(refused.value)


def test_a_recording_of_ours_gives_the_commands_at_their_times(model: VehicleModel, tmp_path: Path) -> None:
    sim = Simulator(deep_scenario(model.model_copy(update={"sonar": None})))
    with Recorder(sim, tmp_path / "run.mcap", topics=["odom", "telemetry"]):
        for surge in (0.3, -0.2):
            sim.rov.set_effort(surge=surge)
            sim.advance(0.53)
    log = read_log(tmp_path / "run.mcap")
    assert log.efforts[:, 0].tolist() == [0.3, -0.2]
    np.testing.assert_allclose(log.effort_times_s, [0.0, 0.53], atol=1e-9)
    np.testing.assert_allclose(log.position_m[-1, 0], sim.rov.pose.position_world_m[0], atol=0.05)
