"""Each registered kind of fault works, and stands in the guide."""

import re
from pathlib import Path

from sites import deep_lake
from uwsim import Simulator
from uwsim.scenario.spec.fault import FAULTS

LEAST = {
    "sensor": {"sensor": "depth"}, "sonar": {}, "camera": {"camera": "front"}, "battery": {"thrust": 0.5},
    "leak": {"kg_per_s": 0.05}, "link": {}, "current": {"velocity_world_m_s": (0.0, 0.2, 0.0)},
}  # fmt: skip


def test_each_kind_can_be_injected():
    assert {*LEAST, "thruster", "tether"} == set(FAULTS.models())
    for model, thruster in (("rov", {"axis": "yaw"}), ("bluerov2_heavy", {"thruster": "front_left"})):
        sim = Simulator(deep_lake(model=model))
        offered = {"thruster": thruster, **LEAST}
        if not sim.scenario.vehicles[0].model.cameras:
            del offered["camera"]
        for kind, given in offered.items():
            sim.faults.inject(kind, **given)
        assert sim.faults.active == tuple(offered)


def test_the_guide_lists_each_kind():
    guide = (Path(__file__).parents[3] / "docs/guides/faults.md").read_text()
    table = guide.partition("| kind |")[2].partition("\n\n")[0]
    assert re.findall(r"^\| `(\w+)`", table, re.MULTILINE) == list(FAULTS.models())
