"""The navigation suite: errors of the estimate by place, compared with the filter's covariance and the way travelled.

Each flight is that of the next packaged vehicle, with random efforts; the measure is the NEES of consistency.py. Where
filterpy is installed, robot_localization's filter receives the samples of one flight in each place; see
peers/navigation.py.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from importlib.util import find_spec
from itertools import cycle

import numpy as np
from scipy.stats import chi2

from uwsim.base.arrays import Floats
from uwsim.base.axes import AXES
from uwsim.evidence.validate.check import Check, Curve, at_most
from uwsim.evidence.validate.navigator.consistency import (
    ERRORS,
    LARGEST_EFFORTS,
    LEG_S,
    PARTS,
    errors,
    nees_of,
    start_navigation,
)
from uwsim.evidence.validate.navigator.places import PLACES, STILL, WITH_DVL, Place
from uwsim.navigation.estimation import Navigator
from uwsim.navigation.estimation.budget import NOISE
from uwsim.simulator.onboard_navigation import ALIGNMENT_STD_M, ALIGNMENT_STD_M_S
from uwsim.simulator.simulator import Simulator

BeginPeer = Callable[[Simulator, Navigator], Callable[[], Floats]]
FLIGHTS = 26  # in each place: two of every vehicle with a gauge
LEGS, LEGS_PER_LOOK = 30, 3
MOST_M_S, MOST_HEIGHT_M = 0.1, 0.35
"""The largest errors of 95 % of the looks, where the DVL works: a flight starts with ALIGNMENT_STD_M on each axis."""
MOST_BY_WAVES_M = 0.05
"""How much larger the errors of position may be in waves than in still water, where the same seeds fly."""
MOST_REJECTED = 0.01
FALSE_ALARM = 1e-3
SHOWN = 6  # sources that are drawn


@dataclass(frozen=True)
class Look:
    """The state of a flight.

    error (9,), nees: of all errors and of each of PARTS. way_m: travelled. fixes: USBL scalars, used and rejected.
    level_variance_m2: of the horizontal position. peer_m (3,): error of another filter's position. budget_m:
    standard deviation of the position by source.
    """

    error: Floats
    nees: tuple[float, ...]
    way_m: float
    fixes: tuple[int, int]
    level_variance_m2: float
    budget_m: dict[str, float]
    peer_m: Floats | None = None


def run(flights: int = FLIGHTS) -> list[Check]:
    """Return the checks of the suite, with the position's budget by place. flights: in each place."""
    flown = {name: fly_in(place, flights) for name, place in PLACES.items()}
    found = [check for name, looks in flown.items() for check in checks(name, PLACES[name], looks)]
    found[0] = replace(found[0], curve=budgets({name: budget_of(looks) for name, looks in flown.items()}))
    still, text = _distances(flown[STILL]), "95 % of errors of position, beyond still water's,"
    for name, looks in flown.items():
        if PLACES[name].surface["kind"] != "still":
            found.append(at_most(_group(name, looks), text, MOST_BY_WAVES_M, float(_distances(looks) - still), "m"))
    if find_spec("filterpy") is not None:
        from uwsim.evidence.validate.peers.navigation import Beside

        found += beside(Beside)
    return found


def beside(begin_peer: BeginPeer) -> list[Check]:
    """Return checks of rms horizontal errors against that of another filter on the same samples, one flight a place.

    The error of a flight is one draw: in each place, the navigator's may be twice the other's; in all, no larger.
    """
    found, squares, peer = [], [], "that of robot_localization's filter,"
    for name, place in PLACES.items():
        looks = list(fly(Simulator(place.scenario(place.vehicles[0])), place, 0, begin_peer))
        pairs = [(look.error[:2], look.peer_m[:2]) for look in looks if look.peer_m is not None]
        squares.append(np.mean(np.square(pairs).sum(axis=2), axis=0))
        ours_m, theirs_m = np.sqrt(squares[-1]).tolist()
        text = f"rms horizontal error, at twice {peer}"
        found.append(at_most(f"a flight in {name}", text, 2.0 * theirs_m, ours_m, "m"))
    ours_m, theirs_m = np.sqrt(np.mean(squares, axis=0)).tolist()
    return [*found, at_most("all places", f"rms horizontal error, at {peer}", theirs_m, ours_m, "m")]


def fly_in(place: Place, flights: int) -> list[list[Look]]:
    """Fly in a place with seeds from 0, in turn with each of its vehicles."""
    sims = place.simulators()
    return [list(fly(sim, place, seed)) for sim, seed in zip(cycle(sims), range(flights), strict=False)]


def fly(sim: Simulator, place: Place, seed: int, begin_peer: BeginPeer | None = None) -> Iterator[Look]:
    """Fly with random efforts, and look at intervals. begin_peer: starts another filter beside the navigator."""
    navigator, draws = start_navigation(
        sim, seed, place.start_world_m, position_std_m=ALIGNMENT_STD_M, velocity_std_m_s=ALIGNMENT_STD_M_S
    )
    peer = None if begin_peer is None else begin_peer(sim, navigator)
    driven = np.array([axis in sim.rov.controllable for axis in AXES])
    way_m, before = 0.0, sim.rov.pose.position_world_m
    for leg in range(LEGS):
        if leg == LEGS // 2:
            sim.parameters.update({f"rov.sensors.{name}.on": False for name in place.lost if name in sim.rov.sensors})
        sim.rov.set_effort(*(LARGEST_EFFORTS * draws.uniform(-1.0, 1.0, 6) * driven))
        sim.advance(LEG_S)
        way_m += float(np.linalg.norm((after := sim.rov.pose.position_world_m) - before))
        before = after
        peer_m = None if peer is None else peer()
        if leg % LEGS_PER_LOOK == LEGS_PER_LOOK - 1:
            error, covariance = errors(sim, navigator), navigator.covariance
            nees = tuple(nees_of(error, covariance, part) for part in (slice(0, ERRORS), *PARTS.values()))
            budget_m = {name: float(np.linalg.norm(std_m)) for name, std_m in navigator.budget.items()}
            fixes = navigator.counts.get("usbl", (0, 0))
            yield Look(error, nees, way_m, fixes, float(np.trace(covariance[:2, :2])), budget_m, peer_m)


def checks(name: str, place: Place, flown: list[list[Look]]) -> list[Check]:
    """Return the checks of the flights in a place."""
    group, found = _group(name, flown), []
    nees = np.array([[look.nees for look in flight] for flight in flown])
    error = np.array([[look.error for look in flight] for flight in flown])
    for k, (part, size) in enumerate({"all 9 errors": ERRORS, **dict.fromkeys(PARTS, 3)}.items()):
        most = float(chi2.ppf(0.975, len(flown) * size) / len(flown))
        found.append(at_most(group, f"mean NEES of {part}", most, float(nees[:, :, k].mean())))
    for vehicle, first in zip(place.vehicles, range(len(flown)), strict=False):
        mine = nees[first :: len(place.vehicles), :, 1]
        most = float(chi2.ppf(1.0 - FALSE_ALARM, 3 * len(mine)) / len(mine))
        found.append(at_most(group, f"mean NEES of position of {vehicle}", most, float(mine.mean())))
    steady = [k for k in range(len(flown)) if place.vehicles[k % len(place.vehicles)] in WITH_DVL]
    if not place.lost:
        speeds = np.linalg.norm(error[steady][:, :, PARTS["velocity"]], axis=2)
        found.append(at_most(group, "95 % of errors of velocity", MOST_M_S, float(np.quantile(speeds, 0.95)), "m/s"))
    height_m = float(np.quantile(np.abs(error[:, :, 2]), 0.95))
    found.append(at_most(group, "95 % of errors of height", MOST_HEIGHT_M, height_m, "m"))
    ends = [flown[k][-1] for k in steady]
    way_m = float(np.mean([look.way_m for look in ends]))
    off_m = float(np.sqrt(np.mean([look.error[:2] @ look.error[:2] for look in ends])))
    expected_m = float(np.sqrt(np.mean([look.level_variance_m2 for look in ends])))
    most = float(np.sqrt(chi2.ppf(0.975, 2 * len(ends)) / (2 * len(ends))))
    name = f"rms horizontal error after {way_m:.0f} m, as the filter expects,"
    found.append(at_most(group, name, most * expected_m, off_m, "m"))
    found.append(
        at_most(group, "the same, of the way travelled,", 100.0 * most * expected_m / way_m, 100.0 * off_m / way_m, "%")
    )
    used, rejected = np.sum([flight[-1].fixes for flight in flown], axis=0)
    rate = float(rejected / max(used + rejected, 1))
    found.append(at_most(group, f"share of {used + rejected} USBL scalars that the gates reject", MOST_REJECTED, rate))
    return found


def budget_of(flown: list[list[Look]]) -> dict[str, float]:
    """Return the rms standard deviation of the position at the ends of flights with a DVL [m], by source."""
    ends = [flight[-1].budget_m for flight in flown if any(name.startswith("dvl.") for name in flight[-1].budget_m)]
    names = dict.fromkeys(name for end in ends for name in end)
    return {name: float(np.sqrt(np.mean([end.get(name, 0.0) ** 2 for end in ends]))) for name in names}


def budgets(by_place: dict[str, dict[str, float]]) -> Curve:
    """Return which metre comes from what, by place: the whole standard deviation, and its greatest sources."""
    whole = np.array([np.hypot.reduce(list(parts.values())) for parts in by_place.values()])
    names = dict.fromkeys(name for parts in by_place.values() for name in parts)
    of = {name: np.array([parts.get(name, 0.0) for parts in by_place.values()]) for name in names}
    ranked = sorted(names, key=lambda name: -float(((of[name] / whole) ** 2).sum()))
    shown = [name for name in ranked if name != NOISE][:SHOWN]
    lines = {"all terms": whole, **{name: of[name] for name in (*shown, NOISE)}}
    return Curve(np.array(list(by_place)), lines, "", "m", "which metre of the position comes from what, by place")


def _distances(flown: list[list[Look]]) -> float:
    return float(np.quantile([np.linalg.norm(look.error[:3]) for flight in flown for look in flight], 0.95))


def _group(name: str, flown: list[list[Look]]) -> str:
    return f"{len(flown)} flights in {name}"
