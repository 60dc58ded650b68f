"""Video: sends a camera's pictures to ground stations as an H.264 stream over RTP."""

from __future__ import annotations

import base64
import logging
import os
import queue
import re
import subprocess
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from types import TracebackType
from typing import Self

from uwsim.base.ffmpeg import encoder_path
from uwsim.bridges.doors.endpoint import Endpoint, EndpointForm
from uwsim.channels.delivery.pictures import RATE_HZ
from uwsim.instruments.cameras import Camera, Frame
from uwsim.live import LiveSimulator, Subscription
from uwsim.simulator.simulator import Simulator

PORT = 5600
"""The UDP port at which QGroundControl and Cockpit expect video."""
FORM = EndpointForm("video", "[HOST:]PORT", {"": None}, sends=("",))
PAYLOAD_TYPE = 96
PACKET_BYTES = 1200
BITRATE_KBIT_S = 4000
KEY_FRAMES_MAX = 1000
"""Pictures after which x264 makes a key frame by itself: more than ever lie between those of each second."""
FIRST_OF_A_SECOND = "if(isnan(prev_forced_t),1,gt(floor(t),floor(prev_forced_t)))"
"""Chooses the key frames, also after a second without pictures."""
SPS, PPS = 7, 8  # types of NAL units
CLOSE_S = 2.0
SHORTEST_S = 0.08
"""The minimum time between two pictures, so that a fast simulation does not render constantly."""

logger = logging.getLogger("uwsim.video")


def own_first(cameras: Mapping[str, Camera]) -> list[str]:
    """Return the names of a vehicle's cameras: the onboard cameras first, then those that follow the vehicle."""
    return sorted(cameras, key=lambda name: cameras[name].mount.follows != "body")


class VideoStream:
    """Sends a camera's pictures to a UDP port, as H.264 over RTP.

    There are up to 10 pictures per second of simulated time, and about as many per second of real time. A picture shows
    the world at the time of its reading. It is rendered on a separate thread, and no step waits for it; the next
    picture is started only once it has been passed to ffmpeg, which encodes and sends it.

    vehicle: the vehicle's name. camera: the name of one of its cameras; by default the first onboard camera. Raises
    ValueError for an unknown camera, MissingExtraError without ffmpeg.
    """

    def __init__(self, live: LiveSimulator, vehicle: str, target: Endpoint, camera: str | None = None) -> None:
        cameras = live.simulator.vehicles[vehicle].cameras
        if not cameras:
            raise ValueError(f"video: vehicle '{vehicle}' has no camera")
        self.camera = own_first(cameras)[0] if camera is None else camera
        if self.camera not in cameras:
            raise ValueError(f"video: camera = '{camera}': must be one of {', '.join(cameras)}")
        self.target, self.sent, self.is_paused = target, 0, False
        self._live, self._vehicle = live, vehicle
        self._path = encoder_path()
        self._subscription: Subscription | None = None
        self._waiting: queue.SimpleQueue[Callable[[], Frame] | None] = queue.SimpleQueue()
        self._is_idle = True
        self._begun_s = -SHORTEST_S
        self._thread = threading.Thread(target=self._run, name="uwsim-video", daemon=True)

    @property
    def size(self) -> tuple[int, int]:
        """The width and height of the stream in pixels, which are even, as H.264 requires."""
        info = self._live.simulator.vehicles[self._vehicle].cameras[self.camera].info
        return info.width // 2 * 2, info.height // 2 * 2

    @property
    def sdp(self) -> str:
        """The session description (RFC 8866, RFC 6184) that a receiver on the target host needs to read the stream.

        It contains the encoder's parameter sets, so that a decoder knows the pictures before a key frame arrives.
        Raises RuntimeError if ffmpeg does not provide them.
        """
        sets = self._parameter_sets()
        joined = ",".join(base64.b64encode(each).decode() for each in sets)
        return (
            f"v=0\no=- 0 0 IN IP4 127.0.0.1\ns={self._vehicle}/{self.camera}\nc=IN IP4 {self.target.host}\nt=0 0\n"
            f"m=video {self.target.port} RTP/AVP {PAYLOAD_TYPE}\na=rtpmap:{PAYLOAD_TYPE} H264/90000\n"
            f"a=fmtp:{PAYLOAD_TYPE} packetization-mode=1; profile-level-id={sets[0][1:4].hex()}; "
            f"sprop-parameter-sets={joined}\n"
        )

    def _parameter_sets(self) -> tuple[bytes, bytes]:
        """Return SPS and PPS, which depend only on the options and the size: those of two black pictures."""
        width, height = self.size
        command = [*self._encoding((height, width)), "-f", "h264", "pipe:1"]
        black = bytes(2 * 3 * width * height)  # ffmpeg discards the first, from which it detects the format
        done = subprocess.run(command, input=black, capture_output=True, timeout=CLOSE_S * 10, check=False)
        units = {unit[0] & 31: unit for unit in re.split(rb"\x00\x00\x00?\x01", done.stdout) if unit}
        if not {SPS, PPS} <= units.keys():
            raise RuntimeError(f"video: no parameter sets: {done.stderr[-200:].decode(errors='replace').strip()}")
        return units[SPS], units[PPS]

    def __enter__(self) -> Self:
        """Start. Raises NotRunningError."""
        if not self.target.is_local:
            logger.warning("video is sent to %s, beyond this machine, in plain text", self.target)
        self._subscription = self._live.every(1 / RATE_HZ, self._begin, self._queue)
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop."""
        if self._subscription is not None:
            self._subscription.cancel()
        self._waiting.put(None)
        self._thread.join(2 * CLOSE_S)

    def _begin(self, sim: Simulator) -> Callable[[], Frame] | None:
        now_s = time.monotonic()
        if self.is_paused or not self._is_idle or now_s - self._begun_s < SHORTEST_S:
            return None
        self._begun_s = now_s
        return sim.vehicles[self._vehicle].cameras[self.camera].later()

    def _queue(self, capture: Callable[[], Frame] | None) -> None:
        if capture is not None:
            self._is_idle = False
            self._waiting.put(capture)

    def _run(self) -> None:
        _yield_to_others(threading.get_native_id())
        encoder: subprocess.Popen[bytes] | None = None
        shape: tuple[int, ...] = ()
        try:
            while (capture := self._waiting.get()) is not None:
                rgb = capture().rgb
                rgb = rgb[: rgb.shape[0] // 2 * 2, : rgb.shape[1] // 2 * 2]
                if encoder is None or rgb.shape != shape:
                    _end(encoder)
                    encoder, shape = self._started(rgb.shape), rgb.shape
                assert encoder.stdin is not None
                encoder.stdin.write(rgb.tobytes())
                self.sent += 1
                self._is_idle = True
        except OSError as error:
            why = b"" if encoder is None or encoder.stderr is None else encoder.stderr.read(2000)
            reason = (why.decode(errors="replace").strip().splitlines() or [str(error)])[-1]
            logger.warning("video to %s ended: %s", self.target, reason)
        finally:
            _end(encoder)

    def _encoding(self, shape: tuple[int, ...]) -> list[str]:
        """Return ffmpeg's command up to its output. The key frames are those of the clock, at any rate of pictures."""
        return [
            self._path, "-loglevel", "error", "-nostdin",
            "-f", "rawvideo", "-pix_fmt", "rgb24", "-video_size", f"{shape[1]}x{shape[0]}",
            "-use_wallclock_as_timestamps", "1", "-fflags", "nobuffer", "-probesize", "32", "-i", "pipe:0",
            "-fps_mode", "passthrough", "-an", "-c:v", "libx264", "-preset", "ultrafast", "-tune", "zerolatency",
            "-pix_fmt", "yuv420p", "-g", str(KEY_FRAMES_MAX),
            "-force_key_frames", f"expr:{FIRST_OF_A_SECOND}", "-threads", "1", "-b:v", f"{BITRATE_KBIT_S}k", "-maxrate",
            f"{BITRATE_KBIT_S}k", "-bufsize", f"{BITRATE_KBIT_S}k", "-x264-params", "repeat-headers=1",
        ]  # fmt: skip

    def _started(self, shape: tuple[int, ...]) -> subprocess.Popen[bytes]:
        local = "&localaddr=127.0.0.1" if self.target.is_local else ""
        command = [
            *self._encoding(shape), "-flush_packets", "1", "-payload_type", str(PAYLOAD_TYPE), "-f", "rtp",
            f"rtp://{self.target}?pkt_size={PACKET_BYTES}{local}",
        ]  # fmt: skip
        encoder = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, bufsize=0,
            start_new_session=True,
        )  # fmt: skip
        _yield_to_others(encoder.pid)
        return encoder


def _yield_to_others(identity: int) -> None:
    """Lower the priority of a process or (on Linux) a thread, so that the simulator comes first."""
    with suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, identity, 10)


def _end(encoder: subprocess.Popen[bytes] | None) -> None:
    if encoder is None:
        return
    assert encoder.stdin is not None
    with suppress(OSError):
        encoder.stdin.close()
    try:
        encoder.wait(CLOSE_S)
    except subprocess.TimeoutExpired:
        encoder.kill()
        encoder.wait()
    if encoder.stderr is not None:
        encoder.stderr.close()
