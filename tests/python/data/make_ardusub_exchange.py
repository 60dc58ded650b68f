"""Record ardusub_exchange.npz: 20 s of servo frames from a stand-in that dives, sways, turns and flies ahead.

.venv/bin/python tests/python/data/make_ardusub_exchange.py
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))

from servo_standin import NEUTRAL, Standin, mixed  # noqa: E402  # beside this folder
from uwsim import Simulator  # noqa: E402
from uwsim.bridges.ardusub import ArduSub, prepared  # noqa: E402
from uwsim.scenario import load  # noqa: E402

RATE_HZ, FRAMES = 400, 8000


def main() -> None:
    """Fly, and write the frames and the positions (north, east, down) once a second."""
    frames: list[list[int]] = []

    def decide(line: dict[str, Any]) -> list[int]:
        frames.append(flown(line) if line else [NEUTRAL] * 8)
        return frames[-1]

    sim = Simulator(prepared(load("lagoon")))
    with ArduSub(sim, port=0) as ardusub, Standin(ardusub.port, decide, frames=FRAMES) as autopilot:
        sim.step(FRAMES)
    positions = np.array([line["position"] for line in autopilot.lines])[RATE_HZ - 1 :: RATE_HZ]
    np.savez_compressed(
        HERE / "ardusub_exchange.npz", outputs_us=np.array(frames, np.uint16), positions_ned_m=positions
    )


def flown(line: dict[str, Any]) -> list[int]:
    """Return the outputs that hold a depth, which grows from 3 to 6.2 m in 8 s, and move on the other axes."""
    time_s, down, speed = line["timestamp"], line["position"][2], line["velocity"][2]
    wanted = 3.0 + 0.4 * min(time_s, 8.0)
    return mixed(
        "vectored_6dof",
        throttle=float(np.clip(1.5 * (down - wanted) + 2.0 * speed, -0.6, 0.6)),
        lateral=0.3 * (2 < time_s < 5),
        yaw=0.25 * (6 < time_s < 9),
        forward=0.4 * (9 < time_s < 15),
    )


if __name__ == "__main__":
    main()
