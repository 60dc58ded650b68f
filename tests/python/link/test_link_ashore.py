"""The map that the station builds from the pings carried by a modem."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from uwsim.channels import Table, channels
from uwsim.channels.channel import Channel
from uwsim.link import Carrier
from uwsim.link.ashore import placed_points
from uwsim.link.packing import PACKINGS, packing_of
from uwsim.live import LiveSimulator
from uwsim.mapping import OccupancyMap
from uwsim.scenario import load
from uwsim.simulator.simulator import Simulator


def lake(modem: str | None, **changes: object) -> Simulator:
    """Return the lake scenario with a link."""
    scenario = load("lake").with_changes(modem=modem)
    if changes:
        scenario = scenario.model_copy(update={"link": scenario.link.model_copy(update=changes)})
    sim = Simulator(scenario, threads=1)
    sim.rov.place((-60.0, -40.0, -12.0))
    sim.rov.sonar.aim(elevation_rad=-0.8)
    return sim


def named(found: list[Channel], name: str) -> Channel:
    return next(channel for channel in found if channel.name == name)


def test_a_placed_ping_gives_the_points_of_the_map_aboard_thinned_and_rounded() -> None:
    sim = lake(None)
    sim.advance(3.0)
    channel = named(channels(sim), "placed_ping")
    message = channel.read(sim)
    whole, origin = placed_points(message)
    ping = sim.rov.sonar.ping()
    assert np.allclose(origin, ping.world_from_sonar[:3, 3], atol=1e-6)
    valid = ping.valid
    assert len(whole) == valid.sum() > 100
    points = ping.points_sonar_m[valid] @ ping.world_from_sonar[:3, :3].T + ping.world_from_sonar[:3, 3]
    assert np.abs(whole - points).max() < 2e-3
    payload = PACKINGS["placed"].pack(message)
    assert len(payload) == 36 + 2 * 65
    thin, _ = placed_points(PACKINGS["placed"].unpack(payload, channel))
    kept = placed_points(_every_eighth(message))[0]
    assert np.abs(thin - kept).max() < 0.012  # half a centimetre of range, plus 3e-5 rad of beam direction at 55 m


def _every_eighth(message: object) -> object:
    message.ranges = message.ranges[::8]
    message.angle_increment *= 8
    return message


@pytest.mark.parametrize("modem", ["s2cm_hs", "tether", "ideal_acoustic"])
def test_the_station_has_a_map_of_what_arrived_and_of_nothing_else(modem: str, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    sim = lake(modem)
    with LiveSimulator(sim, paused=True) as live:
        table = Table(sim)
        placed, services = named(table.channels, "placed_ping"), table.services
        with Carrier(live, table) as carrier:
            changes = named(carrier.channels, "map_changes")
            cells, others = [], []
            for found in (cells, others):
                live.every(0.2, changes.read, lambda message, found=found: found.append(_cells_of(message)))
            live.step(2000 if modem == "s2cm_hs" else 200)
            delay_s = sim.link.reception("rov", "station").delay_s
            live.command("inject_fault", kind="link", name="cut")
            live.step(100)
            seen = sum(cells)
            live.step(300)
            assert sum(cells) == seen > 0, "in a blackout nothing comes"
            arrived = [one for one in sim.link.received("station") if one.topic == "placed_ping"]
            assert sum(count > 0 for count in cells) <= len(arrived)
            answer = next(one for one in services if one.name == "save_map").call(live, {"name": "ashore.bt"})
    assert others == cells, "one reader's look takes nothing from another"
    assert answer == {"success": True, "message": "ashore.bt"}
    assert 2 <= len(arrived) <= 12 if modem == "s2cm_hs" else len(arrived) > 5
    messages = [packing_of(placed, sim.link.modem).unpack(one.payload, placed) for one in arrived]
    if modem != "s2cm_hs":
        assert all(len(message.ranges) == sim.rov.sonar.model.beams for message in messages)
        waited_s = [one.arrived_s - one.given_s for one in arrived]
        if modem == "tether":
            assert min(waited_s) > 1e-3
        else:
            assert waited_s == pytest.approx([delay_s] * len(arrived), rel=0.05)
    expected = OccupancyMap(sim.scenario.survey.voxel_m, on_outside="count")
    for message in messages:
        points, origin = placed_points(message)
        expected.insert_scan(points, origin, sim.rov.sonar.model.range_max_m)
    assert OccupancyMap.read(tmp_path / "ashore.bt").to_bytes("bt") == expected.to_bytes("bt")


def _cells_of(message: Any) -> int:
    return 0 if message is None else len(message.cells)


def test_after_a_blackout_the_map_ashore_grows() -> None:
    sim = lake("s2cm_hs")
    with LiveSimulator(sim, paused=True) as live, Carrier(live, Table(sim)) as carrier:
        changes = named(carrier.channels, "map_changes")
        live.command("inject_fault", kind="link", name="cut")
        live.step(1500)
        assert live.read(changes.read).result() is None
        live.command("end_fault", name="cut")
        live.step(1500)
        assert len(live.read(changes.read).result().cells) > 0


def test_without_pings_over_the_link_there_is_no_map_ashore() -> None:
    sim = lake("micromodem", carries=("telemetry", "key"))
    seen = {channel.name for channel in Carrier(sim, Table(sim)).channels}
    assert not seen & {"map_changes", "octomap_binary", "placed_ping"}
