"""`uwsim vehicle --draft` writes a file from a mesh alone, which floats level and surveys without another edit."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
import yaml
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from command_line import error_line, uwsim
from uwsim import Batch, Simulator
from uwsim.base.texts.yaml_edit import with_values
from uwsim.evidence.identification import MotionLog, identify
from uwsim.evidence.identification.calibrated_file import write_calibrated
from uwsim.evidence.identification.unknowns import unknowns
from uwsim.evidence.scenario_check import check_part
from uwsim.evidence.validate.flights import deep_scenario
from uwsim.exchange.hulls.draft import drafted, written
from uwsim.scenario import VehicleModel, load_vehicle
from uwsim.scenario.build.hydrodynamics import added_mass_of_ellipsoid
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.mesh_file import Forward, Up
from vehicle_files import box_mesh, scenario_file

LENGTH_M, RADIUS_M = 1.3, 0.15


@pytest.fixture(scope="module")
def torpedo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A capsule along x in millimetres, off centre, with a hole of one triangle."""
    hull = trimesh.creation.capsule(height=LENGTH_M - 2 * RADIUS_M, radius=RADIUS_M, count=[16, 16])
    hull.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [0, 1, 0]))
    hull.apply_translation(np.array([0.6, 0.3, -0.2]) - hull.centroid)
    hull.apply_scale(1000.0)
    hull.update_faces(np.arange(len(hull.faces)) != 40)
    path = tmp_path_factory.mktemp("cad") / "torpedo.stl"
    hull.export(path)
    return path


@pytest.fixture(scope="module")
def mine(torpedo: Path) -> Path:
    ran = uwsim("vehicle", torpedo.name, "--draft", cwd=torpedo.parent)
    assert ran.returncode == 0, ran.stderr
    assert "its scale is 0.001, millimetres, guessed" in ran.stderr and "(600, 300, -200) in the file" in ran.stderr
    assert ran.stderr.count("filled holes") == 1
    path = torpedo.with_name("mine.yaml")
    path.write_text(ran.stdout)
    return path


def tilt_deg(sim: Simulator) -> float:
    return float(np.degrees(np.arccos(sim.rov.pose.world_from_body[2, 2])))


def test_a_draft_has_the_shape_s_closed_forms(mine: Path) -> None:
    """A cylinder about its axis has m r^2 / 2, a ball 2 m r^2 / 5; a prism of 16 facets has 5 % less than either."""
    values = yaml.safe_load(mine.read_text())
    assert values["mesh_scale"] == 1e-3
    volume_m3 = np.pi * RADIUS_M**2 * (LENGTH_M - 2 * RADIUS_M) + 4.0 / 3.0 * np.pi * RADIUS_M**3
    assert 0.4 < values["inertia_kg_m2"][0] / (1000.0 * volume_m3 * RADIUS_M**2) < 0.5
    added = np.array(values["added_mass_matrix"])
    lamb = added_mass_of_ellipsoid(np.array([LENGTH_M / 2, RADIUS_M, RADIUS_M]), 1000.0)
    np.testing.assert_array_equal(added, added.T)
    assert 1.0 < added[1, 1] / lamb[1] < 1.6 and added[1, 1] == pytest.approx(added[2, 2], rel=0.01)
    assert sum("estimated by" in line for line in mine.read_text().splitlines()) >= 10


@pytest.mark.parametrize("beside_m", [0.003, 0.01, 0.03, 0.1])
def test_the_written_matrix_of_a_round_hull_beside_its_axis_stays_positive(beside_m: float) -> None:
    """It is singular: nothing resists a turn about the hull's own axis. Rounded, or without its small entries, it would
    have a direction of negative inertia, which the file's own check refuses."""
    of_axis = np.diag([9.0, 63.0, 63.0, 0.0, 4.3, 4.3])
    shift = np.eye(6)
    shift[:3, 3:] = [[0.0, beside_m, 0.0], [-beside_m, 0.0, 0.0], [0.0, 0.0, 0.0]]
    body = SimpleNamespace(mass_kg=76.0, inertia_kg_m2=np.array([0.9, 7.0, 7.0]), added=shift.T @ of_axis @ shift)
    rounded = np.array([[float(f"{value:.4g}") for value in row] for row in written(body)])
    assert np.linalg.eigvalsh(rounded).min() >= 0.0


def test_the_same_mesh_gives_the_same_draft(torpedo: Path, mine: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(torpedo.parent)
    assert drafted(Path(torpedo.name), ["surge", "heave", "yaw"]).text == mine.read_text()


@pytest.mark.parametrize("wall_m, warned", [(0.004, True), (0.1, False)])
def test_a_thin_shell_is_named(tmp_path: Path, panels_left_out: None, wall_m: float, warned: bool) -> None:
    outside, inside = (
        trimesh.creation.box((1.2, 0.4, 0.3)),
        trimesh.creation.box(np.array([1.2, 0.4, 0.3]) - 2 * wall_m),
    )
    inside.invert()
    trimesh.util.concatenate([outside, inside]).export(tmp_path / "hull.stl")
    made = drafted(tmp_path / "hull.stl", ["surge", "yaw"])
    assert any("of its convex hull: where it is a shell" in doubt for doubt in made.doubts) == warned
    assert ("it fills only" in made.text) == warned


def test_a_hull_along_y_is_drafted_with_its_bow_there(tmp_path: Path, panels_left_out: None) -> None:
    (along_x := trimesh.creation.box((1.2, 0.4, 0.3))).export(tmp_path / "hull.stl")
    as_given = yaml.safe_load(drafted(tmp_path / "hull.stl", ["surge", "yaw"]).text)
    along_x.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [0, 0, 1])).export(tmp_path / "hull.stl")
    found = drafted(tmp_path / "hull.stl", ["surge", "yaw"])
    assert any("3 times as long along y as along x: the bow is taken to be along y" in note for note in found.notes)
    turned = yaml.safe_load(found.text)
    assert turned.pop("mesh_forward") == "y"
    assert turned == as_given
    assert "mesh_forward" not in yaml.safe_load(drafted(tmp_path / "hull.stl", ["yaw"], forward="x").text)


@pytest.mark.parametrize(("up", "forward"), [("-x", "x"), ("x", "-x"), ("y", "-y"), ("-y", "y")])
def test_a_hull_on_its_tail_is_asked_about_and_laid_down(
    tmp_path: Path, panels_left_out: None, up: Up, forward: Forward
) -> None:
    """The same file results as for the hull that lies; by either of the axes across, its bow is found or given."""
    (hull := trimesh.creation.box((1.2, 0.3, 0.3))).export(tmp_path / "hull.stl")
    lying = yaml.safe_load(drafted(tmp_path / "hull.stl", ["surge", "yaw"]).text)
    hull.apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2, [0, 1, 0])).export(tmp_path / "hull.stl")
    asked = (
        "4 times as high as long: where it stands on its tail, name the file's axis that points up, --up x or --up y"
    )
    assert any(asked in doubt for doubt in drafted(tmp_path / "hull.stl", ["surge", "yaw"]).doubts)
    laid = drafted(tmp_path / "hull.stl", ["surge", "yaw"], forward=forward, up=up)
    assert not any("as high as long" in doubt for doubt in laid.doubts)
    values = yaml.safe_load(laid.text)
    assert (values.pop("mesh_up"), values.pop("mesh_forward", "x")) == (up, forward)
    assert values == lying


def test_a_guess_of_the_scale_is_asked_about(tmp_path: Path, panels_left_out: None) -> None:
    mesh = box_mesh(tmp_path / "hull.obj", scale=100.0)
    longest = float(np.ptp(trimesh.load(mesh).vertices, axis=0).max())
    (doubt,) = drafted(mesh, ["surge"]).doubts
    assert f"{longest * 0.0254:.3g} m long" in doubt and "in inches: state --unit, --length-m or --mass-kg" in doubt
    stated = drafted(mesh, ["surge"], length_m=2.0)
    assert stated.doubts == () and yaml.safe_load(stated.text)["mesh_scale"] == pytest.approx(2.0 / longest, rel=1e-5)
    stated.text.index("of the length of 2 m, as given")
    volume = float(trimesh.load(mesh).volume) * 1e-6
    assert drafted(mesh, ["surge"], mass_kg=1100.0 * volume, unit="centimetres").doubts == ()
    (doubt,) = drafted(mesh, ["surge"], mass_kg=8000.0 * volume, unit="centimetres").doubts
    assert f"neutral if it were {2.0 * longest * 0.01:.3g} m long" in doubt  # twice as long holds eight times the mass


def test_a_hull_of_14_m_loads(tmp_path: Path, panels_left_out: None) -> None:
    trimesh.creation.box((14.0, 14.0, 1.5)).export(tmp_path / "gate.glb")
    (tmp_path / "gate.yaml").write_text(drafted(tmp_path / "gate.glb", ["surge", "yaw"], up="z").text)
    assert max(load_vehicle(tmp_path / "gate.yaml").quadratic_damping or ()) > 1e6


def test_a_draft_rests_level_and_keeps_its_depth(mine: Path, tmp_path: Path) -> None:
    with Simulator(scenario_file(tmp_path, mine)) as sim:
        sim.advance(20.0)
        assert tilt_deg(sim) < 0.5
        assert sim.rov.pose.position_world_m[2] == pytest.approx(-20.0, abs=0.02)
        sim.rov.set_effort(surge=0.5)
        sim.advance(20.0)
        assert sim.rov.velocity.linear_body_m_s[0] > 1.0 and tilt_deg(sim) < 5.0


def test_a_draft_surveys_without_another_edit(mine: Path, tmp_path: Path) -> None:
    ran = uwsim("survey", "lagoon", "--vehicle-model", mine, "--out", tmp_path / "out", "--report", "json")
    assert ran.returncode == 0, ran.stderr
    assert json.loads((tmp_path / "out/summary.json").read_text())["map"]["coverage"] > 0.9


FACTORS = {"added_mass": 0.8, "linear_damping": 1.3, "quadratic_damping": 1.5, "thrust_gain": 0.9, "thrust_lag": 1.6}
NOISE = np.repeat((0.02, 0.005, 0.01, 0.005), 3)  # of position [m], attitude [rad], velocity [m/s], rate [rad/s]


def flown(model: VehicleModel, seed: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return efforts (81, 6) that change every second, and the motion (81, 13) that they cause, every 0.1 s."""
    batch = Batch(deep_scenario(model.model_copy(update={"sensors": {}, "sonar": None})), n=1)
    changes = np.random.default_rng(seed).uniform(-1, 1, (9, 6)) * [0.6, 0, 0.6, 0, 0, 0.4]
    efforts, rows = np.repeat(changes, 10, axis=0)[:81], []
    for effort in efforts:
        motion = batch.observe()
        rows.append(np.hstack([motion.position_world_m[0], motion.orientation_xyzw[0], motion.velocity_body[0]]))
        batch.step(20, effort[None])
    return efforts, np.array(rows)


def test_a_log_calibrates_a_draft(mine: Path) -> None:
    """A vehicle that differs from its draft by FACTORS flies two logs; the first leads to values that fit the second.

    In the second log, the draft's speeds and rates are off by 0.032 m/s and rad/s rms, those of the new file by 0.005.
    """
    draft = load_vehicle(mine)
    truth = {each: each.value * FACTORS[each.group] for each in unknowns(draft, "rov") if each.group in FACTORS}
    numbers = {place: f"{value:.6g}" for each, value in truth.items() for place in each.places}
    (real := mine.with_name("real.yaml")).write_text(with_values(mine.read_text(), "mine.yaml", numbers))
    efforts, rows = flown(load_vehicle(real), seed=1)
    noise = np.random.default_rng(0).standard_normal((81, 12)) * NOISE
    turns = (Rotation.from_quat(rows[:, 3:7]) * Rotation.from_rotvec(noise[:, 3:6])).as_quat()
    times_s = 0.1 * np.arange(81)
    motion = (rows[:, :3] + noise[:, :3], turns, rows[:, 7:] + noise[:, 6:])
    known = ("command_delay", "current_m_s", "added_mass.roll", "quadratic_damping.roll")
    found = identify(MotionLog(times_s, *motion, times_s, efforts, {}), draft, known=known)
    write_calibrated(found, "run.csv", mine2 := mine.with_name("mine2.yaml"))

    before, after = mine.read_text().splitlines(), mine2.read_text().splitlines()
    assert all(a in before or "measured in run.csv, 95 %: " in a for a in after)
    assert len(after) == len(before) + 1 and any(a.startswith("volume_m3: ") for a in after)  # not stated before
    assert {value.name for value in found.values.values() if not value.is_determined} >= {"linear_damping.surge"}
    assert [line for line in after if line.startswith("  - 0.") and "surge: estimated by the quadratic drag" in line]
    speeds = [flown(load_vehicle(path), seed=2)[1][:, 7:] for path in (real, mine, mine2)]
    off = [float(np.sqrt(np.mean((each - speeds[0]) ** 2))) for each in speeds[1:]]
    assert off[1] < off[0] / 4, off


@pytest.mark.parametrize("axes", ["surge,yaw,heave,sway", "surge,sway,heave,roll,pitch,yaw", "surge,pitch"])
def test_thrusters_drive_the_axes_asked_for(axes: str, tmp_path: Path, panels_left_out: None) -> None:
    (tmp_path / "mine.yaml").write_text(drafted(box_mesh(tmp_path / "hull.obj"), axes.split(",")).text)
    with Simulator(scenario_file(tmp_path, tmp_path / "mine.yaml")) as sim:
        assert sim.rov.controllable >= set(axes.split(","))


def test_the_unit_follows_from_the_mass_or_is_given(tmp_path: Path, panels_left_out: None) -> None:
    mesh = box_mesh(tmp_path / "hull.obj", scale=100.0)
    assert "mesh_scale: 0.01 " in drafted(mesh, ["surge"]).text
    assert "mesh_scale: 0.0254 " in drafted(mesh, ["surge"], mass_kg=12000.0).text
    assert "mesh_scale: 0.3048 " in drafted(mesh, ["surge"], unit="feet").text
    with pytest.raises(ScenarioError, match=r"no unit makes 0\.001 kg a plausible mass"):
        drafted(mesh, ["surge"], mass_kg=0.001)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--draft", "--axes", "surge,jaw"), "--axes = 'jaw'"),
        (("--draft", "--unit", "km"), "--unit = 'km'"),
        (("--draft", "--json"), "leave out --out and --json"),
        (("--draft", "--up", "w"), "--up = 'w': must be one of x, -x, y, -y, z, -z"),
        (("--draft", "--unit", "mm", "--length-m", "2"), "--unit and --length-m both state the scale"),
        (("--up", "x"), "--up has no effect without --draft"),
        (("--axes", "surge"), "--axes has no effect without --draft"),
    ],
)
def test_wrong_options_are_refused(options: tuple[str, ...], message: str, torpedo: Path) -> None:
    ran = uwsim("vehicle", torpedo, *options)
    assert ran.returncode == 2 and message in error_line(ran) and ran.stdout == ""


def test_a_file_that_is_no_mesh_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "hull.stl").write_text("no mesh")
    ran = uwsim("vehicle", tmp_path / "hull.stl", "--draft")
    assert ran.returncode == 1 and "not a readable stl file" in error_line(ran) and ran.stdout == ""


@pytest.mark.usefixtures("panels_left_out")
@pytest.mark.parametrize("size_m, sway", [((2.6, 1.5, 1.6), True), ((1.3, 0.3, 0.3), False)])
def test_a_hull_whose_side_slip_lasts_is_given_sway(
    size_m: tuple[float, float, float], sway: bool, tmp_path: Path
) -> None:
    """The estimate is that of a flight: `uwsim vehicle` of the same draft without sway."""
    mesh = box_mesh(tmp_path / "hull.obj", size_m)
    made = drafted(mesh, unit="metres")
    (note,) = [note for note in made.notes if "its thrusters drive" in note]
    assert ("surge, sway, heave, yaw" in note) == sway
    (tmp_path / "mine.yaml").write_text(drafted(mesh, ["surge", "heave", "yaw"], unit="metres").text)
    check = check_part(tmp_path / "mine.yaml", "vehicle")
    assert check.vehicle is not None and check.vehicle.slip is not None
    stated = float(note.split("halves in ")[1].split(" s")[0])
    assert check.vehicle.slip.time_s == pytest.approx(stated, rel=0.1, abs=0.2)
