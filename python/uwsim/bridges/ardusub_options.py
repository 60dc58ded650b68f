"""Options with which a compiled ArduSub flies the first vehicle."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from uwsim.base.options import option
from uwsim.cli.autopilots import Autopilot

if TYPE_CHECKING:
    from pathlib import Path

    from uwsim.bridges.ardusub import ArduSub
    from uwsim.live import LiveSimulator
    from uwsim.scenario import Scenario
    from uwsim.simulator.simulator import Simulator


@dataclass(frozen=True)
class ArduSubOptions(Autopilot):
    """The options of ArduSub."""

    switch = "ardusub"

    ardusub: bool = option(False, "Let a compiled ArduSub fly and make the steps; see docs/connections/ardupilot.md.")
    ardusub_port: int | None = option(None, "ArduSub: UDP port for its frames. Default: 9002.", bounds=(0, 65535, ""))
    ardusub_host: str | None = option(None, "ArduSub: address to listen on. Default: 127.0.0.1.")
    ardusub_frame: str | None = option(
        None,
        "ArduSub: its frame (FRAME_CONFIG). Default: the one that fits the vehicle's thrusters.",
        choices=("vectored", "vectored_6dof"),
    )
    ardusub_noise: bool = option(False, "ArduSub: send it the IMU's and altimeter's readings with their errors.")
    ardusub_lights: int | None = option(None, "ArduSub: number of the servo output of the lights.", bounds=(1, 32, ""))
    ardusub_tilt: int | None = option(
        None, "ArduSub: number of the servo output of the camera's tilt.", bounds=(1, 32, "")
    )

    def scenario(self, scenario: str | Path) -> Scenario:
        """Return the scenario, prepared for the autopilot. Raises ScenarioError."""
        from uwsim.bridges.ardusub import prepared
        from uwsim.scenario import load

        return prepared(load(scenario))

    @contextmanager
    def flying(self, simulator: Simulator | LiveSimulator) -> Iterator[str]:
        """Let the autopilot make the simulator's steps; yield its address for the greeting."""
        from uwsim.bridges.ardusub import ArduSub

        given = {"port": self.ardusub_port, "host": self.ardusub_host, "frame": self.ardusub_frame,
                 "lights": self.ardusub_lights, "tilt": self.ardusub_tilt}  # fmt: skip
        options: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
        with ArduSub(simulator, with_noise=self.ardusub_noise, **options) as flown:
            yield greeting(flown)


def greeting(flown: ArduSub) -> str:
    """Return the line that describes an autopilot's connection."""
    noise = "sensors with their errors" if flown.with_noise else "exact sensors"
    return f"ArduSub ({flown.frame}, {noise}) flies '{flown.vehicle}' by UDP {flown.address}"
