"""Inverse kinematics: what `reach` returns brings the tool to the point, and what is out of reach is refused."""

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from channel_tools import table
from sites import flat, rov
from uwsim import Simulator
from uwsim.simulator.arm import Arm

JOINTS = ("shoulder", "upperarm", "forearm", "wrist")
LIMITS_RAD = np.radians([[-175, 175], [0, 200], [0, 200], [-165, 165]])


def site(model: Any = "bluerov2_heavy_alpha5", **start: Any) -> Simulator:
    return Simulator(flat(rov(model, start={"position_m": [3, 2, -5], "yaw_deg": 40} | start), bed_m=-15.0))


def arm_of(sim: Simulator) -> Arm:
    assert sim.rov.arm is not None
    return sim.rov.arm


def put(sim: Simulator, positions: dict[str, float]) -> None:
    """Put the arm's joints at positions at once."""
    for name, at in positions.items():
        sim._core.place_joint(0, arm_of(sim).links.index(name), at)


def test_what_it_returns_brings_the_jaw_to_any_point_that_the_joints_can() -> None:
    sim = site()
    rng = np.random.default_rng(3)
    for _ in range(4):
        put(sim, dict(zip(JOINTS, rng.uniform(LIMITS_RAD[:, 0], LIMITS_RAD[:, 1]).tolist(), strict=True)))
        wanted = arm_of(sim).poses_world()["jaw"]
        put(sim, {"shoulder": 0.1, "upperarm": 1.0, "forearm": 1.0, "wrist": 0.0})
        found = arm_of(sim).reach(wanted[:3, 3])
        assert all(low <= found.get(name, 0) <= high for name, (low, high) in zip(JOINTS, LIMITS_RAD, strict=True))
        put(sim, found)
        assert np.linalg.norm(arm_of(sim).poses_world()["jaw"][:3, 3] - wanted[:3, 3]) < 1e-3


def test_a_direction_and_a_tool_are_reached_in_the_vehicles_frame() -> None:
    sim = site()
    put(sim, {"shoulder": 0.4, "upperarm": 1.2, "forearm": 0.7, "wrist": 0.5})
    body_from_link = np.linalg.inv(sim.rov.pose.world_from_body) @ arm_of(sim).poses_world()["jaw"]
    tool, ahead = np.array([0.0, 0.0, -0.04]), np.array([0.0, 0.0, -1.0])
    point, direction = body_from_link[:3, :3] @ tool + body_from_link[:3, 3], body_from_link[:3, :3] @ ahead
    put(sim, {"shoulder": 0.0, "upperarm": 1.0, "forearm": 1.0, "wrist": 0.0})
    put(sim, arm_of(sim).reach(point, 2.0 * direction, axes="body", tool_m=tool, tool_axis=ahead))
    now = np.linalg.inv(sim.rov.pose.world_from_body) @ arm_of(sim).poses_world()["jaw"]
    assert np.linalg.norm(now[:3, :3] @ tool + now[:3, 3] - point) < 1e-3
    assert math.acos(min(float(now[:3, :3] @ ahead @ direction), 1.0)) < math.radians(1.0)


def test_a_boom_on_a_slide_comes_as_near_as_its_stops_allow() -> None:
    mass = {"mass_kg": 1.0, "inertia_kg_m2": [0.01, 0.01, 0.01]}
    slide = {"axis": [1, 0, 0], "limits_m": [0, 0.5], "motor": {"strongest_n": 9, "fastest_m_s": 0.2}}
    model = {"builds_on": "bluerov2_heavy", "arm": {"boom": mass | {"slide": slide, "position_m": [0.2, 0, 0]}}}
    arm = arm_of(site(model))
    assert arm.reach([0.6, 0, 0], axes="body") == {"boom": pytest.approx(0.4, abs=1e-3)}
    with pytest.raises(ValueError, match=r"point_m = \(0.6, 0.3, 0\) m: out of the arm's reach: .* within 0.3 m$"):
        arm.reach([0.6, 0.3, 0], axes="body")
    with pytest.raises(ValueError, match=r"within 0\.1 m"):
        arm.reach([0.8, 0, 0], axes="body")


@pytest.mark.parametrize(
    ("arguments", "rule"),
    [
        ({"point_m": [0.4, 0, np.nan]}, "must be finite"),
        ({"point_m": [0.4, 0]}, r"expected \(3,\)"),
        ({"point_m": [0.4, 0, 0], "link": "claw"}, "must be one of armbase"),
        ({"point_m": [0.4, 0, 0], "axes": "ned"}, "must be world or body"),
        ({"point_m": [0.4, 0, 0], "direction": [0, 0, 0]}, "must be finite and have a direction"),
    ],
)
def test_bad_arguments_are_refused(arguments: dict[str, Any], rule: str) -> None:
    with pytest.raises(ValueError, match=rule):
        arm_of(site()).reach(**arguments)


def test_ikpy_comes_no_nearer_to_what_is_out_of_reach(tmp_path: Path) -> None:
    chains = pytest.importorskip("ikpy.chain", reason="pip install ikpy, which judges what is out of reach")
    sim = site()
    path = tmp_path / "rov.urdf"
    path.write_text(table(sim)["robot_description"].read(sim).data)
    names = ["armbase", *JOINTS, "jaw"]
    elements = ["base_link"]
    for name in names:
        elements += [name if name in JOINTS else f"{name}_arm_link_joint", f"{name}_arm_link"]
    mask = [False, False, True, True, True, True, False]
    chain = chains.Chain.from_urdf_file(str(path), base_elements=elements, active_links_mask=mask)
    for point in ([1.5, 0.0, 0.0], [0.3, -0.9, -0.2], [0.5, 0.2, 0.8]):
        with pytest.raises(ValueError, match="within") as refused:
            arm_of(sim).reach(point, axes="body")
        ours = float(re.findall(r"within ([\d.]+) m", str(refused.value))[0])
        theirs = np.linalg.norm(chain.forward_kinematics(chain.inverse_kinematics(point))[:3, 3] - point)
        assert ours <= theirs + 2e-3
