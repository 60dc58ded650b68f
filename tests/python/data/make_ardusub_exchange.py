"""Make ardusub_exchange.npz from a recording of tools/ardusub-trial: the servo frames of its first 88 s.

tools/ardusub-trial --binary ARDUSUB --defaults sub-6dof.parm --out out
.venv/bin/python tests/python/data/make_ardusub_exchange.py out/1.mcap

In this time ArduSub boots, arms, dives and holds its depth, flies ahead, moves sideways and holds its position.
differences_us: (n, 8) int16, of each frame's outputs from those of the frame before. positions_ned_m: (n / 400, 3),
where the vehicle was, once a second.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from uwsim.base.commands.table import SERVO_FRAMES
from uwsim.bridges.ardusub.servo_frames import unpacked
from uwsim.recording.reader import Recording

RATE_HZ, SECONDS, MOTORS = 400, 88, 8


def main(path: str) -> None:
    """Write the file beside this one."""
    recording = Recording(Path(path))
    sent = [unpacked(command.arguments["frames"]) for command in recording.commands() if command.name == SERVO_FRAMES]
    outputs = np.concatenate(sent)[: RATE_HZ * SECONDS, :MOTORS].astype(np.int16)
    wanted = {round(second * 1e9) for second in range(1, SECONDS + 1)}
    places = [m.message.pose.pose.position for m in recording.messages("odom") if m.time_ns in wanted]
    np.savez_compressed(
        Path(__file__).with_name("ardusub_exchange.npz"),
        differences_us=np.diff(outputs, axis=0, prepend=np.zeros((1, MOTORS), np.int16)),
        positions_ned_m=np.array([(place.y, place.x, -place.z) for place in places]),
    )


if __name__ == "__main__":
    main(sys.argv[1])
