"""Encoders and motors' current sensors read the truth with the errors of the vehicle's file, and no others."""

from math import sqrt
from typing import Any

import numpy as np
import pytest
from scipy.stats import chi2, kstest

from channel_tools import table
from sites import flat, rov
from uwsim import Simulator
from uwsim.scenario import Scenario, ScenarioError

QUANTUM_RAD, STD_RAD_S, TURN_ON_A, TORQUE_NM_A = 0.01, 0.02, 0.5, 2.0
ERRORS = {"position": {"quantum": QUANTUM_RAD}, "speed": {"std": STD_RAD_S}, "current": {"turn_on_std": TURN_ON_A}}
STEPS = 800


def site(errors: dict[str, Any] | None = ERRORS, **changes: Any) -> Scenario:
    motor = {"strongest_nm": 20, "fastest_deg_s": 20, "torque_per_ampere_nm_a": TORQUE_NM_A}
    link = {
        "position_m": [0.3, 0, 0],
        "hinge": {"axis": [0, 1, 0], "motor": motor} | ({} if errors is None else {"errors": errors}),
        "mass_kg": 1.0, "centre_of_mass_m": [0.2, 0, 0], "inertia_kg_m2": [0.01, 0.01, 0.01],
    }  # fmt: skip
    plain = {**link, "position_m": [0, 0, 0.2], "hinge": {"axis": [0, 1, 0], "motor": motor}}
    model = {"builds_on": "bluerov2_heavy", "name": "boom", "arm": {"boom": link, "plain": plain}}
    return flat(rov(model), bed_m=-12.0, **changes)


def test_each_error_is_as_stated_and_the_truth_stays() -> None:
    with Simulator(site()) as sim, Simulator(site(None)) as other:
        off, currents = [], set()
        for each in (sim, other):
            each.rov.set_joints(speeds={"boom": 0.3, "plain": -0.2})
        for _ in range(STEPS):
            sim.step()
            other.step()
            true, now = sim.rov.arm.read(), sim.rov.arm.measure()
            assert (true.positions == other.rov.arm.read().positions).all()
            assert now.positions[0] == pytest.approx(true.positions[0], abs=0.5001 * QUANTUM_RAD)
            assert now.positions[0] / QUANTUM_RAD == pytest.approx(round(now.positions[0] / QUANTUM_RAD), abs=1e-9)
            off.append(now.speeds[0] - true.speeds[0])
            currents.add(round(now.currents_a[0] - true.currents_a[0], 9))
            assert now.motor_torques[0] == pytest.approx(TORQUE_NM_A * now.currents_a[0])
            for values in ("positions", "speeds", "motor_torques", "currents_a"):
                assert getattr(now, values)[1] == getattr(true, values)[1], "of a joint without errors"
        low, high = (STD_RAD_S * sqrt(chi2.ppf(share, STEPS) / STEPS) for share in (1e-4, 1 - 1e-4))
        assert low < np.std(off) < high
        assert kstest(np.array(off) / STD_RAD_S, "norm").pvalue > 1e-4
        assert len(currents) == 1, "constant in a run"
        assert 1e-3 < abs(currents.pop()) < 4 * TURN_ON_A
        exact = other.rov.arm
        assert (exact.measure().positions == exact.read().positions).all()


def test_a_sample_is_the_same_however_often_it_is_read_and_differs_between_seeds() -> None:
    with Simulator(site()) as sim, Simulator(site(), seed=5) as other:
        sim.advance(0.2)
        other.advance(0.2)
        state, first = sim.save_state(), sim.rov.arm.measure()
        sim.advance(0.3)
        sim.restore_state(state)
        again = sim.rov.arm.measure()
        assert (again.speeds == first.speeds).all()
        assert again.currents_a[0] == first.currents_a[0]
        assert other.rov.arm.measure().speeds[0] != first.speeds[0]


def test_joint_states_has_what_is_measured() -> None:
    with Simulator(site()) as sim:
        sim.rov.set_joints(speeds={"boom": 0.3})
        sim.advance(1.0)
        message = table(sim)["joint_states"].read(sim)
        now = sim.rov.arm.measure()
        at = [name.rsplit("/", 1)[-1] for name in message.name].index("boom")
        assert message.position[at] == now.positions[0] != sim.rov.arm.read().positions[0]
        assert message.velocity[at] == now.speeds[0]


def test_errors_with_a_memory_are_refused() -> None:
    with pytest.raises(ScenarioError, match=r"boom.hinge.errors.speed.walk = 0.1: must be 0 for a joint"):
        site({"speed": {"walk": 0.1}})
