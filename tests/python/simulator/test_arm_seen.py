"""An arm is perceived: rays, cameras, sonars, range sensors and shadows meet its links where they are now."""

from typing import Any

import numpy as np
import pytest

from channel_tools import table
from sites import flat, rov
from uwsim import Batch, Simulator
from uwsim.scenario import Scenario, ScenarioError
from uwsim.simulator.moving_shapes import moving_shapes, shape_poses

BOX = {"kind": "box", "name": "boom", "position_m": [0.5, 0, 0], "size_m": [1.0, 0.2, 0.1]}
CAMERA = {"position_m": [0, 0, 0.5], "yaw_pitch_roll_deg": [0, 30, 0], "width": 64, "height": 48}


def boom(shape: Any, **more: Any) -> dict[str, Any]:
    """Return a vehicle with a boom ahead of its bow, which tilts about y."""
    hinge = {"axis": [0, 1, 0], "motor": {"strongest_nm": 20, "fastest_deg_s": 60}}
    link = {"mass_kg": 1.0, "inertia_kg_m2": [0.1, 0.1, 0.1], "position_m": [0.4, 0, 0], "hinge": hinge}
    return {"builds_on": "bluerov2_heavy", "arm": {"boom": link | {"shape": shape}}} | more


def site(model: Any, *others: Any, **changes: Any) -> Scenario:
    return flat(rov(model), *others, bed_m=-15.0, **changes)


def down(sim: Simulator, x_m: float) -> tuple[float, str]:
    """Return the range and the label of a ray down from 2 m above the vehicle, which carries the instrument."""
    hit = sim._core.scene_around(0).cast(np.array([[x_m, 0.0, -3.0]]), np.array([[0.0, 0.0, -1.0]]), 50.0)
    return float(hit.ranges_m[0]), sim.label_names[hit.labels[0]]


def test_rays_meet_a_link_where_its_joint_has_brought_it() -> None:
    with Simulator(site(boom(BOX))) as sim:
        assert down(sim, 1.0)[1] == "rov boom"
        assert down(sim, 1.0)[0] == pytest.approx(1.95)  # its own vehicle's arm, 0.05 m above its axis
        angle = np.radians(30.0)  # about y: the boom points down
        sim._core.place_joint(0, 0, angle)
        sim.advance(sim.step_s)
        base = sim.rov.pose
        now = float(sim.rov.arm.read().positions[0])  # type: ignore[union-attr]
        pitch = np.arcsin(-base.world_from_body[2, 0]) + now
        origin = base.world_from_body[:3, 3] + base.world_from_body[:3, :3] @ [0.4, 0, 0]
        top = origin[2] - (1.0 - origin[0]) * np.tan(pitch) + 0.05 / np.cos(pitch)
        assert down(sim, 1.0)[1] == "rov boom"
        assert down(sim, 1.0)[0] == pytest.approx(-3.0 - top, abs=2e-3)
        assert down(sim, -2.0)[1] == "terrain"


def test_a_fish_keeps_its_label_and_cameras_agree_with_rays() -> None:
    life = [{"kind": "school", "name": "herring", "count": 5, "position_m": [9, 9, -8], "size_m": [0.2, 0.3]}]
    with Simulator(site(boom(BOX, cameras={"front": CAMERA}), life=life)) as sim:
        assert sim.label_names[-2:] == ["herring", "rov boom"]
        assert down(sim, 1.0)[1] == "rov boom"
        frame = sim.rov.cameras["front"].capture(geometry_only=True)
        assert frame.label_names == tuple(sim.label_names)
        seen = {frame.label_names[k] for k in np.unique(frame.labels)}
        assert "rov boom" in seen and "rov" not in seen


def test_sonars_and_range_sensors_perceive_it() -> None:
    above = {"position_m": [0.9, 0, 1.0]}
    sensors = {"below": {"kind": "proximity", "range_max_m": 9, "yaw_pitch_roll_deg": [0, 90, 0]} | above}
    sensors["dvl"] = {"kind": "dvl", "position_m": [0.9, 0, 1.0]}
    sonars = {"ahead": {"kind": "forward_looking", "position_m": [-0.6, 0, 0.5], "yaw_pitch_roll_deg": [0, 20, 0]}}
    plate = BOX | {"size_m": [1.0, 1.6, 0.1]}
    with Simulator(site(boom(plate, sensors=sensors, imaging_sonars=sonars))) as sim:
        assert sim.rov.sensors["below"].read(noise=False) == pytest.approx(0.95)
        slant = sim.rov.sensors["dvl"].read(noise=False).beam_ranges_m
        assert slant == pytest.approx(0.95 / np.cos(np.radians(30.0)))  # of all four beams; the bed is 11 m away
        image = sim.rov.imaging_sonars["ahead"].ping(with_labels=True)
        assert sim.label_names.index("rov boom") in np.unique(image.labels)


def test_a_batch_takes_the_same_pictures() -> None:
    scenario = site(boom(BOX, cameras={"front": CAMERA}))
    batch = Batch(scenario, n=2)
    with Simulator(scenario) as sim:
        batch.step(100)
        sim.step(100)
        assert (batch.capture("front")[0] == sim.rov.cameras["front"].capture().rgb).all()


def test_viewers_draw_it_and_rviz_finds_its_shape() -> None:
    other = {"name": "other", "model": "bluerov2_heavy_alpha5", "start": {"position_m": [5, 0, -5]}}
    with Simulator(site(boom(BOX), other)) as sim:
        shapes, poses = moving_shapes(sim.scenario), shape_poses(sim)
        assert [one.name for one in shapes][:2] == ["rov boom", "other armbase"]
        links = sim.vehicles["other"].arm.poses_world()  # type: ignore[union-attr]
        assert poses[1:, :3] == pytest.approx(np.array([pose[:3, 3] for pose in links.values()]))
        text = table(sim)["rov/robot_description"].read(sim).data
        robot = pytest.importorskip("urdf_parser_py.urdf").URDF.from_xml_string(text.encode())
        link = robot.link_map["rov/boom_arm_link"]
        assert (link.visual.geometry.size, link.visual.origin.xyz) == ([1.0, 0.2, 0.1], [0.5, 0.0, 0.0])
        assert link.collision.geometry.size == [1.0, 0.2, 0.1]


def test_two_links_with_shapes_of_one_name_are_refused() -> None:
    vehicle = boom(BOX)
    vehicle["arm"]["tip"] = vehicle["arm"]["boom"]
    with pytest.raises(ScenarioError, match=r"arm.boom.shape.name = 'boom': must be unique"):
        site(vehicle)


@pytest.mark.parametrize(
    ("shape", "rule"),
    [
        ({"kind": "gate"}, r"arm.boom.shape.*"),
        (BOX | {"on_bed": True}, "placed in the link's frame"),
        (BOX | {"size_m": [1, 1, 0]}, r"arm.boom.shape.*size_m"),
    ],
)
def test_a_shape_that_a_link_cannot_have_is_refused(shape: Any, rule: str) -> None:
    with pytest.raises(ScenarioError, match=rule):
        site(boom(shape))
