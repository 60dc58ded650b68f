"""Simulator.log refuses what no topic can carry, and changes nothing then."""

from typing import Any

import pytest

from uwsim import Simulator
from uwsim.channels import Table


@pytest.mark.parametrize(
    ("topic", "values", "rule"),
    [
        ("/size", {"m": float("nan")}, "log '/size/m' = nan: must be a finite number, a bool or a text"),
        ("/size", {"m": "long"}, "log '/size/m' = 'long': must be a float, as before"),
        ("/size", {"a m": 1.0}, "log '/size/a m': must be letters, digits and _"),
        ("/size", {}, "log '/size': values = {}: must be a dict of values by name"),
        ("/other", {"a": 1.0}, "log '/other/a': is new, and a recorder or server is open: log it before"),
    ],
)
def test_what_cannot_be_logged_is_refused(topic: str, values: Any, rule: str) -> None:
    sim = Simulator("pool")
    sim.log("/size", {"m": 1.0})
    table = Table(sim)
    with pytest.raises(ValueError, match=rule):
        sim.log(topic, values)
    assert sim.logged.values == {"size/m": 1.0} and "size/m" in {each.name for each in table.channels}
    (other := Simulator("pool")).log("ground_truth", {"odom": 1.0})
    with pytest.raises(ValueError, match="log '/ground_truth/odom': the name is taken"):
        Table(other)
