"""Packets of bridges' peers, from which the fuzzers begin."""

from __future__ import annotations

import json
from pathlib import Path

EXCHANGE = Path(__file__).parents[1] / "python" / "data" / "moos" / "exchange.json"


def moos() -> list[bytes]:
    """Return what a MOOSDB has sent."""
    exchange = json.loads(EXCHANGE.read_text())
    return [bytes.fromhex(each["bytes"]) for each in exchange if each["from"] == "MOOSDB"]


def imc() -> list[bytes]:
    """Return a packet of each message, and all of them together."""
    from uwsim.bridges.imc.wire import FORMATS, Message, encoded

    inline = {"beam_config": [("BeamConfig", {"beam_width": 0.5})], "data": b"\1\2", "list": "DVL=1", "services": "a;b"}
    packets = [
        encoded(Message(name, {field: inline[field] for field, _ in of if field in inline}, 0xD1, 1, 1.5))
        for name, (_, of) in FORMATS.items()
    ]
    return [b"".join(packets), *packets]
