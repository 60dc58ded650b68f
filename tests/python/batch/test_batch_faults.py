"""Faults of a batch member, and its vehicle's reactions, equal those of a single simulator to the last bit."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

from uwsim import Batch, Scenario, Simulator
from uwsim.scenario import load
from uwsim.scenario.spec.battery import Failsafe
from uwsim.simulator.helm import FailsafeWarning

N = 3
SEEDS = (3, 11, 4)
STARTS = np.array([[0.0, 0.0, -2.0], [5.0, 2.0, -4.0], [-3.0, 3.0, -1.5]])
EFFORTS = np.linspace(-0.9, 0.9, 18).reshape(N, 6)
SCHEDULED: list[dict[str, Any]] = [
    {"kind": "sensor", "sensor": "depth", "mode": "stuck", "at_s": 0.2},
    {"kind": "sensor", "sensor": "imu", "mode": "bias", "field": "angular_velocity_rad_s", "bias": 0.5, "at_s": 0.4},
    {"kind": "current", "velocity_world_m_s": [0.3, 0.0, 0.0], "at_s": 0.35, "for_s": 0.5},
]
BY_CHANCE: list[dict[str, Any]] = [
    {"kind": "leak", "kg_per_s": 1.0, "rate_per_h": 20000.0, "for_s": 0.3},
    {"kind": "battery", "thrust": 0.5, "rate_per_h": 20000.0, "for_s": 0.1},
    {"kind": "sensor", "sensor": "dvl", "at_s": 0.1},
    {"kind": "sonar", "at_s": 0.3},
    {"kind": "camera", "camera": "front", "at_s": 0.5},
]
FAULTS = (SCHEDULED, BY_CHANCE, [])
CHANGES: tuple[dict[str, Any], ...] = ({}, {"rov.mass_kg": 290.0, "rov.max_force_n.x": 60.0}, {"rov.ballast_kg": 1.0})
GUARD = Failsafe(silence_s=0.9, then="surface", leak_then="hold", sensor_then="hold")


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    """The pool, with a failsafe on its vehicle."""
    pool = load("pool")
    return pool.model_copy(update={"vehicles": (pool.vehicles[0].model_copy(update={"failsafe": GUARD}),)})


def lone(scenario: Scenario, k: int) -> Simulator:
    faulty = Batch(scenario, n=1, faults=FAULTS[k]).faults[0]
    sim = Simulator(scenario.model_copy(update={"faults": faulty}), seed=SEEDS[k], threads=1)
    if CHANGES[k]:
        sim.parameters.update(CHANGES[k])
    sim.rov.place(STARTS[k])
    for efforts in (EFFORTS, None, -EFFORTS):
        if efforts is not None:
            sim.rov.set_effort(*efforts[k])
        sim.step(230)
    return sim


def flown(scenario: Scenario, threads: int) -> Batch:
    batch = Batch(scenario, n=N, seeds=SEEDS, parameters=CHANGES, faults=FAULTS, threads=threads)
    batch.place(STARTS)
    for efforts in (EFFORTS, None, -EFFORTS):
        batch.step(230, efforts)
    return batch


@pytest.mark.filterwarnings("ignore::uwsim.simulator.helm.FailsafeWarning")
def test_a_member_fails_as_the_lone_simulator_does_whatever_the_number_of_threads(scenario: Scenario) -> None:
    batch, other = flown(scenario, 1), flown(scenario, 2)
    happened = set()
    for k in range(N):
        sim = lone(scenario, k)
        assert list(batch.aboard(k).events) == list(sim.events)
        happened |= {(event.name, event.values.get("kind", event.values.get("cause"))) for event in sim.events}
        for name, sensor in sim.rov.sensors.items():
            for noise in (True, False):
                told, sample = batch.read(name, noise=noise), sensor.sample(noise=noise)
                values = [np.ravel(getattr(sample.value, field, sample.value)) for field in told.fields]
                np.testing.assert_array_equal(told.values[k], np.concatenate(values), err_msg=name)
                assert told.valid[k] == sample.valid
        assert batch.ping().ranges_m[k].tobytes() == sim.rov.sonar.ping().ranges_m.tobytes()
        assert batch.simulator(k).save_state() == other.simulator(k).save_state() == sim.save_state()
        assert list(other.aboard(k).events) == list(sim.events)
    assert batch.ping().valid.any(axis=1).tolist() == [True, False, True]
    kinds = ("leak", "battery", "sensor", "sonar", "camera", "current")
    assert {("fault", kind) for kind in kinds} | {("failsafe", "silence"), ("failsafe", "leak")} <= happened


def test_how_many_steps_are_made_at_once_does_not_matter(scenario: Scenario) -> None:
    states = []
    for parts in ((300,), (1, 199, 7, 93)):
        batch = Batch(scenario, n=2, faults=BY_CHANCE)
        batch.place(STARTS[0])
        for steps in parts:
            batch.step(steps)
        states.append([batch.simulator(k).save_state() for k in range(2)])
    assert states[0] == states[1]


def test_a_reset_mends_and_draws_anew(scenario: Scenario) -> None:
    batch = Batch(scenario, n=2, faults=[SCHEDULED, []])
    first = batch.aboard(0)
    batch.step(100)
    assert first.faults.active == ("sensor", "sensor_2", "current")
    batch.reset([True, False])
    assert batch.aboard(0) is not first
    assert batch.aboard(0).faults.active == ()
    batch.step(100)
    assert batch.aboard(0).faults.active == first.faults.active
    batch.reset(faults=[])
    batch.step(100)
    assert [list(batch.aboard(k).events) for k in range(2)] == [[], []]
    assert batch.read("depth").valid.all()


def test_a_fault_is_injected_into_a_member_and_its_failsafe_overridden(scenario: Scenario) -> None:
    batch = Batch(scenario, n=2)
    batch.release()
    batch.step(20, np.zeros((2, 6)))
    aboard = batch.aboard(1)
    aboard.faults.inject("leak", kg_per_s=0.5, for_s=1.0)
    batch.step(400)
    assert aboard.failsafes["rov"].cause == "leak"
    with pytest.warns(FailsafeWarning, match="its failsafe steers"):
        batch.step(1, np.full((2, 6), 0.1))
    aboard.failsafes["rov"].override()
    assert aboard.failsafes["rov"].state == ""
    silence = [(event.name, event.values["cause"]) for event in batch.aboard(0).events]
    assert silence == [("failsafe", "silence"), ("failsafe_ends", "silence")]


def test_a_sensor_that_is_switched_off_tells_nothing() -> None:
    batch = Batch("pool", n=3, parameters=[{}, {"rov.sensors.depth.on": False}, {}])
    batch.step(20)
    told = batch.read("depth")
    assert told.valid.tolist() == [True, False, True]
    assert np.isnan(told.values[:, 0]).tolist() == [False, True, False]
    batch.reset(parameters={})
    assert batch.read("depth").valid.all()


def test_where_one_diverges_those_with_faults_make_their_steps(scenario: Scenario) -> None:
    light = {f"rov.drag.quadratic.{axis}": 1e6 for axis in ("surge", "sway", "heave")}
    batch = Batch(scenario, n=N, seeds=SEEDS, parameters=[{}, light, {}], faults=FAULTS)
    batch.place(STARTS, velocity_body=[[0] * 6, [90, 90, 0, 0, 0, 0], [0] * 6])
    with pytest.raises(ValueError, match=r"batch\[1\]: vehicle 'rov', step \d+: .*diverged"):
        batch.step(200)
    times = batch.observe().time_ns.tolist()
    assert times[0] == times[2] == 1_000_000_000 > times[1]


@pytest.mark.parametrize(
    ("faults", "message"),
    [
        ([{"kind": "sensor", "sensor": "imv", "at_s": 1}], r"batch\[0\]: faults\[0\]: sensor = 'imv': must be one of"),
        ([[], [{"kind": "leek"}]], r"batch\[1\]: faults\[0\]"),
        ([[], [], []], r"faults: 3 lists: expected one, or n = 2"),
        ({"kind": "leak"}, "faults is dict: must be a list"),
    ],
)
def test_wrong_faults_are_refused_and_change_nothing(scenario: Scenario, faults: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Batch(scenario, n=2, faults=faults)
    batch = Batch(scenario, n=2, faults=SCHEDULED)
    batch.step(10)
    with pytest.raises(ValueError, match=message):
        batch.reset(faults=faults)
    assert batch.observe().time_ns.tolist() == [50_000_000] * 2
    assert len(batch.faults[0]) == len(SCHEDULED)


def test_the_loss_of_a_link_that_is_not_there_is_warned_of() -> None:
    lost = [{"kind": "link", "at_s": 0.1}]
    with pytest.warns(UserWarning, match="without a link in the scenario"):
        batch = Batch("pool", n=1, faults=lost)
    batch.step(60)
    assert [event.name for event in batch.aboard(0).events] == ["fault"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Simulator(load("pool").model_copy(update={"faults": batch.faults[0]}))  # the vehicle that channels may command
        Batch(Simulator("pool", link="ideal_acoustic").scenario, n=1, faults=lost)


def test_pings_in_physics_mode_are_those_of_the_lone_simulator() -> None:
    physics = {"rov.sonar.mode": "physics"}
    batch = Batch("pool", n=2, seeds=SEEDS[:2], parameters=physics)
    batch.place(STARTS[:2])
    batch.step(50, EFFORTS[:2])
    pings = batch.ping()
    for k in range(2):
        sim = Simulator("pool", seed=SEEDS[k], threads=1)
        sim.parameters.update(physics)
        sim.rov.place(STARTS[k])
        sim.rov.set_effort(*EFFORTS[k])
        sim.step(50)
        ping = sim.rov.sonar.ping()
        for name, rows in vars(pings).items():
            assert rows[k].tobytes() == getattr(ping, name).tobytes(), name
    batch.reset([True, False], parameters={})
    with pytest.raises(ValueError, match=r"rov\.sonar\.mode: another in batch\[1\]"):
        batch.ping()
