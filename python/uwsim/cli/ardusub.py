"""Options with which a compiled ArduSub flies the first vehicle."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any

import typer

from uwsim.cli.bounds import within
from uwsim.cli.choices import one_of
from uwsim.cli.options import need

if TYPE_CHECKING:
    from pathlib import Path

    from uwsim.bridges.ardusub import ArduSub
    from uwsim.live import LiveSimulator
    from uwsim.scenario import Scenario
    from uwsim.simulator.simulator import Simulator

Ardusub = Annotated[
    bool,
    typer.Option("--ardusub", help="Let a compiled ArduSub fly and make the steps; see docs/connections/ardupilot.md."),
]
ArdusubPort = Annotated[
    int | None, typer.Option(help="ArduSub: UDP port for its frames. Default: 9002.", callback=within(0, 65535))
]
ArdusubHost = Annotated[str | None, typer.Option(help="ArduSub: address to listen on. Default: 127.0.0.1.")]
ArdusubFrame = Annotated[
    str | None,
    typer.Option(
        help="ArduSub: its frame (FRAME_CONFIG). Default: the one that fits the vehicle's thrusters.",
        **one_of("vectored", "vectored_6dof"),
    ),
]
ArdusubNoise = Annotated[
    bool,
    typer.Option("--ardusub-noise", help="ArduSub: send it the IMU's and altimeter's readings with their errors."),
]
ArdusubLights = Annotated[
    int | None, typer.Option(help="ArduSub: number of the servo output of the lights.", callback=within(1, 32))
]
ArdusubTilt = Annotated[
    int | None, typer.Option(help="ArduSub: number of the servo output of the camera's tilt.", callback=within(1, 32))
]


class Autopilot:
    """The autopilot that options request, if any. Raises WithoutEffectError for options without --ardusub."""

    def __init__(
        self,
        *,
        ardusub: bool,
        ardusub_port: int | None,
        ardusub_host: str | None,
        ardusub_frame: str | None,
        ardusub_noise: bool,
        ardusub_lights: int | None,
        ardusub_tilt: int | None,
    ) -> None:
        self._is_wanted = ardusub
        given = {"port": ardusub_port, "host": ardusub_host, "frame": ardusub_frame, "lights": ardusub_lights,
                 "tilt": ardusub_tilt}  # fmt: skip
        if not ardusub:
            need("--ardusub", **{f"ardusub_{name}": value for name, value in given.items()},
                 ardusub_noise=ardusub_noise)  # fmt: skip
        self._options = {name: value for name, value in given.items() if value is not None}
        self._noise = ardusub_noise

    def __bool__(self) -> bool:
        """Return whether an autopilot is requested."""
        return self._is_wanted

    def scenario(self, scenario: str | Path) -> str | Path | Scenario:
        """Return the scenario, prepared for the autopilot. Raises ScenarioError."""
        if not self._is_wanted:
            return scenario
        from uwsim.bridges.ardusub import prepared
        from uwsim.scenario import load

        return prepared(load(scenario))

    def simulator(self, scenario: str | Path, **options: Any) -> Simulator:
        """Return a simulator of the prepared scenario. Raises ScenarioError."""
        from uwsim.simulator.simulator import Simulator

        return Simulator(self.scenario(scenario), **options)

    @contextmanager
    def flying(self, simulator: Simulator | LiveSimulator) -> Iterator[list[str]]:
        """Let the autopilot make the simulator's steps; yield its address for the greeting, if there is one."""
        if not self._is_wanted:
            yield []
            return
        from uwsim.bridges.ardusub import ArduSub

        with ArduSub(simulator, with_noise=self._noise, **self._options) as flown:  # type: ignore[arg-type]  # by name
            yield [greeting(flown)]


def greeting(flown: ArduSub) -> str:
    """Return the line that describes an autopilot's connection."""
    noise = "sensors with their errors" if flown.with_noise else "exact sensors"
    return f"ArduSub ({flown.frame}, {noise}) flies '{flown.vehicle}' by UDP {flown.address}"
