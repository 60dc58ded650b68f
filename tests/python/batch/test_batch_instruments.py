"""Commands and instruments of batch member k equal those of a single simulator with its seed, to the last bit."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from uwsim import Batch, Simulator
from uwsim.navigation.control import Autopilot, Controller, PathFollower
from uwsim.scenario import load, load_vehicle
from uwsim.scenario.spec.vehicle_entry import VehicleEntry
from uwsim.simulator.helm import AllStopWarning

SEEDS = (3, 11)
CHANGES: tuple[dict[str, Any], ...] = ({}, {"rov.mass_kg": 290.0, "optics.jerlov": "5C", "rov.drag.linear.surge": 60.0})
STARTS = np.array([[0.0, 0.0, -2.0], [5.0, 2.0, -4.0]])
PATH = [[0.0, 0.0, -2.0], [3.0, 1.0, -2.5]]
HEADINGS = (0.4, -1.0)
PERIOD_STEPS = 10  # 0.05 s


@pytest.fixture(scope="module")
def batch() -> Batch:
    return Batch("pool", n=2, seeds=SEEDS, parameters=CHANGES, threads=2)


@pytest.fixture(scope="module")
def lone() -> list[Simulator]:
    return [Simulator("pool", seed=seed, threads=1) for seed in SEEDS]


def started(batch: Batch, lone: list[Simulator]) -> tuple[Batch, list[Simulator]]:
    """Return the batch and its members' simulators, all placed at their starts."""
    batch.reset()
    batch.place(STARTS)
    for sim, changes, start in zip(lone, CHANGES, STARTS, strict=True):
        sim.reset()
        if changes:
            sim.parameters.update(changes)
        sim.rov.place(start)
    return batch, lone


def step(batch: Batch, lone: list[Simulator], steps: int) -> None:
    batch.step(steps)
    for sim in lone:
        sim.step(steps)


def same_states(batch: Batch, lone: list[Simulator]) -> None:
    for k, sim in enumerate(lone):
        assert batch.save_state(k) == sim.save_state(), f"batch[{k}]"


STEERS: dict[str, tuple[Callable[[Any], Any], Callable[[Any, int], object]]] = {
    "hold": (
        Controller,
        lambda pilot, k: pilot.hold(
            STARTS[k] + [1.0, -0.5, 0.3], HEADINGS[k], pitch_rad=0.1, velocity_world_m_s=(0.05, 0.0, 0.0)
        ),
    ),
    "path": (lambda rov: PathFollower(Controller(rov), PATH, 0.9), lambda pilot, k: pilot.steer()),
    "autopilot": (Autopilot, lambda pilot, k: pilot.steer(HEADINGS[k], (0.3, 0.0), -2.5 - k)),
}
"""A pilot of a vehicle, and one period of it."""


@pytest.mark.parametrize("name", STEERS)
def test_controllers_aboard_steer_a_member_as_they_steer_the_lone_vehicle(
    batch: Batch, lone: list[Simulator], name: str
) -> None:
    started(batch, lone)
    make, steer = STEERS[name]
    pilots = [(make(batch.aboard(k).rov), make(sim.rov)) for k, sim in enumerate(lone)]
    for _ in range(20):
        for k, (member, alone) in enumerate(pilots):
            steer(member, k)
            steer(alone, k)
        step(batch, lone, PERIOD_STEPS)
    same_states(batch, lone)
    assert np.abs(batch.observe().velocity_body).max() > 0.05


def test_a_controller_acts_on_the_estimate_and_placing_restarts_it(batch: Batch, lone: list[Simulator]) -> None:
    started(batch, lone)
    rovs = [(batch.aboard(k).rov, sim.rov) for k, sim in enumerate(lone)]
    pilots = [[Controller(rov, estimate=rov.estimate) for rov in pair] for pair in rovs]
    for turn in range(8):
        if turn == 4:
            batch.place(STARTS + 0.5)
            for sim, start in zip(lone, STARTS, strict=True):
                sim.rov.place(start + 0.5)
        for k, pair in enumerate(pilots):
            for pilot in pair:
                pilot.hold(STARTS[k] + 1.0, HEADINGS[k])
        step(batch, lone, PERIOD_STEPS)
    found = batch.estimate()
    for k, sim in enumerate(lone):
        own = sim.rov.estimate
        assert found.position_world_m[k].tobytes() == own.pose.position_world_m.tobytes()
        assert found.covariance[k].tobytes() == own.covariance.tobytes()
        assert found.time_s[k] == own.time_s
    same_states(batch, lone)


def test_fins_thrusters_and_wrenches_are_those_of_the_lone_vehicle() -> None:
    pool = load("pool")
    torpedo = VehicleEntry(name="torpedo", model=load_vehicle("remus100"))
    scenario = pool.model_copy(update={"vehicles": (torpedo,)})
    batch, sims = Batch(scenario, n=2, seeds=SEEDS), [Simulator(scenario, seed=seed) for seed in SEEDS]
    fins, wrench = list(sims[0].rov.fins), [[5.0, 0.0, 0.0], [2.0, 0.0, 0.0]]
    (propeller,) = sims[0].rov.thrusters
    angles = {fins[0]: [0.1, -0.2], fins[-1]: 0.05}
    batch.place(STARTS)
    batch.set_thrusters({propeller: [0.5, 1.0]})
    batch.set_fins(angles)
    batch.step(50)
    batch.set_wrench(wrench)
    batch.step(20)
    for k, sim in enumerate(sims):
        sim.rov.place(STARTS[k])
        sim.rov.set_thrusters({propeller: (0.5, 1.0)[k]})
        sim.rov.set_fins({fins[0]: (0.1, -0.2)[k], fins[-1]: 0.05})
        sim.step(50)
        sim.rov.set_wrench(wrench[k])
        sim.step(20)
    same_states(batch, sims)
    assert abs(batch.aboard(1).rov.fins[fins[0]]) > 0.05


def test_imaging_sonars_hear_in_a_member_what_the_lone_one_hears(batch: Batch, lone: list[Simulator]) -> None:
    started(batch, lone)
    step(batch, lone, 3)
    lines, profiles = batch.image("side_scan"), batch.image("profiler", [-0.1, 0.2], with_labels=True)
    for k, sim in enumerate(lone):
        line, profile = sim.rov.imaging_sonars["side_scan"].line(), sim.rov.imaging_sonars["profiler"]
        assert lines[k].port_db.tobytes() == line.port_db.tobytes()
        alone = profile.profile([-0.1, 0.2], with_labels=True)
        assert profiles[k].level_db.tobytes() == alone.level_db.tobytes()
        assert profiles[k].labels.tobytes() == alone.labels.tobytes()
    assert lines[0].port_db.tobytes() != lines[1].port_db.tobytes()


def test_pictures_of_a_member_are_those_of_the_lone_simulator(batch: Batch, lone: list[Simulator]) -> None:
    started(batch, lone)
    batch.aboard(0).rov.lamps["front"].on = lone[0].rov.lamps["front"].on = True
    for rov in (batch.aboard(1).rov, lone[1].rov):
        rov.cameras["front"].aim(pan_rad=0.4, tilt_rad=0.2)
    efforts = np.array([[0.5, 0.1, 0.0, 0.0, 0.0, 0.3], [-0.4, 0.0, 0.2, 0.0, 0.0, 0.0]])
    batch.set_effort(efforts)
    for sim, effort in zip(lone, efforts.tolist(), strict=True):
        sim.rov.set_effort(*effort)
    step(batch, lone, 100)
    for camera, effects in (("front", "on"), ("down", ["attenuation", "noise", "lamps"]), ("chase", "off")):
        pictures = batch.capture(camera, effects, size=(30, 50))
        for picture, sim in zip(pictures, lone, strict=True):
            alone = sim.rov.cameras[camera].resized(50, 30).capture(effects)
            np.testing.assert_array_equal(picture, alone.rgb, err_msg=camera)
    assert pictures.std() > 1


def test_a_camera_that_is_off_is_black_in_its_member_only(batch: Batch) -> None:
    batch.reset()
    batch.aboard(1).parameters["rov.cameras.front.on"] = False
    pictures = batch.capture("front", "off", size=(6, 8))
    assert pictures[0].any() and not pictures[1].any()


def test_a_member_continues_from_the_state_of_a_simulator(batch: Batch, lone: list[Simulator]) -> None:
    started(batch, lone)
    step(batch, lone, 5)
    lone[1].rov.set_effort(surge=0.7)
    lone[1].step(200)
    later = lone[1].save_state()
    batch.restore_state(1, later)
    np.testing.assert_allclose(batch.time_s, [0.025, 1.025], rtol=1e-12)
    step(batch, lone, 50)
    same_states(batch, lone)
    with pytest.raises(ValueError, match=r"batch\[0\]: .*scenario"):
        batch.restore_state(0, later)
    same_states(batch, lone)


def test_all_stop_overrides_every_command_of_a_member(batch: Batch, lone: list[Simulator]) -> None:
    started(batch, lone)
    efforts = np.full((2, 6), 0.3)
    batch.step(20, efforts)
    batch.all_stop(mask=[True, False])
    with pytest.warns(AllStopWarning):
        batch.step(100, efforts)
    batch.set_wrench([20.0, 0.0, 0.0])
    batch.step(10)
    for k, sim in enumerate(lone):
        sim.rov.set_effort(*efforts[k].tolist())
        sim.step(20)
        if k == 0:
            sim.rov.all_stop()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", AllStopWarning)
            sim.rov.set_effort(*efforts[k].tolist())
            sim.step(100)
            sim.rov.set_wrench([20.0, 0.0, 0.0])
            sim.step(10)
    same_states(batch, lone)
    assert [batch.aboard(k).rov.all_stopped for k in range(2)] == [True, False]
    batch.all_stop(False)
    batch.step(20, efforts)
    lone[0].rov.all_stop(False)
    lone[1].rov.all_stop(False)
    for k, sim in enumerate(lone):
        sim.rov.set_effort(*efforts[k].tolist())
        sim.step(20)
    same_states(batch, lone)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda b: b.set_fins({"rudder": 0.1}), r"fins\['rudder'\]: there are none"),
        (lambda b: b.set_thrusters({"front_lft": 0.1}), r"thrusters\['front_lft'\]: "),
        (lambda b: b.set_wrench([[0, 0, 0], [0, np.nan, 0]]), r"force_body_n\[1\]\[1\] = nan: must be finite"),
        (lambda b: b.capture("frnt"), r"cameras\['frnt'\]: must be one of"),
        (lambda b: b.capture("front", size=(0, 8)), "size: height = 0: must be a whole number"),
        (lambda b: b.image("sonr"), r"imaging_sonars\['sonr'\]: must be one of"),
        (lambda b: b.aboard(0).step(), "advanced by Batch.step"),
    ],
)
def test_mistakes_are_named(batch: Batch, call: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call(batch)
