"""The step responses of the packaged vehicles, and that bad gains miss their limits."""

from pathlib import Path

import pytest

from uwsim.evidence.validate.control import GUST_VEHICLE, VEHICLES, response_checks
from uwsim.evidence.validate.gust_flights import gust_checks
from uwsim.evidence.validate.step_figures import draw_steps
from uwsim.evidence.validate.step_responses import step_responses
from uwsim.scenario import load_vehicle
from uwsim.scenario.spec.control import Control


@pytest.mark.parametrize("name", VEHICLES)
def test_every_packaged_vehicle_answers_steps_within_the_limits(name: str) -> None:
    checks = [check for response in step_responses(name, load_vehicle(name)) for check in response_checks(response)]
    assert len(checks) >= (16 if name == "remus100" else 24)
    assert [check for check in checks if not check.passed] == []


def test_a_vehicle_keeps_place_and_path_in_gusts_by_its_own_estimate() -> None:
    checks = gust_checks(GUST_VEHICLE, load_vehicle(GUST_VEHICLE), seeds=(2,))  # `validate` flies six
    assert [check for check in checks if not check.passed] == []


def test_bad_gains_miss_and_are_drawn(tmp_path: Path) -> None:
    weak = {"position_1_s": 0.05, "velocity_1_s": 0.2, "integral_1_s2": 0.0}
    model = load_vehicle("rov").model_copy(update={"control": Control.model_validate({"surge": weak, "yaw": weak})})
    responses = step_responses("rov", model)
    missed = {check.name for response in responses for check in response_checks(response) if not check.passed}
    assert any(name.startswith("ahead") for name in missed) and any(name.startswith("heading") for name in missed)
    assert not any(name.startswith("aside") for name in missed)
    draw_steps(responses, tmp_path / "steps.png")
    assert (tmp_path / "steps.png").read_bytes().startswith(b"\x89PNG")
