"""Each registered kind of fault works, and stands in the guide and on the instructor's page."""

import re
from pathlib import Path

from sites import deep_lake
from uwsim import Simulator
from uwsim.operator.station.services.fault_kinds import fault_kinds
from uwsim.operator.station.wire.training import FaultKinds
from uwsim.scenario.spec.fault import FAULTS


def test_each_kind_can_be_injected_as_the_instructors_form_begins():
    kinds = FaultKinds.model_validate({"success": True, "kinds": fault_kinds()}).kinds
    assert [each.kind for each in kinds] == list(FAULTS.models())
    for model, thruster in (("rov", {"axis": "yaw"}), ("bluerov2_heavy", {"thruster": "front_left"})):
        sim = Simulator(deep_lake(model=model))
        own = {"thruster": thruster, "sensor": {"sensor": "depth"}, "camera": {"camera": "front"}}
        lacking = {"tether"} if sim.scenario.vehicles[0].model.cameras else {"tether", "camera"}
        offered = [each for each in kinds if each.kind not in lacking]
        for each in offered:
            begun = {field.name: field.value for field in each.fields if field.value is not None}
            sim.faults.inject(each.kind, **begun, **own.get(each.kind, {}))
        assert sim.faults.active == tuple(each.kind for each in offered)


def test_the_guide_lists_each_kind():
    guide = (Path(__file__).parents[3] / "docs/guides/faults.md").read_text()
    table = guide.partition("| kind |")[2].partition("\n\n")[0]
    assert re.findall(r"^\| `(\w+)`", table, re.MULTILINE) == list(FAULTS.models())
