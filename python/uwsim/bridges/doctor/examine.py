"""All `uwsim doctor` checks, in order."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from uwsim.bridges.doctor.environment import environment
from uwsim.bridges.doctor.finding import Finding
from uwsim.bridges.doctor.network import network
from uwsim.bridges.doctor.servers import ardusub_port, foxglove_port, rosbridge_port
from uwsim.bridges.doctor.software import extra, software
from uwsim.bridges.ros2.settings import Ros2Settings


@dataclass(frozen=True)
class Plan:
    """The settings for the checks. listen_s: how long to listen for other participants in the domain."""

    settings: Ros2Settings
    port: int = 9090
    foxglove: int = 8765
    ardusub: int = 9002
    listen_s: float = 3.0


def examine(plan: Plan, variables: Mapping[str, str]) -> Iterator[Finding]:
    """Yield findings as they become known. variables: the environment variables."""
    yield from software()
    yield rosbridge_port(plan.port)
    yield foxglove_port(plan.foxglove)
    yield ardusub_port(plan.ardusub, plan.listen_s)
    yield from environment(variables, plan.settings)
    yield from network(plan.settings)
    if extra("ros2").verdict == "ok":
        from uwsim.bridges.doctor.discovery import discovery

        yield from discovery(plan.settings, plan.listen_s)
