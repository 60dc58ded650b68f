"""The station's responsiveness: a simulator is prepared before Start, and pictures are as large as time permits."""

import itertools
import threading
from collections import Counter, deque
from concurrent.futures import Future
from unittest.mock import Mock

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.channels.table import Table
from uwsim.operator.station.start.prepared import Prepared
from uwsim.operator.station.views.picture_size import LEAST_BEHIND, PATIENCE, SHARES, Fit
from uwsim.operator.station.views.views import SMALL_PATIENCE_S, Views
from uwsim.scenario import load


def shown(fit, pictures, full_s, **options):
    """Return the share after as many pictures, whose whole size takes full_s."""
    for _ in range(pictures):
        fit.note(full_s * fit.share**2, 0.1, **options)
    return fit.share


def test_pictures_shrink_until_they_keep_their_rate_and_grow_again():
    fit = Fit()
    assert shown(fit, 40, 0.24) == SHARES[-1]  # 60 ms
    assert shown(fit, 2 * PATIENCE, 0.11) == 0.75  # 62 ms; the full size would be too slow
    assert shown(fit, 2 * PATIENCE, 0.04) == 1.0


def test_pictures_are_larger_and_more_frequent_only_where_they_slow_nothing():
    fit = Fit()
    assert shown(fit, 10 * PATIENCE, 0.015, has_room=False) == 1.0, "there is time, but the steps would be slower"
    assert shown(fit, 2 * PATIENCE, 0.015, has_room=True) == 1.5 and fit.is_large  # 34 ms of 67 ms
    assert shown(fit, 4, 0.015, has_room=False) == 1.0, "as soon as the steps do not keep their pace"
    assert shown(fit, 10 * PATIENCE, 0.025, has_room=True) == 1.0  # 56 ms of 67 ms would be too long


def test_pictures_shrink_while_the_steps_are_behind():
    fit = Fit()
    shown(fit, LEAST_BEHIND - 1, 0.03, is_behind=True)
    assert shown(fit, 1, 0.03, is_behind=False) == 1.0, "a moment's delay changes nothing"
    assert shown(fit, LEAST_BEHIND, 0.03, is_behind=True) == 0.75
    assert shown(fit, 10 * LEAST_BEHIND, 0.03, is_behind=True) == SHARES[-1]
    assert shown(fit, 10 * PATIENCE, 0.03, is_behind=False) == 1.0


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


def made(wanted, took_s, for_s=20.0):
    """Return how many pictures of wanted views, (name, large or small), are made in a time of the test's own clock."""
    sim = Simulator("pool")
    live = Mock(is_behind=True, **{"read.side_effect": lambda snapshot: done(), "simulator.vehicles": sim.vehicles})
    views = Views(Mock(simulator=sim), Table(sim), Mock(), Mock())
    asked = {getattr(views.views[name], size).topic: size for name, size in wanted}
    begun, queue, counts, ready_s = [], deque(), Counter(), 0.0
    views._live, views._node, views._pictures = live, Mock(), Mock()
    views._node.is_wanted.side_effect = asked.__contains__
    views._pictures.submit.side_effect = lambda make: begun.append(Future()) or begun[-1]
    streams = {stream.topic: stream for stream in views._streams()}
    for now_s in np.arange(1.0, 1.0 + for_s, 0.05):
        live.simulator.version = now_s
        before = {topic: streams[topic].begun_s for topic in asked}
        views.beat(now_s)
        queue += [topic for topic in asked if streams[topic].begun_s != before[topic]]
        if queue and now_s >= ready_s + took_s[asked[queue[0]]]:  # one worker makes them in the order of their begin
            counts[queue.popleft()] += 1
            begun.pop(0).set_result(None)
            ready_s = now_s
    return [counts[topic] for topic in asked]


def done():
    future = Future()
    future.set_result(None)
    return future


@pytest.mark.parametrize("took_s", [{"large": 1.6, "small": 0.4}, {"large": 0.05, "small": 0.01}], ids=["slow", "fast"])
def test_no_view_starves_another_however_long_pictures_take(took_s):
    wanted = [("front", "large"), ("down", "large"), ("front", "small"), ("down", "small")]
    front, down, first, second = made(wanted, took_s)
    assert abs(front - down) <= 1 and abs(first - second) <= 1
    assert min(first, second) >= min(0.4 * front, 20.0 / (2 * SMALL_PATIENCE_S)) - 1


def test_what_is_prepared_is_what_would_be_made_and_what_cannot_be_made_says_so():
    scenario = load("pool").with_changes(seed=5)
    made = []

    def make(scenario):
        if scenario.seed != 5:
            raise ValueError("no such lake")
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
    prepared.prepare(load("pool"))
    with pytest.raises(ValueError, match="no such lake"):
        prepared.release(load("pool"))
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
