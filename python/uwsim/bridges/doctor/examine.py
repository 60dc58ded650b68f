"""All `uwsim ros doctor` checks, in order."""

from __future__ import annotations

from collections.abc import Iterator

from uwsim.bridges.doctor.finding import Finding
from uwsim.bridges.doctor.servers import ardusub_port, rosbridge_port
from uwsim.bridges.doctor.software import software
from uwsim.bridges.requested import ExaminedBridges


def examine(bridges: ExaminedBridges, port: int, ardusub: int, listen_s: float) -> Iterator[Finding]:
    """Yield findings as they become known.

    port: the rosbridge's. ardusub: the UDP port for ArduSub's frames. listen_s: how long to listen for peers [s].
    """
    yield from software()
    yield rosbridge_port(port)
    yield ardusub_port(ardusub, listen_s)
    yield from bridges.examine(listen_s)
