"""The validation of the control loops, which tools/docs runs, fails with bad gains."""

from uwsim.evidence.validate.control import response_checks
from uwsim.evidence.validate.step_responses import step_responses
from uwsim.scenario import load_vehicle
from uwsim.scenario.spec.control import Control


def test_bad_gains_miss() -> None:
    weak = {"position_1_s": 0.05, "velocity_1_s": 0.2, "integral_1_s2": 0.0}
    model = load_vehicle("rov").model_copy(update={"control": Control.model_validate({"surge": weak, "yaw": weak})})
    responses = step_responses("rov", model)
    missed = {check.name for response in responses for check in response_checks(response) if not check.passed}
    assert any(name.startswith("ahead") for name in missed) and any(name.startswith("heading") for name in missed)
    assert not any(name.startswith("sideways") for name in missed)
