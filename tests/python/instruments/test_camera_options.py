"""Flat ports and rolling shutters, as scripts use them."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from uwsim import Simulator
from uwsim.scenario.spec.camera import FlatPort

BED_M = 5.0
"""Depth of the pool."""


@pytest.fixture
def pool() -> Simulator:
    sim = Simulator("pool", threads=2)
    sim.rov.place((0.0, 0.0, -3.0))
    return sim


def test_a_flat_port_refracts_and_a_calibration_under_water_describes_it(pool: Simulator) -> None:
    camera, place = pool.rov.cameras["front"].resized(320), np.zeros(3)
    in_air = camera.info.k[0, 0]
    camera.change(camera.mount.model_copy(update={"port": FlatPort(distance_m=0.02, thickness_m=0.01)}))
    air, water = (camera.ray_table(in_water=wet).astype(float) for wet in (False, True))
    sines = [np.sin(np.arctan(np.linalg.norm(rays, axis=-1))) for rays in (air, water)]
    np.testing.assert_allclose(sines[0], 1.333 * sines[1], rtol=1e-5, atol=1e-7)
    rays = np.dstack([water, np.ones(water.shape[:2])]).reshape(-1, 3)
    pixels, _ = cv2.projectPoints(rays, place, place, camera.info.k, camera.info.d)
    np.testing.assert_allclose(pixels.reshape(water.shape), np.indices(water.shape[1::-1]).T, atol=0.2)
    assert camera.info.k[0, 0] == pytest.approx(1.333 * in_air, rel=0.02)
    frame = camera.capture(["distortion", "attenuation"])
    bed = frame.labels == frame.label_names.index("terrain")
    seen = camera.ray_offsets_m()[bed] + water[bed] * frame.depth_m[bed, None]
    ahead, left, up = frame.world_from_camera[2, :3]  # heights of the axes
    height_m = frame.world_from_camera[2, 3] + frame.depth_m[bed] * ahead - seen @ [left, up]
    np.testing.assert_allclose(height_m, -BED_M, atol=2e-5)


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
