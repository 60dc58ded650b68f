"""A link trial: a vehicle moves away from the station and back while its modem sends as much as possible."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.scenario import Scenario
from uwsim.scenario.build.link import link_spec, station_transducer
from uwsim.scenario.spec.link import LinkFault
from uwsim.simulator.link_traffic import LinkRow, link_rows
from uwsim.simulator.network import STATION, Network
from uwsim.simulator.simulator import Simulator

TOPIC = "trial"
BEARINGS = 36
STRIDE_M = 4.0
FARTHEST_M = 20_000.0
MARGIN_M = 2.0  # minimum height of a place above the bed
PACKETS_A_PLACE = 20
MESSAGE_BYTES_MAX = 64

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Leg:
    """The result at one place: its range from the station's transducer, and the number of messages that arrived.

    delay_s: travel time of the sound, NaN if there is no path. uneven: whether reflections other than those of a flat
    bottom contribute (Reception.bed_is_uneven). waited_s: mean time from `send` to arrival. goodput_bit_s: rate at
    which payloads arrived.
    """

    time_s: float
    range_m: float
    delay_s: float
    snr_db: float
    sent: int
    delivered: int
    waited_s: float
    goodput_bit_s: float
    uneven: bool


@dataclass(frozen=True)
class Curve:
    """The theoretical share of packets that arrive, and their delay, by range in water without a bed."""

    range_m: Floats
    delivery: Floats
    delay_s: Floats


@dataclass(frozen=True)
class Trial:
    """The results of a link trial.

    message_bytes: size of each message. table: all traffic, including a USBL's pings.
    """

    scenario: Scenario
    modem: str
    message_bytes: int
    legs: list[Leg]
    open_water: Curve
    faults: tuple[LinkFault, ...]
    table: list[LinkRow]


def run_trial(
    scenario: str | Path | Scenario, modem: str | None, *, seed: int | None = None, depth_m: float = 10.0
) -> Trial:
    """Move the vehicle out and back along the longest clear path at a depth, and send messages at each place.

    Raises ValueError if there is no link or no clear path.
    """
    sim = Simulator(scenario, link=modem, seed=seed)
    network, rov = sim.link, sim.rov
    if network is None or sim.scenario.link is None:
        raise ValueError("link: the scenario has none, or it is of kind 'none': choose one with --modem")
    size = min(MESSAGE_BYTES_MAX, network.modem.packet_bytes)
    out = _places(sim, depth_m)
    legs = []
    for place in [*out, *reversed(out)]:
        rov.place(place)
        legs.append(_leg(sim, network, rov.name, size))
    curve = _open_water(sim, size, depth_m)
    return Trial(sim.scenario, network.modem.name, size, legs, curve, sim.scenario.link.faults, link_rows(sim))


def _places(sim: Simulator, depth_m: float) -> list[Floats]:
    """Return places along the bearing on which a vehicle can move farthest at this depth."""
    start = np.asarray(sim.scenario.station.position_m, np.float64)
    best: list[Floats] = []
    for bearing in np.linspace(0.0, 2.0 * np.pi, BEARINGS, endpoint=False):
        along = np.array([np.cos(bearing), np.sin(bearing), 0.0])
        places: list[Floats] = []
        for far_m in np.arange(STRIDE_M, FARTHEST_M, STRIDE_M):
            place = start + far_m * along
            place[2] = -depth_m
            if not _is_clear(sim, place):
                break
            places.append(place)
        if len(places) > len(best):
            best = places
    if not best:
        raise ValueError(f"link: no clear water around the station at {depth_m:g} m: choose another --depth")
    return best


def _is_clear(sim: Simulator, place: Floats) -> bool:
    """Return whether the bed is known at a place and lies at least MARGIN_M below it."""
    (height_m,) = sim.world.height_at(place[None, :2])
    return bool(np.isfinite(height_m) and height_m < place[2] - MARGIN_M)


def _leg(sim: Simulator, network: Network, vehicle: str, size: int) -> Leg:
    """Send PACKETS_A_PLACE messages from the current place, and wait until all have arrived or are lost."""
    began_s, modem = sim.time_s, network.modem
    station = station_transducer(sim.scenario.link, sim.scenario.station, sim.world)  # type: ignore[arg-type]
    place = sim.rov.pose.position_world_m.copy()
    heard = network.reception(vehicle, STATION)
    before = _counts(network)
    for _ in range(PACKETS_A_PLACE):
        network.send(vehicle, STATION, TOPIC, bytes(size))
    turn_s = len(network.nodes) * (modem.slot_s + modem.guard_s)
    longest_s = PACKETS_A_PLACE * max(modem.packet_s(size) + modem.backoff_s, turn_s) + 2.0 * turn_s + 60.0
    done_s = sim.time_s
    while sim.time_s - began_s < longest_s:
        sim.step(max(1, round(0.05 / sim.step_s)))
        rest = _counts(network)
        done_s = sim.time_s
        if rest.sent + rest.refused - before.sent - before.refused >= PACKETS_A_PLACE and _settled(rest):
            break
    after = _counts(network)
    got = network.received(STATION, began_s)
    delivered = after.delivered - before.delivered
    return Leg(
        time_s=began_s,
        range_m=float(np.linalg.norm(place - station)),
        delay_s=heard.delay_s if heard.reached else np.nan,
        snr_db=heard.snr_db if heard.reached else np.nan,
        sent=after.sent - before.sent,
        delivered=delivered,
        waited_s=float(np.mean([one.arrived_s - one.given_s for one in got])) if got else np.nan,
        goodput_bit_s=8.0 * size * delivered / (done_s - began_s),
        uneven=heard.bed_is_uneven,
    )


class _Sums:
    """Message counts of a trial."""

    def __init__(self, network: Network) -> None:
        found = [one for one in network.counts() if one.topic == TOPIC]
        self.sent = sum(one.sent for one in found)
        self.refused = sum(one.refused for one in found)
        self.delivered = sum(one.delivered for one in found)
        self.lost = sum(sum(one.lost.values()) for one in found)


def _counts(network: Network) -> _Sums:
    return _Sums(network)


def _settled(counts: _Sums) -> bool:
    """Return whether no messages are in transit."""
    return counts.sent == counts.delivered + counts.lost


def _open_water(sim: Simulator, size: int, depth_m: float) -> Curve:
    """Return the share delivered and the delay by range, up to FARTHEST_M, in water without a bed."""
    setup = sim.scenario.link
    assert setup is not None
    spec = link_spec(setup, sim.scenario.station, sim.world)
    assert spec is not None
    water, nothing = _core.LinkWater(spec, sim.world.water), _core.RayScene(_core.World())
    ranges_m = np.geomspace(5.0, FARTHEST_M, 160)
    start = np.array([0.0, 0.0, spec.station_transducer_world_m[2]])
    heard = [water.receive(nothing, start, (far_m, 0.0, -depth_m)) for far_m in ranges_m]
    is_modem = setup.modem.kind == "modem"
    delivery = [1.0 - one.packet_loss(spec.modem, size) if is_modem else 1.0 for one in heard]
    delays_s = [one.delay_s if one.reached else np.nan for one in heard]
    return Curve(ranges_m, np.array(delivery), np.array(delays_s))


def summary(trial: Trial) -> str:
    """Return a one-line summary of a trial's results."""
    sent, delivered = sum(leg.sent for leg in trial.legs), sum(leg.delivered for leg in trial.legs)
    farthest_m = max(leg.range_m for leg in trial.legs)
    heard = trial.open_water.delivery >= 0.5
    uneven = sum(leg.uneven for leg in trial.legs)
    bed = f"; at {uneven} of {len(trial.legs)} places the bed is too uneven for reflections of a flat one"
    reach = f"{trial.open_water.range_m[heard].max():,.0f} m" if heard.any() else "nowhere"
    return (
        f"{trial.modem} in {trial.scenario.name}: {delivered} of {sent} messages of {trial.message_bytes} bytes "
        f"delivered within {farthest_m:,.0f} m; without a bed half of them would reach {reach}{bed if uneven else ''}"
    )
