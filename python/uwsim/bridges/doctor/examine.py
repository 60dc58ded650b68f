"""All that `uwsim ros doctor` looks at, in order."""

from __future__ import annotations

from collections.abc import Iterator

from uwsim.bridges.doctor.finding import Finding
from uwsim.bridges.doctor.software import software
from uwsim.bridges.requested import ExaminedBridges


def examine(bridges: ExaminedBridges, listen_s: float) -> Iterator[Finding]:
    """Yield findings as they become known: the software, then each bridge's peers. listen_s: how long to listen [s]."""
    yield from software()
    yield from bridges.examine(listen_s)
