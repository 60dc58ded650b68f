"""A live simulator over a link: only carried data arrive, possibly late or never, and runs repeat byte for byte."""

from __future__ import annotations

import io
import math
from concurrent.futures import wait

import numpy as np
import pytest
from PIL import Image

from uwsim import Simulator
from uwsim.channels import Table, channels
from uwsim.channels.channel import Channel
from uwsim.channels.families.published import join
from uwsim.channels.ros import build
from uwsim.channels.ros.cdr import encode
from uwsim.link import Carrier
from uwsim.link.carried import carried_channels
from uwsim.link.packing import PACKINGS
from uwsim.live import LiveSimulator, replay
from uwsim.recording import Recorder
from uwsim.recording.replay import replay as replay_file
from uwsim.scenario import load


def linked(modem: str = "s2cm_hs") -> LiveSimulator:
    """Return a paused simulator with a link."""
    return LiveSimulator(Simulator("pool", link=modem, threads=1), paused=True)


def named(carrier: Carrier, name: str) -> Channel:
    """Return a channel as the station sees it."""
    return next(channel for channel in carrier.channels if channel.name == name)


def key(surge: float = 0.0, function: float = 0.0) -> object:
    """Return a published key message."""
    return build.pose(np.array([surge, 0.0, 0.0]), np.array([0.0, 0.0, 0.0, function]))


def test_a_command_takes_effect_when_its_packet_has_arrived() -> None:
    with linked() as live, Carrier(live, Table(live.simulator)) as carrier:
        named(carrier, "key").apply(live, key(surge=0.5, function=1))
        live.step(1)
        assert not live.simulator.rov.released
        live.step(200)
        assert live.simulator.rov.released
        assert live.simulator.rov.effort[0] == pytest.approx(0.5, abs=0.5 / 127)
        (got,) = live.simulator.link.received("rov")
        (steered,) = [entry for entry in live.log if entry.name == "set_effort"]
        assert steered.tick == math.ceil(got.arrived_s / live.simulator.step_s - 1e-9)


def test_the_station_sees_what_was_carried_and_only_that() -> None:
    with linked() as live, Carrier(live, Table(live.simulator)) as carrier:
        seen = named(carrier, "stateData")
        assert live.read(seen.read).result() is None, "nothing has been sent yet"
        said = None
        for _ in range(1000):
            live.step(1)
            said = live.read(seen.read).result()
            if said is not None:
                break
        assert said is not None
        truth = live.read(channels(live.simulator, wire="published")[2].read).result()
        assert len(said.data.split("a")) == 10
        assert said.data != truth.data, "it is older and rounded"
        names = {channel.name for channel in carrier.channels}
        assert "laserPointCloud" not in names, "no modem can carry it"
        assert {"clock", "link", "depthArray"} <= names
        status = live.read(named(carrier, "link").read).result()
        assert status.modem == "s2cm_hs"
        assert status.delivered > 0
        assert 0.0 < status.delay < 0.1


def test_commands_may_be_sent_several_times_and_a_pattern_without_effect_is_refused() -> None:
    scenario = load("pool").with_changes(modem="s2cm_hs")
    repeats = {"key": 2, "command/release": 1}
    link = scenario.link.model_copy(update={"repeats": repeats})
    sim = Simulator(scenario.model_copy(update={"link": link}), threads=1)
    with LiveSimulator(sim, paused=True) as live, Carrier(live, Table(sim)) as carrier:
        named(carrier, "key").apply(live, key(surge=0.5))
        next(one for one in carrier.over(Table(sim).services) if one.name == "release").call(live, {})
        live.step(600)
        counts = {one.topic: one for one in sim.link.counts() if one.sender == "station"}
        assert sim.rov.released
        assert [counts["key"].delivered, counts["command/release"].delivered] == [1, 1]
        assert counts["key"].bytes_sent == 3 * counts["key"].bytes_delivered
        assert counts["command/release"].bytes_sent == 2 * counts["command/release"].bytes_delivered
    other = scenario.link.model_copy(update={"repeats": {"kye": 2}})
    wrong = Simulator(scenario.model_copy(update={"link": other}), threads=1)
    with pytest.raises(ValueError, match=r"'kye': must match a channel.*did you mean 'key'"):
        Carrier(wrong, Table(wrong))


@pytest.mark.parametrize("by", ["key", "release"])
def test_a_vehicle_that_hangs_above_the_water_is_released_there_since_no_modem_is_heard(by: str) -> None:
    """The paper's cage, from which a command over the modem would never let it go."""
    with LiveSimulator(Simulator("paper", link="s2cm_hs", threads=1), paused=True) as live:
        carrier = Carrier(live, table := Table(live.simulator))
        if by == "key":
            named(carrier, "key").apply(live, key(function=1))
        else:
            next(one for one in carrier.over(table.services) if one.name == "release").call(live, {})
        live.step(2)
        assert live.simulator.rov.released
        assert not any(one.sender == "station" for one in live.simulator.link.counts())
        live.step(400)  # it falls in
        assert live.simulator.link.reception("station", "rov").reached


def test_runs_over_a_link_repeat_to_the_same_bytes(tmp_path) -> None:
    path = tmp_path / "run.mcap"
    with linked() as live, Carrier(live, table := Table(live.simulator)) as carrier:
        chosen = ["stateData", "telemetry", "depthArray", "link", "imu"]
        table.channels = carrier.channels
        with Recorder(live, path, topics=chosen, shared=table):
            for surge in (0.2, 0.6, -0.3):
                named(carrier, "key").apply(live, key(surge, function=1.0))
                live.step(400)
            end = live.read(lambda sim: sim.save_state()).result()
        log, tick = live.log, live.tick
    again = replay(Simulator("pool", link="s2cm_hs", threads=1), log, tick)
    assert again.save_state() == end
    result = replay_file(path, threads=1)
    assert result.difference is None
    assert result.state_compared
    assert result.messages["stateData"] > 2


def test_speed_does_not_matter() -> None:
    def run(steps: int) -> bytes:
        with linked() as live, Carrier(live, Table(live.simulator, wire="published")):
            for _ in range(600 // steps):
                live.step(steps)
            return live.read(lambda sim: sim.save_state()).result()

    assert run(1) == run(600)


def test_over_a_cable_everything_goes_whole_when_somebody_listens() -> None:
    with linked("tether") as live, Carrier(live, Table(live.simulator)) as carrier:
        seen = named(carrier, "odom")
        got = []
        subscription = live.every(0.01, seen.read, got.append)
        live.step(40)
        subscription.cancel()
        said = [message for message in got if message is not None]
        assert len(said) > 5
        sent = {one.topic for one in live.simulator.link.counts()}
        assert sent == {"odom"}


def test_a_reset_forgets_what_was_on_its_way() -> None:
    with linked() as live, Carrier(live, Table(live.simulator)) as carrier:
        named(carrier, "key").apply(live, key(0.5, function=1))
        live.reset()
        live.step(300)
        assert not live.simulator.rov.released


def test_packings_keep_what_their_quanta_say() -> None:
    sim = Simulator("lake", threads=1)
    sim.rov.undock()
    sim.rov.set_effort(surge=0.4)
    sim.advance(2.0)
    table = {channel.name: channel for channel in channels(sim)}

    def carried(name: str) -> tuple[object, object, int]:
        channel = table[name]
        message = channel.read(sim)
        payload = PACKINGS[channel.over_link.packing].pack(message)
        return message, PACKINGS[channel.over_link.packing].unpack(payload, channel), len(payload)

    before, after, size = carried("propPos")
    assert size == 20
    assert abs(before.position.x - after.position.x) <= 0.0005
    assert abs(before.orientation.w - after.orientation.w) < 1e-4
    before, after, size = carried("stateData")
    assert size == 21
    values, kept = (np.array([float(v) for v in m.data.split("a")[:-1]]) for m in (before, after))
    assert np.all(np.abs(values - kept) <= [0.006, 0.0006, 0.006, 0.006, 0.051, 0.051, 0.051, 0.051, 0.26])
    before, after, size = carried("depthArray")
    assert size < 150
    depths, thin = (np.array([float(v) for v in m.data.split("a")[:-1]]) for m in (before, after))
    assert len(thin) == len(depths) == 513
    assert np.abs(depths - thin)[::8].max() <= 0.0051
    assert np.all(np.delete(thin, np.s_[::8]) == depths.max())
    before, after, size = carried("scan")
    assert len(after.ranges) == 65
    assert after.angle_max == pytest.approx(before.angle_max, abs=1e-5)
    before, after, size = carried("telemetry")
    assert size < 100
    assert after.depth == pytest.approx(before.depth, abs=0.006)
    assert after.released == before.released
    assert np.allclose(after.efforts, before.efforts, atol=0.006)
    assert list(after.lamps) == list(before.lamps)
    assert np.allclose(after.true_position, before.true_position, atol=0.006, equal_nan=True)
    before, after, size = carried("imu")
    assert bytes(encode(after)) == bytes(encode(before))


def test_a_slow_modem_s_panel_fits_into_one_packet() -> None:
    sim = Simulator(load("lake").with_changes(modem="micromodem"), threads=1)
    (panel,) = [one for one in carried_channels(channels(sim), sim) if one.channel.name == "telemetry"]
    sim.rov.undock()
    sim.rov.set_effort(surge=0.4, yaw=0.3)
    sim.advance(6.0)
    before = panel.channel.read(sim)
    payload = panel.packing.pack(before)
    assert len(payload) <= sim.link.modem.packet_bytes
    after = panel.packing.unpack(payload, panel.channel)
    assert np.allclose(after.position, before.position, atol=0.006)
    assert after.depth == pytest.approx(before.depth, abs=0.006)
    assert abs(np.dot(after.orientation, before.orientation)) > math.cos(0.5 * 3 * math.pi / 254)
    for name in ("speed", "distance_to_seabed", "temperature", "mission_time", "battery", "tilt"):
        assert getattr(after, name) == pytest.approx(getattr(before, name), abs=0.51), name
    assert (after.released, list(after.lamps)) == (before.released, list(before.lamps))
    assert not after.is_truth
    assert bytes(encode(after)), "every field has a value of its type"


def test_what_the_vehicle_does_by_itself_is_carried() -> None:
    sim = Simulator(load("lake").with_changes(modem="s2cm_hs"), threads=1)
    (panel,) = [one for one in carried_channels(channels(sim), sim) if one.channel.name == "telemetry"]
    message = panel.channel.read(sim)
    message.failsafe, message.failsafe_cause, message.alarms = "return", "leak", ["water inside"]
    after = panel.packing.unpack(panel.packing.pack(message), panel.channel)
    assert (after.failsafe, after.failsafe_cause, after.alarms) == ("return", "leak", ["water inside"])
    short = PACKINGS["telemetry_short"]
    assert short.unpack(short.pack(message), panel.channel).failsafe == "return"


def test_infinite_distances_stay_so() -> None:
    values = [0.0, 0.0, 10.0, 101.3, 0.0, 5.0, math.inf, 1.0, 50.0]
    packing = PACKINGS["state"]
    channel = Channel("stateData", "std_msgs/msg/String", "out", "")
    assert packing.unpack(packing.pack(build.text(join(values))), channel).data.split("a")[6] == "Infinity"


def test_pictures_arrive_as_thumbnails() -> None:
    rng = np.random.default_rng(1)
    jpeg = io.BytesIO()
    Image.fromarray(rng.integers(0, 255, (90, 160, 3), np.uint8)).resize((640, 360)).save(jpeg, "JPEG")
    header, data = build.header(1_500_000_000, "front_optical"), np.frombuffer(jpeg.getvalue(), np.uint8)
    message = build.message("sensor_msgs/msg/CompressedImage", header=header, format="jpeg", data=data)
    packing = PACKINGS["thumbnail"]
    data = packing.pack(message)
    small = packing.unpack(data, Channel("x", "sensor_msgs/msg/CompressedImage", "out", ""))
    assert Image.open(io.BytesIO(bytes(small.data))).size == (96, 54)
    assert small.header.frame_id == "front_optical"
    assert small.header.stamp.nanosec == 500_000_000
    assert len(data) < 4000


def test_a_flood_of_commands_does_not_stop_the_time() -> None:
    with linked("micromodem") as live, Carrier(live, Table(live.simulator)) as carrier:
        futures = [named(carrier, "key").apply(live, key(surge=k / 300)) for k in range(300)]
        wait(futures)
        live.step(400)
        counts = next(one for one in live.simulator.link.counts() if one.topic == "key")
        assert counts.given == 300
        assert counts.replaced >= 298
