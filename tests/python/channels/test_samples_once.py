"""A sample is published once, however late it arrives: the reading between two fixes has nothing new."""

import threading

from uwsim.channels import Table
from uwsim.channels.delivery.feed import Feed
from uwsim.live import LiveSimulator


def test_a_late_fix_is_published_once() -> None:
    stamps_ns: list[int] = []
    enough = threading.Event()

    def keep(reading) -> None:
        stamp = reading.message.header.stamp
        stamps_ns.append(10**9 * stamp.sec + stamp.nanosec)
        if len(stamps_ns) > 12:
            enough.set()

    with LiveSimulator("lake", speed="max", paused=True) as live:
        live.step(1120)  # between two multiples of the sensor's period, with a fix that has arrived
        channel = next(each for each in Table(live.simulator).channels if each.name == "usbl")
        stop = Feed(live).listen(channel, keep)
        live.resume()
        assert enough.wait(60.0)
        stop()
    assert stamps_ns == sorted(set(stamps_ns))
