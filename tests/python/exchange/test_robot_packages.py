"""A robot's description in a ROS package: macros of xacro, arguments, packages beside it, and gz-sim's systems."""

import re
from pathlib import Path

import numpy as np
import pytest

import uwsim
from command_line import uwsim as command
from uwsim.exchange.robots.robot import Description, Given
from uwsim.exchange.robots.sdf import read_sdf
from uwsim.exchange.robots.sources import package_folder
from uwsim.exchange.robots.urdf import read_urdf
from uwsim.exchange.xml_text import xml_root
from uwsim.missions.lawn_mower_plan import ALTIMETER, SONAR, missing_for_lanes

pytestmark = pytest.mark.usefixtures("panels_left_out")

DATA = Path(__file__).parents[1] / "data" / "robots"
FIELD = Path(__file__).parents[4] / "shared" / "field" / "robots"
PACKAGE = "<package><name>{}</name></package>"
TOP = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="sled"><xacro:arg name="side" default="1.2"/>
  <xacro:include filename="$(find parts)/screw.xacro"/>
  <link name="base"><inertial><mass value="$(arg mass)"/><inertia ixx="20" ixy="0" ixz="0" iyy="40" iyz="0" izz="50"/>
    </inertial><collision><geometry><box size="$(arg side) ${2*0.4} 0.25"/></geometry></collision></link>
  <xacro:screw name="port" y="0.2"/><xacro:screw name="star" y="-0.2"/></robot>"""
SCREW = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro name="screw" params="name y">
  <link name="${name}"/><joint name="${name}_joint" type="continuous"><origin xyz="-0.6 ${y} 0"/><axis xyz="1 0 0"/>
    <parent link="base"/>
    <child link="${name}"/></joint>
  <gazebo><plugin filename="gz-sim-thruster-system" name="gz::sim::systems::Thruster"><namespace>sled</namespace>
    <joint_name>${name}_joint</joint_name><max_thrust_cmd>30</max_thrust_cmd><min_thrust_cmd>-20</min_thrust_cmd>
    </plugin></gazebo></xacro:macro></robot>"""


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    """Return a description whose macros are in another package of the same checkout, under another folder's name."""
    for folder, name, file, text in (
        ("robots/sled/urdf", "sled_description", "sled.urdf.xacro", TOP),
        ("common/pieces", "parts", "screw.xacro", SCREW),
    ):
        (tmp_path / "ws" / folder).mkdir(parents=True)
        (tmp_path / "ws" / folder / file).write_text(text)
        root = tmp_path / "ws" / ("robots/sled" if name == "sled_description" else folder)
        (root / "package.xml").write_text(PACKAGE.format(name))
    return tmp_path / "ws" / "robots" / "sled" / "urdf" / "sled.urdf.xacro"


def test_packages_are_found_by_their_manifests(workspace: Path, tmp_path: Path) -> None:
    assert package_folder("parts", workspace) == tmp_path / "ws" / "common" / "pieces"
    assert package_folder("sled_description", workspace) == workspace.parents[1]
    assert package_folder("absent", workspace) is None
    far = tmp_path / "other" / "deep" / "far"
    far.mkdir(parents=True)
    (far / "package.xml").write_text(PACKAGE.format("far"))
    for checkout in ("ws", "other"):
        (tmp_path / checkout / ".git").mkdir()
    package_folder.cache_clear()
    assert package_folder("far", workspace) == far, "of another checkout of the same workspace"


def test_macros_are_expanded_with_the_arguments_given(workspace: Path) -> None:
    pytest.importorskip("xacro", reason="the extra robots")
    (robot,) = read_urdf(workspace, Description("", Given({"mass": "250"}))).robots
    assert robot.whole().mass_kg == 250.0
    np.testing.assert_allclose([each.position_m for each in robot.thrusters], [[-0.6, 0.2, 0.0], [-0.6, -0.2, 0.0]])
    assert [dict(each.thrust_n)[1.0] for each in robot.thrusters] == [30.0, 30.0]
    assert np.ptp(robot.solids[0][0], axis=0) == pytest.approx([1.2, 0.8, 0.25])
    with pytest.raises(ValueError, match="argument mass has no value: state it by --arg mass=VALUE"):
        read_urdf(workspace)
    workspace.write_text(TOP.replace("$(find parts)", "$(find lost)"))
    with pytest.raises(ValueError, match="package 'lost' is neither around the file nor in ROS_PACKAGE_PATH"):
        read_urdf(workspace, Description("", Given({"mass": "250"})))
    switch = (
        '<xacro:arg name="use_sim" default="false"/><xacro:if value="$(arg use_sim)"><xacro:screw name="port" y="0.2"/>'
    )
    off = TOP.replace('<xacro:screw name="port" y="0.2"/><xacro:screw name="star" y="-0.2"/>', f"{switch}</xacro:if>")
    workspace.write_text(off)
    switched = read_urdf(workspace, Description("", Given({"mass": "250"})))
    assert len(switched.robots[0].thrusters) == 1
    assert any(str(note).startswith("motion: assumed: --arg use_sim=true") for note in switched.notes)
    workspace.write_text(TOP.replace("2*0.4", "[0]*10**12"))
    with pytest.raises(ValueError, match=r"sled\.urdf\.xacro"):
        read_urdf(workspace, Description("", Given({"mass": "250"})))


@pytest.mark.parametrize("argument, words", [("mass", "must be NAME=VALUE"), ("=1", "must be NAME=VALUE")])
def test_an_argument_has_a_name_and_a_value(argument: str, words: str, workspace: Path, tmp_path: Path) -> None:
    done = command("scenario", "from", workspace, "--arg", argument, "--out", tmp_path / "out")
    assert done.returncode == 2 and words in done.stderr and not (tmp_path / "out").exists()


def test_gz_sim_s_systems_are_the_same_in_urdf(tmp_path: Path) -> None:
    """The vehicle of glider.sdf, its plugins within <gazebo>; gz-sim converts a URDF to SDF in this way."""
    sdf = read_sdf(DATA / "glider.sdf").robots[0]
    plugins = re.findall("<plugin.*?</plugin>", (DATA / "glider.sdf").read_text(), re.DOTALL)
    within = "".join(f"<gazebo>{plugin}</gazebo>" for plugin in plugins)
    links = "".join(
        f"""<link name="{side}"/><joint name="{side}_joint" type="continuous"><origin xyz="{" ".join(map(str, at))}"/>
          <axis xyz="1 0 0"/><parent link="base"/><child link="{side}"/></joint>"""
        for side, at in (("port", sdf.thrusters[0].position_m), ("starboard", sdf.thrusters[1].position_m))
    )
    (tmp_path / "glider.urdf").write_text(
        f"""<robot name="glider"><link name="base"><inertial><mass value="100"/><inertia ixx="9" ixy="0" ixz="0" iyy="9"
          iyz="0" izz="9"/></inertial><collision><geometry><box size="2 0.25 0.2"/></geometry></collision></link>
          {links}{within}</robot>"""
    )
    urdf = read_urdf(tmp_path / "glider.urdf").robots[0]
    for key in ("added_mass", "linear", "quadratic"):
        np.testing.assert_array_equal(getattr(urdf, key), getattr(sdf, key))
    for ours, theirs in zip(urdf.thrusters, sdf.thrusters, strict=True):
        assert ours.thrust_n == theirs.thrust_n
        np.testing.assert_allclose(ours.position_m, theirs.position_m)


def test_a_buoyancy_engine_is_one(tmp_path: Path) -> None:
    """gz-sim's BuoyancyEngine: rho g (V - V_neutral), by command from its least volume to its most."""
    engine = """<gazebo><plugin filename="gz-sim-buoyancy-engine-system" name="gz::sim::systems::BuoyancyEngine">
      <link_name>base</link_name><min_volume>0.0001</min_volume><neutral_volume>0.0005</neutral_volume>
      <max_volume>0.0010</max_volume><max_inflation_rate>0.00001</max_inflation_rate></plugin></gazebo></robot>"""
    (tmp_path / "a.urdf").write_text((DATA / "sled.urdf").read_text().replace("</robot>", engine))
    found = read_urdf(tmp_path / "a.urdf")
    (_, pump) = found.robots[0].thrusters
    assert dict(pump.thrust_n) == pytest.approx({-1.0: -0.4 * 9.80665, 0.0: 0.0, 1.0: 0.5 * 9.80665})
    assert pump.force == "buoyancy" and pump.time_constant_s == pytest.approx(45.0)
    assert any("its pump lags by 45 s" in note.text for note in found.notes)


@pytest.mark.skipif(not FIELD.is_dir(), reason="files of the field, which are not part of the project")
def test_files_of_the_field_have_the_values_that_are_known_without_uwsim() -> None:
    (gz,) = read_urdf(FIELD / "gz_systems.urdf").robots
    np.testing.assert_allclose([each.position_m for each in gz.thrusters], [[-0.2, 0.15, 0.0], [-0.2, -0.15, 0.0]])
    assert [dict(each.thrust_n)[1.0] for each in gz.thrusters] == [30.0, 30.0]
    np.testing.assert_array_equal(np.diagonal(gz.added_mass)[:3], [5.0, 8.0, 10.0])
    np.testing.assert_array_equal(np.diagonal(gz.quadratic)[:3], [30.0, 40.0, 60.0])
    (right,), (odd,) = (read_sdf(FIELD / f"sdf_{name}.sdf").robots for name in ("ok", "second_hydro_zero"))
    np.testing.assert_array_equal(odd.quadratic, right.quadratic)
    (right,), (odd,) = (read_urdf(FIELD / f"uuv_{name}.urdf").robots for name in ("ok", "clamps_swapped"))
    assert [each.thrust_n for each in odd.thrusters] == [each.thrust_n for each in right.thrusters]
    assert not read_urdf(FIELD / "uuv_no_clamp.urdf").robots[0].thrusters


def test_a_checkout_is_enough_and_a_survey_s_outfit_is_added_on_demand(workspace: Path, tmp_path: Path) -> None:
    """The likeliest description is taken, and the others are named; a vehicle is ready for a survey by an option."""
    broken = workspace.with_name("zed.urdf")
    broken.write_text('<robot name="a"><plugin filename="thruster"/></robot>')
    workspace.with_name("sled.urdf").write_text((DATA / "sled.urdf").read_text())
    launch = workspace.parents[1] / "launch" / "all.launch"
    launch.parent.mkdir()
    launch.write_text('<launch><param command="xacro $(find sled)/urdf/zed.urdf sled.urdf.xacro mass:=1"/></launch>')
    out = tmp_path / "out"
    pytest.importorskip("xacro", reason="the extra robots")
    done = command("scenario", "from", tmp_path / "ws", "--arg", "mass=250", "--out", out)
    assert done.returncode == 0, done.stderr
    assert "read: robots/sled/urdf/sled.urdf.xacro, the likeliest" in done.stdout
    assert "refused: " in done.stdout and "zed.urdf" in done.stdout and "sled.urdf" in done.stdout
    assert "lacks a multibeam and an altimeter: --outfit survey adds it" in done.stdout
    fitted = command("scenario", "from", workspace, "--arg", "mass=250", "--out", tmp_path / "b", "--outfit", "survey")
    assert fitted.returncode == 0, fitted.stderr
    sim = uwsim.Simulator(tmp_path / "b" / "sled_water.yaml")
    assert not missing_for_lanes(sim.rov).keys() & {SONAR, ALTIMETER}


def test_a_checkout_s_calibration_is_that_of_the_camera_of_its_name(tmp_path: Path) -> None:
    camera = """<gazebo reference="base"><sensor name="eye" type="camera"><camera><horizontal_fov>1.0</horizontal_fov>
      <image><width>320</width><height>240</height></image></camera></sensor></gazebo></robot>"""
    (tmp_path / "ws" / "config").mkdir(parents=True)
    (tmp_path / "ws" / "sled.urdf").write_text((DATA / "sled.urdf").read_text().replace("</robot>", camera))
    matrix = "camera_matrix: {rows: 3, cols: 3, data: [500.0, 0.0, 310.0, 0.0, 510.0, 250.0, 0.0, 0.0, 1.0]}"
    text = f"""image_width: 640\nimage_height: 480\n{matrix}\ndistortion_model: plumb_bob
distortion_coefficients: {{rows: 1, cols: 5, data: [-0.1, 0.01, 0.0, 0.0, 0.0]}}\n"""
    for name in ("eye", "other"):
        (tmp_path / "ws" / "config" / f"{name}.yaml").write_text(text)
    done = command("scenario", "from", tmp_path / "ws", "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert "read: camera 'eye': its calibration" in done.stdout and "other.yaml': no camera has its name" in done.stdout
    mount = uwsim.Simulator(tmp_path / "out" / "sled_water.yaml").scenario.vehicles[0].model.cameras["eye"]
    assert (mount.width, mount.fx, mount.cy, mount.distortion[0]) == (640, 500.0, 250.0, -0.1)


def test_px4_s_classic_hull_and_motors(tmp_path: Path) -> None:
    """k w |w| at most at the speed of the flight stack's output, and against z for a clockwise motor of positive k."""
    motor = """<link name="{0}"><pose>-0.2 0 0 0 1.5707963 0</pose></link><joint name="{0}j" type="revolute">
      <parent>base</parent><child>{0}</child></joint><plugin filename="libgazebo_motor_model.so">
      <linkName>{0}</linkName><reversible>true</reversible><turningDirection>cw</turningDirection><motorConstant>{1}</motorConstant>
      <maxRotVelocity>1100</maxRotVelocity><motorNumber>0</motorNumber></plugin>"""
    model = f"""<link name="base"><inertial><mass>20</mass></inertial><collision name="c"><geometry><box>
      <size>1 1 0.02</size></box></geometry></collision></link>{motor.format("a", -8.5)}{motor.format("b", 8.5)}
      <plugin filename="libgazebo_uuv_plugin.so"><baseLinkName>base</baseLinkName><dampingLinear>5 17 18</dampingLinear>
      <buoyancy><link_name>base</link_name><origin>0 0 0.01</origin><compensation>1.1</compensation></buoyancy></plugin>
      <plugin filename="m.so"><control_channels><channel><input_index>0</input_index><input_scaling>2</input_scaling>
      </channel></control_channels></plugin>"""
    (tmp_path / "a.sdf").write_text(f'<sdf version="1.6"><model name="a">{model}</model></sdf>')
    (robot,) = read_sdf(tmp_path / "a.sdf").robots
    for thruster, ahead in zip(robot.thrusters, (1.0, -1.0), strict=True):
        assert thruster.thrust_n[-1] == (1.0, pytest.approx(34.0)) and not thruster.clockwise
        np.testing.assert_allclose(thruster.axis, [ahead, 0.0, 0.0], atol=1e-6)
    assert robot.volume_m3 == pytest.approx(0.022) and robot.linear is not None
    np.testing.assert_array_equal(np.diagonal(robot.linear)[:3], [5.0, 17.0, 18.0])
    np.testing.assert_allclose(robot.centre_of_buoyancy_m, [0.0, 0.0, 0.01])


@pytest.mark.parametrize("declared", ['[<!ATTLIST a b CDATA "long">]', '[<!ENTITY a "a">]', "", 'SYSTEM "/etc/passwd"'])
def test_a_document_type_is_refused(declared: str) -> None:
    """Defaults of attributes and entities expand without bound."""
    with pytest.raises(ValueError, match="x: has a DOCTYPE: must have none"):
        xml_root(f"<!DOCTYPE a {declared}><a/>".encode(), "x")
