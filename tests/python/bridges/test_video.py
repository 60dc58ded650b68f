"""A camera's pictures as H.264 by RTP, read by OpenCV's own FFmpeg from the session description."""

import base64
import logging
import os
import re
import shutil
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from listening_sockets import free_port
from uwsim import Simulator
from uwsim.base.extras import MissingExtraError
from uwsim.bridges.doors.endpoint import Endpoint
from uwsim.bridges.video import video as video_module
from uwsim.bridges.video.video import VideoStream
from uwsim.instruments.cameras import Frame
from uwsim.live import LiveSimulator
from waiting import until

needs_ffmpeg = pytest.mark.skipif(
    shutil.which("ffmpeg") is None and find_spec("imageio_ffmpeg") is None, reason="needs ffmpeg, or the extra video"
)


class Kept(VideoStream):
    """A stream that keeps its pictures."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.pictures: list[np.ndarray] = []

    def _queue(self, capture: Callable[[], Frame] | None) -> None:
        def kept() -> Frame:
            assert capture is not None
            frame = capture()
            self.pictures.append(frame.rgb)
            return frame

        super()._queue(None if capture is None else kept)


@pytest.fixture(scope="module")
def live() -> Iterator[LiveSimulator]:
    with LiveSimulator(Simulator("lagoon"), speed=1.0) as live:
        yield live


@pytest.fixture
def port() -> int:
    return free_port(socket.SOCK_DGRAM)


def psnr_db(got: np.ndarray, sent: np.ndarray) -> float:
    return float(10 * np.log10(255**2 / np.mean((got.astype(float) - sent) ** 2)))


@needs_ffmpeg
def test_a_receiver_decodes_the_cameras_pictures(
    live: LiveSimulator, port: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each decoded frame is one of the pictures sent: at least 30 dB (H.264 at 4 Mbit/s, colours at half size)."""
    cv2 = pytest.importorskip("cv2")
    monkeypatch.setenv("OPENCV_FFMPEG_CAPTURE_OPTIONS", "protocol_whitelist;file,rtp,udp")
    with Kept(live, "rov", Endpoint("127.0.0.1", port)) as stream:
        (tmp_path / "video.sdp").write_text(stream.sdp)
        receiver = cv2.VideoCapture(str(tmp_path / "video.sdp"), cv2.CAP_FFMPEG)
        frames = [receiver.read()[1] for _ in range(5)]
        receiver.release()
        sockets = _udp_sockets()
    found = set()
    for frame in frames:
        assert frame is not None and frame.shape == (*reversed(stream.size), 3)
        scores = [psnr_db(frame[..., ::-1], sent) for sent in stream.pictures]
        assert max(scores) > 30, scores
        found.add(int(np.argmax(scores)))
    assert len(found) > 2
    assert sockets and all(host == "127.0.0.1" for host in sockets)


def units_of(payload: bytes) -> list[bytes]:
    """Return the NAL units that begin in an RTP payload (RFC 6184), of a fragmented one only its header."""
    if payload[0] & 31 == 24:
        size = int.from_bytes(payload[1:3], "big")
        rest = payload[3 + size :]
        return [payload[3 : 3 + size], *(units_of(b"\x18" + rest) if rest else [])]
    if payload[0] & 31 == 28:
        return [bytes([payload[1] & 31])] if payload[1] & 0x80 else []
    return [payload]


@needs_ffmpeg
def test_the_first_picture_of_each_second_is_a_key_frame_that_the_description_fits(live: LiveSimulator) -> None:
    """At some four pictures a second, whose times are the packets' own."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(("127.0.0.1", 0))
        receiver.settimeout(180.0)
        live.speed = 0.4
        with VideoStream(live, "rov", Endpoint("127.0.0.1", receiver.getsockname()[1])) as stream:
            described = re.search(r"sprop-parameter-sets=(.*)", stream.sdp)
            keys: dict[int, bool] = {}
            sets: set[str] = set()
            while sum(keys.values()) < 3:
                packet = receiver.recv(2000)
                if packet[1] & 127 != 96:
                    continue
                time_90khz = int.from_bytes(packet[4:8], "big")
                for unit in units_of(packet[12:]):
                    if unit[0] & 31 in (1, 5):
                        keys[time_90khz] = keys.get(time_90khz, False) or unit[0] & 31 == 5
                    elif unit[0] & 31 in (7, 8):
                        sets.add(base64.b64encode(unit).decode())
        live.speed = 1.0
    times = np.array(list(keys)) - next(iter(keys))
    seconds = np.floor((times + 9) / 90000)  # rounded to milliseconds
    assert list(keys.values()) == [True, *(np.diff(seconds) > 0)]
    assert described is not None and set(described[1].split(",")) == sets


def _udp_sockets() -> list[str]:
    """Return the addresses of the UDP sockets of this process's children."""
    children = subprocess.run(["pgrep", "-P", str(os.getpid())], capture_output=True, text=True, check=False).stdout
    inodes = set()
    for child in children.split():
        for link in Path(f"/proc/{child}/fd").glob("*"):
            target = str(link.readlink())
            if target.startswith("socket:["):
                inodes.add(target[8:-1])
    rows = [line.split() for line in Path("/proc/net/udp").read_text().splitlines()[1:]]
    found = [row[1].partition(":")[0] for row in rows if row[9] in inodes]
    return [socket.inet_ntoa(bytes.fromhex(address)[::-1]) for address in found]


@needs_ffmpeg
def test_steps_wait_for_no_picture(port: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """At speed max, 20 s pass while the first picture is still being rendered."""
    with LiveSimulator(Simulator("lagoon"), speed="max", paused=True) as live:
        stream = Kept(live, "rov", Endpoint("127.0.0.1", port))
        slow = stream._queue
        monkeypatch.setattr(stream, "_queue", lambda capture: slow(capture and (lambda: time.sleep(1.0) or capture())))
        with stream:
            live.step(round(20 / live.simulator.step_s))
            assert stream.sent == 0


@needs_ffmpeg
def test_a_stream_ends_with_its_encoder_and_says_so_once(
    live: LiveSimulator, port: int, tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = tmp_path / "ffmpeg"
    broken.write_text("#!/bin/sh\necho 'Unknown encoder' >&2\n")
    broken.chmod(0o755)
    monkeypatch.setattr(video_module, "encoder_path", lambda: str(broken))
    caplog.set_level(logging.WARNING)
    with VideoStream(live, "rov", Endpoint("127.0.0.1", port)):
        until(lambda: "ended" in caplog.text)
        time.sleep(0.3)
    assert caplog.text.count("ended: Unknown encoder") == 1


def test_without_ffmpeg_the_command_to_install_it_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setattr("uwsim.base.ffmpeg.find_spec", lambda module: None)
    with pytest.raises(MissingExtraError, match="apt install ffmpeg"):
        video_module.encoder_path()


def test_an_unknown_camera_is_refused(live: LiveSimulator) -> None:
    with pytest.raises(ValueError, match="camera = 'nose': must be one of chase"):
        VideoStream(live, "rov", Endpoint("127.0.0.1", 5600), "nose")
