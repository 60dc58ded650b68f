"""Sonars and cameras that fail: no echoes and black images until the fault ends."""

import numpy as np
import pytest

from uwsim import Simulator


@pytest.mark.parametrize("mode", ["geometry", "physics"])
def test_a_multibeam_that_fails_hears_nothing_until_it_works_again(mode):
    sim = Simulator("pool", seed=3)
    sim.parameters["rov.sonar.mode"] = mode
    sim.faults.inject("sonar", at_s=1.0, for_s=1.0)
    heard = []
    for _ in range(3):
        sim.advance(0.9)
        heard.append(sim.rov.sonar.ping().valid.any())
        batch = sim.rov.sonar.ping_batch(sim.rov.pose.world_from_body[None]) if mode == "geometry" else None
        assert batch is None or batch.valid.any() == heard[-1]
    assert heard == [True, False, True]
    assert [(event.name, event.time_s) for event in sim.events] == [("fault", 1.0), ("fault_ends", 2.0)]


def test_a_camera_that_fails_takes_black_pictures_of_its_size():
    sim = Simulator("pool", seed=3)
    sim.faults.inject("camera", camera="front")
    front, down = (sim.rov.cameras[name].resized(32).capture() for name in ("front", "down"))
    assert front.rgb.shape == down.rgb.shape and not front.rgb.any() and down.rgb.any()
    assert np.isinf(front.depth_m).all() and not front.labels.any()
    sim.faults.end("camera")
    assert sim.rov.cameras["front"].resized(32).capture().rgb.any()
    with pytest.raises(ValueError, match=r"camera = 'dwon': must be one of .*, down; did you mean 'down'"):
        sim.faults.inject("camera", camera="dwon")
