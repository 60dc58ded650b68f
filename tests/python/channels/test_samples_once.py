"""A sample is published once, however late it arrives: the reading between two fixes has nothing new."""

import threading
from contextlib import nullcontext
from pathlib import Path

import pytest

from uwsim.channels import Table
from uwsim.channels.delivery.feed import Feed
from uwsim.live import LiveSimulator
from uwsim.recording import Recorder


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
