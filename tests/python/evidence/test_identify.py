"""identify: known vehicles are found again, from any kind of log, with intervals that contain the truth."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from uwsim import Batch, Simulator
from uwsim.cli.program import app
from uwsim.evidence.identification import MotionLog, identify, read_log
from uwsim.evidence.identification.unknowns import parameters_at, unknowns
from uwsim.evidence.validate.flights import deep_scenario
from uwsim.recording import Recorder
from uwsim.scenario import VehicleModel, load_vehicle

NOISE = np.repeat((0.02, 0.005, 0.01, 0.005), 3)
KNOWN = ("centre_of_mass_m", "centre_of_buoyancy_m", "added_mass.roll", "added_mass.pitch", "thrust_lag")
DURATION_S = 12.0
NAMES = [
    *(f"p{a}" for a in "xyz"),
    *(f"q{a}" for a in "xyzw"),
    *(f"v{k}" for k in range(6)),
    *(f"e{k}" for k in range(6)),
]


@pytest.fixture(scope="module")
def model() -> VehicleModel:
    return load_vehicle("bluerov2_wu")


def flown(
    model: VehicleModel, seed: int, limits: NDArray[np.float64], duration_s: float = DURATION_S
) -> tuple[dict[str, float], MotionLog]:
    """Return a vehicle's true values, drawn from the prior, and its log with noise."""
    draw = np.random.default_rng(seed)
    found = unknowns(model, "body", known=KNOWN)
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
    log = MotionLog(times_s, rows[:, :3] + noise[:, :3], turned, rows[:, 7:] + noise[:, 6:], times_s, efforts, {})
    return {u.name: u.at(float(v)) for u, v in zip(found, z, strict=True)}, log


def test_intervals_contain_the_truth_and_the_noise_is_found(model: VehicleModel) -> None:
    truth, log = flown(model, 3, np.array([0.6, 0.6, 0.6, 0.1, 0.1, 0.4]))
    found = identify(log, model, known=KNOWN)
    inside = [found.values[name].low <= value <= found.values[name].high for name, value in truth.items()]
    assert np.mean(inside) >= 0.8  # 22 intervals of 95 %: fewer by chance in 1 of 500
    np.testing.assert_allclose(found.noise, NOISE, rtol=0.25)
    assert all(found.values[name].is_determined for name in ("mass_kg", "quadratic_damping.surge", "current_m_s.x"))
    assert found.model.mass_kg == pytest.approx(truth["mass_kg"], rel=0.02)


def test_a_log_without_motion_in_an_axis_says_so(model: VehicleModel) -> None:
    _, log = flown(model, 4, np.array([0.5, 0.0, 0.0, 0.0, 0.0, 0.0]), duration_s=5.0)
    held = (*KNOWN, "current_m_s", "mass_kg", "thrust_gain", "linear_damping")
    found = identify(log, model, known=held)
    assert found.values["quadratic_damping.surge"].is_determined
    for name in ("added_mass.sway", "quadratic_damping.sway", "quadratic_damping.yaw"):
        assert not found.values[name].is_determined
        assert any(name in parts for _, parts in found.undetermined)


def test_a_table_becomes_a_vehicle_file_and_a_report(model: VehicleModel, tmp_path: Path) -> None:
    _, log = flown(model, 5, np.array([0.5, 0.5, 0.5, 0.0, 0.0, 0.3]))
    rows = np.hstack([log.times_s[:, None], log.position_m, log.orientation_xyzw, log.velocity_body, log.efforts])
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header=",".join(["t", *NAMES]), comments="")
    (tmp_path / "map.yaml").write_text(
        "time_s: t\nposition_m: [px, py, pz]\norientation_xyzw: [qx, qy, qz, qw]\n"
        "velocity_body: [v0, v1, v2, v3, v4, v5]\neffort: [e0, e1, e2, e3, e4, e5]\n"
    )
    held = [f"--known={name}" for name in (*KNOWN, "added_mass", "linear_damping")]
    out = tmp_path / "out"
    words = ["identify", str(tmp_path / "log.csv"), "--vehicle=bluerov2_wu", f"--out={out}", *held]
    result = CliRunner().invoke(app, [*words, f"--map={tmp_path / 'map.yaml'}"], catch_exceptions=False)
    assert result.exit_code == 0 and "quadratic_damping.surge" in result.output
    assert load_vehicle(out / "vehicle.yaml").quadratic_damping != model.quadratic_damping
    assert (
        "What the log does not determine" in (out / "report.md").read_text()
        and (out / "residuals.png").stat().st_size > 0
    )
    for broken, rule in (("t", "no column 'time'"), ("e0", "no column 'e9'")):
        text = (tmp_path / "map.yaml").read_text()
        (tmp_path / "bad.yaml").write_text(
            text.replace("time_s: t", "time_s: time") if broken == "t" else text.replace("e0", "e9")
        )
        refused = CliRunner().invoke(app, [*words, f"--map={tmp_path / 'bad.yaml'}"])
        assert refused.exit_code != 0 and rule in str(refused.exception)


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
