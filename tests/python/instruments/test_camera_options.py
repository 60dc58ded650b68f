"""Flat ports, rolling shutters, lamps of a station, and PNG files that another reader finds the same."""

from __future__ import annotations

import io

import cv2
import numpy as np
import pytest
from PIL import Image

from uwsim import Batch, Simulator
from uwsim.instruments.cameras.image_file import encode_png
from uwsim.scenario import load
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.camera import FlatPort
from uwsim.scenario.spec.scenario import Scenario

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


@pytest.mark.parametrize("optimize", [False, True])
@pytest.mark.parametrize("shape", [(1, 1), (5, 1), (1, 6), (7, 9), (1, 1, 3), (7, 9, 3)])
@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_another_reader_finds_the_same_pixels_and_text(
    shape: tuple[int, ...], kind: type[np.generic], optimize: bool
) -> None:
    if len(shape) == 3 and kind is np.uint16:
        pytest.skip("Pillow reads 16 bits in grey only")
    pixels = np.random.default_rng(3).integers(0, np.iinfo(kind).max, shape, kind, endpoint=True)
    text = {"Title": "größe", "Comment": "a\nb"}
    for laid_out in (pixels, pixels[::-1, ::-1], np.asfortranarray(pixels), np.zeros_like(pixels)):
        file = encode_png(laid_out, optimize=optimize, text=text)
        assert file == encode_png(laid_out.copy(), optimize=optimize, text=text)
        with Image.open(io.BytesIO(file)) as picture:
            picture.load()
            np.testing.assert_array_equal(np.array(picture), laid_out)
            assert picture.text == text
