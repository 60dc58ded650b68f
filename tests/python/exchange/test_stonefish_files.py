"""Stonefish's files as others publish them: arguments, data folders, formulas, and odd elements beside sound ones."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from uwsim.exchange.robots import shapes
from uwsim.exchange.robots.robot import Description, Given, Robot
from uwsim.exchange.robots.stonefish import read_stonefish
from uwsim.exchange.robots.stonefish_text import formula
from uwsim.exchange.robots.written import write_found
from uwsim.scenario import load
from uwsim.scenario.read.note import Note

pytestmark = pytest.mark.usefixtures("panels_left_out")

SCN = (Path(__file__).parents[1] / "data" / "robots" / "robot.scn").read_text()
FIELD = Path(__file__).parents[4] / "shared" / "field" / "robots"
MASS_KG = 900.0 * 0.1 + 8.0
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
THRUST = '<thrust_model type="fluid_dynamics"><thrust_coeff forward="0.4" reverse="0.2"/>'


def read(path: Path, text: str, data: Path | None = None, **arguments: str) -> Description:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return read_stonefish(path, Description(path.stem, Given(arguments, data)))


def field(name: str, **arguments: str) -> Robot:
    if not (FIELD / name).is_file():
        pytest.skip(f"{FIELD / name}: not on this machine")
    return read_stonefish(FIELD / name, Description("field", Given(arguments))).robots[0]


def test_arguments_come_from_the_user_the_include_or_the_file_itself(tmp_path: Path) -> None:
    text = SCN.replace('name="Robot"', 'name="$(arg id)"').replace('xyz="10 3 4"', 'xyz="$(param start)"')
    own = text.replace("<environment>", '<arg name="id" value="own"/><environment>')
    assert read(tmp_path / "a.scn", own, start="1 2 3").robots[0].name == "own"
    (robot,) = read(tmp_path / "a.scn", own, start="1 2 3", id="given").robots
    assert robot.name == "given"
    np.testing.assert_allclose(robot.place.position_m, [2.0, 1.0, -3.0])  # NED to ENU
    top = '<scenario><include file="a.scn"><arg name="id" value="of_include"/></include></scenario>'
    assert read(tmp_path / "top.scn", top, start="1 2 3", id="given").robots[0].name == "of_include"
    with pytest.raises(ValueError, match=r"a\.scn'.*give --arg id=VALUE --arg start=VALUE"):
        read(tmp_path / "a.scn", text)


def test_data_is_looked_for_above_the_file_unless_it_is_given(tmp_path: Path) -> None:
    mesh = 'type="model"><physical><mesh filename="m/a.obj"/></physical>'
    text = SCN.replace('type="box"><dimensions xyz="1 2 3"/>', mesh)
    for size, folder in enumerate(("pkg/resources", "other"), start=1):
        (tmp_path / folder / "m").mkdir(parents=True)
        (tmp_path / folder / "m" / "a.obj").write_text(OBJ.replace("1 0 0", f"{size} 0 0"))
    for data, size in ((None, 1.0), (tmp_path / "other", 2.0)):
        vertices, _ = read(tmp_path / "pkg" / "scenarios" / "a.scn", text, data).meshes["Post"]
        assert np.ptp(vertices[:, 1]) == size  # north


def test_a_package_is_the_folder_whose_manifest_names_it(tmp_path: Path) -> None:
    (tmp_path / "checkout").mkdir()
    (tmp_path / "checkout" / "package.xml").write_text("<package><name>rovs</name></package>")
    (tmp_path / "checkout" / "rovs").mkdir()  # of its Python code
    (tmp_path / "checkout" / "robot.scn").write_text(SCN)
    found = read(tmp_path / "checkout" / "top.scn", '<scenario><include file="$(find rovs)/robot.scn"/></scenario>')
    assert found.robots[0].name == "Robot"


@pytest.mark.parametrize(
    "text, value",
    [("-2^2", 4.0), ("2^3^2", 64.0), ("7%4", 3.0), ("log 100", 2.0), ("pow(2, 3) - ln(e())", 7.0), ("ncr(5,2)", 10.0)],
)
def test_formulas_are_those_of_tinyexpr(text: str, value: float) -> None:
    assert formula(text) == pytest.approx(value)


GRIPPER = """<link name="Claw" type="model"><physical><mesh filename="lost.obj"/></physical><mass value="0.5"/>
  <cg xyz="1 0 0" rpy="0 0 0"/></link><joint name="J" type="revolute"><parent name="Body"/><child name="Claw"/>
  <origin xyz="0.5 0 0" rpy="0 0 0"/></joint>"""


@pytest.mark.parametrize(
    "odd, noted",
    [
        ('<actuator name="Odd" type="warp"/>', "'Odd', of type warp"),
        ('<actuator name="Odd" type="thruster"/>', "'Odd': link None is not one of Body"),
        ('<sensor name="Odd" type="dvl"><link name="Lost"/></sensor>', "'Odd': link 'Lost' is not one of Body"),
        ('<sensor name="Odd" type="nose"/>', "'Odd', of type nose"),
        ('<link name="Odd" type="box"/>', "'Odd': no joint connects it"),
        ('<joint name="Odd" type="fixed"><parent name="Lost"/></joint>', "'Odd': it holds nothing to"),
        (GRIPPER, "link 'Claw': 0.5 kg that displace nothing: 'lost.obj': is in no folder above"),
        ('</robot><robot name="Odd"><base_link type="box"/>', "robot 'Odd': no thruster moves it"),
        ('</robot><static name="Odd" type="model"/><robot name="Prop">', "static 'Odd': has no <physical>"),
        ('</robot><include file="odd.scn"/><robot name="Prop">', "include: 'odd.scn': is in no folder above"),
        ('</robot><robot name="Odd"><actuator name="T" type="push"/>', "robot 'Odd': has no <base_link>"),
    ],
)
def test_an_odd_element_refuses_none_beside_it(odd: str, noted: str, tmp_path: Path) -> None:
    head, tail = SCN.rsplit("</robot>", 1)
    found = read(tmp_path / "a.scn", f"{head}{odd}</robot>{tail}")
    (robot,) = found.robots
    assert len(robot.thrusters) == 1 and robot.volume_m3 == pytest.approx(0.1)
    assert any(noted in note.text for note in found.notes), found.notes
    assert robot.whole().mass_kg == pytest.approx(MASS_KG + (0.5 if odd is GRIPPER else 0.0))
    if odd is GRIPPER:
        np.testing.assert_allclose(robot.lumps[-1].centre_m, [1.5, 0.0, 0.0])


def test_what_cannot_move_or_float_is_refused_with_the_reason(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="robot 'Robot': none of its thrusters can be used"):
        read(tmp_path / "a.scn", SCN.replace("<specs max", "<none max"))
    with pytest.raises(ValueError, match="robot 'Robot': none of its thrusters can be used"):
        read(tmp_path / "a.scn", SCN.replace('diameter="0.2"', 'diameter="1e308"'))
    with pytest.raises(ValueError, match="robot 'Robot': no part of it that can be used displaces water"):
        read(tmp_path / "a.scn", SCN.replace('<dimensions xyz="1 0.5 0.2"/>', ""))


def test_an_unknown_material_is_the_first_and_a_dry_part_displaces_nothing(tmp_path: Path) -> None:
    found = read(tmp_path / "a.scn", SCN.replace('<material name="foam"/>', '<material name="cork"/>'))
    assert found.robots[0].whole().mass_kg == pytest.approx(MASS_KG)
    assert Note("assumed", "material 'cork', which no file has, is 'foam', of 900 kg/m3") in found.notes
    with pytest.raises(ValueError, match="displaces water"):
        read(tmp_path / "a.scn", SCN.replace('type="box" buoyant="true"', 'type="box" physics="surface"'))


@pytest.mark.parametrize("mass_kg, volume_m3", [(1500.0, 1.5), (500.0, 0.5), (700.0, 0.5), (1300.0, 1.5)])
def test_a_mesh_wound_both_ways_displaces_what_balances_its_mass(
    mass_kg: float, volume_m3: float, tmp_path: Path
) -> None:
    """A cube of 1 m3, and a slab of 0.5 m3 that winds inward: Stonefish counts 0.5 m3."""
    (outer, faces), (inner, _) = shapes.box(np.ones(3)), shapes.box(np.array([0.5, 1.0, 1.0]))
    points, turned = (
        np.concatenate([outer, inner + np.array([3.0, 0.0, 0.0])]),
        np.concatenate([faces, faces[:, ::-1] + len(outer)]),
    )
    lines = [f"v {x} {y} {z}" for x, y, z in points] + [f"f {a} {b} {c}" for a, b, c in turned + 1]
    (tmp_path / "a.obj").write_text("\n".join([*lines, ""]))
    mesh = 'type="model" buoyant="true"><physical><mesh filename="a.obj"/></physical>'
    text = SCN.replace(
        'type="box" buoyant="true"><dimensions xyz="1 0.5 0.2"/>', f'{mesh}<mass value="{mass_kg - 8}"/>'
    )
    found = read(tmp_path / "a.scn", text.replace('<water density="1020"/>', ""))
    assert found.robots[0].volume_m3 == pytest.approx(volume_m3)
    assert any(
        f"displaces {volume_m3:g} m3, nearer to its mass than {2.0 - volume_m3:g} m3" in note.text
        for note in found.notes
    )


def test_water_is_the_first_file_s_and_its_currents_add_up(tmp_path: Path) -> None:
    (tmp_path / "a.scn").write_text(SCN)
    current = '<current type="uniform"><velocity xyz="{} 0 0"/></current>'
    ocean = f"<environment><ocean>{current.format(1)}{current.format(2)}{current.format(99)}</ocean></environment>"
    found = read(tmp_path / "top.scn", f'<scenario>{ocean}<include file="a.scn"/></scenario>')
    np.testing.assert_allclose(found.current_m_s, [0.0, 3.0, 0.0])
    assert any("99 m/s: must be at most 5 m/s" in note.text for note in found.notes)
    assert found.density_kg_m3 == 1000.0


def yoerger(speed: float, setpoint: float) -> float:
    return 2.0 * setpoint - 0.5 * speed * abs(speed)


def bessa(speed: float, setpoint: float) -> float:
    return (setpoint * 3.0 / 1.5 - 0.4 * speed - 0.1 * speed * abs(speed)) / 0.2


@pytest.mark.parametrize(
    "rate, rotor",
    [
        (yoerger, '"yoerger"><alpha value="0.5"/><beta value="2"/>'),
        (bessa, '"bessa"><jmsp value="0.2"/><kv1 value="0.4"/><kv2 value="0.1"/><kt value="3"/><rm value="1.5"/>'),
    ],
)
def test_a_thruster_has_the_speed_at_which_its_rotor_settles(
    rate: Callable[[float, float], float], rotor: str, tmp_path: Path
) -> None:
    text = SCN.replace('"first_order"><time_constant value="0.1"/>', rotor).replace("${600/60*2*pi}", "50")
    text = text.replace(THRUST, '<thrust_model type="quadratic"><thrust_coeff value="0.3"/>')
    (thruster,) = read(tmp_path / "a.scn", text).robots[0].thrusters
    speed, full = 0.0, dict(thruster.thrust_n)[1.0]
    for _ in range(20_000):
        speed += 1e-3 * rate(speed, 50.0)
    assert full == pytest.approx(0.3 * speed**2, rel=1e-3)
    slope = (rate(speed + 1e-3, 50.0) - rate(speed, 50.0)) / 1e-3
    assert thruster.time_constant_s == pytest.approx(-1.0 / slope, rel=1e-3)


def test_a_table_of_thrust_keeps_its_points_where_the_largest_setpoint_is_far_beyond(tmp_path: Path) -> None:
    table = '<thrust_model type="linear_interpolation"><input value="-7 0 3 9"/><output value="-5 0 1 8"/>'
    text = SCN.replace(THRUST, table).replace("${600/60*2*pi}", "800")
    (thruster,) = read(tmp_path / "a.scn", text).robots[0].thrusters
    commands, thrust_n = np.array(thruster.thrust_n).T
    np.testing.assert_allclose(
        np.interp(np.array([-7.0, 3.0, 6.0, 9.0]) / 800.0, commands, thrust_n), [-5.0, 1.0, 4.5, 8.0]
    )


def test_sonars_and_sensors_have_the_figures_that_are_stated(tmp_path: Path) -> None:
    place = '<link name="Body"/><origin xyz="0.5 0 0" rpy="1.5707963267948966 0 1.5707963267948966"/></sensor>'
    sensors = f"""<sensor name="fls" type="fls"><specs beams="128" bins="300" horizontal_fov="90" vertical_fov="500"/>
      <settings range_max="20"/>{place}<sensor name="log" type="dvl" rate="5"><specs beam_angle="25"/>
      <range altitude_max="60"/>{place}<sensor name="p" type="pressure" rate="5"><noise pressure="7"/>{place}</robot>"""
    found = read(tmp_path / "a.scn", SCN.replace("</robot>", sensors))
    model = load(write_found(found, tmp_path / "out")).vehicles[0].model
    sonar = model.imaging_sonars["fls"]
    assert (sonar.figures["beams"], sonar.figures["range_bins"], sonar.figures["range_max_m"]) == (128, 300, 20)
    assert sonar.figures["field_of_view_rad"] == pytest.approx(np.pi / 2.0)
    np.testing.assert_allclose(sonar.yaw_pitch_roll_deg, np.zeros(3), atol=1e-3)  # it looks ahead, upright
    assert any("vertical_width_deg = 500: must be" in note.text for note in found.notes)
    assert found.robots[0].sensors["log"]["beam_slant_deg"] == 25.0
    assert found.robots[0].sensors["log"]["range_max_m"] == 60.0
    assert found.robots[0].sensors["p"]["channels"] == {"pressure": {"std": 7.0}}


def test_a_ring_has_the_volume_of_pappus() -> None:
    mesh = shapes.torus(1.0, 0.2)
    assert shapes.volume_and_centre(mesh)[0] == pytest.approx(2.0 * np.pi * np.pi * 0.2**2)
    np.testing.assert_allclose(np.ptp(mesh[0], axis=0), [2.4, 0.4, 2.4], rtol=0.02)


def test_stated_dynamics_of_a_published_kind_are_the_vehicle_s() -> None:
    whole = field("scn_stated_dynamics.scn").whole()
    np.testing.assert_allclose(np.diagonal(whole.inertia_kg_m2), [11.0, 23.0, 26.0])
    np.testing.assert_allclose(whole.centre_m, [0.0, 0.0, -0.05], atol=1e-12)


def test_a_mesh_wound_both_ways_encloses_its_volume_and_files_are_found_as_published() -> None:
    assert field("scn_mixed_winding.scn").volume_m3 == pytest.approx(0.037)  # 37 kg, neutral in 1000 kg/m3
    assert field("pkg/scenarios/sea.scn").volume_m3 is not None
    np.testing.assert_allclose(field("scn_param.scn", start_xyz="0 0 2").place.position_m, [0.0, 0.0, -2.0])


BALL = """<dynamic name="Ball" type="sphere" physics="submerged" buoyant="true"><dimensions radius="0.5"/>
  <origin xyz="0 0 0" rpy="0 0 0"/><material name="foam"/><world_transform xyz="3 4 2" rpy="0 0 0"/></dynamic>"""
BEACON = '<comm name="Beacon" type="acoustic_modem" device_id="2"><world_transform xyz="30 5 9" rpy="0 0 0"/></comm>'
USBL = """<comm name="Fix" type="usbl" device_id="1"><connect device_id="2"/><link name="Body"/><specs range="300"/>
  <origin xyz="0.1 0 0" rpy="0 0 0"/><autoping rate="2"/><noise range="0.2" horizontal_angle="1" vertical_angle="2"/>
  <resolution range="0.1"/></comm></robot>"""


def test_loose_bodies_beacons_and_usbl_are_taken_over(tmp_path: Path) -> None:
    """In NED, (3, 4, 2) is 4 m east, 3 m north and 2 m deep; foam of 900 kg/m3 fills a ball of 0.5 m radius."""
    text = SCN.replace("</robot>", USBL).replace("</scenario>", f"{BALL}{BEACON}</scenario>")
    found = read(tmp_path / "a.scn", text)
    scenario = load(write_found(found, tmp_path / "out"))
    (ball,), (pinger,) = scenario.objects, scenario.pingers
    volume, centre = shapes.volume_and_centre(found.meshes["Ball"])
    np.testing.assert_allclose(centre, [4.0, 3.0, -2.0], atol=1e-6)
    assert volume == pytest.approx(np.pi / 6.0) and ball.mass_kg == pytest.approx(900.0 * np.pi / 6.0)
    assert pinger.position_m == (5.0, 30.0, -9.0) and scenario.station.position_m == (5.0, 30.0, 0.0)
    usbl = found.robots[0].sensors["Fix"]
    assert usbl["rate_hz"] == 2.0 and usbl["range_max_m"] == 300.0 and usbl["position_m"] == [0.1, 0.0, 0.0]
    assert usbl["channels"]["range"] == {"std": 0.2, "quantum": 0.1}
    assert usbl["channels"]["bearing"]["std"] == pytest.approx(np.radians(2.0))


TURN = 0.1
SLOPED = {
    "plane": f'<static name="F" type="plane"><world_transform xyz="0 0 6" rpy="0 {TURN} 0"/></static>',
    "pool": f"""<static name="F" type="box"><dimensions xyz="40 40 1"/>
      <world_transform xyz="0 0 6.5" rpy="0 {TURN} 0"/></static>""",
}


@pytest.mark.parametrize("floor", SLOPED)
def test_a_sloped_floor_is_the_bed(floor: str, tmp_path: Path) -> None:
    """In NED, a pitch by a turns the floor's north end up: it rises by tan a per metre to the north."""
    text = re.sub("<static.*?</static>", "", SCN, flags=re.DOTALL).replace("</scenario>", f"{SLOPED[floor]}</scenario>")
    found = read(tmp_path / "a.scn", text)
    scenario = load(write_found(found, tmp_path / "out"))
    heights = scenario.terrain.heights()
    rows, columns = heights.shape
    middle, north = heights[rows // 2, columns // 2], heights[rows // 2 + 20, columns // 2]
    top = 6.0 if floor == "plane" else 6.5 - 0.5 / np.cos(TURN)
    assert middle == pytest.approx(-top, abs=1e-3)
    assert north - middle == pytest.approx(20 * scenario.terrain.spacing_m * np.tan(TURN), rel=1e-3)


def test_a_pool_s_own_floor_is_the_bed_and_a_guest_starts_in_its_water(tmp_path: Path) -> None:
    """24 m long, 1.2 to 3.5 m deep; its faces wind any way, and a deck about it is above the water."""
    rim = "v -12 -6 -0.2\nv 12 -6 -0.2\nv 12 6 -0.2\nv -12 6 -0.2\nv -15 -9 -0.2\nv 15 -9 -0.2\n"
    floor = "v -12 -6 1.2\nv 12 -6 3.5\nv 12 6 3.5\nv -12 6 1.2\n"
    (tmp_path / "pool.obj").write_text(f"{rim}{floor}f 7 8 9\nf 7 10 9\nf 1 2 7\nf 2 7 8\nf 1 2 5\nf 2 5 6\n")
    still = 'xyz="0 0 0" rpy="0 0 0"/>'
    pool = f'<physical><mesh filename="pool.obj"/><origin {still}</physical><world_transform {still}'
    (tmp_path / "a.scn").write_text(f'<scenario><static name="P" type="model">{pool}</static></scenario>')
    lines: list[str] = []
    found = read_stonefish(tmp_path / "a.scn", Description("a", Given(progress=lines.append)))
    assert lines == ["mesh 1: 'pool.obj'"]
    scenario = load(write_found(found, tmp_path / "out"))
    heights, step = scenario.terrain.heights(), scenario.terrain.spacing_m
    middle = heights.shape[0] // 2
    assert heights[middle + round(6.0 / step), middle] == pytest.approx(-2.35 - 6.0 * 2.3 / 24.0, abs=2e-3)
    np.testing.assert_allclose(scenario.vehicles[0].start.position_m, [-1.5, 0.0, -1.175], atol=1e-3)
