"""The link's packets in a scenario: travel times, terrain, faults, replay."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from uwsim import Simulator, _core
from uwsim.channels import Table
from uwsim.instruments.acoustics import arrivals
from uwsim.link import seen_channels
from uwsim.recording.recorder import Recorder
from uwsim.recording.replay import replay
from uwsim.scenario import Scenario, ScenarioError, load
from uwsim.scenario.build.station import modem_spec, station_transducer
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.link import BOTTOMS, LinkSetup, ModemModel, load_modem
from uwsim.scenario.spec.settings import Station

MODEMS = ("none", "tether", "ideal_acoustic", "micromodem", "s2cm_hs")


def lake(modem: str, **changes: object) -> Simulator:
    """Return the pair scenario's basin with a link."""
    scenario = load("pair").with_changes(modem=modem)
    if changes:
        scenario = scenario.model_copy(update={"link": scenario.link.model_copy(update=changes)})
    return Simulator(scenario, threads=1)


def test_every_packaged_modem_loads_and_none_is_no_link() -> None:
    for name in MODEMS:
        assert load_modem(name).name == name
    assert lake("none").link is None


def test_the_ideal_link_is_late_by_distance_over_sound_speed() -> None:
    sim = lake("ideal_acoustic")
    sim.link.send("station", "scout", "t", b"hello")
    sim.advance(0.1)
    (got,) = sim.link.received("scout")
    station = [*sim.scenario.station.position_m[:2], -3.0]
    distance_m = np.linalg.norm(np.subtract([0.0, 0.0, -5.0], station))
    speed = sim.world.water.sound_speed_m_s(-4.0)
    assert got.payload == b"hello"
    assert got.arrived_s - got.given_s == pytest.approx(distance_m / speed, rel=1e-3)


def test_a_modem_s_message_takes_its_path_and_its_bits() -> None:
    sim = lake("micromodem")
    heard = sim.link.reception("station", "scout")
    modem = sim.link.modem
    sim.link.send("station", "scout", "t", b"12345")
    sim.advance(5.0)
    (got,) = sim.link.received("scout")
    assert got.arrived_s - got.given_s == pytest.approx(heard.delay_s + modem.packet_s(5), abs=1e-6)
    assert sim.link.silence_s("scout") == pytest.approx(5.0 - got.arrived_s)
    assert sim.link.silence_s("rov") == pytest.approx(5.0)


def test_terrain_hides_one_end_from_the_other() -> None:
    sim = Simulator("lake", link="s2cm_hs", threads=1)
    behind = None
    for x in np.arange(-60.0, 120.0, 10.0):
        for y in np.arange(-100.0, 100.0, 10.0):
            try:
                sim.rov.place((x, y, -30.0))
            except ValueError:
                continue
            if not sim.link.reception("station", "rov").reached:
                behind = (x, y)
    assert behind is not None, "no place at 30 m depth is in the shadow of a hill"


def test_a_packet_is_received_by_all_arrivals_however_often_they_bounce_and_turn() -> None:
    """Over 1889 m in 100 m of water that bends sound up, all paths turn, and bounce off the surface if at all."""
    water, world = _core.Water(), _core.World()
    water.profile = _core.WaterProfile([0.0, 100.0], [8.0, 8.0], [0.0, 0.0], [1000.0, 1000.0], [1480.0, 1530.0])
    water.bottom_depth_m = 100.0
    world.set_terrain(np.full((2, 2), -100.0, np.float32), 6000.0, (-3000.0, -3000.0))
    spec = _core.LinkSpec()
    spec.modem = modem_spec(load_modem("micromodem"))
    spec.set_bottom(*BOTTOMS["silt"])
    heard = _core.LinkWater(spec, water).receive(_core.RayScene(world), (0.0, 0.0, -46.9), (1889.0, 0.0, -11.3))
    alpha = _core.absorption_db_km(spec.modem.frequency_hz, 8.0, 0.0, 50.0)
    found = arrivals(
        [(0, 1480), (100, 1530)], 46.9, 11.3, 1889.0, "silt",
        frequency_hz=spec.modem.frequency_hz, absorption_db_km=alpha, within_db=20,
    )  # fmt: skip
    assert found.turns.max() >= 1 and len(found) > 5
    assert heard.delay_s == pytest.approx(found.time_s.min(), rel=1e-4)
    assert heard.spread_s == pytest.approx(np.ptp(found.time_s), abs=1e-3)
    level_db = spec.modem.source_level_db + 10.0 * np.log10(np.sum(10.0 ** (0.1 * found.level_db)))
    assert heard.signal_db == pytest.approx(level_db, abs=1.0), "rays that turn focus, so the cell's middle differs"


@pytest.mark.parametrize(("top_m", "bounces"), [(-10.5, 0), (-9.5, 1), (0.5, None)])
def test_a_ridge_blocks_the_rays_below_its_top(top_m: float, bounces: int | None) -> None:
    """Between ends at 10 m, a ridge leaves the straight ray, then the one by the surface; an island leaves none."""
    spec, water, world = _core.LinkSpec(), _core.Water(), _core.World()
    water.profile = _core.WaterProfile([0.0, 40.0], [8.0, 8.0], [0.0, 0.0], [1000.0, 1000.0], [1480.0, 1480.0])
    water.bottom_depth_m = 40.0
    spec.modem = modem_spec(load_modem("micromodem"))
    spec.set_bottom(1.0, 1.0, 0.5)  # water: nothing is reflected
    heights = np.full((401, 401), -40.0, np.float32)
    heights[:, 195:206] = top_m
    world.set_terrain(heights, 1.0, (-200.0, -200.0))
    heard = _core.LinkWater(spec, water).receive(_core.RayScene(world), (-100.0, -20.0, -10.0), (100.0, 40.0, -10.0))
    assert heard.reached == (bounces is not None)
    if bounces is not None:
        assert heard.delay_s == pytest.approx(np.hypot(np.hypot(200.0, 60.0), 20.0 * bounces) / 1480.0, rel=1e-4)


def test_a_blackout_loses_everything_and_restoring_the_state_gives_the_same() -> None:
    fault = {"from_s": 1.0, "until_s": 2.0}
    scenario = load("pair")
    link = LinkSetup(modem="s2cm_hs", access="aloha", faults=[fault])
    sim = Simulator(scenario.model_copy(update={"link": link}), threads=1)

    def talk(seconds: int) -> list[object]:
        for k in range(10 * seconds):
            sim.link.send("rov", "station", "t", bytes([k % 256]) * 40)
            sim.advance(0.1)
        return [sim.link.received("station"), sim.link.counts()]

    talk(1)
    state = sim.save_state()
    first = talk(2)
    sim.restore_state(state)
    assert talk(2) == first
    (counts,) = [one for one in sim.link.counts() if one.topic == "t"]
    assert counts.lost["fault"] > 2
    assert not [got for got in first[0] if 1.05 < got.arrived_s < 2.0]
    assert [got for got in first[0] if got.arrived_s > 2.0]
    assert counts.delivered + sum(counts.lost.values()) == counts.sent


def test_a_burst_takes_its_share_and_the_status_says_so_while_it_lasts() -> None:
    burst = {"from_s": 1.0, "until_s": 51.0, "loss": 0.5}
    link = LinkSetup(modem="s2cm_hs", access="aloha", faults=[burst])
    sim = Simulator(load("lake").model_copy(update={"link": link}), threads=1)
    (status,) = [one for one in seen_channels(sim, Table(sim)) if one.name == "link"]
    told = []
    for k in range(110):
        sim.link.send("station", "rov", "t", bytes([k]) * 8)
        sim.advance(0.5)
        told.append((sim.time_s, status.read(sim).fault_loss))
    assert all(loss == (0.5 if 1.0 <= time_s < 51.0 else 0.0) for time_s, loss in told)
    (counts,) = [one for one in sim.link.counts() if one.topic == "t"]
    assert abs(counts.lost["fault"] - 50) < 4 * 5, "of a binomial, n = 100 and p = 0.5, sigma is 5"


def acknowledging(**changes: object) -> Simulator:
    """Return the pair's basin, in which packets get lost and messages are acknowledged."""
    setup = {"modem": "s2cm_hs", "access": "aloha", "retransmissions": 4}
    setup["faults"] = [{"from_s": 0.0, "until_s": 1e6, "loss": 0.3}]
    return Simulator(load("pair").model_copy(update={"link": LinkSetup(**setup | changes)}), threads=1)


def test_acknowledged_messages_arrive_and_a_restored_state_repeats_them() -> None:
    sim = acknowledging()

    def talk() -> list[object]:
        for k in range(10):
            sim.link.send("scout", "station", "up", bytes([k]) * 40)
            sim.link.send("station", "scout", "down", bytes([k]) * 40)
            sim.advance(3.0)
        sim.advance(20.0)
        return [sim.link.received("station"), sim.link.received("scout"), sim.link.counts()]

    sim.link.send("scout", "station", "up", bytes(40))
    sim.advance(0.2)  # a message is held until it is acknowledged
    state = sim.save_state()
    first = talk()
    sim.restore_state(state)
    assert talk() == first
    assert {one.sender for one in first[0] if one.topic == "up"} == {"scout"}
    up, down = [next(one for one in sim.link.counts() if one.topic == topic) for topic in ("up", "down")]
    assert up.sender == "scout" and down.sender == "station"
    for counts in (up, down):
        assert counts.delivered >= 10
        assert counts.resent > 0
        assert counts.delivered + sum(counts.lost.values()) == counts.sent
    assert sim.link.waiting("scout") == (0, 0)


def test_acknowledged_messages_replay_to_the_byte(tmp_path: Path) -> None:
    sim, path = acknowledging(), tmp_path / "link.mcap"
    with Recorder(sim, path, topics=["scout/depth"]):
        for k in range(8):
            sim.link.send("scout", "station", "up", bytes([k]) * 40, replaces=k % 2 == 0)
            sim.advance(0.7)
    result = replay(path, threads=1)
    assert result.difference is None
    assert result.state_compared
    assert sum(one.resent for one in sim.link.counts()) > 0


def test_a_bed_that_is_not_flat_is_reported() -> None:
    """A ramp of 1 in 10 below a path of 200 m: 10 m deeper and shallower at the ends than half-way, of 40 m."""
    spec, water = _core.LinkSpec(), _core.Water()
    water.bottom_depth_m = 50.0
    spec.modem = modem_spec(load_modem("micromodem"))
    heard_in, ends = _core.LinkWater(spec, water), ((-100.0, 0.0, -5.0), (100.0, 0.0, -5.0))

    def departure(slope: float) -> _core.Reception:
        world = _core.World()
        heights = -40.0 + slope * np.linspace(-500.0, 500.0, 101, dtype=np.float32)
        world.set_terrain(np.tile(heights, (101, 1)).astype(np.float32), 10.0, (-500.0, -500.0))
        return heard_in.receive(_core.RayScene(world), *ends)

    assert departure(0.0).bed_departure == pytest.approx(0.0, abs=1e-6)
    assert departure(0.1).bed_departure == pytest.approx(0.25, rel=1e-3)
    assert departure(0.1).bed_is_uneven and not departure(0.019).bed_is_uneven
    spec.set_bottom(1.0, 1.0, 0.5)  # water: nothing is reflected
    heard_in = _core.LinkWater(spec, water)
    assert departure(0.1).bed_departure == 0.0, "no arrival that counts has touched the bed"


def test_mistakes_are_named(tmp_path) -> None:
    sim = lake("tether")
    with pytest.raises(ValueError, match="node = 'rob': must be one of station, rov, scout; did you mean 'rov'"):
        sim.link.send("station", "rob", "t", b"")
    with pytest.raises(ValueError, match="another node"):
        sim.link.send("rov", "rov", "t", b"")
    with pytest.raises(ScenarioError, match="no effect on a link of kind 'ideal'"):
        Simulator(load("pair").with_changes(modem=_file(tmp_path, "name: x\nkind: ideal\nbit_rate_bit_s: 9\n")))
    with pytest.raises(ScenarioError, match=r"slot_s.*must hold a full packet"):
        text = "name: x\nbit_rate_bit_s: 80\nfrequency_hz: 25000\nbandwidth_hz: 4000\nsource_level_db: 180\nslot_s: 1\n"
        load("pair").with_changes(modem=_file(tmp_path, text))
    with pytest.raises(ScenarioError, match="did you mean"):
        load("pair").with_changes(modem="micromodm")
    with pytest.raises(ScenarioError, match=r"retransmissions.*no effect on a link of kind 'cable'"):
        validated(Scenario, load("pair").given() | {"link": {"modem": "tether", "retransmissions": 2}})


def _file(folder, text: str) -> str:
    path = folder / "modem.yaml"
    path.write_text(text)
    return str(path)


def test_a_modem_s_values_reach_the_core() -> None:
    """Every parameter of a modem changes something in the core's specification."""
    modem = load_modem("s2cm_hs")
    figures = set(ModemModel.model_fields) - {"name", "description", "kind", "latency_s"}
    changed = {"modulation": "fsk", "fading": True, "access": "aloha", "slot_s": 0.5}
    before = _plain(modem_spec(modem))
    for key in figures:
        value = changed.get(key, getattr(modem, key))
        other = modem.model_copy(update={key: value if key in changed else value + 1})
        assert _plain(modem_spec(other)) != before, key


def _plain(spec: object) -> dict[str, object]:
    return {
        key: getattr(spec, key) for key in dir(spec) if not key.startswith("_") and not callable(getattr(spec, key))
    }


def test_the_station_s_transducer_hangs_in_the_water_wherever_the_station_stands() -> None:
    world = _core.World()
    world.set_terrain(np.tile(np.float32([-12.0, -7.0, -2.0, 3.0]), (4, 1)), 10.0, [0.0, 0.0])  # a shore
    link = LinkSetup(modem="s2cm_hs")

    def hangs(link: LinkSetup, x_m: float, z_m: float, **station: object) -> list[float]:
        at = Station(position_m=(x_m, 10.0, z_m), **station)
        return station_transducer(link, at, world).tolist()

    assert hangs(link, 0.0, 0.0) == hangs(link, 0.0, 6.4) == [0.0, 10.0, -3.0]  # below the surface, not the platform
    assert hangs(link, 20.0, 6.4) == [20.0, 10.0, -1.0]  # half-way to the bed
    assert hangs(link, 1e4, 6.4) == [1e4, 10.0, -3.0]  # beyond the terrain
    assert hangs(link, 30.0, 1.0, carrier="boat") == [30.0, 10.0, -3.0]  # in the boat's frame
    with pytest.raises(ScenarioError, match=r"stands on land, 3 m above the water: give link\.station_transducer_m"):
        hangs(link, 30.0, 6.4)
    assert hangs(LinkSetup(modem="tether"), 30.0, 6.4) == [30.0, 10.0, 0.0]  # a cable needs no water
    given = LinkSetup(modem="s2cm_hs", station_transducer_m=(0.0, 0.0, -3.0))
    rule = r"station_transducer_m = \[0, 0, -3\] m: is 3\.4 m above the water, since the station is at z = 6\.4 m"
    with pytest.raises(ScenarioError, match=rule):
        hangs(given, 0.0, 6.4)
