"""A USBL that shares its vehicle's modem: pings and fixes are packets with air time, turnaround and losses."""

from __future__ import annotations

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.scenario import load
from uwsim.scenario.spec.link import LinkFault, LinkSetup
from uwsim.simulator.link_traffic import link_rows

TOPIC = "ranging/usbl"


def lake(
    modem: str = "s2cm_hs", *, shares: bool = True, usbl: dict[str, object] | None = None, **link: object
) -> Simulator:
    """Return the lake scenario with a link and an error-free USBL."""
    scenario = load("lake")
    entry = scenario.vehicles[0]
    changes = {"drop_out": 0.0, "channels": {}, "position_m": (0.0, 0.0, 0.0), **(usbl or {})}
    mount = entry.model.sensors["usbl"].model_copy(update={**changes, "parameters": {"shares_modem": (float(shares),)}})
    model = entry.model.model_copy(update={"sensors": {**entry.model.sensors, "usbl": mount}})
    return Simulator(
        scenario.model_copy(update={"vehicles": (entry.model_copy(update={"model": model}),),
                                    "link": LinkSetup(modem=modem, **link)}),
        threads=1,
    )  # fmt: skip


def counts(sim: Simulator, sender: str):
    return next(one for one in sim.link.counts() if (one.topic, one.sender) == (TOPIC, sender))


def test_a_fix_is_where_the_ping_left_and_comes_with_the_answer() -> None:
    sim = lake()
    sim.rov.place((-60.0, -40.0, -12.0))
    sim.rov.set_effort(surge=0.6)
    usbl, track, arrivals = sim.rov.sensors["usbl"], {}, []
    for _ in range(4000):
        track[sim.time_ns] = np.array(sim.rov.pose.position_world_m)
        before = usbl.sample()
        sim.step()
        sample = usbl.sample()
        if sample.valid and sample.stamp_s != before.stamp_s:
            arrivals.append((sim.time_s, sample))
    fixes = [one for one in sim.link.received("rov") if one.topic == TOPIC]
    assert len(arrivals) == len(fixes) == counts(sim, "station").delivered > 5
    station = np.asarray(sim.scenario.station.position_m)
    for (now_s, sample), fix in zip(arrivals, fixes, strict=True):
        assert fix.arrived_s <= now_s < fix.arrived_s + sim.step_s + 1e-9
        assert np.allclose(sample.value.position_m + station, track[round(1e9 * sample.stamp_s)], atol=1e-6)
    pings = [one for one in sim.link.received("station") if one.topic == TOPIC]
    heard = sim.link.reception("rov", "station").delay_s
    packet_s = sim.link.modem.packet_s(len(pings[-1].payload))
    assert pings[-1].arrived_s - arrivals[-1][1].stamp_s == pytest.approx(heard + packet_s, abs=2 * sim.step_s)


def test_one_ping_is_under_way_at_a_time_and_takes_its_turn() -> None:
    sim = lake("micromodem")
    sim.advance(120.0)
    modem = sim.link.modem
    round_s = 2 * (modem.slot_s + modem.guard_s)
    pings = counts(sim, "rov").sent
    assert 0.8 * 120.0 / round_s < pings <= 1 + 120.0 / round_s
    assert sim.link.sending_s == pytest.approx(
        pings * modem.packet_s(2) + counts(sim, "station").sent * modem.packet_s(14)
    )


def test_pings_take_the_air_from_messages_and_collide_with_them() -> None:
    def lost(shares: bool) -> int:
        sim = lake("s2cm_hs", shares=shares, access="aloha", usbl={"rate_hz": 10.0})
        for _ in range(100):
            sim.link.send("station", "rov", "talk", bytes(500))
            sim.advance(0.2)
        return sum(sum(one.lost.values()) for one in sim.link.counts())

    assert lost(False) == 0
    assert lost(True) > 5


def test_in_a_blackout_there_is_no_fix_and_the_last_becomes_invalid() -> None:
    sim = lake("s2cm_hs", faults=(LinkFault(from_s=10.0, until_s=30.0),))
    sim.rov.place((-60.0, -40.0, -12.0))
    usbl = sim.rov.sensors["usbl"]
    sim.advance(9.9)
    assert usbl.sample().valid
    sim.advance(19.0)
    old = usbl.sample()
    assert not old.valid
    assert old.stamp_s < 10.0
    assert sum(counts(sim, "rov").lost.values()) > 2
    sim.advance(8.0)
    assert usbl.sample().valid
    assert usbl.sample().stamp_s > 30.0


def test_whoever_watches_gets_each_fix_once_and_a_restored_state_goes_on_alike() -> None:
    sim = lake(usbl={"latency_s": 0.1})
    sim.rov.place((-60.0, -40.0, -12.0))
    stream = sim.rov.sensors["usbl"].stream()
    sim.advance(3.3)
    state = sim.save_state()
    sim.advance(10.2)
    samples = stream.take()
    assert len(set(samples.stamps_ns)) == len(samples) == counts(sim, "station").delivered > 5
    assert (samples.arrivals_ns > samples.stamps_ns).all()
    fixes = [one.arrived_s for one in sim.link.received("rov") if one.topic == TOPIC]
    assert 1e-9 * samples.arrivals_ns - fixes == pytest.approx(0.1, abs=sim.step_s)
    end = sim.save_state()
    sim.restore_state(state)
    sim.advance(10.2)
    assert sim.save_state() == end


def test_with_a_band_of_its_own_or_a_cable_nothing_is_on_the_air() -> None:
    for sim in (lake(shares=False), lake("tether"), lake("ideal_acoustic")):
        sim.rov.place((-60.0, -40.0, -12.0))
        sim.advance(3.0)
        assert link_rows(sim) == []
        assert sim.rov.sensors["usbl"].sample().valid


def test_a_ping_ends_nobody_s_silence() -> None:
    sim = lake()
    sim.advance(5.0)
    assert counts(sim, "station").delivered > 0
    assert sim.link.silence_s("rov") == pytest.approx(5.0)


def test_whether_it_shares_the_modem_can_be_changed_while_it_runs() -> None:
    sim = lake()
    sim.advance(4.0)
    assert counts(sim, "rov").sent > 0
    sim.parameters["rov.sensors.usbl.shares_modem"] = False
    sim.advance(2.0)
    sent = counts(sim, "rov").sent
    sim.advance(5.0)
    assert counts(sim, "rov").sent == sent
    assert sim.rov.sensors["usbl"].sample().valid
