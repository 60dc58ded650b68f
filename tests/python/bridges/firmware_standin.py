#!/usr/bin/env python3
"""A stand-in for the program ArduSub: frames by ArduPilot's JSON interface, and MAVLink on its second serial port.

The file `standin.json` in its folder states its life: {"frames": how many before it ends, "last": its last line,
"code": its exit code, "ignores": whether it ignores SIGTERM, "message": hex of the MAVLink that it sends, "pwm": [us],
"restarts": the frame at which it starts again, with other sockets for MAVLink}.
It writes the datagrams that it receives to `received.txt`, as hex.
"""

import json
import os
import signal
import socket
import struct
import sys
from pathlib import Path


def main() -> int:
    """Send frames, each after the answer to the last, until killed or as stated."""
    options = dict(word[2:].split("=", 1) for word in sys.argv[1:])
    found = Path("standin.json")
    life = json.loads(found.read_text()) if found.exists() else {}
    restarts = life.get("restarts")
    if life.get("ignores"):
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
    Path("pid.txt").write_text(str(os.getpid()))
    physics, radio = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
    radio.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    radio.bind(("", int(options["rc-in-port"])))
    serials = [connected(options[f"serial{number}"]) for number in range(2)]
    with Path("received.txt").open("w") as received:
        for number in range(life.get("frames", 2**31)):
            if restarts and number == restarts:
                serials = [connected(options[f"serial{number}"]) for number in range(2)]
            if number % 20 == 0:
                serials[1].send(bytes.fromhex(life.get("message", "00")))
            pwm = life.get("pwm", [1500] * 8)
            frame = struct.pack(
                "<HHI16H", 18458, 400, number % restarts if restarts else number, *pwm, *[0] * (16 - len(pwm))
            )
            physics.sendto(frame, ("127.0.0.1", int(options["sim-port-out"])))
            physics.recv(2000)
            try:
                received.write(f"{serials[1].recv(4096).hex()}\n")
                received.flush()
            except BlockingIOError:
                pass
    sys.stdout.write(life.get("last", ""))
    return int(life.get("code", 0))


def connected(address: str) -> socket.socket:
    """A UDP socket that sends to an address, such as udpclient:127.0.0.1:14550, and receives from it."""
    _, host, port = address.split(":")
    made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    made.connect((host, int(port)))
    made.setblocking(False)
    return made


sys.exit(main())
