"""A tether of a loose body: to the bed, to the station, to another body, to one that is fixed or on a path."""

import math

import numpy as np
import pytest

from sites import flat, rov
from uwsim import Simulator
from uwsim.channels.authority.steering import is_cut_off
from uwsim.scenario import Scenario, ScenarioError
from uwsim.scenario.build.multibeam import label_names

GRAVITY_M_S2, WATER_KG_M3, BED_M = 9.80665, 1000.0, -10.0
ROV = rov(position_m=(-6, 0, -4))
BLOCK = {"kind": "box", "name": "block", "position_m": [3, 2, -4], "size_m": [0.5, 0.5, 0.5]}
CABLE = {"anchor": [0, 0, -4], "length_m": 4.0, "elements": 8}
OTHERS = [
    {"shape": BLOCK, "density_kg_m3": 1020.0},
    {"shape": BLOCK | {"name": "post", "position_m": [3, -2, -4]}, "fixed": True},
    {"shape": BLOCK | {"name": "boat", "position_m": [0, 3, -1]}, "path": {"points_m": [[9, 3, -1]], "speed_m_s": 0.5}},
]
ENDS = {
    "point": [0, 0, -4],
    "station": "station",
    "vehicle": {"to": "rov", "at_m": [0.3, 0, 0]},
    "loose body": {"to": "block", "at_m": [0, 0, 0.25]},
    "fixed body": {"to": "post", "at_m": [0, 0.25, 0]},
    "body on a path": {"to": "boat"},
}


def site(tether: dict | None, *others: dict, vehicles: list[dict] | None = None, **buoy: object) -> Scenario:
    """A buoy, a box of 0.4 m and 300 kg/m3, with this tether, beside other bodies."""
    shape = {"kind": "box", "name": "buoy", "position_m": [0, 0, -6], "size_m": [0.4, 0.4, 0.4]}
    own = {"shape": shape, "density_kg_m3": 300.0, **({"tether": tether} if tether else {})} | buoy
    values = {"water": {"density_kg_m3": WATER_KG_M3}, "station": {"position_m": [0, 0, -1]}}
    return flat(*vehicles or [ROV], bed_m=BED_M, objects=[own, *others], **values)


def of(end: str, **more: object) -> Scenario:
    start = {"station": [1, 0, -4], "vehicle": [-4, 1, -5]}.get(end, [1, 1, -3])
    shape = {"kind": "box", "name": "buoy", "position_m": start, "size_m": [0.4, 0.4, 0.4]}
    winch = {"longest_m": 8.0, "fastest_m_s": 0.4}
    return site(CABLE | {"anchor": ENDS[end], "length_m": 6.0, "winch": winch} | more, *OTHERS, shape=shape)


def test_a_buoy_on_a_cable_to_the_bed_rests_at_the_closed_form() -> None:
    """Its net buoyancy pulls at it, and at the anchor what the cable weighs in water is less."""
    line = {"anchor": [0, 0, BED_M], "length_m": 5.0, "elements": 10, "mass_kg_m": 0.4, "diameter_m": 0.012}
    sim = Simulator(site(line | {"breaking_load_n": 1e9}))
    sim.advance(60.0)
    buoy, now = sim.objects["buoy"], sim.tethers["buoy"].read()
    net_n = (WATER_KG_M3 - 300.0) * 0.4**3 * GRAVITY_M_S2
    weight_n = (0.4 - WATER_KG_M3 * math.pi / 4 * 0.012**2) * 5.0 * GRAVITY_M_S2
    half_n = 0.5 * weight_n / 10  # of half of an element, which the node at the end bears
    assert now.vehicle_force_world_n == pytest.approx([0, 0, -net_n], abs=1e-3 * net_n)
    assert now.anchor_force_world_n == pytest.approx([0, 0, net_n - weight_n], abs=1e-3 * net_n)
    assert now.tensions_n[[0, -1]] == pytest.approx([net_n - weight_n + half_n, net_n - half_n], rel=1e-3)
    stretch_m = 5.0 * (net_n - weight_n / 2) / 6.5e4
    assert buoy.pose.position_world_m == pytest.approx([0, 0, BED_M + 5.0 + stretch_m], abs=2e-3)
    force_n = buoy.pose.world_from_body[:3, :3] @ buoy.forces["tether"].force_body_n
    assert force_n == pytest.approx([0, 0, -net_n], abs=1e-2 * net_n)


@pytest.mark.parametrize("step_s", [0.005, 0.02])
def test_a_buoy_that_is_held_off_its_middle_comes_to_rest(step_s: float) -> None:
    """It turns at about 10 rad/s about where it is held, with no damping but quadratic drag: nothing may feed that."""
    held = CABLE | {"anchor": [0, 0, BED_M], "at_m": [0, 0, -0.2], "length_m": 5.0, "breaking_load_n": 1e9}
    sim = Simulator(site(held).with_changes(step_s=step_s))
    sim.advance(30.0)
    fastest_rad_s = 0.0
    for _ in range(200):
        sim.advance(0.1)
        turns_rad_s = sim.objects["buoy"].velocity.angular_body_rad_s[:2]  # about its vertical axis, nothing holds it
        fastest_rad_s = max(fastest_rad_s, np.linalg.norm(turns_rad_s))
    assert fastest_rad_s < 0.02


def test_three_lines_share_the_lift_of_a_buoy() -> None:
    """The bases of the lines stand on the bed in a regular triangle, and each line is as long as the way to it."""
    bases = [
        {
            "shape": {
                "kind": "box", "name": f"base_{k}", "size_m": [0.2, 0.2, 0.2],
                "position_m": [4 * math.cos(2 * math.pi * k / 3), 4 * math.sin(2 * math.pi * k / 3), -9.0],
            },
            "fixed": True,
            "tether": {"anchor": {"to": "buoy"}, "length_m": 5.0, "elements": 6, "axial_stiffness_n": 1e7},
        }
        for k in range(3)
    ]  # fmt: skip
    sim = Simulator(site(None, *bases))
    sim.objects["buoy"].apply_wrench([30.0, 20.0, 0.0], axes="world", duration_s=1.0)
    sim.advance(30.0)
    net_n = (WATER_KG_M3 - 300.0) * 0.4**3 * GRAVITY_M_S2
    pulls_n = [tether.read().anchor_force_world_n for tether in sim.tethers.values()]
    assert sum(pulls_n) == pytest.approx([0, 0, -net_n], abs=2e-3 * net_n)
    assert [pull_n[2] for pull_n in pulls_n] == pytest.approx([-net_n / 3] * 3, rel=0.02)
    assert sim.objects["buoy"].velocity.linear_body_m_s == pytest.approx([0, 0, 0], abs=1e-3)


@pytest.mark.parametrize("stiffness_n", [1e3, 1e6])
def test_two_bodies_that_a_cable_pulls_together_keep_their_momentum(stiffness_n: float) -> None:
    """Weightless and without drag: the sum of momenta, with those of added masses, does not change."""
    thin = {"anchor": {"to": "heavy"}, "length_m": 4.0, "elements": 4, "diameter_m": 1e-4, "mass_kg_m": 1e-4}
    rest = {"normal_drag": 0.0, "tangential_drag": 0.0, "bending_stiffness_n_m2": 0.0, "breaking_load_n": 1e9}
    heavy = {"kind": "box", "name": "heavy", "position_m": [3.8, 0, -6], "size_m": [0.8, 0.8, 0.8]}
    afloat = {"density_kg_m3": WATER_KG_M3, "drag_coefficient": 0.0}
    cable = thin | rest | {"axial_stiffness_n": stiffness_n, "axial_damping_n_s": 0.0}
    alone = Simulator(site(None, {"shape": heavy} | afloat, **afloat))
    for body in alone.objects.values():
        body.apply_wrench([100.0, 0, 0], duration_s=1.0)
    alone.advance(1.0)
    masses_kg = [100.0 / body.velocity.linear_body_m_s[0] for body in alone.objects.values()]
    sim = Simulator(site(cable, {"shape": heavy} | afloat, **afloat, velocity_m_s=[-2.0, 0, 0]))
    start, most_n = -2.0 * masses_kg[0], 0.0
    for _ in range(80):
        sim.step(5)
        speeds = [body.velocity.linear_body_m_s[0] for body in sim.objects.values()]
        assert np.dot(masses_kg, speeds) == pytest.approx(start, rel=1e-5)
        most_n = max(most_n, sim.tethers["buoy"].read().tensions_n.max())
    assert most_n > 100.0 and speeds[0] > -1.0 > 2.0 * speeds[1] - 1.0, "it has pulled them together"


@pytest.mark.parametrize("end", list(ENDS))
def test_it_holds_and_is_wound_and_cut(end: str) -> None:
    sim = Simulator(of(end))
    sim.step(200)
    sim.objects["buoy"].set_winch(rate_m_s=-0.2)
    sim.step(1000)
    now, buoy = sim.objects["buoy"].tether.read(), sim.objects["buoy"].pose
    assert now.length_m == pytest.approx(5.0, abs=0.05)
    assert now.points_world_m[-1] == pytest.approx(buoy.position_world_m, abs=1e-6)
    assert np.linalg.norm(now.points_world_m[-1] - now.points_world_m[0]) <= now.length_m * 1.02
    sim.objects["buoy"].cut_tether(2.0)
    sim.step()
    assert sim.tethers["buoy"].is_broken


def test_a_body_on_a_path_tows_what_hangs_on_it() -> None:
    sim = Simulator(of("body on a path"))
    sim.advance(13.0)
    pulls_n = []
    for _ in range(200):  # it jerks
        sim.advance(0.02)
        boat, now = sim.objects["boat"].pose.position_world_m, sim.tethers["buoy"].read()
        pulls_n.append(now.tensions_n.min())
        assert now.points_world_m[0] == pytest.approx(boat, abs=1e-9)
    assert np.mean(pulls_n) > 1.0
    assert 4.0 < boat[0] - sim.objects["buoy"].pose.position_world_m[0] < 6.1


def test_it_breaks_is_seen_and_cuts_off_what_hangs_on_it() -> None:
    held = ROV | {"tether": CABLE | {"anchor": {"to": "buoy"}, "length_m": 8.0}}
    sim = Simulator(site(CABLE | {"anchor": [0, 0, BED_M], "breaking_load_n": 1200.0}, vehicles=[held]))
    sim.advance(10.0)
    assert not sim.tethers["buoy"].is_broken and not is_cut_off(sim, "rov")
    names = label_names(sim.scenario)
    assert names.count("buoy tether") == names.count("rov tether") == 11
    sim.objects["buoy"].apply_wrench([0, 0, 2000.0], axes="world", duration_s=5.0)
    sim.advance(20.0)
    assert sim.tethers["buoy"].is_broken and is_cut_off(sim, "rov")
    assert sim.objects["buoy"].pose.position_world_m[2] > -1.0, "it floats up"


def test_a_fault_breaks_it_or_lets_it_bear_less() -> None:
    moored = site(CABLE | {"anchor": [0, 0, BED_M], "length_m": 4.5, "breaking_load_n": 1e9})
    for fault, is_broken in (({}, True), ({"breaking_load_n": 400.0}, True), ({"breaking_load_n": 2e4}, False)):
        sim, other = Simulator(moored), Simulator(moored)
        sim.faults.inject("tether", object="buoy", at_s=20.0, for_s=20.0, **fault)
        sim.advance(20.0)
        assert not sim.tethers["buoy"].is_broken
        sim.step()
        other.restore_state(sim.save_state())
        sim.advance(1.0)
        other.advance(1.0)
        assert sim.tethers["buoy"].is_broken is is_broken
        assert other.save_state() == sim.save_state()
    with pytest.raises(ValueError, match="object = 'bouy': must be one with a tether, buoy; did you mean 'buoy'"):
        sim.faults.inject("tether", object="bouy")
    with pytest.raises(ValueError, match="vehicle 'rov' has no tether"):
        sim.faults.inject("tether")


def test_rays_and_foxglove_meet_it() -> None:
    sim = Simulator(site(CABLE | {"diameter_m": 0.2, "anchor": [0, 0, BED_M]}, vehicles=[ROV | {"model": "rov"}]))
    names = label_names(sim.scenario)
    sim.rov.place([-2.0, 0, -8.0])
    assert "buoy tether" in {names[label] for label in np.unique(sim.rov.sonar.ping().labels)}
    pytest.importorskip("foxglove")
    from uwsim.bridges.foxglove.tethers import tethers

    drawn = tethers({"buoy": sim.tethers["buoy"].read()}, sim.scenario, 0)
    assert b"tether of buoy" in drawn.encode()


@pytest.mark.parametrize(
    ("tether", "message"),
    [
        ({"length_m": 2.0}, "tether.* length_m = 2: must be at least the distance of its ends, 4"),
        ({"at_m": [0, 0, -7]}, "must be above the bed"),
        ({"anchor": {"to": "buoy"}}, "tether.anchor.to = 'buoy': must be another vehicle or a loose body: rov, block"),
        ({"anchor": {"to": "rovs"}}, "did you mean 'rov'"),
        ({"winch": {"longest_m": 1.0}}, "tether.winch.longest_m = 1 m: must be at least length_m"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(tether: dict, message: str) -> None:
    with pytest.raises(ScenarioError, match=message) as refusal:
        Simulator(site(CABLE | {"anchor": [0, 0, BED_M]} | tether, *OTHERS))
    assert "objects[0].tether" in str(refusal.value)
    assert "\n" not in str(refusal.value).strip()


def test_commands_of_a_body_without_one_are_refused() -> None:
    buoy = Simulator(site(None)).objects["buoy"]
    for command in (lambda: buoy.set_winch(rate_m_s=0.1), lambda: buoy.cut_tether(1.0)):
        with pytest.raises(ValueError, match="object 'buoy': has no tether"):
            command()
