#!/usr/bin/env python3
"""A stand-in for the program ArduSub: frames by ArduPilot's JSON interface, and MAVLink on its second serial port.

The file `standin.json` in its folder states its life: {"frames": how many before it ends, "last": its last line,
"code": its exit code, "ignores": whether it ignores SIGTERM, "message": hex of the MAVLink that it sends, "pwm": [us]}.
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
    if life.get("ignores"):
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
    Path("pid.txt").write_text(str(os.getpid()))
    physics, radio, *serials = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(4))
    radio.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    radio.bind(("", int(options["rc-in-port"])))
    for number, serial in enumerate(serials):
        _, host, port = options[f"serial{number}"].split(":")
        serial.connect((host, int(port)))
    serial.setblocking(False)
    serial.send(bytes.fromhex(life.get("message", "00")))
    with Path("received.txt").open("w") as received:
        for number in range(life.get("frames", 2**31)):
            pwm = life.get("pwm", [1500] * 8)
            frame = struct.pack("<HHI16H", 18458, 400, number, *pwm, *[0] * (16 - len(pwm)))
            physics.sendto(frame, ("127.0.0.1", int(options["sim-port-out"])))
            physics.recv(2000)
            try:
                received.write(f"{serial.recv(4096).hex()}\n")
                received.flush()
            except BlockingIOError:
                pass
    sys.stdout.write(life.get("last", ""))
    return int(life.get("code", 0))


sys.exit(main())
