"""Numbers that a robot's description states are the vehicle's, or are asked for: mass, drag and bounds of thrust."""

import re
from pathlib import Path

import numpy as np
import pytest

from uwsim.exchange.robots import shapes
from uwsim.exchange.robots.robot import Description, Given, Robot
from uwsim.exchange.robots.sdf import read_sdf
from uwsim.exchange.robots.stonefish import read_stonefish
from uwsim.exchange.robots.urdf import read_urdf
from uwsim.exchange.robots.written import write_found
from uwsim.scenario import load

pytestmark = pytest.mark.usefixtures("panels_left_out")

DATA = Path(__file__).parents[1] / "data" / "robots"
RHO, SIDES = 1020.0, np.array([0.8, 0.5, 0.4])
MASS = '<mass value="170"/>'
BODY = '<base_link name="Body" type="compound">'


def with_box(more: str, kind: str = 'type="box"') -> str:
    """Return a scenario whose robot is a box of steel, filled, with more elements."""
    text = (DATA / "robot.scn").read_text()
    head, rest = text.split(BODY)
    box = f"""<base_link name="Body" {kind}><dimensions xyz="0.8 0.5 0.4"/><origin xyz="0 0 0" rpy="0 0 0"/>
      <material name="steel"/>{more}</base_link>"""
    return head + box + rest.split("</base_link>")[1]


def stonefish(tmp_path: Path, text: str) -> Robot:
    (tmp_path / "a.scn").write_text(text)
    return read_stonefish(tmp_path / "a.scn").robots[0]


def of_box(mass_kg: float) -> np.ndarray:
    return mass_kg / 12.0 * ((SIDES**2).sum() - SIDES**2)


def test_a_stated_mass_scales_the_inertia_and_a_stated_inertia_and_centre_of_gravity_are_the_vehicle_s(
    tmp_path: Path,
) -> None:
    whole = stonefish(tmp_path, with_box(MASS)).whole()
    np.testing.assert_allclose(np.diagonal(whole.inertia_kg_m2), of_box(170.0))
    more = MASS + '<inertia xyz="11 23 26"/><cg xyz="0.1 0.02 0.05" rpy="0 0 0"/>'
    whole = stonefish(tmp_path, with_box(more)).whole()
    np.testing.assert_allclose(np.diagonal(whole.inertia_kg_m2), [11.0, 23.0, 26.0])
    np.testing.assert_allclose(whole.centre_m, [0.1, -0.02, -0.05], atol=1e-12)  # forward, port, up


def test_what_is_not_stated_beside_a_centre_of_gravity_is_the_material_s(tmp_path: Path) -> None:
    """Stonefish's SetArbitraryPhysicalProperties: the inertia is not scaled by the mass there."""
    whole = stonefish(tmp_path, with_box(MASS + '<cg xyz="0 0 0.05" rpy="0 0 0"/>')).whole()
    assert whole.mass_kg == 170.0
    np.testing.assert_allclose(np.diagonal(whole.inertia_kg_m2), of_box(7850.0 * 0.16))


def test_a_part_of_a_compound_keeps_its_centre_of_gravity_where_the_part_is(tmp_path: Path) -> None:
    part = MASS + '<inertia xyz="1 2 2.5"/><cg xyz="0 0.1 0" rpy="0 0 0"/>'
    turned = 'compound_transform xyz="0 0 -0.05" rpy="0 0 1.5707963267948966"'
    text = (DATA / "robot.scn").read_text().replace('<mass value="8"/>', part)
    lead = stonefish(tmp_path, text.replace('compound_transform xyz="0 0 -0.05" rpy="0 0 0"', turned)).lumps[1]
    np.testing.assert_allclose(lead.centre_m, [-0.1, 0.0, 0.05], atol=1e-12)
    np.testing.assert_allclose(lead.inertia_kg_m2, np.diag([2.0, 1.0, 2.5]), atol=1e-12)


def write_box(path: Path, inward: set[int]) -> None:
    """Write a box of SIDES, some of whose faces wind inward."""
    x, y, z = np.meshgrid(*([-s / 2, s / 2] for s in SIDES), indexing="ij")
    corners = np.stack([x, y, z], axis=-1).reshape(8, 3)
    quads = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
    wound = [quad[::-1] if k in inward else quad for k, quad in enumerate(quads)]
    lines = [f"v {a} {b} {c}" for a, b, c in corners] + [f"f {' '.join(map(str, quad))}" for quad in wound]
    path.write_text("\n".join([*lines, ""]))


def test_a_mesh_of_mixed_winding_has_the_inertia_of_its_solid(tmp_path: Path) -> None:
    write_box(tmp_path / "hull.obj", {1, 2})
    model = f'<physical><mesh filename="hull.obj"/><origin xyz="0 0 0" rpy="0 0 0"/></physical>{MASS}'
    with pytest.warns(UserWarning, match="repaired"):
        whole = stonefish(tmp_path, with_box(model, 'type="model"')).whole()
    np.testing.assert_allclose(np.diagonal(whole.inertia_kg_m2), of_box(170.0))


def test_stated_drag_is_that_of_the_box_s_faces(tmp_path: Path) -> None:
    """Stonefish: rho / 2 Cd S v^2 on the face ahead, and rho Cf A v on those along; the weights are those of axes."""
    drag = '<hydrodynamics viscous_drag="0.05 0.08 0.09" quadratic_drag="0.2 0.6 0.7"/>'
    (tmp_path / "a.scn").write_text(with_box(MASS + drag))
    found = read_stonefish(tmp_path / "a.scn")
    model = load(write_found(found, tmp_path / "out")).vehicles[0].model
    faces = np.prod(SIDES) / SIDES
    np.testing.assert_allclose(model.quadratic_damping[:3], 0.5 * RHO * np.array([0.2, 0.6, 0.7]) * faces, rtol=1e-6)
    along = 2.0 * (faces.sum() - faces)
    np.testing.assert_allclose(model.linear_damping[:3], RHO * np.array([0.05, 0.08, 0.09]) * along, rtol=1e-6)
    # About x, the skin of the face at half a side h, of width w, moves tangentially with h: h^2 A; the ends with r.
    width, height = SIDES[1:]
    roll = 2.0 * (faces[1] * (width / 2) ** 2 + faces[2] * (height / 2) ** 2 + faces[0] * (width**2 + height**2) / 12)
    assert model.linear_damping[3] == pytest.approx(RHO * 0.05 * roll, rel=0.01)
    assert model.crossflow_length_m == 0.0 and not model.fins
    assert any("added mass is estimated" in note.text for note in found.notes)
    assert not any("hydrodynamics" in note.text for note in found.notes)


def test_drag_turns_with_its_part_and_what_is_not_stated_is_named(tmp_path: Path) -> None:
    level, turned = (f'<compound_transform xyz="0 0 -0.1" rpy="0 0 {yaw}"/>' for yaw in ("0", "1.5707963267948966"))
    foam = '<hydrodynamics quadratic_drag="0.2 0.6 0.7"/>' + turned
    text = (DATA / "robot.scn").read_text().replace(level, foam)
    (tmp_path / "a.scn").write_text(text)
    found = read_stonefish(tmp_path / "a.scn")
    (linear, quadratic) = found.robots[0].drag(np.zeros(3))
    sides = np.array([0.5, 1.0, 0.2])  # as it stands in the body
    faces = np.prod(sides) / sides
    np.testing.assert_allclose(quadratic[:3], 0.5 * RHO * np.array([0.6, 0.2, 0.7]) * faces, rtol=1e-6)
    own = 0.1 * 0.2 / sides  # Stonefish's own Cf: a tenth of the smallest half axis over each
    np.testing.assert_allclose(linear[:3], RHO * own * 2.0 * (faces.sum() - faces), rtol=1e-6)
    assert any("'Foam': drag that it does not state is Stonefish's own" in note.text for note in found.notes)


CLAMPS = "<clampMin>-100</clampMin><clampMax>200</clampMax>"


def urdf(tmp_path: Path, clamps: str) -> Robot:
    return found_urdf(tmp_path, clamps).robots[0]


def found_urdf(tmp_path: Path, clamps: str) -> Description:
    (tmp_path / "sled.urdf").write_text((DATA / "sled.urdf").read_text().replace(CLAMPS, clamps))
    return read_urdf(tmp_path / "sled.urdf")


def bounds_n(robot: Robot) -> tuple[float, float]:
    curve = dict(robot.thrusters[0].thrust_n)
    return curve[-1.0], curve[1.0]


def test_a_thruster_without_a_bound_is_a_question(tmp_path: Path) -> None:
    unbound = found_urdf(tmp_path, "")
    assert not unbound.robots[0].thrusters
    assert any(re.search(r"'tail_joint' has no bound.*thruster_manager.yaml", note.text) for note in unbound.notes)
    (tmp_path / "thruster_manager.yaml").write_text("thruster_manager:\n  max_thrust: 37.5\n")
    assert bounds_n(urdf(tmp_path, "")) == pytest.approx((-37.5, 37.5))
    (tmp_path / "thruster_manager.yaml").write_text("thruster_manager:\n  max_thrust: much\n")
    much = found_urdf(tmp_path, "").notes
    assert any("max_thrust = 'much': must be a positive number [N]" in note.text for note in much)


def test_a_bound_is_the_user_s_or_the_checkout_s_for_this_vehicle(tmp_path: Path) -> None:
    here, other = tmp_path / "sled_description", tmp_path / "sled_control" / "config"
    for folder in (here, other, tmp_path / ".git", tmp_path / "another"):
        folder.mkdir(parents=True)
    manager = "/**:\n  ros__parameters:\n    thruster_manager: {tf_prefix: SLED, max_thrust: 20}\n"
    (other / "thruster_manager.yaml").write_text(manager.replace("SLED", "sled"))
    (tmp_path / "another" / "thruster_manager.yaml").write_text(manager.replace("SLED", "another"))
    assert bounds_n(urdf(here, "")) == pytest.approx((-20.0, 20.0))
    found = Description("", Given({"max_thrust": "45"}))
    read_urdf(here / "sled.urdf", found)
    assert bounds_n(found.robots[0]) == pytest.approx((-45.0, 45.0))
    (other / "thruster_manager.yaml").write_text(manager)
    assert not urdf(here, "").thrusters


def test_a_bound_of_thrust_bounds_the_thrust_and_one_clamp_counts_for_both(tmp_path: Path) -> None:
    robot = urdf(tmp_path, "<thrustMin>-20</thrustMin><thrustMax>30</thrustMax>")
    assert bounds_n(robot) == pytest.approx((-20.0, 30.0))
    assert dict(robot.thrusters[0].thrust_n)[0.5] == pytest.approx(7.5)  # by the square of the input
    assert bounds_n(urdf(tmp_path, "<clampMax>50</clampMax>")) == pytest.approx((-25.0, 25.0))
    swapped = "<clampMin>200</clampMin><clampMax>-100</clampMax>"
    assert bounds_n(urdf(tmp_path, swapped)) == bounds_n(urdf(tmp_path, CLAMPS))


def test_damping_by_the_speed_ahead_is_quadratic_ahead(tmp_path: Path) -> None:
    """UUV Simulator's forces are -u D v; those of u alone are the vehicle's, the others are named."""
    text = (DATA / "sled.urdf").read_text()
    forward = "<linear_damping_forward_speed>-8 -162 -108 -13 -20 -32</linear_damping_forward_speed><linear_damping>"
    (tmp_path / "sled.urdf").write_text(text.replace("<linear_damping>", forward))
    found = read_urdf(tmp_path / "sled.urdf")
    np.testing.assert_array_equal(np.diagonal(found.robots[0].quadratic)[:3], [158.0, 250.0, 300.0])
    assert any("162, 108, 13, 20, 32 on their own" in note.text for note in found.notes)


def test_dynamics_of_other_kinds_leave_the_thruster(tmp_path: Path) -> None:
    text = (DATA / "sled.urdf").read_text().replace("<type>FirstOrder", "<type>Yoerger")
    (tmp_path / "sled.urdf").write_text(text)
    found = read_urdf(tmp_path / "sled.urdf")
    (thruster,) = found.robots[0].thrusters
    assert thruster.time_constant_s == 0.0 and any("type Yoerger" in note.text for note in found.notes)


def test_parts_without_a_silhouette_are_refused_in_words(tmp_path: Path) -> None:
    """As of a description whose only collision shapes are the pads of a gripper."""
    pads = "".join(
        f'<collision><origin xyz="{x} 0 {x}"/><geometry><box size="1e-3 1e-3 1e-3"/></geometry></collision>'
        for x in (0, 9)
    )
    text = (DATA / "sled.urdf").read_text().replace("libuuv_underwater_object_ros_plugin.so", "other.so")
    a, b = text.index("<collision>"), text.index("</collision>") + len("</collision>")
    (tmp_path / "sled.urdf").write_text(text[:a] + pads + text[b:])
    with pytest.raises(ValueError, match="has no silhouette"):
        write_found(read_urdf(tmp_path / "sled.urdf"), tmp_path / "out")


def test_a_link_that_no_joint_holds_is_left_out(tmp_path: Path) -> None:
    loose = '<link name="buoy"><inertial><mass value="9"/></inertial></link></robot>'
    (tmp_path / "sled.urdf").write_text((DATA / "sled.urdf").read_text().replace("</robot>", loose))
    found = read_urdf(tmp_path / "sled.urdf")
    assert found.robots[0].whole().mass_kg == 202.0
    assert any("link 'buoy': no joint holds it" in note.text for note in found.notes)


def test_a_table_of_pulse_widths_is_read_about_its_middle(tmp_path: Path) -> None:
    table = """<conversion><type>LinearInterp</type><inputValues>0 1099 1100 1480 1520 1900 1901</inputValues>
      <outputValues>0 0 -20 0 0 30 0</outputValues></conversion>"""
    text = (DATA / "sled.urdf").read_text().replace(CLAMPS, "")
    basic = text[text.index("<conversion>") : text.index("</conversion>") + len("</conversion>")]
    (tmp_path / "sled.urdf").write_text(text.replace(basic, table))
    robot = read_urdf(tmp_path / "sled.urdf").robots[0]
    assert bounds_n(robot) == pytest.approx((-20.0, 30.0))
    assert dict(robot.thrusters[0].thrust_n)[0.0] == 0.0  # at 1500


def test_an_inertia_that_no_body_has_is_the_nearest_that_one_has(tmp_path: Path) -> None:
    text = (DATA / "sled.urdf").read_text().replace('izz="50"', 'izz="80"')
    (tmp_path / "sled.urdf").write_text(text)
    found = read_urdf(tmp_path / "sled.urdf")
    x, y, z = load(write_found(found, tmp_path / "out")).vehicles[0].model.inertia_kg_m2
    assert z == pytest.approx(x + y) and any("which no rigid body has" in note.text for note in found.notes)


def test_hydrodynamics_of_other_links_are_carried_to_the_base_and_summed(tmp_path: Path) -> None:
    """Drag along an axis turns with the link; of two links, volumes and drag add up about the centre between them."""
    shell = """<link name="shell"/><joint name="shell_joint" type="fixed">
      <origin xyz="0.5 0 0" rpy="0 0 1.57079632679"/>
      <parent link="base"/><child link="shell"/></joint></robot>"""
    text = (DATA / "sled.urdf").read_text().replace("</robot>", shell)
    (tmp_path / "sled.urdf").write_text(text.replace('<link name="base"><volume>', '<link name="shell"><volume>'))
    one = read_urdf(tmp_path / "sled.urdf").robots[0]
    np.testing.assert_allclose(one.centre_of_buoyancy_m, [0.5, 0.0, 0.1], atol=1e-9)
    np.testing.assert_allclose(np.diagonal(one.linear)[:3], [40.0, 30.0, 50.0], atol=1e-6)
    np.testing.assert_allclose(one.linear[5, 5], 20.0 + 30.0 * 0.5**2, atol=1e-6)
    link = text[text.index('<link name="base"><volume>') : text.index("</link></plugin>") + len("</link>")]
    (tmp_path / "sled.urdf").write_text(text.replace(link, link + link.replace('"base"', '"shell"')))
    two = read_urdf(tmp_path / "sled.urdf").robots[0]
    assert two.volume_m3 == 0.4
    np.testing.assert_allclose(two.centre_of_buoyancy_m, [0.25, 0.0, 0.1], atol=1e-9)
    np.testing.assert_allclose(np.diagonal(two.linear)[:3], [70.0, 70.0, 100.0], atol=1e-6)


def test_a_mesh_that_winds_inward_displaces_what_it_encloses(tmp_path: Path) -> None:
    """It was dropped in silence, as a shape that only stands in for one."""
    write_box(tmp_path / "keel.obj", set(range(6)))
    keel = '<collision name="keel"><geometry><mesh><uri>keel.obj</uri></mesh></geometry></collision><sensor name="nose"'
    (tmp_path / "world.sdf").write_text((DATA / "glider.sdf").read_text().replace('<sensor name="nose"', keel))
    with pytest.warns(UserWarning, match="repaired"):
        robot = read_sdf(tmp_path / "world.sdf").robots[0]
    assert robot.volume_m3 == pytest.approx(2.0 * 0.25 * 0.2 + SIDES.prod())


DAE = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>{}</asset>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="12">0 0 0 1 0 0 0 2 0 0 0 3
</float_array><technique_common><accessor source="#a" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="4">
<input semantic="VERTEX" source="#v" offset="0"/><p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles></mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


@pytest.mark.parametrize(
    "asset, unit_m",
    [("<up_axis>Y_UP</up_axis>", 1.0), ("<up_axis>Z_UP</up_axis>", 1.0), ("", 1.0), ('<unit meter="0.01"/>', 0.01)],
)
def test_a_collada_file_has_its_unit_and_the_axes_that_gazebo_gives_it(
    asset: str, unit_m: float, tmp_path: Path
) -> None:
    """Gazebo's ColladaLoader reads the unit alone: whichever axis is up, the corners stay where they are."""
    pytest.importorskip("assimp_py", reason="the extra meshes")
    (tmp_path / "a.dae").write_text(DAE.format(asset))
    vertices, _ = shapes.from_file(tmp_path / "a.dae", np.ones(3))
    np.testing.assert_allclose(np.ptp(vertices, axis=0), np.array([1.0, 2.0, 3.0]) * unit_m, rtol=1e-5)
