"""The lamps of a station shine throughout, for every camera, also for those of a batch."""

import numpy as np
import pytest

from uwsim import Batch, Simulator
from uwsim.scenario import load
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.scenario import Scenario

LAMP = {"on": True, "flux_lm": 2000, "half_angle_deg": 60}


def night(yaw_deg: float = 0.0, **lamps: object) -> Scenario:
    """Return the pool at night. lamps: by name."""
    pool = load("pool")
    station = {**pool.station.given(), "yaw_deg": yaw_deg, "lamps": lamps}
    data = {**pool.given(), "station": station, "optics": {"sun_elevation_deg": -6, "jerlov": "I"}}
    return validated(Scenario, data).read_from(pool.source_file)


def lamp(x: float, y: float, heading_deg: float, **changes: object) -> dict[str, object]:
    spot = {"position_m": [x, y, -1.0], "yaw_pitch_roll_deg": [heading_deg, 40, 0]}
    return {**LAMP, "spots": [spot], **changes}


def radiance(scenario: Scenario) -> np.ndarray:
    with Simulator(scenario) as sim:
        sim.rov.place((-4.0, 0.0, -2.0))
        return sim.rov.cameras["front"].capture({"attenuation", "lamps"}, radiance=True).radiance


def test_a_lamp_of_the_station_lights_what_is_before_it_and_turns_with_the_station():
    lit, dark, off = radiance(night(one=lamp(5, 0, 0))), radiance(night()), radiance(night(one=lamp(5, 0, 0, on=False)))
    assert lit.mean() > 100.0 * dark.mean() and np.array_equal(dark, off)
    turned = radiance(night(90.0, one=lamp(0, -5, -90)))
    np.testing.assert_allclose(turned, lit, rtol=1e-3, atol=1e-6 * lit.max())


def test_the_vehicles_switches_do_not_reach_it_and_a_reset_leaves_it_on():
    with Simulator(night(one=lamp(5, 0, 0))) as sim:
        sim.rov.place((-4.0, 0.0, -2.0))
        before = sim.rov.cameras["front"].capture().rgb
        sim.reset()
        sim.rov.place((-4.0, 0.0, -2.0))
        assert not any(one.on for one in sim.rov.lamps.values())
        assert np.array_equal(sim.rov.cameras["front"].capture().rgb, before)


@pytest.mark.parametrize("size", [None, (30, 40)])
def test_pictures_of_a_batch_have_the_same_light(size):
    batch = Batch(night(one=lamp(5, 0, 0)), n=2)
    together = batch.capture("front", size=size)
    for k in range(2):
        camera = batch.aboard(k).rov.cameras["front"]
        alone = camera if size is None else camera.resized(size[1], size[0])
        assert np.array_equal(together[k], alone.capture().rgb)
    assert together.max() > 0
