"""Sonars whose pings are read at the same time ping together; the others do not ping."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.channels import Table
from uwsim.scenario import load
from uwsim.scenario.dump import plain


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
