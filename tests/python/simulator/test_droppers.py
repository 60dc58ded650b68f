"""Droppers and launchers: what they hold weighs on the vehicle, and momentum and energy are kept when they let go."""

import math
from concurrent.futures import Future
from typing import Any

import numpy as np
import pytest

import uwsim
from uwsim import _core
from uwsim.channels.table import Table
from uwsim.exercises.goals.passing import Pass
from uwsim.exercises.moment import Moment
from uwsim.live import LiveSimulator
from uwsim.scenario import ScenarioError, load


def marker(name: str, density: float = 2700.0, radius_m: float = 0.04) -> dict[str, Any]:
    shape = {"kind": "sphere", "name": name, "position_m": (0, 20, -5), "radius_m": radius_m}
    return {"shape": shape, "density_kg_m3": density, "drag_coefficient": 0.47}


def site(droppers: dict[str, Any], *objects: dict[str, Any], **more: Any) -> dict[str, Any]:
    start = {"position_m": [0, 0, -4], "yaw_deg": 30}
    return {
        "name": "site",
        "water": {"surface_temperature_deg_c": 15, "bottom_temperature_deg_c": 15},
        "terrain": {"source": "noise", "size_m": [60, 60], "bed_depth_m": 10, "hill_height_m": 0},
        "vehicles": [{"name": "rov", "model": "bluerov2_heavy", "start": start, "droppers": droppers}],
        "objects": list(objects),
        **more,
    }


LEFT = {"position_m": [0.1, 0.3, -0.25], "yaw_pitch_roll_deg": [0, 90, 0], "holds": ["one", "two"]}
TUBE = {"position_m": [0.4, -0.2, -0.25], "holds": ["one"], "spring_j": 5.0}


def test_a_dropper_lets_go_in_order_and_is_filled_again() -> None:
    with uwsim.Simulator(site({"left": LEFT}, marker("one"), marker("two"))) as sim:
        left = sim.rov.droppers["left"]
        sim.advance(1.0)
        assert left.loaded == ("one", "two") and sim.objects["one"].carried
        place = sim.rov.pose.world_from_body @ [0.1, 0.3, -0.25, 1.0]
        np.testing.assert_allclose(sim.objects["two"].pose.position_world_m, place[:3], atol=1e-9)
        assert left.release() == "one" and left.loaded == ("two",)
        sim.advance(1.0)
        fallen_m = place[2] - sim.objects["one"].pose.position_world_m[2]
        assert fallen_m > 0.5 and not sim.objects["one"].carried
        assert left.release() == "two"
        with pytest.raises(ValueError, match=r"vehicle 'rov' dropper 'left': is empty; reload\(\) fills it"):
            left.release()
        left.reload()
        assert left.loaded == ("one", "two")
        sim.rov.all_stop()
        with pytest.raises(ValueError, match="release: all stop is set"):
            left.release()


def test_what_it_holds_weighs_on_the_vehicle_and_moves_with_it() -> None:
    body = marker("one", density=2000.0, radius_m=(3e-3 / 4 / math.pi) ** (1 / 3))  # a litre
    with uwsim.Simulator(site({"it": {"position_m": [0, 0, -0.3], "holds": ["one"]}}, body)) as sim:
        water = sim.world.water.density_at_kg_m3(-4.0)
        sim.step()
        sinks_m_s2 = -sim.rov.velocity.linear_body_m_s[2] / sim.step_s
        weight_n, moved_kg = (2.0 - 1e-3 * water) * 9.80665, 2.0 + 0.5e-3 * water
        assert 0.1 < sinks_m_s2 < 1.0
        assert sim.rov.forces["arm"].force_body_n[2] == pytest.approx(moved_kg * sinks_m_s2 - weight_n, rel=0.02)
        sim.rov.droppers["it"].release()
        sim.step()
        assert np.abs(sim.rov.forces["arm"].force_body_n).max() < 1e-9


def test_release_keeps_momentum_and_the_spring_gives_its_energy() -> None:
    with uwsim.Simulator(site({"tube": TUBE}, marker("one", radius_m=0.06))) as sim:
        sim.rov.set_effort(surge=0.6, yaw=0.3, heave=0.1)
        sim.advance(2.0)
        before = motion(sim)
        np.testing.assert_allclose(before[1], before[0][:3] + np.cross(before[0][3:], TUBE["position_m"]), atol=1e-12)
        sim.rov.droppers["tube"].release()
        lost, gained = (late - early for late, early in zip(motion(sim), before, strict=True))
        mass = mass_of(sim)
    place, along = np.array(TUBE["position_m"]), np.array([1.0, 0.0, 0.0])
    impulse = -(mass @ lost)[0]
    # All six: the spring's impulse acts along x, through the ball, and the ball with its water has it, too.
    np.testing.assert_allclose(mass @ lost, -impulse * np.concatenate([along, np.cross(place, along)]), atol=1e-9)
    assert impulse / gained[0] == pytest.approx((2700 + 0.5 * 1000) * 4 / 3 * math.pi * 0.06**3, rel=0.03)
    apart_m_s = gained[0] - (lost[:3] + np.cross(lost[3:], place))[0]
    assert 0.5 * impulse * apart_m_s == pytest.approx(5.0, rel=1e-9)


def test_a_dropped_body_leaves_the_vehicle_s_motion_as_it_is() -> None:
    with uwsim.Simulator(site({"left": LEFT}, marker("one"), marker("two"))) as sim:
        sim.rov.set_effort(surge=0.6, yaw=0.3)
        sim.advance(1.0)
        before = motion(sim)
        sim.rov.droppers["left"].release()
        after = motion(sim)
    assert np.array_equal(before[0], after[0])
    np.testing.assert_allclose(before[1], after[1], atol=1e-12)


def test_a_jet_drives_a_torpedo_and_goals_see_it_pass_only_when_it_is_free() -> None:
    tube = {**TUBE, "spring_j": 0.0, "jet_n": 8.0, "jet_s": 1.0}
    with uwsim.Simulator(site({"tube": tube}, marker("one", density=1050.0))) as sim:
        x, y, z = (sim.rov.pose.world_from_body @ [1.4, -0.2, -0.25, 1.0])[:3].tolist()
        goal = {"kind": "pass", "name": "hit", "title": "Hit", "position_m": (x, y, z), "heading_deg": 30}
        hit = Pass.model_validate({**goal, "within_m": 0.2, "object": "one"})
        hit.require(sim)
        progress = hit.progress(hit)
        for step in range(30):
            progress.judge(Moment.of(sim, sim.rov, sim.time_s), 0.1)
            if step == 10:
                sim.rov.droppers["tube"].release()
            sim.advance(0.1)
        assert progress.is_met
        with pytest.raises(ValueError, match="object = 'two': must be one of one"):
            Pass.model_validate({**goal, "object": "two"}).require(sim)


def test_a_torpedo_flies_straight_by_its_fins_and_without_them_turns_broadside() -> None:
    def turned_rad(share: float) -> float:
        rod = {"kind": "cylinder", "name": "one", "position_m": [0, 20, -5], "yaw_pitch_roll_deg": [10, 90, 0],
               "radius_m": 0.02, "length_m": 0.2}  # fmt: skip
        along = [3.0 * math.cos(math.radians(12)), 3.0 * math.sin(math.radians(12)), 0.0]  # 2 degrees off its axis
        body = {"shape": rod, "density_kg_m3": 1010, "munk_share": share, "velocity_m_s": along}
        sim = uwsim.Simulator(site({}, body))
        before = sim.objects["one"].pose.world_from_body[:3, 2]
        sim.advance(1.0)
        return float(np.arccos(abs(before @ sim.objects["one"].pose.world_from_body[:3, 2])))

    assert turned_rad(0.0) < 0.01 and turned_rad(1.0) > 0.5


def test_a_rebuilt_vehicle_and_a_member_of_a_batch_are_without_what_they_released() -> None:
    scenario = site({"left": LEFT}, *map(marker, ("one", "two")))
    sim = uwsim.Simulator(scenario)
    sim.rov.droppers["left"].release()
    sim.parameters["rov.friction"] = 0.3
    assert sim.rov.droppers["left"].loaded == ("two",)
    batch = uwsim.Batch(scenario, n=2)
    batch.step(200)
    batch.drop("left", mask=[False, True])
    batch.step(200)
    aboard = [batch.aboard(k) for k in range(2)]
    assert [each.rov.droppers["left"].loaded for each in aboard] == [("one", "two"), ("two",)]
    assert aboard[0].objects["one"].pose.position_world_m[2] > aboard[1].objects["one"].pose.position_world_m[2] + 0.3


def test_ros_lets_go_by_service_and_by_topic() -> None:
    sim = uwsim.Simulator(site({"left": LEFT}, marker("one"), marker("two")))
    with LiveSimulator(sim, paused=True) as live:
        table = Table(sim)
        services = {one.name: one for one in table.services}
        topics = {one.name: one for one in table.channels}
        done = services["left/release"].call(live, {})
        assert (done.result() if isinstance(done, Future) else done)["success"]
        topics["left/drop"].apply(live, None)
        live.step(1)
        assert topics["left/loaded"].read(sim).data == 0
        refused = services["left/release"].call(live, {})
        answer = refused.result() if isinstance(refused, Future) else refused
        assert not answer["success"] and "is empty" in answer["message"]


@pytest.mark.parametrize(
    ("droppers", "message"),
    [
        ({"it": {"position_m": [0, 0, 0], "holds": ["on"]}}, r"holds\[0\].*must be an object.*did you mean 'one'"),
        ({"a": LEFT, "b": TUBE}, r"droppers.b.holds\[0\].*is already in a dropper"),
        ({"it": {**TUBE, "jet_n": 5.0}}, "jet_s.*give both jet_n and jet_s"),
    ],
)
def test_mistakes_are_one_line(droppers: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        load(site(droppers, marker("one"), marker("two")))


def motion(sim: uwsim.Simulator) -> tuple[Any, Any]:
    """Return the vehicle's velocity (6,), and that of the body `one` along the vehicle's axes, (3,)."""
    velocity, body = sim.rov.velocity, sim.objects["one"]
    turn = sim.rov.pose.world_from_body[:3, :3].T @ body.pose.world_from_body[:3, :3]
    own = np.concatenate([velocity.linear_body_m_s, velocity.angular_body_rad_s])
    return own, turn @ body.velocity.linear_body_m_s


def mass_of(sim: uwsim.Simulator) -> Any:
    """Return the vehicle's mass with its water, (6, 6), from its kinetic energy."""

    def energy(velocity: Any) -> float:
        craft: _core.Craft = sim.rov._craft
        return craft.kinetic_energy_j(_core.BodyState((0, 0, -4), (0, 0, 0, 1), velocity))

    axes = np.eye(6)
    return np.array([[energy(a + b) - energy(a) - energy(b) for b in axes] for a in axes])
