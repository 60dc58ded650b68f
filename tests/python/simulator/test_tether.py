"""A vehicle's tether: it holds, winds, breaks, is read, saved, repeated and batched; what cannot be is refused."""

import numpy as np
import pytest

from channel_tools import table
from sites import flat, rov
from uwsim import Batch, Simulator
from uwsim.channels.authority.steering import is_cut_off
from uwsim.missions import follow_tether, goto, run
from uwsim.scenario import Scenario, ScenarioError
from uwsim.scenario.fingerprint import scenario_fingerprint
from uwsim.scenario.spec.camera import CameraMount
from uwsim.simulator.tether import turns_about
from uwsim.simulator.vehicle import Vehicle

TETHER = {"anchor": [0, 0, -4], "at_m": [-0.2, 0, 0], "length_m": 6.0, "elements": 12}


def site(tether: dict | None = None, **changes: object) -> Scenario:
    held = {} if tether is None else {"tether": TETHER | tether}
    return flat(rov(position_m=(5, 0, -4), **held), **changes)


def test_a_vehicle_goes_no_farther_than_its_tether() -> None:
    sim = Simulator(site({}))
    sim.rov.set_effort(surge=0.4)
    sim.advance(15.0)
    now, rov = sim.rov.tether.read(), sim.rov
    assert now.points_world_m.shape == (13, 3)
    assert now.tensions_n.shape == (12,)
    reach_m = np.linalg.norm(rov.pose.world_from_body[:3, :3] @ [-0.2, 0, 0] + rov.pose.position_world_m - [0, 0, -4])
    assert 5.9 < reach_m < 6.0 * (1 + 1.2 * now.tensions_n.max() / 6.5e4)
    assert now.points_world_m[-1] == pytest.approx(
        rov.pose.position_world_m + rov.pose.world_from_body[:3, :3] @ [-0.2, 0, 0]
    )
    assert now.vehicle_tension_n > 5.0
    pull = rov.forces["tether"]
    assert rov.pose.world_from_body[:3, :3] @ pull.force_body_n == pytest.approx(now.vehicle_force_world_n, rel=1e-3)
    assert pull.torque_body_nm == pytest.approx(np.cross([-0.2, 0, 0], pull.force_body_n), rel=1e-2, abs=1e-3)
    momentum = sum(rov.forces[name].force_body_n for name in rov.forces if name != "total")
    assert rov.forces["total"].force_body_n == pytest.approx(momentum)


def test_a_winch_pays_out_at_its_rate_until_a_reset() -> None:
    sim = Simulator(site({"winch": {"longest_m": 9.0, "fastest_m_s": 0.3}}))
    sim.rov.set_winch(rate_m_s=0.2)
    sim.advance(2.0)
    assert sim.rov.tether.read().length_m == pytest.approx(6.4)
    with pytest.raises(ValueError, match=r"winch = 0.4: must be at most 0.3 m/s"):
        sim.rov.set_winch(rate_m_s=0.4)
    sim.reset()
    assert sim.rov.tether.read().length_m == pytest.approx(6.0)


@pytest.mark.parametrize("stiffness_n", [1e2, 1e6, 7e10])
def test_no_stiffness_makes_it_unstable(stiffness_n: float) -> None:
    """A fast vehicle on a thin, heavy tether of short elements, which it snaps taut again and again."""
    thin = {"length_m": 6.14, "elements": 84, "diameter_m": 0.0054, "mass_kg_m": 0.05, "axial_damping_n_s": 44.0}
    sim = Simulator(site(thin | {"axial_stiffness_n": stiffness_n, "breaking_load_n": 1e9}))
    start_m_s = np.array([-2.88, -2.35, 1.54, -1.68, 1.49, 1.10])
    sim.rov.place([3, 0, -4], velocity_body=start_m_s)
    sim.rov.set_effort(surge=1.0)
    for _ in range(100):
        sim.step(4)
        now = sim.rov.tether.read()
        reach_m = np.linalg.norm(now.points_world_m[-1] - now.points_world_m[0])
        assert np.linalg.norm(sim.rov.velocity.linear_body_m_s) < np.linalg.norm(start_m_s)
        assert reach_m < 6.14 * (1.01 + now.tensions_n.max() / stiffness_n)


def test_a_broken_tether_cuts_the_vehicle_off() -> None:
    sim = Simulator(site({"breaking_load_n": 1.0}))
    assert not is_cut_off(sim, "rov")
    sim.rov.set_effort(surge=0.5)
    sim.advance(10.0)
    assert sim.rov.tether.is_broken
    assert is_cut_off(sim, "rov")
    assert np.linalg.norm(sim.rov.pose.position_world_m - [0, 0, -4]) > 6.5, "nothing holds it any more"


def two(anchor: dict, **tether: float) -> Scenario:
    """The vehicle on another one, a garage that hangs on a tether of its own, or on a crate."""
    own = {"anchor": [0, 0, -1], "length_m": 3.2, "elements": 10} | tether
    garage = rov(position_m=(0, 0, -4), tether=own, name="garage")
    crate = {"kind": "box", "name": "crate", "position_m": [1, 1, -5], "size_m": [0.5, 0.5, 0.5]}
    held = rov(position_m=(3, 0, -4), tether=TETHER | {"anchor": anchor, "length_m": 5.0} | tether)
    return flat(garage, held, objects=[{"shape": crate, "density_kg_m3": 1100}])


@pytest.mark.parametrize("stiffness_n", [6.5e4, 1e10])
def test_one_vehicle_holds_another(stiffness_n: float) -> None:
    """Pulled straight, what pulls at each vehicle is in balance: the tether passes the thrust on."""
    sim = Simulator(two({"to": "garage", "at_m": [0.2, 0, 0]}, axial_stiffness_n=stiffness_n, breaking_load_n=1e9))
    garage, rov = sim.vehicles["garage"], sim.vehicles["rov"]
    rov.place([3, 0, -4], velocity_body=[2, 1, 0.5, 1, -1, 0.5])
    rov.set_effort(surge=1.0)
    sim.advance(30.0)
    inner, outer = rov.tether.read(), garage.tether.read()
    fastened_m = garage.pose.position_world_m + garage.pose.world_from_body[:3, :3] @ [0.2, 0, 0]
    assert inner.points_world_m[0] == pytest.approx(fastened_m)
    assert np.linalg.norm(inner.points_world_m[-1] - fastened_m) == pytest.approx(5.0, rel=0.01)
    assert np.linalg.norm(rov.velocity.linear_body_m_s) < 0.1

    def others_n(vehicle: Vehicle, *names: str) -> np.ndarray:
        return vehicle.pose.world_from_body[:3, :3] @ sum(vehicle.forces[name].force_body_n for name in names)

    still = pytest.approx(np.zeros(3), abs=1.5)
    assert inner.vehicle_tension_n > 50.0
    assert inner.vehicle_force_world_n + others_n(rov, "actuators", "weight", "buoyancy") == still
    assert inner.vehicle_force_world_n + inner.anchor_force_world_n == still
    held_n = inner.anchor_force_world_n + outer.vehicle_force_world_n
    assert held_n + others_n(garage, "weight", "buoyancy") == still


def test_a_loose_body_is_towed_and_what_leads_to_the_vehicle_cuts_it_off() -> None:
    sim = Simulator(two({"to": "crate", "at_m": [0, 0, 0.25]}))
    start_m = sim.objects["crate"].pose.position_world_m
    sim.vehicles["rov"].set_effort(surge=0.8)
    sim.advance(15.0)
    assert sim.objects["crate"].pose.position_world_m[0] > start_m[0] + 1.0
    sim.vehicles["garage"].cut_tether(1.0)
    assert not is_cut_off(sim, "rov"), "its tether does not go through the garage"
    sim = Simulator(two({"to": "garage"}), link="tether")
    sim.vehicles["garage"].cut_tether(1.0)
    sim.advance(0.1)
    sim.link.send("station", "rov", "topic", b"1")
    sim.advance(1.0)
    assert sim.link.received("rov") == []
    sim = Simulator(two({"to": "garage"}))
    sim.vehicles["garage"].cut_tether(1.0)
    assert is_cut_off(sim, "rov")


def test_a_cable_link_is_lost_with_the_tether() -> None:
    sim = Simulator(site({}), link="tether")
    assert sim.link is not None
    sim.link.send("station", "rov", "topic", b"0")
    sim.advance(0.1)
    assert len(sim.link.received("rov")) == 1
    sim.rov.cut_tether(3.0)
    sim.advance(0.1)
    sim.link.send("station", "rov", "topic", b"1")
    sim.advance(1.0)
    assert len(sim.link.received("rov")) == 1


def test_its_topics_exist_only_with_it() -> None:
    sim = Simulator(site({}))
    channels = table(sim)
    assert len(channels["tether/shape"].read(sim).poses) == 13
    assert channels["tether/tension"].read(sim).data[0] == pytest.approx(6.0)
    assert not any("tether" in name for name in table(Simulator(site())))


def test_no_tether_changes_no_fingerprint() -> None:
    assert scenario_fingerprint(site()) == scenario_fingerprint(site().model_copy())
    assert scenario_fingerprint(site()) != scenario_fingerprint(site({}))
    assert "tether" not in Simulator(site()).rov.forces


@pytest.mark.parametrize(
    ("tether", "message"),
    [
        ({"length_m": 4.0}, "length_m = 4: must be at least the distance of its ends, 4.8 m"),
        ({"anchor": {"to": "rov"}}, "anchor.to = 'rov': must be another vehicle or a loose body: there is none"),
        ({"winch": {"longest_m": 5.0}}, r"winch.longest_m = 5.* m: must be at least length_m, 6 m"),
    ],
)
def test_what_cannot_be_is_refused(tether: dict, message: str) -> None:
    with pytest.raises(ScenarioError, match=message) as refusal:
        Simulator(site(tether))
    assert "vehicles[0].tether" in str(refusal.value)
    assert "\n" not in str(refusal.value).strip()


PILE = {"kind": "cylinder", "name": "pile", "position_m": [0, 0, -5], "radius_m": 0.3, "length_m": 12}


def by_a_pile(**tether: object) -> Scenario:
    return site({"anchor": [-4, 0, -4], "length_m": 12.0, "elements": 24} | tether, obstacles=[PILE])


@pytest.mark.parametrize(("laps", "turns"), [(0.0, 0), (0.3, 0), (0.7, 1), (1.2, 1), (-0.7, -1), (2.6, 3)])
def test_turns_are_those_of_the_loop_that_the_straight_way_back_closes(laps: float, turns: int) -> None:
    angles = np.linspace(0.4, 0.4 + 2 * np.pi * laps, 200)
    radius = np.linspace(1.0, 3.0, 200)
    points = np.column_stack([5 + radius * np.cos(angles), -2 + radius * np.sin(angles), np.linspace(-3, -6, 200)])
    assert turns_about(points, (5.0, -2.0)) == turns
    assert turns_about(points, (20.0, 0.0)) == 0


def test_a_pile_holds_it_and_the_way_back_frees_it() -> None:
    sim = Simulator(by_a_pile())
    sim.rov.place([-2, 1, -4])

    def round_the_pile(vehicle):
        for place in ((0, 2, -4), (2, 0, -4), (0.5, -2, -4)):
            yield from goto(vehicle, place, within_m=0.5)

    run(round_the_pile, sim.rov, sim)
    assert sim.rov.tether.read().turns == {"pile": -1}
    sim.rov.set_effort(surge=0.0)

    def home(vehicle):
        yield from follow_tether(vehicle, short_of_m=2.0)

    run(home, sim.rov, sim)
    now = sim.rov.tether.read()
    assert now.turns == {"pile": 0} and not now.is_tangled
    inside_m = np.linalg.norm(now.points_world_m[:, :2], axis=1)
    assert inside_m.min() > 0.28, "no node is in the pile"


def test_what_would_pass_through_an_obstacle_is_refused_and_changes_nothing() -> None:
    wall = {"kind": "box", "name": "wall", "position_m": [1, 0, -5], "size_m": [0.4, 50, 12]}
    with pytest.raises(ScenarioError, match="passes through 'wall' wherever it is laid"):
        Simulator(site({}, obstacles=[wall]))
    sim = Simulator(site({"anchor": [2, 0, -4]}, obstacles=[wall]))
    before = sim.save_state()
    with pytest.raises(ValueError, match="passes through 'wall'"):
        sim.rov.place([-2, 0, -4])
    assert sim.save_state() == before


def test_rays_meet_it() -> None:
    sim = Simulator(site({"anchor": [0, 0, -4], "diameter_m": 0.05}))
    points = sim.rov.tether.read().points_world_m
    at = 0.5 * (points[3] + points[4])
    scene = sim._core.scene_around(0)
    assert sim.label_names.count("rov tether") == 15
    eye = at + np.array([0.0, -2.0, 0.0])
    hits = scene.cast(np.array([eye]), np.array([[0.0, 1.0, 0.0]]), 10.0)
    assert sim.label_names[hits.labels[0]] == "rov tether"
    assert hits.ranges_m[0] == pytest.approx(2.0 - 0.025, abs=0.004)


def test_cameras_see_it() -> None:
    camera = {"position_m": [0.2, 0, 0], "yaw_pitch_roll_deg": [180, 0, 0], "width": 320, "height": 180}
    scenario = site({"diameter_m": 0.05, "at_m": [0.3, 0, 0]})
    rov = scenario.vehicles[0].model_copy(
        update={"model": scenario.vehicles[0].model.model_copy(update={"cameras": {"back": CameraMount(**camera)}})}
    )
    scenario = scenario.model_copy(update={"vehicles": (rov,)})
    sim, batch = Simulator(scenario), Batch(scenario, n=2)
    for each in (sim, batch):
        each.step(20)
    frame = sim.rov.cameras["back"].capture()
    labels = [frame.label_names[label] for label in np.unique(frame.labels)]
    assert "rov tether" in labels
    assert frame.label_names.count("rov tether") == 15
    assert np.array_equal(batch.capture("back")[0], frame.rgb)


def test_a_fault_breaks_it_at_its_time() -> None:
    sim = Simulator(site({}, faults=[{"kind": "tether", "at_m": 2.0, "at_s": 1.0, "for_s": 1.0}]))
    sim.advance(0.99)
    assert not sim.rov.tether.is_broken
    sim.advance(2.0)
    assert sim.rov.tether.read().broken_at_m == pytest.approx(2.0, abs=0.26)
    assert is_cut_off(sim, "rov")
    assert [event.name for event in sim.events] == ["fault", "fault_ends"]


def test_a_damaged_tether_breaks_under_less_load_while_it_is_damaged() -> None:
    def flown(**figures: float) -> Simulator:
        sim = Simulator(site({}))
        sim.faults.inject("tether", breaking_load_n=5.0, **figures)
        sim.advance(2.0)
        assert not sim.rov.tether.is_broken, "slack as yet"
        sim.rov.set_effort(surge=0.5)
        return sim

    repaired = flown(for_s=2.0)
    repaired.advance(10.0)
    assert not repaired.rov.tether.is_broken
    damaged = flown()
    state = damaged.save_state()
    damaged.advance(10.0)
    assert damaged.rov.tether.is_broken
    restored = Simulator(site({}))
    restored.restore_state(state)
    restored.advance(10.0)
    assert restored.save_state() == damaged.save_state()
    damaged.reset()
    damaged.rov.set_effort(surge=0.5)
    damaged.advance(10.0)
    assert not damaged.rov.tether.is_broken


@pytest.mark.parametrize(
    ("fault", "tether", "message"),
    [
        ({}, None, "faults[0]: kind = 'tether': vehicle 'rov' has no tether"),
        ({"at_m": 1.0, "breaking_load_n": 5.0}, {}, "faults[0].at_m"),
        ({"breaking_load_n": 0.0}, {}, "faults[0].breaking_load_n"),
    ],
)
def test_a_fault_of_what_cannot_break_is_refused(fault: dict, tether: dict | None, message: str) -> None:
    with pytest.raises(ScenarioError) as refusal:
        Simulator(site(tether, faults=[{"kind": "tether", "at_s": 1.0} | fault]))
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value).strip()


def test_foxglove_draws_it_by_tension() -> None:
    pytest.importorskip("foxglove")
    from uwsim.bridges.foxglove.tethers import STOPS, tension_colours, tethers

    assert tension_colours([0.0, 1.0, 1e9], 1557.0) == pytest.approx(STOPS[[0, 0, 2]])
    sim = Simulator(site({}))
    whole = len(tethers({"rov": sim.rov.tether.read()}, sim.scenario, 0).encode())
    sim.rov.cut_tether(3.0)
    assert len(tethers({"rov": sim.rov.tether.read()}, sim.scenario, 0).encode()) < whole
