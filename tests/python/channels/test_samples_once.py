"""When samples are taken and published: once, late ones skipped, and sonars that are read at the same time together."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from threading import Event
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.channels import Table
from uwsim.channels.delivery.feed import Feed
from uwsim.channels.delivery.pictures import RATE_HZ, Pictures
from uwsim.live import LiveSimulator
from uwsim.recording import Recorder
from uwsim.scenario import load
from uwsim.scenario.dump import plain


@pytest.mark.parametrize("is_recorded", [False, True])
def test_a_late_fix_is_published_once(is_recorded: bool, tmp_path: Path) -> None:
    stamps_ns: list[int] = []
    enough = threading.Event()

    def keep(reading) -> None:
        stamp = reading.message.header.stamp
        stamps_ns.append(10**9 * stamp.sec + stamp.nanosec)
        if len(stamps_ns) > 12:
            enough.set()

    with LiveSimulator("lake", speed="max", paused=True) as live:
        live.step(1120)  # between two multiples of the sensor's period, with a fix that has arrived
        table, feed = Table(live.simulator), Feed(live)
        channel = next(each for each in table.channels if each.name == "usbl")
        recorder = Recorder(live, tmp_path / "a.mcap", topics=["usbl"], shared=table, feed=feed)
        with recorder if is_recorded else nullcontext():
            stop = feed.listen(channel, keep)
            live.resume()
            assert enough.wait(180.0)
            stop()
    assert stamps_ns == sorted(set(stamps_ns))


PERIOD_NS = int(1e9 / RATE_HZ)


class SlowCamera:
    """A camera whose pictures are ready when the test sets `may_end`; each encodes the period in which it began."""

    def __init__(self, sim: SimpleNamespace) -> None:
        self.sim = sim
        self.may_end = Event()
        self.begun: list[int] = []

    def later(self) -> Callable[[], SimpleNamespace]:
        at = self.sim.time_ns // PERIOD_NS

        def capture() -> SimpleNamespace:
            self.begun.append(at)
            assert self.may_end.wait(180)
            return SimpleNamespace(jpeg=lambda quality: str(at).encode())

        return capture


def test_a_late_picture_is_read_once_when_it_is_ready_and_none_is_begun_before() -> None:
    sim = SimpleNamespace(time_ns=0)
    camera, pictures = SlowCamera(sim), Pictures(may_wait=lambda: False)

    def read(period: int) -> bytes | None:
        sim.time_ns = period * PERIOD_NS
        picture = pictures.read(sim, "front", camera)
        return None if picture is None else picture.jpeg

    assert [read(period) for period in range(5)] == [None] * 5, "the steps do not wait"
    camera.may_end.set()
    ready = next(iter(pictures._jobs["front"])).picture
    ready.result(180)
    assert [read(5), read(5)] == [b"0", b"0"], "all readers of one period get the same"
    pictures._jobs["front"][-1].picture.result(180)
    assert read(6) == b"5"
    assert camera.begun[:2] == [0, 5]


def test_sonars_ping_together_as_long_as_both_are_read(monkeypatch: pytest.MonkeyPatch) -> None:
    rov = plain(load("pool"))["vehicles"][0]
    sim = Simulator(
        plain(load("pool")) | {"vehicles": [rov, rov | {"name": "twin", "start": {"position_m": [0, 2, -1]}}]}
    )
    pinged: list[int] = []
    ping = Simulator.ping
    monkeypatch.setattr(Simulator, "ping", lambda *those: pinged.append(len(those) - 1) or ping(*those))
    pings: dict[str, Any] = Table(sim).pings

    def read(*names: str) -> None:
        for name in names:
            taken = pings[name].newest(sim)
            assert taken.ping.time_ns == sim.time_ns
            assert np.array_equal(taken.ping.ranges_m, sim.vehicles[name].sonar.ping().ranges_m)
        sim.advance(pings["rov"].interval_s)

    read("rov", "twin")  # nothing is known of the second reader yet
    read("rov", "twin")
    read("twin", "rov")
    read("rov")  # the second reader has left, and one ping is in vain
    read("rov")
    read("twin", "rov")
    assert pinged == [1, 1, 2, 1, 2, 1, 2, 1, 2, 1]
