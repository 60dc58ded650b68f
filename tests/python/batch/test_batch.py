"""Each member of a batch equals, to the last bit, the single simulator with its seed and parameters."""

from __future__ import annotations

import copy
import warnings
from typing import Any

import numpy as np
import pytest

from sites import gusty_pool
from uwsim import Batch, DockedWarning, Scenario, Simulator
from uwsim.scenario import load

SEEDS = (3, 11, 4)
CHANGES: tuple[dict[str, Any], ...] = (
    {},
    {"rov.drag.linear.surge": 60.0},
    {"rov.mass_kg": 290.0, "water.current_world_m_s": [0.2, -0.1, 0.0]},
)
STARTS = np.array([[0.0, 0.0, -2.0], [5.0, 2.0, -4.0], [-3.0, 3.0, -1.5]])
EFFORTS = np.linspace(-0.9, 0.9, 18).reshape(3, 6)
STEPS, STEPS_NS = 50, 250_000_000  # short, since waves are expensive, but long enough for every sensor to measure
SENSORS = ("imu", "depth", "dvl")


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Scenario:
    return load(gusty_pool(tmp_path_factory.mktemp("batch")))


def flown(scenario: Scenario, k: int) -> Simulator:
    sim = Simulator(scenario, seed=SEEDS[k], threads=1)
    if CHANGES[k]:
        sim.parameters.update(CHANGES[k])
    sim.rov.place(STARTS[k])
    sim.rov.set_effort(*EFFORTS[k])
    sim.step(STEPS)
    return sim


def the_batch(scenario: Scenario, threads: int) -> Batch:
    batch = Batch(scenario, n=3, seeds=SEEDS, parameters=CHANGES, threads=threads)
    batch.place(STARTS)
    batch.step(STEPS, EFFORTS)
    return batch


@pytest.mark.parametrize("threads", [1, 2])
def test_a_member_gives_the_bytes_of_the_lone_simulator_of_its_seed(scenario: Scenario, threads: int) -> None:
    batch = the_batch(scenario, threads)
    motion = batch.observe()
    samples = {name: copy.deepcopy(batch.read(name)) for name in SENSORS}
    pings = batch.ping()
    for k in range(3):
        sim = flown(scenario, k)
        rov, ping = sim.rov, sim.rov.sonar.ping()
        assert motion.time_ns[k] == sim.time_ns
        assert motion.position_world_m[k].tobytes() == rov.pose.position_world_m.tobytes()
        assert motion.orientation_xyzw[k].tobytes() == rov.pose.orientation_xyzw.tobytes()
        assert motion.velocity_body[k, :3].tobytes() == rov.velocity.linear_body_m_s.tobytes()
        assert motion.velocity_body[k, 3:].tobytes() == rov.velocity.angular_body_rad_s.tobytes()
        assert samples["depth"].fields["depth_m"][k] == rov.sensors["depth"].read()
        imu = rov.sensors["imu"].read()
        assert samples["imu"].fields["angular_velocity_rad_s"][k].tobytes() == imu.angular_velocity_rad_s.tobytes()
        assert samples["dvl"].stamp_ns[k] == rov.sensors["dvl"].sample().stamp_ns
        for name in ("ranges_m", "points_sonar_m", "incidence_rad", "intensity_db", "labels", "valid"):
            assert getattr(pings, name)[k].tobytes() == getattr(ping, name).tobytes(), name
        assert pings.world_from_sonar[k].tobytes() == ping.world_from_sonar.tobytes()
        assert batch.simulator(k).save_state() == sim.save_state()
    assert np.isfinite(pings.ranges_m).any()


def test_a_member_after_one_with_equal_parameters_has_its_own_seed(scenario: Scenario) -> None:
    batch = Batch(scenario, n=2, seeds=(4, SEEDS[1]), parameters=CHANGES[1], threads=1)
    batch.place(STARTS[1])
    batch.step(STEPS, np.tile(EFFORTS[1], (2, 1)))
    assert batch.simulator(1).save_state() == flown(scenario, 1).save_state()


def test_a_reset_of_some_leaves_the_others_alone(scenario: Scenario) -> None:
    batch, other = the_batch(scenario, 2), the_batch(scenario, 1)
    batch.reset(np.array([False, True, False]))
    assert batch.observe().time_ns.tolist() == [STEPS_NS, 0, STEPS_NS]
    batch.place(STARTS, mask=[False, True, False])
    batch.step(STEPS, EFFORTS)
    other.step(STEPS)
    assert batch.observe().position_world_m[[0, 2]].tobytes() == other.observe().position_world_m[[0, 2]].tobytes()
    assert batch.simulator(1).save_state() == flown(scenario, 1).save_state()


def test_a_reset_gives_other_seeds_and_parameters_to_the_masked(scenario: Scenario) -> None:
    batch = Batch(scenario, n=3, seeds=[8, 9, 10])
    batch.reset([True, False, True], seeds=SEEDS, parameters=CHANGES)
    assert batch.seeds == (3, 9, 4)
    assert [dict(one) for one in batch.parameters] == [CHANGES[0], {}, CHANGES[2]]
    batch.place(STARTS)
    batch.step(STEPS, EFFORTS)
    assert batch.simulator(2).save_state() == flown(scenario, 2).save_state()


def test_arrays_belong_to_the_batch_and_are_read_only(scenario: Scenario) -> None:
    batch = Batch(scenario, n=2)
    for look in (batch.observe, batch.ping, lambda: batch.read("imu")):
        first = look()
        arrays = [array for array in vars(first).values() if isinstance(array, np.ndarray)]
        assert look() is first
        assert arrays
        assert not any(array.flags.writeable for array in arrays)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda b: b.step(1, np.zeros((3, 6))), r"efforts.shape = \(3, 6\): expected \(2, 6\)"),
        (lambda b: b.step(1, [[0] * 6, [0, 0, 2, 0, 0, 0]]), r"efforts\[1\].heave = 2: must be in \[-1, 1\]"),
        (lambda b: b.step(1, np.full((2, 6), np.nan)), r"efforts\[0\].surge = .*nan: must be in"),
        (lambda b: b.step(-1), "n = -1: must be a whole number"),
        (lambda b: b.step(1, {"rvo": np.zeros((2, 6))}), "vehicle = 'rvo': must be one of rov"),
        (lambda b: b.read("sonor"), r"rov.sensors\['sonor'\]: must be one of "),
        (lambda b: b.reset([1, 0]), r"mask: int64 \(2,\): expected bool \(2,\)"),
        (lambda b: b.reset(seeds=[1]), "seeds: 1 of them: expected n = 2"),
        (lambda b: b.reset(seeds=[1, -2]), r"seeds\[1\] = -2: must be a whole number"),
        (lambda b: b.reset(parameters=[{}, {"rov.mass": 1}]), r"batch\[1\]: .*rov\.mass"),
        (lambda b: b.reset(parameters={"rov.mass_kg": -1}), r"batch\[0\]: rov\.mass_kg"),
        (lambda b: b.place([[0, 0, -2], [0, 0, -1e4]]), r"batch\[1\]: .*must be above the ground"),
        (lambda b: b.simulator(2), "member = 2: must be a whole number"),
    ],
)
def test_mistakes_are_named(scenario: Scenario, call: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call(Batch(scenario, n=2))


def test_where_one_diverges_the_others_make_their_steps(scenario: Scenario) -> None:
    light = {"rov.drag.quadratic.surge": 1e6, "rov.drag.quadratic.sway": 1e6, "rov.drag.quadratic.heave": 1e6}
    batch = Batch(scenario, n=3, seeds=SEEDS, parameters=[{}, light, {}])
    batch.place(STARTS, velocity_body=[[0] * 6, [90, 90, 0, 0, 0, 0], [0] * 6])
    with pytest.raises(ValueError, match=r"batch\[1\]: vehicle 'rov', step \d+: .*diverged"):
        batch.step(20)
    times = batch.observe().time_ns.tolist()
    assert times[0] == times[2] == 100_000_000 > times[1]
    batch.reset([False, True, False], parameters={})
    batch.step(20)
    assert batch.observe().time_ns.tolist() == [200_000_000, 100_000_000, 200_000_000]


@pytest.mark.parametrize("arguments", [{"n": 0}, {"n": 2.0}, {"n": 1, "threads": 0}, {"n": 2, "parameters": [{}]}])
def test_a_batch_that_cannot_be_is_refused(scenario: Scenario, arguments: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=r"must be|expected"):
        Batch(scenario, **arguments)


@pytest.mark.parametrize(
    "command", [lambda b: b.set_effort(np.full((2, 6), 0.1)), lambda b: b.set_wrench([10.0, 0.0, 0.0])]
)
def test_commands_to_docked_vehicles_are_warned_of_when_time_passes(command: Any) -> None:
    batch = Batch("pool", n=2)
    command(batch)
    with pytest.warns(DockedWarning, match="docked in some members"):
        batch.step(2)
    batch.release()
    assert batch.observe().released.all()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        batch = Batch("pool", n=2)
        command(batch)
        batch.release()
        batch.step(2)


def test_a_saved_member_continues_in_a_member_of_another_batch_with_its_seed_parameters_and_faults() -> None:
    faults = [{"kind": "leak", "kg_per_s": 0.05, "at_s": 0.2}]
    batch = Batch("pool", n=2, seeds=[5, 6], parameters=[{}, {"rov.mass_kg": 290.0}], faults=[[], faults], threads=1)
    batch.place([0.0, 0.0, -2.0])
    batch.step(60, np.full((2, 6), 0.2))
    state = batch.save_state(1)
    changes = [{}, {}, {"rov.mass_kg": 290.0}]
    other = Batch("pool", n=3, seeds=[0, 1, 6], parameters=changes, faults=[[], [], faults], threads=2)
    other.restore_state(2, state)
    for each in (batch, other):
        each.step(60)
    assert batch.save_state(1) == other.save_state(2) != state
    assert [event.name for event in other.aboard(2).events] == [event.name for event in batch.aboard(1).events] != []
    with pytest.raises(ValueError, match="member = 3"):
        other.restore_state(3, state)
    before = other.save_state(0)
    for bad in (b"", state, state[:-8], Batch("lake", n=1).save_state(0)):
        with pytest.raises(ValueError, match=r"\w"):
            other.restore_state(0, bad)
    assert other.save_state(0) == before
