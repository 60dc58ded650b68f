"""`uwsim vehicle` reports a vehicle's coefficients, motion and views as closed forms and a panel code give them."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from command_line import uwsim
from uwsim import Simulator, _core
from uwsim.evidence.scenario_check import CheckReport, check_part
from uwsim.evidence.vehicle.estimates import estimates
from uwsim.evidence.vehicle.linear_motion import course_growth_1_s, model_motion, modes, motion_matrix
from uwsim.evidence.vehicle.report import allocation, vehicle_report
from uwsim.evidence.vehicle.sheets import SUPPLY_V, Statements, hover_power_w
from uwsim.evidence.vehicle.trials import straight_run
from uwsim.evidence.vehicle.views import fields_of_view
from uwsim.exchange.hulls.hull_drag import ACROSS
from uwsim.scenario import load_vehicle
from uwsim.scenario.build.hydrodynamics import added_mass_of_ellipsoid, simplified
from uwsim.scenario.read.spec_file import read_spec
from uwsim.scenario.spec.actuator import Control
from vehicle_files import vehicle_file

WATER_KG_M3, GRAVITY_M_S2 = 1000.0, 9.80665
SPHERE = trimesh.creation.icosphere(subdivisions=3)


def checked(folder: Path, without: tuple[str, ...] = (), **changes: Any) -> CheckReport:
    return check_part(vehicle_file(folder, without=without, **changes), "vehicle")


def simulator(check: CheckReport) -> Simulator:
    assert check.simulator is not None, check.mistakes
    return check.simulator


@pytest.mark.parametrize("subdivisions", [3, 4])
def test_panels_have_the_added_mass_of_an_ellipsoid(subdivisions: int) -> None:
    """Lamb's closed form for the volume that the flat triangles enclose, however many are simplified."""
    axes_m = np.array([0.8, 0.2, 0.1])
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions)
    shrunk = np.cbrt(mesh.volume / (4.0 / 3.0 * np.pi))
    matrix = _core.added_mass(*simplified(mesh.vertices * axes_m, mesh.faces), WATER_KG_M3, 1500)
    lamb = added_mass_of_ellipsoid(shrunk * axes_m, WATER_KG_M3)
    np.testing.assert_allclose(np.diagonal(matrix), lamb, rtol=0.002)
    np.testing.assert_allclose(matrix - np.diag(np.diagonal(matrix)), 0.0, atol=5e-4 * matrix.max())


def test_the_edges_of_a_box_need_no_fine_panels() -> None:
    """The potential is singular at edges; with equal panels, 800 are 3 % low in translation, and 8 % in rotation."""
    box = trimesh.creation.box((1.2, 0.8, 0.7))
    fine, coarse = (np.diagonal(_core.added_mass(box.vertices, box.faces, WATER_KG_M3, n)) for n in (2400, 800))
    assert (coarse < fine).all()
    np.testing.assert_allclose(coarse[:3], fine[:3], rtol=0.003)
    np.testing.assert_allclose(coarse[3:], fine[3:], rtol=0.015)


def test_added_mass_moves_with_the_origin() -> None:
    """A point of the body at r moves with v + w x r: A' = T^T A T, as for any rigid motion."""
    hull = trimesh.creation.box((0.6, 0.3, 0.2))
    offset_m = np.array([0.3, -0.2, 0.1])
    move = np.eye(6)
    move[:3, 3:] = -np.cross(np.eye(3), offset_m)
    centred = _core.added_mass(hull.vertices, hull.faces, WATER_KG_M3, 800)
    moved = _core.added_mass(hull.vertices + offset_m, hull.faces, WATER_KG_M3, 800)
    np.testing.assert_allclose(moved, move.T @ centred @ move, atol=1e-3 * moved.max())
    np.testing.assert_array_equal(moved, moved.T)
    assert np.linalg.eigvalsh(moved)[0] > 0.0


def test_lamb_s_ellipsoids_have_their_published_limits() -> None:
    """A sphere has half its displaced mass; Fossen's REMUS 100 has 0.84, 29.4 and 3.43 (PythonVehicleSimulator)."""
    sphere = added_mass_of_ellipsoid(np.ones(3), WATER_KG_M3)
    np.testing.assert_allclose(sphere, [2000.0 / 3.0 * np.pi] * 3 + [0.0] * 3, rtol=1e-9)
    remus = added_mass_of_ellipsoid(np.array([0.8, 0.095, 0.095]), 1026.0)
    np.testing.assert_allclose(remus, [0.84, 29.4, 29.4, 0.0, 3.43, 3.43], rtol=2e-3)


@pytest.mark.usefixtures("panels_left_out")
def test_silhouettes_give_a_box_its_drag() -> None:
    """Strips of width w over a length l have a third moment of w l^4 / 32 about the middle, as in Prestero's REMUS."""
    size_m = length, width, height = 1.2, 0.8, 0.7
    box = trimesh.creation.box(size_m)
    gyration = np.sqrt(np.array([width**2 + height**2, length**2 + height**2, length**2 + width**2]) / 12.0)
    found = estimates(box.vertices, box.faces, tuple(gyration), WATER_KG_M3, 1.0)

    def turning(a: float, b: float, depth: float) -> float:
        """Rotation in the plane of a and b: strips along a move along b, and the other way round."""
        return depth * (a**4 + b**4) / 32.0

    arms = [turning(width, height, length), turning(length, height, width), turning(length, width, height)]
    areas = [width * height, length * height, length * width]
    np.testing.assert_allclose(found.bluff, 0.5 * WATER_KG_M3 * ACROSS * np.array([*areas, *arms]), rtol=0.02)


@pytest.mark.usefixtures("panels_left_out")
def test_a_box_reports_its_closed_forms(tmp_path: Path) -> None:
    """Terminal speed: K v^2 + D v = F. Roll at rest: a pendulum, (I + A) w^2 = W GM, damped by D / 2 (I + A)."""
    check = checked(tmp_path)
    assert check.vehicle is not None
    report = vehicle_report(simulator(check), check.vehicle)
    for axis, force in ((0, 800.0), (1, 300.0), (2, 300.0)):
        square, linear = report.quadratic_damping[axis], report.linear_damping[axis]
        speed = (-linear + np.sqrt(linear**2 + 4.0 * square * force)) / (2.0 * square)
        np.testing.assert_allclose(report.terminal[axis], speed, rtol=2e-3)
    mass_kg, lever_m = 672.0, 0.1
    inertia = mass_kg / 12.0 * (0.8**2 + 0.7**2) + 23.0
    (roll,) = (mode for mode in report.motions[0.0] if mode.moves == "roll")
    assert roll.growth_1_s == pytest.approx(-60.0 / (2.0 * inertia), rel=0.05)  # coupled to sway by the lever
    size = np.hypot(roll.growth_1_s, roll.frequency_rad_s)
    assert size == pytest.approx(np.sqrt(mass_kg * GRAVITY_M_S2 * lever_m / inertia), rel=0.05)
    assert report.allocation.rank is None
    assert report.allocation.driven == ("surge", "sway", "heave", "roll", "pitch", "yaw")


@pytest.mark.usefixtures("panels_left_out")
def test_a_slow_hull_reaches_its_speed(tmp_path: Path) -> None:
    """K v^2 = F, approached like tanh(t / tau), tau = (m + A) v / F = 33 s."""
    check = checked(
        tmp_path, max_force_n=[20, 20, 20], linear_damping=[0.01, 0.01, 0.01, 60, 80, 30],
        quadratic_damping=[40, 40, 40, 13, 30, 30],
    )  # fmt: skip
    assert check.vehicle is not None
    speeds = vehicle_report(simulator(check), check.vehicle).terminal[:3]
    np.testing.assert_allclose(speeds, np.sqrt(20.0 / 40.0), rtol=1e-3)


def test_a_side_slip_dies_down_by_its_drag(tmp_path: Path) -> None:
    """m dv/dt = -(a + b v) v: v / 2 after m / a ln((2 a + b v) / (a + b v)) and m / b ln((a + b v) / (a + b v / 2)).

    The centre of mass is at the origin, so that a slip does not roll the box.
    """
    check = checked(tmp_path, max_force_n=[800, 0, 300], centre_of_mass_m=[0.0, 0.0, 0.0])
    assert check.vehicle is not None and check.vehicle.slip is not None
    mass_kg, a, b, v = check.vehicle.mass_kg + 250.0, 50.0, 450.0, 0.5
    assert check.vehicle.slip.time_s == pytest.approx(mass_kg / a * np.log((2 * a + b * v) / (a + b * v)), abs=0.11)
    along_m = mass_kg / b * np.log((a + b * v) / (a + b * v / 2))
    assert check.vehicle.slip.distance_m == pytest.approx(along_m, abs=0.03)
    steered = checked(tmp_path)
    assert steered.vehicle is not None and steered.vehicle.slip is None


def test_a_thrust_above_the_centre_pitches_a_straight_run_down(tmp_path: Path) -> None:
    """T h = W GM sin(pitch), with T = K v^2 + D v, since this box has no Munk moment; it dives along its own axis."""
    height_m, lever_m = 0.25, 0.01
    mount = {"model": "t200_16v", "axis": [1, 0, 0]}
    thrusters = {
        "port": {**mount, "spin": "clockwise", "position_m": [0, 0.3, height_m]},
        "starboard": {**mount, "spin": "counter-clockwise", "position_m": [0, -0.3, height_m]},
    }
    check = checked(tmp_path, ("max_force_n", "max_torque_nm"), thrusters=thrusters, centre_of_mass_m=[0, 0, -lever_m])
    assert check.vehicle is not None
    run = check.vehicle.straight
    assert run is not None
    thrust_n = 300.0 * run.speed_m_s**2 + 30.0 * run.speed_m_s
    expected_deg = np.degrees(np.arcsin(thrust_n * height_m / (672.0 * GRAVITY_M_S2 * lever_m)))
    assert run.nose_down_deg == pytest.approx(expected_deg, abs=1.0)
    assert run.climb_m < 0.0 and abs(run.roll_to_starboard_deg) < 0.1 and abs(run.heading_change_deg) < 0.1
    assert [warning for warning in check.warnings if "thrust" in warning and "nose down" in warning]


def test_a_straight_run_without_fins_names_the_munk_moment() -> None:
    model = load_vehicle("remus100")
    sound = straight_run(model, WATER_KG_M3, None)
    assert sound.tilt_deg < 15.0 and sound.tilt_without_munk_deg is None
    bare = straight_run(model.model_copy(update={"fins": {}, "control": Control()}), WATER_KG_M3, None)
    assert abs(bare.heading_change_deg) > 360.0 and bare.speed_m_s < sound.speed_m_s
    assert bare.tilt_without_munk_deg is not None and bare.tilt_without_munk_deg < 15.0 < bare.tilt_deg


def test_a_flight_decays_as_its_eigenvalues_say() -> None:
    """The simulator, released with a small sway and yaw on a straight course, so briefly that it hardly slows down."""
    sim, speed, flown_s = simulator(check_part("remus100", "vehicle")), 2.0, 0.1
    matrix = model_motion(sim.scenario.vehicles[0].model, None, WATER_KG_M3, speed)
    start = np.array([0, 0.002, 0, 0, 0, 0.002, 0, 0])
    sim.rov.place((0, 0, -100), velocity_body=start[:6] + speed * np.eye(6)[0])
    sim.advance(flown_s)
    motion = np.concatenate([sim.rov.velocity.linear_body_m_s, sim.rov.velocity.angular_body_rad_s])
    values, vectors = np.linalg.eig(matrix)
    expected = (vectors @ (np.exp(flown_s * values) * np.linalg.solve(vectors, start))).real
    np.testing.assert_allclose(motion[[1, 5]], expected[[1, 5]], rtol=0.05)
    assert motion[5] < 0.8 * start[5]
    assert course_growth_1_s(matrix) < 0.0


def test_a_hull_with_its_weight_on_top_has_a_growing_mode() -> None:
    parameters = _core.CraftParameters()
    parameters.mass_kg = float(SPHERE.volume) * WATER_KG_M3
    parameters.centre_of_mass_body_m, parameters.inertia_kg_m2 = np.array([0, 0, 0.05]), 100.0 * np.eye(3)
    craft = _core.Craft(parameters, SPHERE.vertices, SPHERE.faces)
    assert modes(motion_matrix(craft, [], 0.0, WATER_KG_M3))[0].growth_1_s > 0.1


def test_the_rank_falls_with_the_thruster_that_is_alone_on_its_axis(tmp_path: Path) -> None:
    mounts = {
        "port": {"position_m": [-0.5, 0.3, 0], "axis": [1, 0, 0]},
        "starboard": {"position_m": [-0.5, -0.3, 0], "axis": [1, 0, 0]},
        "second_port": {"position_m": [0.5, 0.3, 0], "axis": [1, 0, 0]},
        "lift": {"position_m": [0, 0, 0], "axis": [0, 0, 1]},
    }
    thrusters = {name: {"model": "t200_16v", "spin": "clockwise", **mount} for name, mount in mounts.items()}
    own = allocation(simulator(checked(tmp_path, ("max_force_n", "max_torque_nm"), thrusters=thrusters)))
    assert own.rank == 3  # surge, heave, yaw
    assert own.rank_without == {"port": 3, "starboard": 2, "second_port": 3, "lift": 2}


def test_a_camera_that_looks_back_sees_its_hull(tmp_path: Path) -> None:
    """1 m ahead of a face of 0.8 x 0.7 m, with a square picture of 90 degrees: 0.8 x 0.7 of 2 x 2 m in its plane."""
    back = {"position_m": [1.6, 0, 0], "yaw_pitch_roll_deg": [180, 0, 0], "field_of_view_deg": 90}
    cameras = {"back": {**back, "width": 64, "height": 64}, "ahead": {"position_m": [0.7, 0, 0]}}
    views = {view.label: view for view in fields_of_view(simulator(checked(tmp_path, cameras=cameras)))}
    assert views["cameras.back"].share == pytest.approx(0.8 * 0.7 / 4.0, rel=0.05)
    assert views["cameras.back"].nearest_m == pytest.approx(1.0, rel=0.01)
    assert views["cameras.ahead"].share == 0.0 and np.isinf(views["cameras.ahead"].nearest_m)


def test_the_command_writes_rows_a_page_or_json(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    ran = uwsim("vehicle", "remus100", "--out", page)
    assert ran.returncode == 0, ran.stderr
    row = next(line for line in ran.stdout.splitlines() if "speed at full ahead" in line)
    assert row.split()[5:8] == ["2.55", "2.5", "2000"], "what is stated, beside what it does"
    values = json.loads(uwsim("vehicle", vehicle_file(tmp_path), "--json").stdout)
    assert values["vehicle"] == "box" and values["allocation"]["rank"] is None
    text = page.read_text()
    assert text.count("data:image/png;base64,") == 3 and "Added mass [kg, kg m2]" in text


def test_a_mistake_in_the_file_is_one_line(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    ran = uwsim("vehicle", vehicle_file(tmp_path, added_mass=[1, 2]), "--out", page)
    assert ran.returncode == 1 and not page.exists()
    assert len(ran.stderr.splitlines()) == 1 and "added_mass" in ran.stderr, ran.stderr
    assert ran.stdout == ""


def test_a_thrust_without_a_speed_is_one_line(tmp_path: Path) -> None:
    slippery = {"linear_damping": [1e-3] * 6, "quadratic_damping": [0.0] * 6, "max_force_n": [1e5, 300, 300]}
    done = uwsim("vehicle", vehicle_file(tmp_path, **slippery))
    assert done.returncode != 0
    assert done.stderr.strip().startswith("uwsim: error: vehicle 'box': full effort on surge drives it beyond 99 m/s")
    assert "\n" not in done.stderr.strip()


def test_what_is_stated_is_of_packaged_vehicles_and_has_a_source() -> None:
    statements = read_spec(Statements, "vehicles", "claims").statements
    for each in statements:
        assert each.source and all(load_vehicle(name).name == name for name in each.vehicles)
    keys = [(name, each.quantity) for each in statements for name in each.vehicles]
    assert len({*keys}) == len(keys)


def test_hovering_takes_the_power_of_the_sheets_of_its_thrusters() -> None:
    heavy = load_vehicle("bluerov2_heavy")
    power_w = [hover_power_w(heavy, -load_n) for load_n in (40.0, 80.0)]
    assert (
        power_w[0] and power_w[1] and 2.0 < power_w[1] / power_w[0] < 2.0**1.7
    )  # F^1.5 by momentum, and the motors' losses
    sheets = heavy.thrusters["vertical_front_left"].model.performance()
    force_n, current_a, _ = sheets.at(0.4, SUPPLY_V)
    assert hover_power_w(heavy, -4 * force_n) == pytest.approx(4 * SUPPLY_V * current_a)
    assert hover_power_w(heavy, -1e4) is None  # it cannot
    assert hover_power_w(load_vehicle("otter"), -1.0) is None  # nothing upright
