"""A tether between any two of station, point, vehicle and loose body, with and without a winch."""

import math

import numpy as np
import pytest

from uwsim import Batch, Simulator
from uwsim.live import LiveSimulator, replay
from uwsim.scenario import Scenario, ScenarioError
from uwsim.scenario.read.validated import validated

BED_M = -10.0
STATION = {"position_m": [0.0, 0.0, -3.0]}
CARRIED = {"carrier": "boat", "position_m": [0.0, 0.0, -0.3]}
# Where the first end is at the start, within a metre, and the scenario's station.
ENDS = {
    "station": ("station", STATION),
    "a station that a vehicle carries": ("station", CARRIED),
    "point": ([0.0, 0.5, -3.0], STATION),
    "vehicle": ({"to": "boat", "at_m": [0.2, 0.0, -0.1]}, STATION),
    "loose body": ({"to": "crate", "at_m": [0.0, 0.0, 0.25]}, STATION),
}


def site(end: str, *, winch: bool = False, boat: dict | None = None, **tether: object) -> Scenario:
    anchor, station = ENDS[end]
    cable = {"anchor": anchor, "at_m": [-0.2, 0, 0.1], "length_m": 6.0, "elements": 12} | tether
    if winch:
        cable["winch"] = {"longest_m": 9.0, "fastest_m_s": 0.4}
    rov = {"name": "rov", "model": "bluerov2_heavy", "start": {"position_m": [4, 0, -4]}, "tether": cable}
    carrier = {"name": "boat", "model": "bluerov2_heavy", "start": {"position_m": [0, 0, -3]}} | (boat or {})
    crate = {"kind": "box", "name": "crate", "position_m": [0.5, 1.5, -3], "size_m": [0.5, 0.5, 0.5]}
    terrain = {"source": "noise", "size_m": [60, 60], "spacing_m": 1, "bed_depth_m": -BED_M, "hill_height_m": 0}
    values = {"name": "ends", "terrain": terrain, "station": station, "vehicles": [rov, carrier]}
    return validated(Scenario, values | {"objects": [{"shape": crate, "density_kg_m3": 1020}]})


def fly(sim: Simulator, winch: bool) -> None:
    sim.vehicles["rov"].set_effort(surge=0.6, sway=0.1)
    if winch:
        sim.vehicles["rov"].set_winch(rate_m_s=0.3)


@pytest.mark.parametrize("winch", [False, True])
@pytest.mark.parametrize("end", list(ENDS))
def test_it_holds_is_saved_and_batched(end: str, winch: bool) -> None:
    scenario = site(end, winch=winch)
    first, second = Simulator(scenario, seed=3), Simulator(scenario, seed=3)
    fly(first, winch)
    first.step(400)
    middle = first.save_state()
    first.step(1600)
    now = first.vehicles["rov"].tether.read()
    assert np.linalg.norm(now.points_world_m[-1] - now.points_world_m[0]) <= now.length_m * 1.01
    assert now.length_m == pytest.approx(9.0 if winch else 6.0)
    held = {"vehicle": first.vehicles["boat"], "a station that a vehicle carries": first.vehicles["boat"]}.get(end)
    if end == "loose body":
        assert np.linalg.norm(first.objects["crate"].pose.position_world_m - [0.5, 1.5, -3]) > 0.5, "it is towed"
    elif held is not None:
        assert np.linalg.norm(held.pose.position_world_m - [0, 0, -3]) > 0.3, "it is towed"
    second.restore_state(middle)
    second.step(1600)
    assert second.save_state() == first.save_state()
    batch, alone = Batch(scenario, n=2, seeds=[3, 4]), Simulator(scenario, seed=4)
    assert batch.save_state(1) == alone.save_state()
    batch.step(200)
    alone.step(200)
    assert batch.save_state(1) == alone.save_state()


@pytest.mark.parametrize("end", list(ENDS))
def test_it_is_replayed(end: str) -> None:
    scenario = site(end, winch=True)
    with LiveSimulator(Simulator(scenario), paused=True, speed="max") as live:
        live.vehicles["rov"].set_effort(surge=0.5)
        live.vehicles["rov"].set_winch(tension_n=4.0)
        live.step(300)
        live.vehicles["rov"].cut_tether(2.0)
        live.step(100)
        state, tick = live.simulator.save_state(), live.tick
    assert replay(Simulator(scenario), live.log, tick).save_state() == state


@pytest.mark.parametrize("end", list(ENDS))
@pytest.mark.parametrize(
    ("tether", "message"),
    [
        ({"length_m": 2.0}, r"length_m = 2: must be at least the distance of its ends, \d.*m"),
        ({"mass_kg_m": 0.0}, r"tether.mass_kg_m = 0.*: must be"),
        ({"diameter_m": 0.0}, r"tether.diameter_m = 0.*: must be"),
        ({"length_m": math.nan}, r"tether.length_m = nan.*: must be"),
        ({"at_m": [0, 0, -7]}, "must be above the bed"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(end: str, tether: dict, message: str) -> None:
    with pytest.raises(ScenarioError, match=message) as refusal:
        Simulator(site(end, **tether))
    assert "vehicles[0].tether" in str(refusal.value)
    assert "\n" not in str(refusal.value).strip()


@pytest.mark.parametrize(
    ("anchor", "message"),
    [
        ([0.0, 0.0, -11.0], "must be above the bed"),
        ({"to": "boat", "at_m": [0, 0, -8]}, "must be above the bed"),
        ({"to": "crate", "at_m": [0, 0, -8]}, "must be above the bed"),
        ({"to": "rov"}, "must be another vehicle or a loose body: boat, crate"),
        ({"to": "boats"}, "must be another vehicle or a loose body: boat, crate; did you mean 'boat'"),
        ("crate", "anchor"),
    ],
)
def test_an_anchor_that_cannot_be_is_refused_in_one_line(anchor: object, message: str) -> None:
    with pytest.raises(ScenarioError, match=message) as refusal:
        Simulator(site("point", anchor=anchor))
    assert "vehicles[0].tether" in str(refusal.value)
    assert "\n" not in str(refusal.value).strip()


def test_a_vehicle_that_carries_the_station_is_not_tethered_to_itself() -> None:
    own = {"anchor": "station", "length_m": 5.0}
    with pytest.raises(ScenarioError, match="it carries the station; give a point") as refusal:
        site("a station that a vehicle carries", boat={"tether": own})
    assert "vehicles[1].tether.anchor" in str(refusal.value)
    assert "\n" not in str(refusal.value).strip()
