"""A reset simulator equals a new one to the last bit, and keeps its vehicle objects."""

from pathlib import Path

import numpy as np
import pytest

from sites import gusty_pool
from uwsim import Simulator

FLIGHT = {"surge": 0.6, "heave": -0.2, "yaw": 0.3}


def flown(sim: Simulator) -> bytes:
    """Fly, ping and read sensors for one second; return the final state."""
    sim.rov.release()
    sim.rov.set_effort(**FLIGHT)
    sim.rov.sonar.aim(-0.3)
    sim.advance(1.0)
    return sim.save_state()


def test_it_flies_as_a_new_one_of_the_given_seed() -> None:
    sim, fresh = Simulator("pool", seed=5), Simulator("pool", seed=11)
    rov = sim.rov
    rov.lamps["front"].on = True
    sim.set_optics(jerlov="5C")
    flown(sim)
    sim.reset(11)
    assert (sim.tick, rov.released, rov.lamps["front"].on) == (0, False, False)
    assert (sim.seed, sim.optics) == (fresh.seed, fresh.optics)
    np.testing.assert_array_equal(rov.sonar.ping().ranges_m, fresh.rov.sonar.ping().ranges_m)
    assert flown(sim) == flown(fresh)
    for name, sensor in rov.sensors.items():
        got, expected = (str(own.sample()) for own in (sensor, fresh.rov.sensors[name]))
        assert got == expected
    picture, wanted = (s.rov.cameras["front"].capture() for s in (sim, fresh))
    np.testing.assert_array_equal(picture.rgb, wanted.rgb)


def test_waves_and_gusts_follow_the_seed(tmp_path: Path) -> None:
    path = gusty_pool(tmp_path)
    sim = Simulator(path, seed=1)
    first = flown(sim)
    sim.reset(seed=2)
    assert flown(sim) == flown(Simulator(path, seed=2))
    sim.reset(seed=1)
    assert flown(sim) == first


def test_the_version_goes_on() -> None:
    sim = Simulator("pool")
    sim.step(3)
    before = sim.version
    sim.reset()
    assert sim.version > before


@pytest.mark.parametrize("seed", [-1, 2**63, "7", 1.5])
def test_a_wrong_seed_is_refused_and_changes_nothing(seed: object) -> None:
    sim = Simulator("pool", seed=5)
    state = flown(sim)
    with pytest.raises(ValueError, match="seed"):
        sim.reset(seed)  # type: ignore[arg-type]
    assert sim.save_state() == state
