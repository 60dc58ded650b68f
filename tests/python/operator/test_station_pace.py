"""The station's responsiveness: a simulator is prepared before Start, and pictures are as large as time permits."""

import itertools
import threading

import pytest

from uwsim import Simulator
from uwsim.operator.station.fit import LEAST_BEHIND, PATIENCE, SHARES, Fit
from uwsim.operator.station.prepared import Prepared
from uwsim.scenario import load


def test_pictures_shrink_until_they_keep_their_rate_and_grow_again():
    fit, full_s = Fit(), 0.24

    def note(pictures):
        for _ in range(pictures):
            fit.note(full_s * fit.share**2, 0.1)

    note(40)
    assert fit.share == SHARES[-1]  # 60 ms
    full_s = 0.11
    note(2 * PATIENCE)
    assert fit.share == 0.75  # 62 ms; the full size would be too slow
    full_s = 0.04
    note(2 * PATIENCE)
    assert fit.share == 1.0


def test_pictures_are_larger_and_more_frequent_only_where_they_slow_nothing():
    fit, full_s = Fit(), 0.015

    def note(pictures, has_room):
        for _ in range(pictures):
            fit.note(full_s * fit.share**2, 0.1, has_room=has_room)

    note(10 * PATIENCE, has_room=False)
    assert fit.share == 1.0, "there is time, but the steps would be slower"
    note(2 * PATIENCE, has_room=True)
    assert fit.share == 1.5 and fit.is_large  # 34 ms of 67 ms
    note(4, has_room=False)
    assert fit.share == 1.0, "as soon as the steps do not keep their pace"
    full_s = 0.025
    note(10 * PATIENCE, has_room=True)
    assert fit.share == 1.0  # 56 ms of 67 ms would be too long


def test_pictures_shrink_while_the_steps_are_behind():
    fit = Fit()

    def note(pictures, is_behind):
        for _ in range(pictures):
            fit.note(0.03 * fit.share**2, 0.1, is_behind=is_behind)

    note(LEAST_BEHIND - 1, is_behind=True)
    note(1, is_behind=False)
    assert fit.share == 1.0, "a moment's delay changes nothing"
    note(LEAST_BEHIND, is_behind=True)
    assert fit.share == 0.75
    note(10 * LEAST_BEHIND, is_behind=True)
    assert fit.share == SHARES[-1]
    note(10 * PATIENCE, is_behind=False)
    assert fit.share == 1.0


def test_one_slow_picture_does_not_shrink_a_stream():
    fit = Fit()
    for k in range(200):
        fit.note(0.15 if k % 50 == 0 else 0.05, 0.1)
        assert fit.share == 1.0


def test_a_size_that_failed_is_tried_less_and_less_often():
    fit, trials, was_small = Fit(), [], False
    for k in range(3000):
        took_s = 0.2 if fit.share == 1.0 else 0.02  # too slow at full size, however fast the smaller one is
        fit.note(took_s, 0.1)
        if fit.share == 1.0 and was_small:
            trials.append(k)
        was_small = fit.share < 1.0
    waits = [later - before for before, later in itertools.pairwise(trials)]
    assert len(waits) >= 3 and all(later > 1.5 * before for before, later in itertools.pairwise(waits[:4]))


def test_what_is_prepared_is_what_would_be_made():
    scenario = load("pool").with_changes(seed=5)
    made = []

    def make(scenario):
        made.append(Simulator(scenario))
        return made[-1]

    prepared = Prepared(make)
    prepared.prepare(scenario)
    prepared.prepare(load("pool").with_changes(seed=5))  # an equal scenario
    simulator = prepared.release(load("pool").with_changes(seed=5))
    assert made == [simulator]
    fresh = Simulator(scenario)
    for sim in (simulator, fresh):
        sim.rov.release()
        sim.rov.set_effort(surge=0.5)
        sim.advance(1.0)
    assert simulator.save_state() == fresh.save_state()
    assert (simulator.rov.sonar.ping().ranges_m == fresh.rov.sonar.ping().ranges_m).all()
    assert prepared.release(scenario) is not simulator  # it is handed out only once
    prepared.close()


def test_another_choice_takes_the_place_of_the_prepared_one_and_does_not_wait_for_it():
    first, second = load("pool"), load("pool").with_changes(seed=8)
    begun, may_go = threading.Event(), threading.Event()

    def make(scenario):
        if scenario.seed == first.seed:
            begun.set()
            assert may_go.wait(60.0)
        return Simulator(scenario)

    prepared = Prepared(make)
    try:
        prepared.prepare(first)
        assert begun.wait(60.0)
        prepared.prepare(second)  # queued
        assert prepared.release(second).seed == 8
    finally:
        may_go.set()
        prepared.close()


def test_what_cannot_be_made_says_so_when_it_is_taken():
    def make(scenario):
        raise ValueError("no such lake")

    prepared = Prepared(make)
    prepared.prepare(load("pool"))
    with pytest.raises(ValueError, match="no such lake"):
        prepared.release(load("pool"))
    prepared.close()
