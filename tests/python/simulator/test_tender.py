"""The packaged boat launches an ROV, follows it by its USBL and recovers it."""

import numpy as np
import pytest

import uwsim
from uwsim import Simulator
from uwsim.examples import m15_launch_and_recovery as example
from uwsim.missions import OwnVehicle, Steps, race, wait


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
