"""A station that rides on a boat, and the packaged boat that launches, follows and recovers an ROV."""

from collections.abc import Iterator

import numpy as np
import pytest

import uwsim
from uwsim import Simulator
from uwsim.examples import m15_launch_and_recovery as example
from uwsim.missions import OwnVehicle, Steps, race, wait
from uwsim.scenario import Scenario
from uwsim.scenario.read.validated import validated

AT = [-0.5, 0.2, 0.0]
SEA = {
    "name": "pair", "description": "a boat and an ROV", "mission_time_s": 900,
    "terrain": {"source": "noise", "size_m": [400, 400], "spacing_m": 10, "bed_depth_m": 40},
    "station": {"carrier": "boat", "position_m": AT, "dock_m": [0, 0, -3]},
    "link": {"modem": "s2cm_hs", "station_transducer_m": [0, 0, -0.5]},
    "vehicles": [
        {"name": "boat", "model": "otter", "start": {"position_m": [10, 5, 0], "yaw_deg": 30}},
        {"name": "rov", "model": "bluerov2_heavy", "start": {"position_m": [12, 5, -10]}},
    ],
}  # fmt: skip


def sea(**changes: object) -> Simulator:
    return Simulator(validated(Scenario, SEA | changes), seed=1)


def on_boat(sim: Simulator, point_m: list[float]) -> np.ndarray:
    world_from_body = sim.vehicles["boat"].pose.world_from_body
    return world_from_body[:3, :3] @ point_m + world_from_body[:3, 3]


@pytest.fixture(scope="module")
def sim() -> Iterator[Simulator]:
    """The pair after the boat has gone for 40 s."""
    yield gone(sea())


def gone(sim: Simulator) -> Simulator:
    sim.vehicles["boat"].set_thrusters({"port": 0.9, "starboard": 0.8})
    sim.advance(40.0)
    return sim


def test_distances_and_travel_times_are_to_where_the_boat_has_carried_it(sim: Simulator) -> None:
    station, rov = on_boat(sim, AT), sim.vehicles["rov"]
    assert np.linalg.norm(station - [10, 5, 0]) > 15.0
    assert np.allclose(sim.station_world_m, station)
    there = rov.pose.position_world_m
    assert rov.telemetry().distance_to_station_m == pytest.approx(np.linalg.norm(station - there), abs=1e-6)
    head = on_boat(sim, [AT[0], AT[1], AT[2] - 0.5])
    speed = sim.world.water.sound_speed_m_s(0.5 * there[2])
    delay_s = sim.link.reception("rov", "station").delay_s
    assert delay_s * speed == pytest.approx(np.linalg.norm(head - there), rel=2e-3)


def test_a_usbl_measures_from_the_boat(sim: Simulator) -> None:
    rov = sim.vehicles["rov"]
    usbl = next(one for one in rov.sensors.values() if one.kind == "usbl")
    seen, station = usbl.read(noise=False).position_m, usbl.read(noise=False).station_world_m
    turn = rov.pose.world_from_body[:3, :3]
    mounted = rov.pose.position_world_m + turn @ usbl.spec.position_m
    assert np.allclose(seen, mounted - on_boat(sim, AT), atol=1e-3)
    assert np.allclose(station, on_boat(sim, AT), atol=1e-9)


def test_what_is_docked_rides_along_and_leaves_from_where_the_boat_is() -> None:
    docked = [SEA["vehicles"][0], SEA["vehicles"][1] | {"start": "station"}]
    sim = gone(sea(vehicles=docked))
    boat, rov = sim.vehicles["boat"], sim.vehicles["rov"]
    assert np.allclose(rov.pose.position_world_m, on_boat(sim, [AT[0], AT[1], -3.0]), atol=1e-9)
    assert np.allclose(rov.pose.world_from_body[:3, :3], boat.pose.world_from_body[:3, :3], atol=1e-9)
    rov.undock()
    assert np.allclose(rov.pose.position_world_m, on_boat(sim, [AT[0] + 3.0, AT[1], -3.0]), atol=1e-6)


def test_saved_and_restored_it_flies_the_same(sim: Simulator) -> None:
    state = sim.save_state()
    sim.advance(5.0)
    first = sim.station_world_m
    sim.restore_state(state)
    sim.advance(5.0)
    assert np.array_equal(first, sim.station_world_m)


@pytest.mark.parametrize(
    ("changes", "rule"),
    [
        ({"station": {"carrier": "bot"}}, "station.carrier.*must be one of the vehicles, boat, rov.*boat"),
        ({"station": {"carrier": "boat", "mesh": "meshes/boat.glb"}}, "must be the vehicle's, as the station rides on"),
        (
            {"vehicles": [SEA["vehicles"][0] | {"start": "station"}, SEA["vehicles"][1]]},
            "vehicles.*start.*it carries the station; give it a position_m",
        ),
    ],
)
def test_what_cannot_carry_it_is_refused(changes: dict, rule: str) -> None:
    with pytest.raises(ValueError, match=rule):
        sea(**changes)


def test_the_boat_follows_by_what_it_knows_and_winds_the_rov_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(example, "SITE_M", example.SITE_M[:2])  # one side of the site
    sim = Simulator("lake_tender")
    boat, rov = sim.vehicles["boat"], sim.vehicles["rov"]
    assert rov.tether is not None
    away_m, depth_m, pull_n, own_m = [], [], [], []

    def watch(known: OwnVehicle) -> Steps[None]:
        while True:
            there, here, tether = rov.pose.position_world_m, boat.pose.position_world_m, rov.tether.read()
            away_m.append(np.linalg.norm((there - here)[:2]))
            depth_m.append(-there[2])
            pull_n.append(tether.anchor_tension_n)
            own_m.append(np.linalg.norm(known.pose.position_world_m - here))
            yield wait(0.5)

    def watched(vehicles: dict[str, OwnVehicle]) -> Steps[None]:
        yield from race(example.mission(vehicles), watch(vehicles["boat"]))

    flown = uwsim.fly(watched, sim, estimate="filter")
    assert not flown.ended_early
    times_s = {event.name: event.time_s for event in flown.events}
    lowered, back = (int(times_s[name] / 0.5) + 1 for name in ("lowered", "back"))
    assert max(own_m) < 0.1, "by its GNSS"
    assert max(depth_m) > 10.0
    assert max(away_m) < 6.0
    settled = slice(lowered + 10, back - 1)
    assert np.median(pull_n[settled]) == pytest.approx(example.WINCH_N, rel=0.1)
    assert max(pull_n[settled]) < 40.0
    weight_n = float(np.linalg.norm(rov.forces["weight"].force_body_n))
    cable_n = rov.tether.read().length_m * 0.043 * 9.80665
    assert rov.tether.read().length_m == pytest.approx(example.HUNG_M, abs=0.05)
    assert pull_n[-1] == pytest.approx(weight_n + cable_n, rel=0.02), "it hangs in the air"
    assert boat.pose.world_from_body[2, 2] > np.cos(np.radians(15.0))
    assert max(pull_n) < 1.3 * weight_n
