"""Drives the pilot in the simulator, without ROS: `uwsim course score` starts this program, and time waits for it.

Each line is JSON. The program states what it reads; then, in turns, the simulator sends the messages of a period and
the program its commands, until a line states why the run has ended.
"""

import json
import os
import socket
import sys
from pathlib import Path
from types import SimpleNamespace

sys.path[0] = str(Path(__file__).resolve().parents[1])  # where the package is, as ROS has it

from pilot.pilot import READS, Pilot  # noqa: E402


def main():
    """Fly until the run ends."""
    pilot = Pilot(log=lambda text: print(text, flush=True))
    with socket.socket(fileno=int(os.environ["UWSIM_COURSE_FD"])) as peer, peer.makefile("rw") as lines:

        def send(values):
            print(json.dumps(values), file=lines, flush=True)

        send({"reads": list(READS)})
        for line in lines:
            turn = json.loads(line, object_hook=lambda values: SimpleNamespace(**values))
            if hasattr(turn, "ended_because"):
                print(turn.ended_because)
                return
            for topic, message in turn.messages:
                pilot.receive(topic, message)
            send({"commands": pilot.commands()})


if __name__ == "__main__":
    main()
