"""The cost of recording pictures, measured on this machine before a recording starts."""

from __future__ import annotations

import time

from uwsim.channels.delivery.pictures import RATE_HZ, Stream
from uwsim.instruments.cameras import Camera
from uwsim.simulator.simulator import Simulator


def picture_cost_text(sim: Simulator) -> str:
    """Return a text with the processor time that the cameras' pictures take per simulated second, at full rate.

    This takes one picture with each camera, which does not change the simulator.
    """
    cameras = [*sim.cameras.values(), *(each for rov in sim.vehicles.values() for each in rov.cameras.values())]
    cost_s = RATE_HZ * sum(picture_cost_s(camera) for camera in cameras)
    return (
        f"about {cost_s:.1f} s of processor time per simulated second for the pictures of {len(cameras)} cameras; at "
        "real-time pace, pictures that are late are left out"
    )


def picture_cost_s(camera: Camera) -> float:
    """Return the processor time [s] to render and encode one picture on this thread."""
    snapshot = camera.snapshot()
    begun_s = time.thread_time()
    camera.capture(at=snapshot, threads=1).jpeg(Stream().quality)
    return time.thread_time() - begun_s
