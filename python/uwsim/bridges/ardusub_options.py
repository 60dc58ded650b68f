"""Options with which a compiled ArduSub flies the first vehicle."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from uwsim.base.options import Flag, FlagGroup, WithoutEffectError, need, option
from uwsim.cli.autopilots import Autopilot

if TYPE_CHECKING:
    from uwsim.bridges.ardusub import ArduSub
    from uwsim.live import LiveSimulator
    from uwsim.scenario import Scenario
    from uwsim.simulator.simulator import Simulator

LIGHTS, TILT = 13, 16
"""Servo outputs of a firmware that is started here, as a BlueROV2 with the Navigator board assigns them."""


@dataclass(frozen=True)
class ArduSubOptions(Autopilot):
    """The options of ArduSub."""

    switch = "ardusub"

    ardusub: bool = option(False, "Let a compiled ArduSub fly and make the steps; see docs/connections/ardupilot.md.")
    ardusub_binary: Path | None = option(None, "ArduSub: start this program, instead of waiting for one.")
    ardusub_parameters: tuple[str, ...] = option((), "ArduSub: parameter file for the program; may be repeated.")
    ardusub_folder: str | None = option(
        None, "ArduSub: folder that keeps the program's parameters and logs. Default: a temporary one."
    )
    ardusub_station: str | None = option(
        None, "ArduSub: UDP address to which the program sends MAVLink. Default: 127.0.0.1:14550."
    )
    ardusub_vehicle: str | None = option(
        None,
        "ArduSub: vehicle that replaces the first one, as a packaged name or a file. Default: bluerov2_heavy_outfit, "
        "with `uwsim ardusub` always, otherwise if the first one has no thrusters.",
    )
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

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.ardusub_binary is None:
            of_program = {name: getattr(self, name) for name in OF_PROGRAM}
            need("--ardusub-binary", **of_program)
        elif self.ardusub_host is not None:
            rule = "the program that is started here connects to 127.0.0.1"
            raise WithoutEffectError(f"--ardusub-host: cannot be given with --ardusub-binary: {rule}")

    def scenario(self, scenario: str | Path) -> Scenario:
        """Return the scenario, prepared for the autopilot. Raises ScenarioError."""
        from uwsim.bridges.ardusub import prepared
        from uwsim.scenario import load

        return prepared(load(scenario), self.ardusub_vehicle)

    @contextmanager
    def flying(self, simulator: Simulator | LiveSimulator) -> Iterator[str]:
        """Let the autopilot make the simulator's steps; yield its address for the greeting."""
        from uwsim.bridges.ardusub import ArduSub

        given = {"port": self.ardusub_port, "host": self.ardusub_host, "frame": self.ardusub_frame,
                 "lights": self.ardusub_lights, "tilt": self.ardusub_tilt}  # fmt: skip
        options: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
        if self.ardusub_binary is not None:
            options = {"port": 0, "lights": LIGHTS, "tilt": TILT, **options}
        with ExitStack() as stack:
            flown = stack.enter_context(ArduSub(simulator, with_noise=self.ardusub_noise, **options))
            text = greeting(flown)
            if self.ardusub_binary is not None:
                from uwsim.bridges.firmware_flight import STATION, firmware_flying

                station = self.ardusub_station or STATION
                files = [Path(each) for each in self.ardusub_parameters]
                folder = None if self.ardusub_folder is None else Path(self.ardusub_folder)
                stack.enter_context(
                    firmware_flying(flown, self.ardusub_binary, station=station, files=files, folder=folder)
                )
                text = f"{text}, with MAVLink to UDP {station}"
            yield text


OF_PROGRAM = ("ardusub_parameters", "ardusub_folder", "ardusub_station")


class ProgramOptions(FlagGroup):
    """The options of ArduSub for a command that starts its program."""

    def __init__(self, **values: Any) -> None:
        self._values = values

    @classmethod
    def flags(cls) -> Mapping[str, Flag]:
        """Return the flags by name."""
        given = ("ardusub", "ardusub_binary", "ardusub_host")
        return {name: flag for name, flag in ArduSubOptions.flags().items() if name not in given}

    def of(self, binary: Path) -> ArduSubOptions:
        """Return the options with which this program is started. Raises OptionError."""
        from uwsim.bridges.ardusub import VEHICLE

        vehicle = self._values.get("ardusub_vehicle") or VEHICLE
        return ArduSubOptions(**{**self._values, "ardusub_vehicle": vehicle}, ardusub=True, ardusub_binary=binary)


def greeting(flown: ArduSub) -> str:
    """Return the line that describes an autopilot's connection."""
    noise = "sensors with their errors" if flown.with_noise else "exact sensors"
    return f"ArduSub ({flown.frame}, {noise}) flies '{flown.vehicle}' by UDP {flown.address}"
