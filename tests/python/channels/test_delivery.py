"""Delivery to subscribers, and its order: nothing latched is lost, frames come first, each ping comes once."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest

from channel_tools import stamp_ns
from uwsim import Simulator
from uwsim.bridges.rosbridge.graph import Graph
from uwsim.bridges.rosbridge.simulator_node import SimulatorNode
from uwsim.channels import Channel, Table, diagnostics_channel
from uwsim.channels.channel import LATCHED
from uwsim.channels.delivery.feed import Feed
from uwsim.channels.delivery.outgoing import Line, Turns
from uwsim.channels.delivery.pictures import Pictures
from uwsim.channels.ros.build import text
from uwsim.live import LiveSimulator

TEXT = "std_msgs/msg/String"


@pytest.fixture
def live() -> Iterator[LiveSimulator]:
    with LiveSimulator("pool", paused=True, speed="max") as live:
        yield live


def test_frequent_messages_displace_only_their_own_and_the_order_is_kept() -> None:
    turns: Turns[int] = Turns()
    often, once = Line[int]("often", 3), Line[int]("once", 1)
    turns.put(often, 0)
    turns.put(once, -1)
    for number in range(1, 100):
        turns.put(often, number)
    taken = [turns.take(wait=False) for _ in range(len(turns))]
    assert [turn[1] for turn in taken if turn] == [97, -1, 98, 99]
    assert turns.take(wait=False) is None and (often.drops.count, once.drops.count) == (97, 0)


class BusyLoop:
    """An event loop that only queues its callbacks; the test runs them."""

    def __init__(self) -> None:
        self.waiting: list[Callable[[], object]] = []

    def call_soon_threadsafe(self, function: Callable[..., object], *arguments: Any) -> None:
        self.waiting.append(lambda: function(*arguments))


def test_a_busy_server_keeps_latched_messages_and_reports_the_others_that_it_drops(live: LiveSimulator) -> None:
    fixed = Channel("fixed", TEXT, "out", "", delivery=LATCHED, read=lambda sim: text("fixed"))
    often = Channel("often", TEXT, "out", "", rate_hz=200.0, read=lambda sim: text("often"))
    diagnostics, graph, loop, seen = diagnostics_channel(live, lambda: [fixed, often]), Graph(), BusyLoop(), []
    with SimulatorNode(live, [fixed, often], [], None, graph, loop):  # type: ignore[arg-type]
        for name in ("fixed", "often"):
            graph.subscribe("client", name, name, TEXT, lambda sample: seen.append(sample.message.data))
        live.step(3000)
        assert diagnostics.read(live.simulator).status[1].level == 1
        for work in loop.waiting:
            work()
    assert seen.count("fixed") == 1 and seen.count("often") + often.drops.count == 3001
    (pair,) = diagnostics.read(live.simulator).status[1].values
    assert (pair.key, int(pair.value)) == ("/often", often.drops.count) and often.drops.count > 0
    assert diagnostics.read(live.simulator).status[1].level == 0, "none since the last message"


def test_time_and_transforms_precede_all_readings_of_the_same_tick(live: LiveSimulator) -> None:
    table, feed, order = {channel.name: channel for channel in Table(live.simulator).channels}, Feed(live), []
    for name in ("points", "imu", "tf", "clock"):  # the frames are subscribed to last
        feed.listen(table[name], lambda reading: order.append((reading.tick, reading.channel.name)))
    begun = live.tick  # until then, readings are taken one by one, as each is subscribed to
    live.step(400)
    ticks = {tick for tick, name in order if name == "points" and tick > begun}
    assert len(ticks) > 10
    for tick in ticks:
        assert {name for at, name in order if at == tick} == {"points", "imu", "tf", "clock"}
        assert {name for at, name in [one for one in order if one[0] == tick][:2]} == {"tf", "clock"}


def test_each_ping_is_published_once_even_when_pings_become_rarer(live: LiveSimulator) -> None:
    stamps: dict[str, list[int]] = {name: [] for name in ("scan", "ping", "laserPointCloud", "points")}
    feed = Feed(live)
    for channel in Table(live.simulator).channels:
        if channel.name in stamps:
            feed.listen(channel, lambda reading: stamps[reading.channel.name].append(stamp_ns(reading.message)))
    live.step(200)
    quick = {name: len(each) for name, each in stamps.items()}
    assert all(10 <= count <= 15 for count in quick.values()), "about 13 pings a second to 55 m"
    live.command("set_parameter", name="rov.sonar.model", value=1).result()  # to 95 m
    live.step(400)
    for name, each in stamps.items():
        assert each == sorted(set(each)) and 10 <= len(each) - quick[name] <= 16, name


def test_the_first_picture_after_a_pause_shows_the_present() -> None:
    sim, pictures = Simulator("pool"), Pictures(lambda: False)

    def begin(stream: Any) -> Callable[[], int]:
        time_ns = sim.time_ns
        return lambda: time_ns

    def first_seen() -> int:
        for _ in range(10):
            found: int | None = pictures.read_made(sim, "camera", begin)
            pictures.submit(lambda: None).result()  # what has been started is finished
            if found is not None:
                return found
            sim.advance(0.1)
        raise AssertionError("no picture within a second")

    first_seen()
    sim.advance(30.0)
    again_ns = sim.time_ns
    assert first_seen() >= again_ns
