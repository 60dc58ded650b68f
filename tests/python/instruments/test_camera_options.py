"""Flat ports, rolling shutters and forward scattering, as scripts use them."""

from __future__ import annotations

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.instruments.cameras import EFFECTS

BED_M = 5.0
"""Depth of the pool."""


@pytest.fixture
def pool() -> Simulator:
    sim = Simulator("pool", threads=2)
    sim.rov.place((0.0, 0.0, -3.0))
    return sim


def test_a_rolling_shutter_sees_each_row_from_where_the_camera_was(pool: Simulator) -> None:
    camera = pool.rov.cameras["down"]
    camera.change(camera.mount.model_copy(update={"readout_ms": 100.0}))
    rising_m_s = 0.4
    pool.rov.place((0.0, 0.0, -3.0), (0, 0, 0, 1), (0.0, 0.0, rising_m_s, 0.0, 0.0, 0.0))
    frame = camera.capture(["shutter"], geometry_only=True)
    rows = (np.arange(frame.info.height) - 0.5 * (frame.info.height - 1)) / frame.info.height
    expected = BED_M - 3.0 + camera.mount.position_m[2] + rising_m_s * 0.1 * rows
    bed = frame.labels == frame.label_names.index("terrain")
    np.testing.assert_allclose(frame.depth_m[bed], np.broadcast_to(expected[:, None], bed.shape)[bed], rtol=2e-5)


def test_forward_scattering_blurs_and_is_off_by_default(pool: Simulator) -> None:
    camera = pool.rov.cameras["front"].resized(160)
    plain = camera.capture(without=("noise", "exposure"), radiance=True)
    assert "forward_scatter" in EFFECTS
    np.testing.assert_array_equal(
        camera.capture(without=("noise", "exposure", "forward_scatter"), radiance=True).radiance, plain.radiance
    )
    pool.set_optics(forward_scatter_mrad=30.0)
    blurred = camera.capture(without=("noise", "exposure"), radiance=True)
    assert blurred.radiance.mean() > plain.radiance.mean()
    assert (blurred.radiance >= plain.radiance).all()
