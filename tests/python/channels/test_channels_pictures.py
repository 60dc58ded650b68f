"""Pictures: rendered once for all readers, delivered one period late, streamed on request."""

import io

import numpy as np
import pytest
from PIL import Image

from channel_tools import stamp_ns, table
from uwsim import Simulator
from uwsim.channels import Table
from uwsim.live import LiveSimulator


@pytest.fixture(scope="module")
def sim() -> Simulator:
    sim = Simulator("pool")
    sim.rov.lamps["front"].on = True
    return sim


def test_all_readers_get_one_picture_of_one_moment(sim: Simulator) -> None:
    found = table(sim)
    stamps = []
    for _ in range(3):
        names = ("image_raw/compressed", "camera_info", "depth/image_raw")
        messages = [found[f"camera/front/{name}"].read(sim) for name in names]
        again = found["camera/front/image_raw/compressed"].read(sim)
        assert again.data.tobytes() == messages[0].data.tobytes()
        assert len({stamp_ns(message) for message in messages}) == 1
        stamps.append(stamp_ns(messages[0]))
        sim.advance(0.1)
    assert np.diff(stamps).tolist() == [0, 100_000_000]  # waited for; later ones are a period late


def test_a_picture_is_of_the_moment_of_its_stamp(sim: Simulator) -> None:
    channel = table(sim)["camera/front/depth/image_raw"]
    expected = sim.rov.cameras["front"].capture(geometry_only=True).depth_m
    channel.read(sim)
    sim.rov.set_effort(surge=1.0)
    sim.advance(0.1)
    message = channel.read(sim)
    got = np.frombuffer(message.data.tobytes(), np.float32).reshape(message.height, message.width)
    np.testing.assert_array_equal(got, expected)
    assert (message.encoding, message.step) == ("32FC1", 4 * message.width)


def test_the_published_topic_carries_the_cameras_in_turn(sim: Simulator) -> None:
    channel = table(sim)["images/compressed"]
    frames = []
    for _ in range(4):
        message = channel.read(sim)
        frames.append(message.header.frame_id)
        assert Image.open(io.BytesIO(message.data.tobytes())).size == (640, 360)
        sim.advance(1.0 / channel.rate_hz)
    assert frames[:2] == frames[2:]
    assert set(frames) == {"front_optical", "down_optical"}


def test_a_stream_is_chosen_with_its_rate_and_size() -> None:
    with LiveSimulator("pool", speed="max", paused=True) as live:
        sim, seen = live.simulator, []
        whole = Table(sim)
        found = {channel.name: channel for channel in whole.channels}
        (service,) = [service for service in whole.services if service.name == "camera/front/set_stream"]
        assert service.call(live, {"rate_hz": 5.0, "width": 320, "quality": 50})["success"]
        picture, info = (found[f"camera/front/{name}"] for name in ("image_raw/compressed", "camera_info"))
        for _ in range(11):
            message = picture.read(sim)
            if message is not None:
                intrinsics = info.read(sim)
                assert Image.open(io.BytesIO(message.data.tobytes())).size == (320, 180)
                assert (intrinsics.width, intrinsics.height) == (320, 180)
                # A ray through the centre stays in the centre: half the pixels, half the focal length.
                assert intrinsics.k[0] == pytest.approx(0.5 * sim.rov.cameras["front"].info.k[0, 0])
                assert intrinsics.k[2] == pytest.approx(0.5 * (320 - 1))
                seen.append(stamp_ns(message))
            live.step(20)
        assert set(np.diff(np.unique(seen))) == {200_000_000}
        assert service.call(live, {"enabled": False})["success"]
        live.step(40)
        assert picture.read(sim) is None
        for request in ({"rate_hz": 99.0}, {"width": 3}, {"quality": 0}, {"enabled": "yes"}):
            answer = service.call(live, request)
            assert not answer["success"] and next(iter(request)) in answer["message"]
