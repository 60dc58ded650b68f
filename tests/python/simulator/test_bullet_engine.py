"""Bullet's own dynamics as the engine of a simulator: it flies alike and continues saved states."""

from contextvars import copy_context
from pathlib import Path

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.evidence.validate import run_suite
from uwsim.evidence.validate.flights import ENGINE, deep_scenario
from uwsim.scenario import Scenario, ScenarioError, load, load_vehicle


def pool(engine: str) -> Scenario:
    data = load("pool").given()
    return Scenario.model_validate({**data, "dynamics": {"engine": engine}})


def flown(sim: Simulator) -> bytes:
    """Let the vehicle sink onto the bed and slide along it; return the final state."""
    sim.rov.release()
    sim.rov.set_effort(surge=0.6, heave=-0.8, yaw=-0.1)
    sim.advance(6.0)
    return sim.save_state()


def test_both_engines_fly_alike_and_touch_the_bed() -> None:
    ours, bullets = Simulator(pool("uwsim"), seed=5), Simulator(pool("bullet"), seed=5)
    for sim in (ours, bullets):
        sim.rov.release()
        sim.rov.set_effort(surge=0.4)
        sim.advance(2.0)
    apart_m = np.linalg.norm(np.subtract(ours.rov.pose.position_world_m, bullets.rov.pose.position_world_m))
    assert 0 < apart_m < 0.15
    flown(bullets)
    assert bullets.rov.collisions > 0


def test_a_saved_state_continues_to_the_last_bit_and_a_reset_starts_again() -> None:
    sim = Simulator(pool("bullet"), seed=5)
    state = flown(sim)
    assert sim.rov.collisions > 0
    other = Simulator(pool("bullet"), seed=5)
    other.restore_state(state)
    for each in (sim, other):
        each.advance(1.0)
    end = sim.save_state()
    assert other.save_state() == end
    sim.reset()
    assert flown(sim) == state


def test_a_changed_mass_keeps_the_engine() -> None:
    sim = Simulator(pool("bullet"), seed=5)
    sim.parameters["rov.mass_kg"] = 1.5 * sim.parameters["rov.mass_kg"]
    sim.rov.release()
    before_m = sim.rov.pose.position_world_m[2]
    sim.advance(2.0)
    assert sim.rov.pose.position_world_m[2] < before_m - 0.2
    assert sim.scenario.dynamics.engine == "bullet"


def test_a_state_of_the_other_engine_is_refused() -> None:
    state = Simulator(pool("bullet"), seed=5).save_state()
    with pytest.raises(ValueError, match="scenario"):
        Simulator(pool("uwsim"), seed=5).restore_state(state)


def test_an_unknown_engine_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "other.yaml"
    path.write_text(
        "name: other\ndynamics: {engine: havok}\nterrain: {source: noise, size_m: [20, 20], bed_depth_m: 9}\n"
        "vehicles: [{name: rov, model: rov}]\n"
    )
    with pytest.raises(ScenarioError, match=r"dynamics\.engine = .?havok.?: "):
        load(path)


def test_validation_runs_with_the_chosen_engine() -> None:
    context = copy_context()
    context.run(ENGINE.set, "bullet")
    assert context.run(deep_scenario, load_vehicle("rov")).dynamics.engine == "bullet"
    with pytest.raises(ValueError, match="unknown"):
        run_suite("flight", engine="bullet")
