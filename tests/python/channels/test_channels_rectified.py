"""Cameras as image_pipeline expects them: raw and rectified pictures, each described by the camera_info beside it."""

import logging
from typing import Any

import cv2
import numpy as np
import pytest

from channel_tools import chain, stamp_ns, table
from uwsim import Simulator
from uwsim.channels import Table
from uwsim.channels.delivery.pictures import Stream
from uwsim.instruments.cameras.lens import rectify
from uwsim.scenario.spec.camera import FlatPort

BED_Z_M = -5.0
D = (-0.25, 0.06, 0.01, -0.008, -0.01)
SEEN = ("image_raw/compressed", "image_raw", "image_rect", "camera_info", *(
    f"depth/{name}" for name in ("image_raw", "image_rect", "camera_info")
))  # fmt: skip


@pytest.fixture
def sim() -> Simulator:
    """Return a vehicle that pitches and rolls above a flat bed, all that its small, distorting camera sees."""
    sim = Simulator("pool", threads=2)
    sim.rov.place((-3.0, 0.0, -2.0), (0.14, -0.1, 0.0, 0.985))
    camera = sim.rov.cameras["down"]
    lens = {"distortion": D, "wobble_mrad": 0.0, "width": 160, "height": 120, "field_of_view_deg": 50.0}
    camera.change(camera.mount.model_copy(update=lens))
    return sim


def read(found: Any, sim: Simulator, name: str) -> Any:
    return found[f"camera/down/{name}"].read(sim)


def pixels(message: Any) -> Any:
    kind, shape = {"32FC1": (np.float32, ()), "rgb8": (np.uint8, (3,))}[message.encoding]
    assert message.step * message.height == message.data.size
    return np.frombuffer(message.data.tobytes(), kind).reshape(message.height, message.width, *shape)


def heights_m(sim: Simulator, found: Any, depth: Any, rays: Any) -> Any:
    """Return the height of the point in each pixel by its depth, its ray (h, w, 2) and the frames on /tf."""
    points = np.concatenate([rays, np.ones((*rays.shape[:2], 1))], axis=2) * pixels(depth)[..., None]
    world_from_optical = chain(sim, found, depth.header.frame_id)
    return points @ world_from_optical[2, :3] + world_from_optical[2, 3]


@pytest.mark.parametrize("port", [None, FlatPort(distance_m=0.02, thickness_m=0.01)], ids=["dome", "flat port"])
def test_rectified_depth_gives_the_true_point_in_every_pixel(sim: Simulator, port: FlatPort | None) -> None:
    sim.rov.cameras["down"].change(sim.rov.cameras["down"].mount.model_copy(update={"port": port}))
    found = table(sim)
    depth, info = (read(found, sim, f"depth/{name}") for name in ("image_rect", "camera_info"))
    fx, cx, fy, cy = info.p[[0, 2, 5, 6]]
    u, v = np.meshgrid(np.arange(info.width), np.arange(info.height))
    rays = np.stack([(u - cx) / fx, (v - cy) / fy], axis=2)
    np.testing.assert_allclose(heights_m(sim, found, depth, rays), BED_Z_M, atol=1e-5)
    assert np.ptp(pixels(depth)) > 0.5, "the bed is slanted, so that wrong rays would miss it"
    raw = heights_m(sim, found, read(found, sim, "depth/image_raw"), rays)
    assert np.abs(raw - BED_Z_M).max() > 0.005, "the raw depth is the lens's"


def test_raw_depth_gives_the_true_point_by_the_distortion_beside_it(sim: Simulator) -> None:
    found = table(sim)
    depth, info = (read(found, sim, f"depth/{name}") for name in ("image_raw", "camera_info"))
    places = np.stack(np.meshgrid(np.arange(info.width), np.arange(info.height)), axis=2).astype(float)
    accurate = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-9)
    rays = cv2.undistortPoints(places.reshape(-1, 1, 2), info.k.reshape(3, 3), info.d, criteria=accurate)
    np.testing.assert_allclose(heights_m(sim, found, depth, rays.reshape(places.shape)), BED_Z_M, atol=1e-5)


@pytest.mark.parametrize("width", [0, 80])
def test_a_rectified_picture_is_the_raw_one_as_opencv_rectifies_it(sim: Simulator, width: int) -> None:
    whole = Table(sim)
    whole.pictures.set_stream("down", Stream(width=width))
    found = {channel.name: channel for channel in whole.channels}
    raw, rectified, info = (read(found, sim, name) for name in ("image_raw", "image_rect", "camera_info"))
    assert {(one.width, one.height) for one in (raw, rectified, info)} == {(width or 160, (width or 160) * 3 // 4)}
    k, p = info.k.reshape(3, 3), info.p.reshape(3, 4)
    maps = cv2.initUndistortRectifyMap(k, info.d, np.eye(3), p, (info.width, info.height), cv2.CV_32FC1)
    expected = cv2.remap(pixels(raw), *maps, cv2.INTER_LINEAR)
    off = np.abs(pixels(rectified).astype(int) - expected)
    assert off.max() <= 3, "OpenCV rounds places to 1/32 pixel"
    assert off.mean() < 0.2
    assert np.abs(pixels(raw).astype(int) - expected).mean() > 1.0


def test_what_a_pinhole_sees_is_what_rectification_makes_of_a_distorted_picture(sim: Simulator) -> None:
    camera = sim.rov.cameras["down"]
    sim.rov.place((2.2, 0.0, -2.5), (0.14, -0.1, 0.0, 0.985))  # the box is in view
    info = camera.info
    seen = rectify(camera.capture(["distortion"]).rgb, info.k, info.d, info.p)[10:-10, 10:-10].astype(int)
    expected = camera.rectified().capture("off").rgb[10:-10, 10:-10]
    inside = seen.any(axis=2)
    assert inside.mean() > 0.7
    assert np.median(np.abs(seen - expected)[inside]) <= 2
    assert np.percentile(np.abs(seen - expected)[inside], 95) <= 12, "but for edges"


def test_every_topic_of_a_picture_has_its_stamp(sim: Simulator) -> None:
    found = table(sim)
    for _ in range(2):
        messages = [read(found, sim, name) for name in SEEN]
        assert len({(stamp_ns(message), message.header.frame_id) for message in messages}) == 1
        sim.advance(0.1)
    late = Table(sim, may_wait=lambda: False)
    found, stamps = {channel.name: channel for channel in late.channels}, {name: set[int]() for name in SEEN}
    for _ in range(5):
        late.pictures.submit(lambda: None).result()  # what has been started is finished
        for name in SEEN:
            message = read(found, sim, name)
            stamps[name].update(() if message is None else (stamp_ns(message),))
        sim.advance(0.1)
    every = stamps["camera_info"]
    assert len(every) >= 3
    for name in SEEN:
        assert every - stamps[name] <= {min(every)} and stamps[name] <= every, "but for the first of a new reader"


def test_parts_are_made_only_for_readers(sim: Simulator, monkeypatch: pytest.MonkeyPatch) -> None:
    camera = sim.rov.cameras["down"]
    # Pictures of a width of their own, since those of earlier tests may still be in the making, on threads.
    camera.change(camera.mount.model_copy(update={"width": 168}))
    found, made = table(sim), list[float]()

    def note(rgb: Any, *lens: Any) -> Any:
        if rgb.shape[1] == 168:
            made.append(sim.time_s)
        return rgb

    monkeypatch.setattr("uwsim.channels.delivery.pictures.rectify", note)
    for name, reads in (("image_raw", 2), ("image_rect", 3), ("image_raw", 5)):
        for _ in range(reads):
            sim.advance(0.1)
            read(found, sim, name)
    assert 3 <= len(made) <= 6


def test_a_camera_in_the_bed_is_dark(sim: Simulator, caplog: pytest.LogCaptureFixture) -> None:
    sim.rov.place((-3.0, 0.0, -4.8))
    found = table(sim)
    with caplog.at_level(logging.DEBUG):
        assert not pixels(read(found, sim, "image_raw")).any()
        assert not pixels(read(found, sim, "image_rect")).any()
        assert np.isinf(pixels(read(found, sim, "depth/image_rect"))).all()
    assert not caplog.records
    assert pixels(found["camera/front/image_raw"].read(sim)).any(), "which is above it"
