"""The control suite: step responses of the packaged vehicles, and flights in gusts, compared with limits."""

from __future__ import annotations

from dataclasses import replace

from uwsim.evidence.validate.check import Check, at_most, relative
from uwsim.evidence.validate.gust_flights import gust_checks, top_speed_m_s
from uwsim.evidence.validate.step_responses import StepResponse, step_responses
from uwsim.scenario import load_vehicle

VEHICLES = ("rov", "paper", "bluerov2_heavy", "bluerov2_heavy_cfd", "bluerov2_wu", "bluerov2_tank", "remus100")
"""All packaged vehicles; remus100, which steers by fins, is tested under way."""
RISE_S = {"m": 5.0, "rad": 5.0, "m/s": 2.5, "rad/s": 1.5}
SETTLING_S = {"m": 10.0, "rad": 10.0, "m/s": 5.0, "rad/s": 4.0}
GUST_VEHICLE, MAKERS_SPEED_M_S, SPEED_TOLERANCE = "bluerov2_heavy_cfd", 1.5, 0.1  # Blue Robotics' data sheet: 3 knots
OVERSHOOT, STEADY = 0.1, 0.02  # shares of the step


def run() -> list[Check]:
    """Return the checks of the suite, with the step responses of all vehicles."""
    flown = (response for name in VEHICLES for response in step_responses(name, load_vehicle(name)))
    checks = [check for response in flown for check in response_checks(response)]
    fast = load_vehicle(GUST_VEHICLE)
    top = relative(GUST_VEHICLE, "speed at full thrust", MAKERS_SPEED_M_S, top_speed_m_s(fast), SPEED_TOLERANCE, "m/s")
    return [*checks, top, *gust_checks(GUST_VEHICLE, fast)]


def response_checks(response: StepResponse) -> list[Check]:
    """Compare a step response's rise time, overshoot, settling time and steady-state error with their limits."""
    step, unit = response.step, response.step.unit
    name = f"{step.name} {step.size:.3g} {unit}"
    rise = at_most(response.vehicle, f"{name}: rise time", RISE_S[unit], response.rise_s, "s")
    return [
        replace(rise, curve=response.curve()),
        at_most(response.vehicle, f"{name}: overshoot", OVERSHOOT, response.overshoot),
        at_most(response.vehicle, f"{name}: settling time", SETTLING_S[unit], response.settling_s, "s"),
        at_most(response.vehicle, f"{name}: steady-state error", STEADY, response.steady_error),
    ]
