"""An arm's links touch and hold: in water, where the vehicle feels what it lifts, and dry against MuJoCo's contacts."""

from typing import Any

import numpy as np
import pytest

from sites import flat, rov
from uwsim import Simulator
from uwsim.scenario import Scenario, ScenarioError

GRAVITY_M_S2 = 9.80665
TABLE_TOP_M = 2.0
REST_GAP_M = 1e-3  # above what a body rests on


def finger(side: int, at_m: tuple[float, float, float], strongest_n: float, **changes: Any) -> dict[str, Any]:
    """Return a finger on a slide, which closes with positive positions and is 0.1 m from the other at zero."""
    motor = {"strongest_n": strongest_n, "fastest_m_s": 0.05}
    return {
        "position_m": [at_m[0], at_m[1] + side * 0.07, at_m[2]],
        "slide": {"axis": [0, -side, 0], "limits_m": [-0.05, 0.05], "motor": motor},
        "mass_kg": 0.1,
        "inertia_kg_m2": [1e-4, 1e-4, 1e-4],
        "volume_m3": 4e-5,
        "shape": {"kind": "box", "name": "left" if side > 0 else "right", "position_m": [0, 0, 0],
                  "size_m": [0.06, 0.04, 0.06]},
        "friction": 0.5,
    } | changes  # fmt: skip


def gripper(at_m: tuple[float, float, float], strongest_n: float = 20.0, **vehicle: Any) -> dict[str, Any]:
    arm = {"left": finger(1, at_m, strongest_n), "right": finger(-1, at_m, strongest_n)}
    return {"builds_on": "bluerov2_heavy", "name": "gripper", "arm": arm} | vehicle


def site(model: dict[str, Any], start_m: list[float], **changes: Any) -> Scenario:
    return flat(rov(model, start_m), bed_m=-8.0, **changes)


def sample(at_m: list[float], mass_kg: float) -> dict[str, Any]:
    shape = {"kind": "box", "name": "sample", "position_m": at_m, "size_m": [0.06, 0.098, 0.06]}
    return {"shape": shape, "mass_kg": mass_kg, "friction": 0.5}


def touching(body: Any) -> list[tuple[str, str, str]]:
    return [(each.link, each.other, each.other_link) for each in body.contacts]


def test_a_vehicle_lifts_what_it_grasps_and_tilts_under_it_until_it_lets_go() -> None:
    at_m = (0.4, 0.0, -0.1)
    below_m = [at_m[0], at_m[1], at_m[2] - 4.0]
    with Simulator(site(gripper(at_m), [0, 0, -4], objects=[sample(below_m, 0.9)])) as sim:
        sim.rov.set_joints(speeds={"left": 0.05, "right": 0.05})
        sim.advance(8.0)
        block = sim.objects["sample"]
        held = sim.rov.pose.world_from_body[:3, :3].T @ (block.pose.position_world_m - sim.rov.pose.position_world_m)
        touched = touching(sim.rov)
        assert set(touched) == {("left", "sample", ""), ("right", "sample", "")}
        assert set(touching(block)) == {("", "rov", "left"), ("", "rov", "right")}
        state = sim.save_state()
        sim.step()
        sim.restore_state(state)
        assert touching(sim.rov) == touched
        # No glue: friction alone holds it. Between two motors that both give all they have, it may slide sideways.
        assert held == pytest.approx(at_m, abs=0.03)
        assert held[[0, 2]] == pytest.approx([at_m[0], at_m[2]], abs=3e-3)
        assert sim.rov.arm.read().motor_torques == pytest.approx(20.0)
        wet_n = 0.9 * GRAVITY_M_S2 - block.forces["buoyancy"].force_body_n @ block.pose.world_from_body[2, :3]
        bow_down = np.degrees(np.arcsin(-sim.rov.pose.world_from_body[2, 0]))
        assert bow_down > 3.0
        sim.rov.set_joints(speeds={"left": -0.05, "right": -0.05})
        sim.advance(1.0)
        assert block.pose.position_world_m[2] < sim.rov.pose.position_world_m[2] - 0.3  # it falls
        sim.advance(10.0)
        assert abs(np.degrees(np.arcsin(-sim.rov.pose.world_from_body[2, 0]))) < 0.5 * bow_down
        assert wet_n > 2.0


def test_a_friction_that_cannot_be_is_refused() -> None:
    model = gripper((0.4, 0.0, -0.1))
    model["arm"]["left"]["friction"] = -0.1
    with pytest.raises(ScenarioError, match="friction"):
        site(model, [0, 0, -4])


def dry(model: dict[str, Any], start_z_m: float = TABLE_TOP_M + 0.2, **changes: Any) -> Scenario:
    """Return a heavy vehicle over a table above the water."""
    table = {"kind": "box", "name": "table", "position_m": [0, 0, TABLE_TOP_M - 0.25], "size_m": [4, 4, 0.5]}
    heavy = {"mass_kg": 130.0, "inertia_kg_m2": [3, 3, 4]}
    return site(model | heavy, [0, 0, start_z_m], obstacles=[table], **changes)


def standing_z_m() -> float:
    """Return the height at which the vehicle stands on the table."""
    with Simulator(dry(gripper((0.6, 0.0, 0.4)))) as sim:
        sim.advance(2.0)
        return float(sim.rov.pose.position_world_m[2])


def test_a_block_slips_through_dry_fingers_as_in_mujoco() -> None:
    mujoco = pytest.importorskip("mujoco", reason="needs `pip install mujoco`, a judge")
    force_n, at_m, stands_m = 20.0, (0.6, 0.0, 0.4), standing_z_m()
    for share, least_m in ((0.9, None), (1.3, 0.01)):
        mass_kg = share * 2 * 0.5 * force_n / GRAVITY_M_S2
        objects = [sample([at_m[0], 0.0, stands_m + at_m[2]], mass_kg)]
        with Simulator(dry(gripper(at_m, force_n), stands_m, objects=objects)) as sim:
            sim.rov.set_joints(torques={"left": force_n, "right": force_n})
            first = sim.objects["sample"].pose.position_world_m[2]
            sim.advance(0.2)
            fallen_m = first - sim.objects["sample"].pose.position_world_m[2]
        judge = mujoco.MjModel.from_xml_string(
            f"""<mujoco><option timestep="0.0005" gravity="0 0 {-GRAVITY_M_S2}" cone="elliptic" impratio="100"/>
            <default><geom friction="0.5 0 0" condim="3" solref="0.002 1"/></default><worldbody>
            <body pos="0 0.07 0"><joint name="left" type="slide" axis="0 -1 0"/>
            <geom type="box" size="0.03 0.02 0.03" mass="0.1"/></body>
            <body pos="0 -0.07 0"><joint name="right" type="slide" axis="0 1 0"/>
            <geom type="box" size="0.03 0.02 0.03" mass="0.1"/></body>
            <body name="sample"><freejoint/><geom type="box" size="0.03 0.05 0.03" mass="{mass_kg}"/></body>
            </worldbody><actuator><motor joint="left"/><motor joint="right"/></actuator></mujoco>"""
        )
        data = mujoco.MjData(judge)
        data.ctrl[:] = force_n
        for _ in range(400):
            mujoco.mj_step(judge, data)
        theirs_m = -data.body("sample").xpos[2]
        if least_m is None:
            assert fallen_m < 1e-3
            assert theirs_m < 2e-3  # its contacts creep
        else:
            assert fallen_m > least_m
            assert fallen_m == pytest.approx(theirs_m, rel=0.04)


def test_a_chain_falls_on_a_table_as_in_mujoco() -> None:
    mujoco = pytest.importorskip("mujoco", reason="needs `pip install mujoco`, a judge")
    half, mass_kg, damping = 0.15, 0.5, 0.05
    across = mass_kg * (0.04**2 + (2 * half) ** 2) / 12
    arm: dict[str, Any] = {}
    for k in range(3):
        arm[f"l{k}"] = {
            "position_m": [0.6, 0, 0.25] if k == 0 else [2 * half, 0, 0],
            "hinge": {"axis": [0, 1, 0], "viscous_nm_s_rad": damping, "start_deg": -20.0 if k == 0 else 25.0},
            "mass_kg": mass_kg, "centre_of_mass_m": [half, 0, 0],
            "inertia_kg_m2": [mass_kg * 2 * 0.04**2 / 12, across, across],
            "shape": {"kind": "box", "name": f"l{k}", "position_m": [half, 0, 0], "size_m": [2 * half, 0.04, 0.04]},
            "friction": 0.0,
        }  # fmt: skip
        if k > 0:
            arm[f"l{k}"]["on"] = f"l{k - 1}"
    model = {"builds_on": "bluerov2_heavy", "name": "chain", "arm": arm, "restitution": 0.0}
    ours = []
    with Simulator(dry(model, standing_z_m())) as sim:
        base = sim.rov.arm.poses_world()["l0"][:3, 3]
        steps = 60
        for _ in range(steps):
            sim.advance(0.05)
            ours.append(sim.rov.arm.read().positions)
        rest = sim.rov.arm.poses_world()["l0"][:3, 3]
    height_m = rest[2] - TABLE_TOP_M - REST_GAP_M
    bodies = "</body>" * 3
    for k in (2, 1, 0):
        place = f"0 0 {height_m}" if k == 0 else f"{2 * half} 0 0"
        bodies = (
            f'<body pos="{place}"><joint type="hinge" axis="0 1 0" damping="{damping}"/><inertial pos="{half} 0 0" '
            f'mass="{mass_kg}" diaginertia="{mass_kg * 2 * 0.04**2 / 12} {across} {across}"/>'
            f'<geom type="box" pos="{half} 0 0" size="{half} 0.02 0.02"/>{bodies}'
        )
    judge = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="0.0005" gravity="0 0 {-GRAVITY_M_S2}"/>
        <default><geom friction="0 0 0" condim="1" solref="0.004 1" contype="1" conaffinity="2"/></default><worldbody>
        <geom type="plane" size="5 5 1" contype="2" conaffinity="1"/>{bodies}</worldbody></mujoco>"""
    )
    data = mujoco.MjData(judge)
    data.qpos[:] = np.radians([-20.0, 25.0, 25.0])
    theirs = []
    for _ in range(steps):
        for _ in range(100):
            mujoco.mj_step(judge, data)
        theirs.append(data.qpos.copy())
    apart = np.abs(np.array(ours) - np.array(theirs)).max(axis=1)
    assert np.linalg.norm(rest - base) < 2e-3  # the vehicle stands
    assert apart[-1] < 0.01
    assert apart.max() < 0.15
