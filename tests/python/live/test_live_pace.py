"""The pace's schedule, on a clock set by the test."""

import math

import pytest

from uwsim.live.pace import REST_S, SLIP_S, Pace

STEP_S = 0.005


def run(
    pace: Pace, wall_s: float, *, step_cost_s: float = 0.0, start_s: float = 100.0, awaited: int | None = 1
) -> tuple[int, float]:
    """Step as the loop does for wall_s seconds; return the number of steps and the time at the end.

    awaited: the number of steps that a caller waits for.
    """
    now_s, steps = start_s, 0
    while now_s < start_s + wall_s:
        due = pace.due(now_s)
        if due == 0:
            now_s += max(pace.wait_s(now_s, awaited), 1e-9)
            continue
        end_s = now_s + due * step_cost_s + 1e-9
        pace.made(due, now_s, end_s)
        now_s, steps = end_s, steps + due
    return steps, now_s


def test_a_machine_that_is_fast_enough_makes_exactly_the_scheduled_steps() -> None:
    for speed in (0.25, 1.0, 3.7, 50.0):
        pace = Pace(speed, STEP_S)
        steps, _ = run(pace, 4.0, step_cost_s=1e-5)
        assert steps == pytest.approx(4.0 * speed / STEP_S, abs=2)
        assert pace.factor == pytest.approx(speed, rel=0.03)
        assert pace.slipped_s == 0.0 and pace.lateness_s < 0.001


def test_a_machine_that_is_too_slow_slips_and_says_so() -> None:
    pace = Pace(1.0, STEP_S)  # each step costs twice its simulated duration
    steps, now_s = run(pace, 4.0, step_cost_s=2 * STEP_S)
    assert steps == pytest.approx(2.0 / STEP_S, abs=2)
    assert pace.factor == pytest.approx(0.5, rel=0.03)
    behind_s = (now_s - 100.0) - steps * STEP_S
    assert pace.slipped_s == pytest.approx(behind_s, abs=SLIP_S + 2 * STEP_S)
    assert SLIP_S < pace.lateness_s < SLIP_S + 3 * STEP_S


@pytest.mark.parametrize(("delay_s", "made_up"), [(0.2, True), (10.0, False)])
def test_short_delays_are_made_up_for_and_long_ones_are_not(delay_s: float, made_up: bool) -> None:
    pace = Pace(1.0, STEP_S)
    before, now_s = run(pace, 1.0)
    after, _ = run(pace, 1.0, start_s=now_s + delay_s)
    expected = (2.0 + (delay_s if made_up else 0.0)) / STEP_S
    assert before + after == pytest.approx(expected, abs=3)
    assert pace.lateness_s == pytest.approx(delay_s, abs=STEP_S)
    assert pace.slipped_s == pytest.approx(0.0 if made_up else delay_s, abs=STEP_S)
    pace.forget_delays()
    assert (pace.lateness_s, pace.slipped_s) == (0.0, 0.0)


def test_steps_that_nobody_waits_for_rest_without_being_late() -> None:
    pace = Pace(1.0, STEP_S)
    assert pace.due(100.0) == 1  # the first step
    pace.made(1, 100.0, 100.0)
    assert pace.wait_s(100.0, None) == pytest.approx(REST_S)  # one wake-up runs several steps
    assert pace.wait_s(100.0, 2) == pytest.approx(2 * STEP_S)  # a caller waits for the second step
    assert pace.wait_s(100.0, None) == pytest.approx(REST_S)
    assert pace.due(100.0 + REST_S + 1e-6) == round(REST_S / STEP_S)
    assert pace.lateness_s < 1e-5
    assert pace.due(100.0 + REST_S + 0.2) > round(REST_S / STEP_S)
    assert (pace.lateness_s, pace.slipped_s) == (pytest.approx(0.2), 0.0)


def test_at_max_something_is_always_due() -> None:
    pace = Pace("max", STEP_S)
    steps, _ = run(pace, 0.1, step_cost_s=1e-5)
    assert steps == pytest.approx(0.1 / 1e-5, rel=0.02)
    assert pace.factor == pytest.approx(STEP_S / 1e-5, rel=0.02)
    assert pace.lateness_s == 0.0


def test_a_pause_is_no_delay() -> None:
    pace = Pace(1.0, STEP_S)
    _, now_s = run(pace, 1.0)
    pace.restart()
    run(pace, 1.0, start_s=now_s + 1000.0)
    assert (pace.slipped_s, pace.factor) == (0.0, pytest.approx(1.0, rel=0.03))
    assert pace.lateness_s < 0.001


def test_another_speed_is_refused_and_changes_nothing() -> None:
    pace = Pace(2.0, STEP_S)
    for speed in (0.0, -1.0, math.nan, math.inf, "fast", None, True):
        with pytest.raises(ValueError, match=r"speed = .*: must be a factor in \[0.001, 1000000\], or 'max'"):
            pace.set_speed(speed)  # type: ignore[arg-type]
        assert pace.speed == 2.0
