"""Attributes that change the meaning of a value in a description are used, or the value is refused by name.

Each right value follows from the format's own specification: SDFormat's, URDF's, and the sources of the simulators.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from uwsim.exchange.robots.links import Joint, Links, summed_volume
from uwsim.exchange.robots.robot import Description, Robot
from uwsim.exchange.robots.sdf import read_sdf
from uwsim.exchange.robots.urdf import read_urdf
from uwsim.exchange.robots.xml_file import HERE

AHEAD, SIDE = [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]
THRUSTER = """<plugin name="t" filename="gz-sim-thruster-system"><joint_name>prop_joint</joint_name>
  <max_thrust_cmd>30</max_thrust_cmd><min_thrust_cmd>-30</min_thrust_cmd>{}</plugin>"""
PROP = """<link name="prop">{pose}<inertial><mass>1</mass></inertial></link><joint name="prop_joint" type="revolute">
  <parent>base</parent><child>prop</child>{axis}</joint>"""
Z = "<axis><xyz>0 0 1</xyz></axis>"
POSE = "<pose>-0.3 0 0 0 1.5707963267948966 0</pose>"
BASE = """<link name="base"><inertial><mass>20</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>
  <collision name="hull"><geometry><box><size>0.8 0.4 0.0625</size></box></geometry></collision></link>"""


def found(tmp_path: Path, model: str, version: str = "1.9", attributes: str = "") -> Description:
    (tmp_path / "a.sdf").write_text(f'<sdf version="{version}"><model name="a" {attributes}>{model}</model></sdf>')
    return read_sdf(tmp_path / "a.sdf")


def boat(tmp_path: Path, *, pose: str = POSE, axis: str = Z, more: str = "", version: str = "1.9") -> Robot:
    (robot,) = found(tmp_path, BASE + PROP.format(pose=pose, axis=axis) + more + THRUSTER.format(""), version).robots
    return robot


@pytest.mark.parametrize(
    "pose, more",
    [
        ('<pose degrees="true">-0.3 0 0 0 90 0</pose>', ""),
        ('<pose degrees="True" rotation_format="euler_rpy">-0.3 0 0 0 90 0</pose>', ""),
        ('<pose rotation_format="quat_xyzw">-0.3 0 0  0 2 0 2</pose>', ""),  # of any length
        ('<pose relative_to="stern"/>', f'<frame name="stern">{POSE}</frame>'),
        ('<pose frame="stern">0 0 0 0 0 0</pose>', f'<frame name="stern">{POSE}</frame>'),  # SDF 1.5 and 1.6
        ('<pose relative_to="rig::stern"/>', f'<model name="rig"><frame name="stern">{POSE}</frame></model>'),
        ('<pose relative_to="rig"/>', f'<model name="rig" placement_frame="mast">{POSE}<frame name="mast"/></model>'),
    ],
)
def test_a_pose_means_the_same_in_each_of_its_forms(pose: str, more: str, tmp_path: Path) -> None:
    (thruster,) = boat(tmp_path, pose=pose, more=more).thrusters
    np.testing.assert_allclose(thruster.axis, AHEAD, atol=1e-9)
    np.testing.assert_allclose(thruster.position_m, [-0.3, 0.0, 0.0], atol=1e-9)


@pytest.mark.parametrize(
    "axis, version, right",
    [
        ("<axis><xyz>0 0 5</xyz></axis>", "1.9", AHEAD),
        ('<axis><xyz expressed_in="base">0 1 0</xyz></axis>', "1.9", SIDE),
        ("<axis><xyz>1 0 0</xyz><use_parent_model_frame>True</use_parent_model_frame></axis>", "1.6", AHEAD),
        ("<axis><xyz>1 0 0</xyz></axis>", "1.4", AHEAD),  # as libsdformat converts it
        ("<axis><xyz>0 0 1</xyz></axis>", "1.10", AHEAD),
        ("<axis><xyz>0 0 1</xyz><limit><lower>-inf</lower><upper>inf</upper></limit></axis>", "1.9", AHEAD),
    ],
)
def test_an_axis_is_in_the_frame_that_its_file_names(
    axis: str, version: str, right: list[float], tmp_path: Path
) -> None:
    np.testing.assert_allclose(boat(tmp_path, axis=axis, version=version).thrusters[0].axis, right, atol=1e-9)


@pytest.mark.parametrize(
    "odd, words",
    [
        ('<link name="b"><pose rotation_format="euler">0 0 0 0 0 0</pose></link>', "rotation_format = 'euler'"),
        ('<link name="b"><pose degrees="1" rotation_format="quat_xyzw">0 0 0 0 0 0 1</pose></link>', "without degrees"),
        ('<link name="b"><pose relative_to="lost"/></link>', "there is no link, joint or frame 'lost'"),
        ('<link name="b"><inertial><pose relative_to="base"/></inertial></link>', "relative_to = 'base'"),
        ('<model name="b" placement_frame="lost"/>', "there is no placement_frame 'lost'"),
        ("".join(f'<frame name="f{k}"><pose relative_to="f{(k + 1) % 3000}"/></frame>' for k in range(3000))
         + '<link name="b"><pose relative_to="f0"/></link>', "its pose refers to itself"),
    ],
)  # fmt: skip
def test_a_value_whose_meaning_is_unknown_is_refused_by_name_with_each_plugin(
    odd: str, words: str, tmp_path: Path
) -> None:
    notes = Description("")
    (tmp_path / "a.sdf").write_text(f'<sdf version="1.9"><model name="a">{BASE}{odd}{THRUSTER}</model></sdf>')
    with pytest.raises(ValueError, match=r"a\.sdf") as refused:
        read_sdf(tmp_path / "a.sdf", notes)
    assert words in str(refused.value) and any("gz-sim-thruster-system" in note.text for note in notes.notes)


@pytest.mark.parametrize(
    "odd, words",
    [
        ("<axis><xyz>0 0 0</xyz></axis>", "joint 'odd_joint'/axis: its axis must not be zero"),
        ("<axis><xyz>0 0</xyz></axis>", "joint 'odd_joint'/axis/xyz: '0 0': must be 3 finite numbers"),
        ('<axis><xyz expressed_in="lost">0 0 1</xyz></axis>', "there is no link, joint or frame 'lost'"),
        ("<pose relative_to='lost'/>", "there is no link, joint or frame 'lost'"),
    ],
)
def test_an_odd_joint_and_shape_are_left_out_alone(odd: str, words: str, tmp_path: Path) -> None:
    ball = '<collision name="odd"><geometry><sphere><radius>-1</radius></sphere></geometry></collision></link>'
    more = PROP.format(pose="", axis=odd).replace("prop", "odd")
    wrong = THRUSTER.format("").replace("prop_joint", "odd_joint")
    text = BASE.replace("</link>", ball) + PROP.format(pose=POSE, axis=Z) + more + THRUSTER.format("") + wrong
    read = found(tmp_path, text)
    (robot,) = read.robots
    assert [each.name for each in robot.thrusters] == ["prop"] and robot.volume_m3 == pytest.approx(0.02)
    assert any(words in note.text for note in read.notes) and any(
        "radius and length" in note.text for note in read.notes
    )


def test_a_merged_model_has_its_parts_sensors_and_plugins_in_the_outer_one(tmp_path: Path) -> None:
    (tmp_path / "rig").mkdir()
    sensor = '<sensor name="eye" type="imu"><pose relative_to="rod">0 0 0.1 0 0 0</pose></sensor></link>'
    rig = f'<link name="rod"><inertial><mass>3</mass></inertial>{sensor}' + PROP.format(pose=POSE, axis=Z)
    rig = rig.replace("<parent>base", "<parent>rod") + THRUSTER.format("")
    (tmp_path / "rig" / "model.sdf").write_text(f'<sdf version="1.9"><model name="rig">{rig}</model></sdf>')
    include = '<include merge="true"><uri>model://rig</uri><pose>0 0.5 0 0 0 0</pose></include>'
    joint = '<joint name="j" type="fixed"><parent>base</parent><child>rod</child></joint>'
    (robot,) = found(tmp_path, BASE + include + joint).robots
    np.testing.assert_allclose(robot.thrusters[0].position_m, [-0.3, 0.5, 0.0])
    assert robot.whole().mass_kg == 24.0 and robot.sensors["eye"]["position_m"] == pytest.approx([0.0, 0.5, 0.1])


def test_masses_are_stated_follow_from_shapes_or_are_sdf_s_defaults(tmp_path: Path) -> None:
    """A box of 0.02 m3: 1000 kg/m3 by default, or its own density, or scaled to a mass; a link without any has 1 kg."""
    auto = '<link name="base"><inertial auto="{}">{}</inertial>' + BASE[BASE.index("<collision") :]
    for of, more, mass in (
        ("true", "", 20.0),
        ("1", "<density>800</density>", 16.0),
        ("true", "<mass>30</mass>", 30.0),
    ):
        read = found(tmp_path, auto.format(of, more) + PROP.format(pose=POSE, axis=Z) + THRUSTER.format(""))
        lump = read.robots[0].lumps[0]
        assert lump.mass_kg == pytest.approx(mass)
        assert lump.inertia_kg_m2[2, 2] == pytest.approx(mass * (0.8**2 + 0.4**2) / 12.0)
    (robot,) = found(
        tmp_path, BASE + '<link name="prop"/>' + PROP.partition("</link>")[2].format(axis=Z) + THRUSTER
    ).robots
    np.testing.assert_array_equal(robot.lumps[1].inertia_kg_m2, np.eye(3))
    assert robot.whole().mass_kg == 21.0


def test_added_mass_of_a_link_and_a_placed_model(tmp_path: Path) -> None:
    added = "<fluid_added_mass><xx>5</xx><yy>8</yy><xy>1</xy><zz>10</zz></fluid_added_mass></inertial>"
    text = BASE.replace("</inertial>", added) + PROP.format(pose=POSE, axis=Z) + THRUSTER.format("")
    (robot,) = found(tmp_path, f"<pose>0 0 -3 0 0 0</pose>{text}", attributes='placement_frame="prop"').robots
    np.testing.assert_array_equal(np.asarray(robot.added_mass)[:2, :3], [[5.0, 1.0, 0.0], [1.0, 8.0, 0.0]])
    np.testing.assert_allclose(robot.place.turn[:, 0], [0.0, 0.0, 1.0], atol=1e-9)  # the propeller's z is the world's


def test_only_links_that_the_world_enables_displace_water(tmp_path: Path) -> None:
    sphere = "<geometry><sphere><radius>1</radius></sphere></geometry>"
    ball = f'<link name="ball"><collision name="c">{sphere}</collision></link>'
    world = '<plugin filename="gz-sim-buoyancy-system"><enable>a::base</enable></plugin>'
    model = f'<model name="a">{BASE}{ball}{PROP.format(pose=POSE, axis=Z)}{THRUSTER}</model>'
    (tmp_path / "a.sdf").write_text(f'<sdf version="1.9"><world name="w">{world}{model}</world></sdf>')
    assert read_sdf(tmp_path / "a.sdf").robots[0].volume_m3 == pytest.approx(0.02)


@pytest.mark.parametrize("coefficient, ahead", [(0.02, 1.0), (-0.02, -1.0)])
def test_a_command_of_speed_gives_the_thrust_of_its_square(coefficient: float, ahead: float, tmp_path: Path) -> None:
    """gz-sim's Thruster: k rho D^4 w |w|, whose bounds are rad/s; a left-handed screw pushes the other way."""
    more = f"""<use_angvel_cmd>true</use_angvel_cmd><propeller_diameter>0.1</propeller_diameter>
      <fluid_density>1025</fluid_density><thrust_coefficient>{coefficient}</thrust_coefficient>"""
    (robot,) = found(tmp_path, BASE + PROP.format(pose=POSE, axis=Z) + THRUSTER.format(more)).robots
    (thruster,) = robot.thrusters
    assert dict(thruster.thrust_n)[1.0] == pytest.approx(0.02 * 1025.0 * 0.1**4 * 30.0**2)
    np.testing.assert_allclose(thruster.axis, [ahead, 0.0, 0.0], atol=1e-9)
    assert thruster.clockwise == (ahead > 0.0)


def test_a_thruster_in_its_deadband_does_not_push(tmp_path: Path) -> None:
    model = BASE + PROP.format(pose=POSE, axis=Z) + THRUSTER.format("<deadband>3</deadband>")
    commands, thrust = np.array(found(tmp_path, model).robots[0].thrusters[0].thrust_n).T
    np.testing.assert_allclose(np.interp([-0.5, -0.09, 0.09, 0.5, 1.0], commands, thrust), [-15, 0, 0, 15, 30], 1e-5)


MOTOR = """<plugin name="m" filename="{}"><jointName>prop_joint</jointName><linkName>prop</linkName>{}
  <turningDirection>ccw</turningDirection></plugin>"""


@pytest.mark.parametrize(
    "file, stated, thrust",
    [
        (
            "libGenericMotorModelPlugin.so",
            """<motorType>force_polynomial</motorType><controlMethod>duty_cycle</controlMethod><minDutyCycle>1100</minDutyCycle>
            <maxDutyCycle>1900</maxDutyCycle><bidirectionalMotor>1</bidirectionalMotor><minCommand>0.1</minCommand>
            <positiveThrustPolynomial>[0.0, 2.0, 30]</positiveThrustPolynomial>
            <negativeThrustPolynomial>[0.0, 0, 20.0]</negativeThrustPolynomial>""",
            lambda x: 0.0 if abs(x) < 0.1 else 2.0 * x + 30.0 * x**2 if x > 0.0 else -20.0 * x**2,
        ),
        (
            "gz-sim-multicopter-motor-model-system",
            "<maxRotVelocity>400</maxRotVelocity><motorConstant>2e-4</motorConstant>",
            lambda x: 32.0 * x * abs(x),
        ),
    ],
)
def test_motors_thrust_along_their_link_as_their_sources_state(
    file: str, stated: str, thrust: Callable[[float], float], tmp_path: Path
) -> None:
    """The link's z is ahead, whatever its joint's axis is; of a counter-clockwise rotor, torque is against that z."""
    side = "<axis><xyz>1 0 0</xyz></axis>"
    (robot,) = found(tmp_path, BASE + PROP.format(pose=POSE, axis=side) + MOTOR.format(file, stated)).robots
    (motor,) = robot.thrusters
    np.testing.assert_allclose(motor.axis, AHEAD, atol=1e-9)
    commands, forces = np.array(motor.thrust_n).T
    for x in (-1.0, -0.5, 0.0, 0.05, 0.75, 1.0):
        assert np.interp(x, commands, forces) == pytest.approx(thrust(x), abs=1e-3 * forces.max())
    assert motor.clockwise


def test_notes_on_the_motion_come_first_and_those_on_looks_last(tmp_path: Path) -> None:
    """A wing whose coefficients mean something else than LiftDrag's is one on the motion."""
    base = BASE.replace("</link>", '<visual name="v"/><sensor name="s" type="nose"/><gravity>0</gravity></link>')
    wing = '<plugin name="w" filename="gz-sim-advanced-lift-drag-system"><link_name>prop</link_name></plugin>'
    notes = found(tmp_path, base + PROP.format(pose=POSE, axis=Z) + THRUSTER.format("") + wing).all_notes()
    order = ["read", "motion", "senses", "looks", "topic", ""]
    grades = [order.index(note.grade or note.kind) for note in notes]
    assert grades == sorted(grades)
    of = [next(n for n in notes if word in n.text) for word in ("link/gravity = 0", "advanced", "nose", "visual")]
    assert [note.grade for note in of] == ["motion", "motion", "senses", "looks"]
    assert str(of[0]).startswith("motion: left out: ")


def test_urdf_s_values_have_their_meaning_and_an_odd_one_is_left_out_alone(tmp_path: Path) -> None:
    parts = [
        f"<collision><geometry><{each}/></geometry></collision>"
        for each in ("box size=&1 1 1&", "box size=&1 1&", "capsule radius=&1& length=&2&")
    ]
    inertial = "<inertial><origin quat_xyzw=&0 0 1 1&/><mass value=&1&/><inertia ixx=&1& iyy=&2& izz=&3&/></inertial>"
    joint = '<joint name="{0}" type="revolute"><parent link="b"/><child link="{0}"/>{1}</joint><link name="{0}"/>'
    limits, zero = "<limit lower=&-inf& upper=&inf&/><axis xyz=&0 0 7&/>", "<axis xyz=&0 0 0&/>"
    text = f'<link name="b">{inertial}{"".join(parts)}</link>{joint.format("c", limits)}{joint.format("d", zero)}'
    (tmp_path / "a.urdf").write_text(f'<robot name="a">{text}</robot>'.replace("&", '"'))
    read = read_urdf(tmp_path / "a.urdf")
    assert summed_volume(read.robots[0].solids)[0] == pytest.approx(1.0 + np.pi * (2.0 + 4.0 / 3.0))
    np.testing.assert_allclose(np.diagonal(read.robots[0].lumps[0].inertia_kg_m2), [2.0, 1.0, 3.0])
    assert any("joint 'd'/axis: its axis must not be zero" in note.text for note in read.notes)


class _Counted(dict[str, Joint]):
    asked = 0

    def values(self):  # type: ignore[no-untyped-def]
        self.asked += 1
        return super().values()


def test_a_chain_of_links_is_walked_once(tmp_path: Path) -> None:
    links, joints = Links(None), _Counted()  # type: ignore[arg-type]
    for k in range(5000):
        links.poses[f"l{k}"] = HERE
        joints[f"j{k}"] = Joint(f"j{k}", "fixed", f"l{k}", f"l{k + 1}", HERE, np.zeros(3))
    links.poses["l5000"], links.joints = HERE, joints
    assert links.base(Description("")) == "l0" and joints.asked < 5
