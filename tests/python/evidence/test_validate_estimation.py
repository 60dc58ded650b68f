"""The validation of the navigation filter, whose flights tools/docs makes: its statistics, and which vehicles fly."""

import numpy as np

from uwsim import Simulator
from uwsim.evidence.validate import consistency, estimation


def test_a_filter_that_is_too_sure_of_itself_fails() -> None:
    honest = np.random.default_rng(0).chisquare(3, (20, 12, 3))
    nees = np.concatenate([honest.sum(axis=2, keepdims=True), honest], axis=2)
    assert all(check.passed for check in consistency.consistency_checks(nees))
    assert not any(check.passed for check in consistency.consistency_checks(2.0 * nees))
    assert not any(check.passed for check in consistency.consistency_checks(0.5 * nees))


def test_the_closed_form_grows_with_the_cube_of_time_at_last() -> None:
    sim = Simulator("lake")
    navigator, _ = consistency.start_navigation(sim, 0)
    early, late = (np.trace(estimation.closed_form(sim, navigator, t)) for t in (500.0, 1000.0))
    assert 2.0**6 < late / early < 2.0**7  # a gyroscope's bias grows as t^3, its drift as t^3.5
