"""Options with which compiled ArduSubs fly vehicles."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from uwsim.base.options import Flag, FlagGroup, OptionError, WithoutEffectError, need, option
from uwsim.cli.autopilots import Autopilot

if TYPE_CHECKING:
    from uwsim.bridges.ardusub.ardusub import ArduSub
    from uwsim.live import LiveSimulator
    from uwsim.scenario import Scenario
    from uwsim.simulator.simulator import Simulator

PORT_MAX = 65535
LIGHTS, TILT = 13, 16
"""Servo outputs of a firmware that is started here, as a BlueROV2 with the Navigator board assigns them."""


@dataclass(frozen=True)
class ArduSubOptions(Autopilot):
    """The options of ArduSub."""

    switch = "ardusub"

    ardusub: bool = option(False, "Let a compiled ArduSub fly and make the steps; see docs/connections/ardupilot.md.")
    ardusub_fly: tuple[str, ...] = option(
        (), "ArduSub: name of the vehicle that it flies; may be repeated, for one program each. Default: the first one."
    )
    ardusub_binary: Path | None = option(None, "ArduSub: start this program, instead of waiting for one.")
    ardusub_parameters: tuple[str, ...] = option((), "ArduSub: parameter file for the program; may be repeated.")
    ardusub_folder: str | None = option(
        None,
        "ArduSub: folder that keeps the program's parameters and logs, in a folder for each vehicle if there are "
        "several. Default: a temporary one.",
    )
    ardusub_station: str | None = option(
        None, "ArduSub: UDP address to which the program sends MAVLink. Default: 127.0.0.1:14550."
    )
    ardusub_vehicle: str | None = option(
        None,
        "ArduSub: vehicle that replaces the one to be flown, as a packaged name or a file. Default: "
        "bluerov2_heavy_outfit, with `uwsim ardusub` always, otherwise if that one has no thrusters.",
    )
    ardusub_port: int | None = option(
        None,
        "ArduSub: UDP port for its frames; each further one's is 10 higher. Default: 9002.",
        bounds=(0, PORT_MAX, ""),
    )
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
        from uwsim.bridges.ardusub.ardusub import prepared
        from uwsim.scenario import load

        return prepared(load(scenario), self.ardusub_vehicle, self.ardusub_fly)

    @contextmanager
    def flying(self, simulator: Simulator | LiveSimulator) -> Iterator[str]:
        """Let the autopilots make the simulator's steps; yield their addresses for the greeting."""
        with ExitStack() as stack:
            texts = [
                stack.enter_context(self._flying(simulator, name, number))
                for number, name in enumerate(self.ardusub_fly or (None,))
            ]
            yield "; ".join(texts)

    @contextmanager
    def _flying(self, simulator: Simulator | LiveSimulator, vehicle: str | None, number: int) -> Iterator[str]:
        from uwsim.bridges.ardusub.ardusub import ArduSub

        given = {"port": self._port(number), "host": self.ardusub_host, "frame": self.ardusub_frame,
                 "lights": self.ardusub_lights, "tilt": self.ardusub_tilt}  # fmt: skip
        options: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
        if self.ardusub_binary is not None:
            options = {"lights": LIGHTS, "tilt": TILT, **options}
        with ExitStack() as stack:
            flown = stack.enter_context(ArduSub(simulator, vehicle=vehicle, with_noise=self.ardusub_noise, **options))
            text = greeting(flown)
            if self.ardusub_binary is not None:
                from uwsim.bridges.firmware.flight import STATION, firmware_flying

                station = self.ardusub_station or STATION
                files = [Path(each) for each in self.ardusub_parameters]
                folder = None if self.ardusub_folder is None else Path(self.ardusub_folder)
                if folder is not None and len(self.ardusub_fly) > 1:
                    folder /= flown.vehicle
                stack.enter_context(
                    firmware_flying(
                        flown, self.ardusub_binary, station=station, files=files, folder=folder, system=1 + number
                    )
                )
                text = f"{text}, with MAVLink to UDP {station} as system {1 + number}"
            yield text

    def _port(self, number: int) -> int:
        """Return the port of the ArduSub with this number, from 0. A program that is started here may have any."""
        from uwsim.bridges.ardusub.ardusub import PORT, PORTS_APART

        first = self.ardusub_port if self.ardusub_port is not None else 0 if self.ardusub_binary else PORT
        port = first and first + PORTS_APART * number
        if port > PORT_MAX:
            raise OptionError(f"--ardusub-port: {first}: the port of vehicle {number + 1} would be {port}")
        return port


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
        from uwsim.bridges.ardusub.ardusub import VEHICLE

        vehicle = self._values.get("ardusub_vehicle") or VEHICLE
        return ArduSubOptions(**{**self._values, "ardusub_vehicle": vehicle}, ardusub=True, ardusub_binary=binary)


def greeting(flown: ArduSub) -> str:
    """Return the line that describes an autopilot's connection."""
    noise = "sensors with their errors" if flown.with_noise else "exact sensors"
    return f"ArduSub ({flown.frame}, {noise}) flies '{flown.vehicle}' by UDP {flown.address}"
