"""`uwsim scenario from` an SDF, URDF or Stonefish file: small vehicles of our own in those formats.

The laws: terminal speed and trim by the formulas of each source, and what is where in the world.
"""

import os
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import uwsim
from command_line import uwsim as command
from uwsim.evidence.scenario_check import check_part
from uwsim.evidence.vehicle.figures import VehicleFigures
from uwsim.evidence.vehicle.trials import terminal_speeds
from uwsim.exchange.robots import shapes
from uwsim.exchange.robots.robot import Lump, Robot
from uwsim.exchange.robots.sdf import read_sdf
from uwsim.exchange.robots.stonefish import read_stonefish
from uwsim.exchange.robots.stonefish_text import formula
from uwsim.exchange.robots.urdf import read_urdf
from uwsim.exchange.robots.written import _ply, write_found
from uwsim.exchange.robots.xml_file import HERE, Pose, read_xml, turned, yaw_pitch_roll_deg

pytestmark = pytest.mark.usefixtures("panels_left_out")

G = 9.80665
DATA = Path(__file__).parents[1] / "data" / "robots"
WORLD, URDF, SCN = ((DATA / name).read_text() for name in ("glider.sdf", "sled.urdf", "robot.scn"))


def screw(right: str, inverted: str) -> str:
    """The Stonefish scenario with another propeller."""
    changed = SCN.replace('right="true"', f'right="{right}"')
    return changed.replace('inverted_setpoint="false"', f'inverted_setpoint="{inverted}"')


def made(tmp_path: Path, name: str, text: str) -> tuple[uwsim.Simulator, str]:
    """A simulator of what the command makes of a file, and what it printed."""
    (tmp_path / name).write_text(text)
    done = command("scenario", "from", tmp_path / name, "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    (path,) = [file for file in (tmp_path / "out").glob("*.yaml") if "vehicles:" in file.read_text()]
    (tmp_path / "out").rename(tmp_path / "moved")  # the folder is complete
    return uwsim.Simulator(tmp_path / "moved" / path.name), done.stdout


def reported(vehicle: Path) -> tuple[VehicleFigures, NDArray[np.float64]]:
    """The figures of a vehicle's file, and its terminal speeds."""
    check = check_part(vehicle, "vehicle")
    assert check.vehicle is not None and check.simulator is not None, check.mistakes
    return check.vehicle, terminal_speeds(check.simulator.scenario)


def steady(force_n: float, linear: float, quadratic: float) -> float:
    """The speed at which drag equals a force."""
    return float((-linear + np.sqrt(linear**2 + 4.0 * quadratic * force_n)) / (2.0 * quadratic))


def test_an_sdf_vehicle_has_the_source_s_speed_and_trim(tmp_path: Path) -> None:
    sim, printed = made(tmp_path, "world.sdf", WORLD)
    (rov,) = sim.vehicles.values()
    assert sim.scenario.water.density_kg_m3 == 1025.0
    np.testing.assert_allclose(rov.pose.position_world_m, [5.0, 2.0, -6.0])
    assert sim.scenario.vehicles[0].start.yaw_deg == pytest.approx(np.degrees(0.5), abs=1e-3)
    model = sim.scenario.vehicles[0].model
    assert model.mass_kg == pytest.approx(100.0)  # the propellers are part of it
    np.testing.assert_allclose(model.centre_of_mass_m, [-0.009, 0.0, -0.0495], atol=1e-9)
    figures, terminal = reported(tmp_path / "moved" / "glider.yaml")
    assert figures.net_buoyancy_n == pytest.approx((0.1 * 1000.0 - 100.0) * G, abs=0.01)  # in fresh water
    assert terminal[0] == pytest.approx([steady(80.0, 4.0, 20.0)] * 2, rel=0.003)
    for note in ("sensor 'nose'", "yVabsR", "model 'crate'"):
        assert note in printed
    assert {*model.cameras} == {"eye"} and {*model.sensors} == {"inertial"}


def test_rounded_angles_of_thrusters_are_straight(tmp_path: Path) -> None:
    """As in bluerov2_gz, where axes of 1.571 rad left 4 N of 141 N to surge, the rest to balance a pitch of nothing."""
    crooked = WORLD.replace("1.5707963267948966 0</pose><inertial><mass>0.5", "1.571 0</pose><inertial><mass>0.5", 1)
    sim, _ = made(tmp_path, "world.sdf", crooked)
    for thruster in sim.scenario.vehicles[0].model.thrusters.values():
        np.testing.assert_array_equal(thruster.axis, [1.0, 0.0, 0.0])


RUDDER = """
    <link name="rudder"><pose>-1 0 0.2 0 0 0</pose><inertial><mass>0.1</mass></inertial></link>
    <joint name="rudder_joint" type="revolute"><parent>base</parent><child>rudder</child>
      <axis><xyz>0 0 AXIS</xyz><limit><lower>-0.4</lower><upper>0.5</upper></limit></axis></joint>
    <plugin filename="gz-sim-lift-drag-system" name="gz::sim::systems::LiftDrag"><link_name>rudder</link_name>
      <air_density>1000</air_density><cla>4.0</cla><cda>0.2</cda><alpha_stall>0.3</alpha_stall><area>0.05</area>
      <cp>-0.1 0 0.05</cp><forward>FORWARD</forward><upward>0 1 0</upward></plugin>
  </model>
  <model name="pier">"""


def ruddered(axis: int, forward: str) -> str:
    rudder = RUDDER.replace("AXIS", str(axis)).replace("FORWARD", forward)
    return WORLD.replace('</model>\n  <model name="pier">', rudder.strip("\n"))


@pytest.mark.parametrize("axis", [1, -1])
def test_an_sdf_rudder_has_the_source_s_lift(axis: int, tmp_path: Path) -> None:
    """gz-sim's LiftDrag: q A cla alpha, with its own density, across the flow at the centre of pressure."""
    sim, printed = made(tmp_path, "world.sdf", ruddered(axis, "1 0 0"))
    (rov,) = sim.vehicles.values()
    assert "smaller of its limits" in printed
    assert sim.scenario.vehicles[0].model.fins["rudder"].deflection_max_deg == pytest.approx(np.degrees(0.4))
    angle, speed = 0.08, 2.0
    rov.set_fins({"rudder": angle})
    sim.advance(0.5)
    rov.place([0, 0, -8], [0, 0, 0, 1], [speed, 0, 0, 0, 0, 0])
    sim.step()
    lift_n = 0.5 * 1000.0 * speed**2 * 0.05 * 4.0 * angle
    wrench = rov.forces["actuators"]
    assert wrench.force_body_n[1] == pytest.approx(axis * lift_n, rel=0.01)  # x turned to port of a joint about z
    assert wrench.torque_body_nm[2] == pytest.approx(-1.1 * axis * lift_n, rel=0.01)
    assert wrench.torque_body_nm[0] == pytest.approx(-0.25 * axis * lift_n, rel=0.01)


@pytest.mark.parametrize("kind", ["TwoLines", "Steep", "Quadratic"])
def test_a_urdf_fin_has_the_source_s_lift(kind: str, tmp_path: Path) -> None:
    """UUV Simulator's LiftDragModel: rho u^2 A cla alpha / 2, or a constant times u^2 alpha."""
    coefficients = {
        "TwoLines": "<area>0.05</area><fluid_density>1000</fluid_density><a0>0</a0><alpha_stall>0.3</alpha_stall>"
        "<cla>4</cla><cla_stall>-1</cla_stall><cda>0.1</cda><cda_stall>1</cda_stall>",
        "Steep": "<area>0.0125</area><fluid_density>1000</fluid_density><a0>0</a0><alpha_stall>0.3</alpha_stall>"
        "<cla>16</cla><cla_stall>-1</cla_stall><cda>0.1</cda><cda_stall>1</cda_stall>",  # no thin fin is beyond 2 pi
        "Quadratic": "<lift_constant>100</lift_constant><drag_constant>1</drag_constant>",
    }[kind]
    fin = f"""<link name="fin0"/><joint name="fin0_joint" type="revolute"><origin xyz="-0.5 0 0.2"/>
      <axis xyz="0 0 1"/><parent link="base"/><child link="fin0"/><limit lower="-0.4" upper="0.4"/></joint>
      <gazebo><plugin name="f" filename="libuuv_fin_ros_plugin.so"><link_name>fin0</link_name>
      <liftdrag><type>{kind.replace("Steep", "TwoLines")}</type>{coefficients}</liftdrag></plugin></gazebo></robot>"""
    sim, _ = made(tmp_path, "sled.urdf", URDF.replace("</robot>", fin))
    (rov,) = sim.vehicles.values()
    rov.set_fins({"fin0": 0.08})
    sim.advance(0.5)
    rov.place([0, 0, -8], [0, 0, 0, 1], [2.0, 0, 0, 0, 0, 0])
    sim.step()
    assert rov.forces["actuators"].force_body_n[1] == pytest.approx(100.0 * 2.0**2 * 0.08, rel=0.01)


def test_a_fin_turns_no_further_than_its_lift_grows(tmp_path: Path) -> None:
    """C_La sin a cos a is greatest at 45 deg; a fin that turned by 90 deg would steer the other way."""
    wide = ruddered(1, "1 0 0").replace("<lower>-0.4", "<lower>-1.5708").replace("<upper>0.5", "<upper>1.5708")
    wide = wide.replace("<alpha_stall>0.3", "<alpha_stall>1.5708")
    sim, printed = made(tmp_path, "world.sdf", wide)
    assert "joint 'rudder_joint': it turns by 45 deg, at which its lift is greatest, not 90" in printed
    (rov,) = sim.vehicles.values()
    forces_n = []
    for angle in np.radians([15, 30, 44.9]):
        rov.place([0, 0, -8], [0, 0, 0, 1])
        rov.set_fins({"rudder": angle})
        sim.advance(1.5)
        rov.place([0, 0, -8], [0, 0, 0, 1], [2.0, 0, 0, 0, 0, 0])
        sim.step()
        forces_n.append(rov.forces["actuators"].force_body_n[1])
    assert sim.scenario.vehicles[0].model.fins["rudder"].deflection_max_deg == pytest.approx(45.0)
    assert forces_n[0] < forces_n[1] < forces_n[2]


def test_a_surface_that_uwsim_does_not_have_is_named(tmp_path: Path) -> None:
    sim, printed = made(tmp_path, "world.sdf", ruddered(1, "0 0 1"))
    assert "its forward direction is not the vehicle's" in printed
    assert not sim.scenario.vehicles[0].model.fins
    (tmp_path / "flat.sdf").write_text(ruddered(1, "0 0 0"))
    assert any(
        "forward and upward must be two directions" in note.text for note in read_sdf(tmp_path / "flat.sdf").notes
    )


def test_sdf_obstacles_are_where_their_poses_put_them(tmp_path: Path) -> None:
    sim, _ = made(tmp_path, "world.sdf", WORLD)
    axis_m = np.array([3.0, 5.0, -2.0])  # a quarter turn takes 1 m along x to 1 m along y
    assert sim.scene.distance_m(axis_m + np.array([[0.9, 0.0, 0.0], [0.0, 0.0, 2.4]])) == pytest.approx(
        [0.4, 0.4], abs=0.01
    )


WALL = """<sdf version="1.9"><world name="harbour">
  <model name="wall"><static>1</static><pose>10 0 -6 0 0 0</pose><link name="l"><collision name="c"><geometry>
    <box><size>4 2 4</size></box></geometry></collision></link></model>
  <model name="wreck"><static>1</static><link name="hull"><collision name="c"><geometry>
    <mesh><uri>model://wreck/hull.stl</uri></mesh></geometry></collision></link></model></world></sdf>"""


def test_a_world_without_a_vehicle_gets_one_over_its_objects(tmp_path: Path) -> None:
    sim, printed = made(tmp_path, "harbour.world", WALL)
    (rov,) = sim.vehicles.values()
    assert "no vehicle is in it: 'bluerov2_heavy' starts at (10, 0, -2) m" in printed
    assert "model 'wreck'/link 'hull'/collision 'c'/geometry/mesh: 'model://wreck/hull.stl': not in" in printed
    np.testing.assert_allclose(rov.pose.position_world_m, [10.0, 0.0, -2.0])
    assert sim.scene.distance_m(np.array([[10.0, 0.0, -2.0]])) == pytest.approx([2.0], abs=1e-6)
    (tmp_path / "high.world").write_text(WALL.replace("10 0 -6", "10 0 -2"))
    found = read_sdf(tmp_path / "high.world")
    write_found(found, tmp_path / "high")
    np.testing.assert_allclose(found.robots[0].place.position_m, [14.0, 0.0, -2.0])  # beside it


def test_a_world_s_guest_starts_in_its_basin_and_its_current_is_uuv_simulator_s(tmp_path: Path) -> None:
    """Walls about a floor: the middle is clear; with a raft over it, the nearest place beside the raft."""
    box = """<model name="NAME"><static>1</static><pose>AT 0 0 0</pose><link name="l"><collision name="c"><geometry>
      <box><size>SIZE</size></box></geometry></collision></link></model>"""
    parts = [("floor", "0 0 -12", "60 20 1"), ("west", "-30 0 -6", "1 20 14"), ("east", "30 0 -6", "1 20 14")]
    models = "".join(box.replace("NAME", a).replace("AT", b).replace("SIZE", c) for a, b, c in parts)
    flow = """<plugin name="flow" filename="libuuv_underwater_current_ros_plugin.so"><constant_current><velocity>
      <mean>0.5</mean></velocity><horizontal_angle><mean>1.5707963</mean></horizontal_angle></constant_current></plugin>"""
    raft = box.replace("NAME", "raft").replace("AT", "0 0 0").replace("SIZE", "8 30 1")
    for more, at_m in (("", (0.0, 0.0, -2.0)), (raft, (6.1, 0.0, -2.0))):
        path = tmp_path / "basin.world"
        path.write_text(f'<sdf version="1.9"><world name="basin">{models}{more}{flow}</world></sdf>')
        found = read_sdf(path)
        sim = uwsim.Simulator(write_found(found, tmp_path / f"out{len(more)}"))
        np.testing.assert_allclose(found.robots[0].place.position_m, at_m, atol=1e-9)
        np.testing.assert_allclose(sim.scenario.water.current_world_m_s, [0.0, 0.5, 0.0], atol=1e-6)


def test_a_world_has_its_checkout_s_models_its_plane_as_the_bed_and_water_without_them(tmp_path: Path) -> None:
    model = tmp_path / "models" / "deep" / "wreck_v2"
    for folder in (model, tmp_path / ".git", tmp_path / "sim" / "launch" / "worlds"):
        folder.mkdir(parents=True)
    (model / "model.config").write_text(
        '<model><sdf version="1.4">old.sdf</sdf><sdf version="1.9">new.sdf</sdf></model>'
    )
    (model / "new.sdf").write_text("""<sdf version="1.9"><model name="wreck"><static>1</static><link name="l">
      <collision name="c"><geometry><mesh><uri>hull.ply</uri></mesh></geometry></collision></link></model></sdf>""")
    (model / "hull.ply").write_bytes(_ply(shapes.box(np.ones(3))))
    world = """<sdf version="1.9"><world name="bay"><model name="floor"><static>1</static><pose>0 0 -40 0 0 0</pose>
      <link name="l"><collision name="c"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision></link>
      </model><include><uri>model://wreck_v2</uri><pose>4 0 -9 0 0 0</pose></include></world></sdf>"""
    path = tmp_path / "sim" / "launch" / "worlds" / "bay.world"
    path.write_text(world)
    sim = uwsim.Simulator(write_found(read_sdf(path), tmp_path / "out"))
    assert sim.scene.distance_m(np.array([[4.0, 0.0, -8.0]])) == pytest.approx([0.5], abs=1e-6)
    assert sim.scenario.terrain.bed_depth_m == 40.0
    path.write_text(world.replace("wreck_v2", "absent").replace("-40", "3"))
    found = read_sdf(path)
    assert uwsim.Simulator(write_found(found, tmp_path / "bare")).vehicles
    assert {"absent", "at 3 m", "nothing fixed"} <= {
        word for word in ("absent", "at 3 m", "nothing fixed") if any(word in note.text for note in found.notes)
    }


def test_poses_of_an_sdf_are_relative_to_what_comes_later_and_prefixes_need_no_declaration(tmp_path: Path) -> None:
    parts = """<link name="eye"><pose relative_to="mast">0 0 0.1 0 0 0</pose>
        <sensor name="log" type="custom" gz:type="dvl"><update_rate>8</update_rate></sensor></link>
      <joint name="eye_joint" type="fixed"><parent>base</parent><child>eye</child></joint>
      <frame name="mast" attached_to="base"><pose>0.5 0 0.2 0 0 1.5707963</pose></frame></model>
      <model name="pier">"""
    sim, _ = made(tmp_path, "world.sdf", WORLD.replace('</model>\n  <model name="pier">', parts))
    log = sim.scenario.vehicles[0].model.sensors["log"]
    assert (log.kind, log.rate_hz) == ("dvl", 8.0)
    (tmp_path / "a.sdf").write_text(WORLD.replace("</model>", parts.split("</model>")[0] + "</model>", 1))
    body = read_sdf(tmp_path / "a.sdf").robots[0].sensors["log"]
    np.testing.assert_allclose(body["position_m"], [0.5, 0.0, 0.3], atol=1e-9)


def test_uuv_simulators_plugins_are_the_same_in_sdf(tmp_path: Path) -> None:
    (tmp_path / "sled.urdf").write_text(URDF)
    wanted = read_urdf(tmp_path / "sled.urdf").robots[0]
    plugins = "".join(part.split("</gazebo>")[0] for part in URDF.split("<gazebo>")[1:])
    model = f"""<sdf version="1.6"><model name="sled"><link name="base"><inertial><mass>202</mass></inertial>
      <collision name="c"><geometry><box><size>1 1 1</size></box></geometry></collision></link>
      <link name="tail"><pose>-0.6 0 -0.1 0 0 3.141592653589793</pose></link>
      <joint name="tail_joint" type="revolute"><parent>base</parent><child>tail</child>
      <axis><xyz>1 0 0</xyz><use_parent_model_frame>1</use_parent_model_frame></axis></joint>{plugins}</model></sdf>"""
    (tmp_path / "sled.sdf").write_text(model)
    got = read_sdf(tmp_path / "sled.sdf").robots[0]
    assert got.volume_m3 == wanted.volume_m3
    for key in ("added_mass", "linear", "quadratic", "centre_of_buoyancy_m"):
        np.testing.assert_array_equal(getattr(got, key), getattr(wanted, key))
    assert got.thrusters[0].thrust_n == wanted.thrusters[0].thrust_n
    np.testing.assert_allclose(got.thrusters[0].axis, wanted.thrusters[0].axis, atol=1e-9)


def test_a_urdf_vehicle_has_the_source_s_speed_and_trim(tmp_path: Path) -> None:
    sim, _ = made(tmp_path, "sled.urdf", URDF)
    model = sim.scenario.vehicles[0].model
    (thruster,) = model.thrusters.values()
    np.testing.assert_allclose(thruster.axis, [1.0, 0.0, 0.0], atol=1e-9)  # -x of a link that faces aft
    np.testing.assert_allclose(thruster.position_m, [-0.6, 0.0, -0.1], atol=1e-9)
    curve = dict(thruster.model.thrust_n)
    assert curve[1.0] == pytest.approx(0.01 * 200.0**2) and curve[-1.0] == pytest.approx(-0.01 * 100.0**2)
    assert curve[-1.0] == curve[-0.5]  # clamped
    body = read_urdf(tmp_path / "sled.urdf").robots[0]
    assert body.volume_m3 == 0.2 and body.whole().mass_kg == 202.0
    figures, terminal = reported(tmp_path / "moved" / "sled.yaml")
    assert figures.net_buoyancy_n == pytest.approx((0.2 * 1000.0 - 202.0) * G, abs=0.01)  # in fresh water
    np.testing.assert_allclose(figures.centre_of_buoyancy_m, [0.0, 0.0, 0.1], atol=1e-6)
    speeds = [steady(force_n, 30.0, 150.0) for force_n in (400.0, 100.0)]  # its thruster is below its centre of mass
    assert terminal[0] == pytest.approx(speeds, rel=0.003)


def test_the_urdf_reader_agrees_with_ros_s_and_with_pinocchio(tmp_path: Path) -> None:
    (tmp_path / "sled.urdf").write_text(URDF)
    whole = read_urdf(tmp_path / "sled.urdf").robots[0].whole()
    parser = pytest.importorskip("urdf_parser_py.urdf", reason="ROS's reader")
    links = parser.URDF.from_xml_string(URDF).links
    assert whole.mass_kg == sum(link.inertial.mass for link in links)
    pinocchio = pytest.importorskip("pinocchio", reason="an independent sum of the links' inertia")
    model = pinocchio.buildModelFromXML(URDF, pinocchio.JointModelFreeFlyer())
    data = model.createData()
    neutral = pinocchio.neutral(model)
    np.testing.assert_allclose(pinocchio.centerOfMass(model, data, neutral), whole.centre_m, atol=1e-12)
    composite = pinocchio.crba(model, data, neutral)[3:6, 3:6]  # about the base's origin
    off = whole.centre_m
    about = whole.inertia_kg_m2 + whole.mass_kg * (off @ off * np.eye(3) - np.outer(off, off))
    np.testing.assert_allclose(composite, about, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("right, inverted", [("true", "false"), ("true", "true"), ("false", "false")])
def test_a_stonefish_vehicle_has_the_source_s_masses_and_thrust(right: str, inverted: str, tmp_path: Path) -> None:
    (tmp_path / "robot.scn").write_text(screw(right, inverted))
    robot = read_stonefish(tmp_path / "robot.scn").robots[0]
    assert robot.whole().mass_kg == pytest.approx(900.0 * 0.1 + 8.0)
    assert robot.volume_m3 == pytest.approx(0.1)
    np.testing.assert_allclose(robot.centre_of_buoyancy_m, [0.0, 0.0, 0.1], atol=1e-12)  # down becomes up
    (thruster,) = robot.thrusters
    ahead = 1.0 if right == "true" and inverted == "false" else -1.0
    np.testing.assert_allclose(thruster.axis, [ahead, 0.0, 0.0], atol=1e-9)
    strong, weak = 1020.0 * 0.4 * 0.2**4 * 10.0**2, 1020.0 * 0.2 * 0.2**4 * 10.0**2  # rho K_T D^4 n^2, 10 1/s
    wanted = (strong, -weak) if ahead > 0.0 else (weak, -strong)
    curve = dict(thruster.thrust_n)
    assert (curve[1.0], curve[-1.0]) == pytest.approx(wanted)
    assert thruster.torque_per_thrust_m == pytest.approx(0.2 * 0.05 / 0.4)


def test_a_stonefish_world_is_turned_from_ned_to_enu(tmp_path: Path) -> None:
    sim, printed = made(tmp_path, "robot.scn", SCN)
    assert "added mass and drag are estimated" in printed
    model = sim.scenario.vehicles[0].model
    assert model.mass_kg == pytest.approx(900.0 * 0.1 + 8.0)
    (written,), (thruster,) = model.thrusters.values(), read_stonefish(tmp_path / "robot.scn").robots[0].thrusters
    np.testing.assert_allclose(written.axis, thruster.axis, atol=1e-9)
    assert dict(written.model.thrust_n) == pytest.approx(dict(thruster.thrust_n))
    assert written.model.torque_per_thrust_m == pytest.approx(thruster.torque_per_thrust_m)
    (rov,) = sim.vehicles.values()
    centroid = np.array([3.0, 10.0, -4.0 + 0.1])  # east is NED's y; the body's origin is the hull's centroid
    np.testing.assert_allclose(rov.pose.position_world_m, centroid, atol=1e-9)
    assert sim.scenario.vehicles[0].start.yaw_deg == pytest.approx(90.0)  # north
    np.testing.assert_allclose(sim.scenario.water.current_world_m_s, [0.1, 0.3, 0.0])
    assert sim.world.height_at(np.array([[0.0, 0.0]])) == pytest.approx([-15.0])
    # A post of 1 m north by 2 m east about 6 m north, 1 m east and 8 m down.
    faces = np.array([[2.5, 6.0, -8.0], [1.0, 7.0, -8.0], [1.0, 6.0, -6.0]])
    assert sim.scene.distance_m(faces) == pytest.approx([0.5, 0.5, 0.5], abs=1e-6)
    np.testing.assert_allclose(
        model.cameras["eye"].yaw_pitch_roll_deg, [0.0, 0.0, 0.0], atol=1e-3
    )  # it looks ahead, upright


def test_files_of_a_ros_package_are_found_beside_a_stonefish_scenario(tmp_path: Path) -> None:
    (tmp_path / "rovs" / "scenarios").mkdir(parents=True)
    (tmp_path / "rovs" / "scenarios" / "robot.scn").write_text(SCN)
    top = '<scenario><include file="$(find rovs)/scenarios/robot.scn"/></scenario>'
    (tmp_path / "rovs" / "scenarios" / "top.scn").write_text(top)
    (found,) = read_stonefish(tmp_path / "rovs" / "scenarios" / "top.scn").robots
    assert found.volume_m3 == pytest.approx(0.1)
    lost = tmp_path / "rovs" / "lost.scn"
    lost.write_text(top.replace("find rovs", "find lost"))
    (found,) = read_stonefish(lost).robots  # the rest of the path is in a folder above
    lost.write_text(top.replace("robot.scn", "none.scn"))
    with pytest.raises(ValueError, match=r"none\.scn': is in no folder above .*: --data FOLDER names"):
        read_stonefish(lost)


@pytest.mark.parametrize("angles", [(0.3, -0.7, 2.1), (0.0, np.pi / 2, 0.4), (3.0, 1.2, -3.1)])
def test_angles_and_rotations_are_inverse(angles: tuple[float, float, float]) -> None:
    yaw, pitch, roll = np.radians(yaw_pitch_roll_deg(turned(*angles)))
    np.testing.assert_allclose(turned(roll, pitch, yaw), turned(*angles), atol=1e-12)
    pose = Pose(np.array([1.0, -2.0, 3.0]), turned(*angles))
    np.testing.assert_allclose(pose.then(pose.inverse()).position_m, HERE.position_m, atol=1e-12)


def test_a_shell_s_inertia_is_that_of_a_hollow_sphere() -> None:
    lump = shapes.shell_lump(shapes.sphere(2.0), 3.0)
    np.testing.assert_allclose(lump.inertia_kg_m2, 2.0 / 3.0 * 3.0 * 4.0 * np.eye(3), rtol=0.02, atol=1e-9)


def test_lumps_add_up_as_steiner_states() -> None:
    robot = Robot("two", HERE, [Lump(2.0, np.array([s, 0.0, 0.0]), np.zeros((3, 3))) for s in (-1.0, 1.0)])
    np.testing.assert_allclose(np.diagonal(robot.whole().inertia_kg_m2), [0.0, 4.0, 4.0])


@pytest.mark.parametrize("text, value", [("1000.0/60*2*pi", 1000.0 / 60.0 * 2.0 * np.pi), ("-(2+3)*4", -20.0)])
def test_formulas_are_numbers_only(text: str, value: float) -> None:
    assert formula(text) == pytest.approx(value)
    for bad in ("__import__('os')", "pi**9", "a", "1/0", "(" * 500, ""):
        with pytest.raises(ValueError, match="must consist of numbers"):
            formula(bad)


def test_shapes_that_only_stand_in_displace_nothing(tmp_path: Path) -> None:
    speck = """<collision name="s"><geometry><cylinder><radius>1e-6</radius><length>1e-6</length></cylinder></geometry>
      </collision><sensor name="nose\""""
    (tmp_path / "world.sdf").write_text(WORLD.replace('<sensor name="nose"', speck))
    robot = read_sdf(tmp_path / "world.sdf").robots[0]
    assert robot.volume_m3 == pytest.approx(2.0 * 0.25 * 0.2)
    assert len(robot.solids) == 1


ZERO = """<plugin filename="gz-sim-hydrodynamics-system" name="gz::sim::systems::Hydrodynamics">
  <link_name>base</link_name><xUabsU>0</xUabsU></plugin></model>"""
ODD = [
    ("a.sdf", WORLD.replace("<xU>-4", "<xU>4"), ": xU = 4 would drive the hull: -4 is meant"),
    ("a.sdf", WORLD.replace("</model>", ZERO, 1), ": zero coefficients do nothing"),
    ("a.sdf", WORLD.replace("<radius>0.5", "<radius>1e308"), "radius and length must be positive, at most 1e+06"),
    ("a.urdf", URDF.replace("-150 -250", "150 -250"), "150 of axis 1 would drive the hull: -150 is meant"),
]


@pytest.mark.parametrize("name, text, words", ODD)
def test_an_odd_element_does_not_refuse_its_neighbours(name: str, text: str, words: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(text)
    (tmp_path / f"right_{name}").write_text(WORLD if name.endswith("sdf") else URDF)
    read = read_sdf if name.endswith("sdf") else read_urdf
    odd, right = read(tmp_path / name), read(tmp_path / f"right_{name}")
    assert any(words in note.text for note in odd.notes), odd.notes
    assert not any(words in note.text for note in right.notes)
    for key in ("added_mass", "linear", "quadratic", "volume_m3"):
        np.testing.assert_array_equal(getattr(odd.robots[0], key), getattr(right.robots[0], key))
    assert [each.thrust_n for each in odd.robots[0].thrusters] == [each.thrust_n for each in right.robots[0].thrusters]


BOMB = '<!DOCTYPE a [<!ENTITY a "aaaa">]><sdf/>'


@pytest.mark.parametrize(
    "name, text, words",
    [
        ("a.sdf", "no", "must be XML"),
        ("a.sdf", BOMB, "has a DOCTYPE"),
        ("a.sdf", "<sdf>" + "<model>" * 200 + "</model>" * 200 + "</sdf>", "deep: must be at most 100"),
        ("a.sdf", "<sdf/>", "has no model with a thruster"),
        ("a.docx", "<sdf/>", "must be the checkout of a Unity project"),
        ("a.sdf", WORLD.replace("<mass>99", "<mass>nan"), "link 'base'/inertial/mass: 'nan': must be 1 finite number"),
        ("a.sdf", WORLD.replace("<mass>99", "<mass>-99"), "mass"),
        ("a.sdf", WORLD.replace("<mass>99", "<mass>999999"), "': as converted: vehicles[0].model: vehicle 'glider'"),
        ("a.sdf", WORLD.replace("2 0.25 0.2", "2 0.25"), "must be 3 finite numbers"),
        ("a.urdf", URDF.replace('<parent link="base"/>', '<parent link="tail"/>'), "circle"),
        ("a.urdf", URDF.replace("Basic", "Odd"), "must be Basic, Bessa or LinearInterp"),
        ("a.scn", SCN + "<a/>", "must be XML"),
        ("a.scn", SCN.replace("thruster", "lamp").replace("static", "floor"), "has no <robot> that a thruster moves"),
        ("a.scn", SCN.replace("${600/60*2*pi}", "$(arg most)"), "arguments without a value: give --arg most=VALUE"),
    ],
)
def test_mistakes_are_one_line_after_what_was_found_and_write_nothing(
    name: str, text: str, words: str, tmp_path: Path
) -> None:
    (tmp_path / name).write_text(text)
    done = command("scenario", "from", tmp_path / name, "--out", tmp_path / "out")
    *found, last = done.stderr.splitlines()
    assert done.returncode != 0 and last.startswith("uwsim: error: ") and words in done.stderr
    assert all(
        line.removeprefix("motion: ")
        .removeprefix("senses: ")
        .removeprefix("looks: ")
        .startswith(("read: ", "left out: ", "assumed: ", "topic: ", "for a survey, ", "arguments: "))
        for line in found
    ), found
    assert not (tmp_path / "out").exists()


def test_entities_are_refused_in_any_encoding(tmp_path: Path) -> None:
    (tmp_path / "a.sdf").write_bytes(('<?xml version="1.0" encoding="UTF-16"?>' + BOMB).encode("utf-16"))
    with pytest.raises(ValueError, match="has a DOCTYPE"):
        read_sdf(tmp_path / "a.sdf")


def test_only_a_regular_file_is_read(tmp_path: Path) -> None:
    """A device or a pipe may never end."""
    os.mkfifo(tmp_path / "pipe")
    for path in (Path("/dev/zero"), tmp_path / "pipe", tmp_path):
        with pytest.raises(ValueError, match="must be a regular file"):
            read_xml(path)
    with pytest.raises(FileNotFoundError):
        read_xml(tmp_path / "absent.sdf")


def test_nothing_that_is_not_ours_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "world.sdf").write_text(WORLD)
    found = read_sdf(tmp_path / "world.sdf")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "glider.yaml").write_text("mine")
    with pytest.raises(FileExistsError, match=r"glider\.yaml"):
        write_found(found, tmp_path / "out")
    assert (tmp_path / "out" / "glider.yaml").read_text() == "mine"
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["glider.yaml"]


def test_a_vehicle_that_nothing_moves_does_not_refuse_another(tmp_path: Path) -> None:
    """The second has one thruster, whose joint is not there."""
    model = WORLD.split('<model name="glider">')[1].split("</model>")[0]
    second = f'<model name="prop">{model}</model>'.replace(">port_joint<", ">lost<").replace(
        ">starboard_joint<", ">lost<"
    )
    sim, printed = made(tmp_path, "world.sdf", WORLD.replace("</world>", f"{second}</world>"))
    assert [*sim.vehicles] == ["glider"]
    assert "left out: vehicle 'prop': has no thrusters, so nothing could move it" in printed
