"""A tether between any two of station, point, vehicle and loose body, with and without a winch."""

import math

import numpy as np
import pytest

from sites import flat, rov
from uwsim import Simulator
from uwsim.scenario import Scenario, ScenarioError

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
    crate = {"kind": "box", "name": "crate", "position_m": [0.5, 1.5, -3], "size_m": [0.5, 0.5, 0.5]}
    vehicles = rov(position_m=(4, 0, -4), tether=cable), rov(position_m=(0, 0, -3), name="boat", **boat or {})
    return flat(*vehicles, station=station, objects=[{"shape": crate, "density_kg_m3": 1020}])


@pytest.mark.parametrize("end", list(ENDS))
def test_it_holds_and_its_winch_pays_out(end: str) -> None:
    sim = Simulator(site(end, winch=True), seed=3)
    rov, boat, crate = *sim.vehicles.values(), sim.objects["crate"]
    rov.set_effort(surge=0.6, sway=0.1)
    for seconds, length_m in ((4.0, 6.0), (8.0, 9.0)):
        sim.advance(seconds)
        now = rov.tether.read()
        assert np.linalg.norm(now.points_world_m[-1] - now.points_world_m[0]) <= now.length_m * 1.01
        assert now.length_m == pytest.approx(length_m, abs=0.01)
        rov.set_winch(rate_m_s=0.4)
    held, from_m, least_m = (crate, [0.5, 1.5, -3], 0.5) if end == "loose body" else (boat, [0, 0, -3], 0.3)
    if end in ("loose body", "vehicle", "a station that a vehicle carries"):
        assert np.linalg.norm(held.pose.position_world_m - from_m) > least_m, "it is towed"


@pytest.mark.parametrize("end", ["point", "a station that a vehicle carries"])
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
