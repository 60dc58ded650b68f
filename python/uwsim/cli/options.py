"""Arguments and options that several commands share, and parsers for their values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import typer

from uwsim.base.options import Options, option
from uwsim.cli.bounds import within
from uwsim.cli.values import scenarios

SETTINGS: dict[str, Any] = {
    "add_completion": False,
    "context_settings": {"help_option_names": ["-h", "--help"]},
    "pretty_exceptions_enable": False,
    "rich_markup_mode": None,  # markup would swallow units in brackets
}
"""Settings for all typer programs."""

ScenarioName = Annotated[
    str, typer.Argument(help="Name of a packaged scenario, or path of a YAML file.", autocompletion=scenarios)
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON.")]
SEED, SEEDS = "Replaces the scenario's seed.", (0, 2**63 - 1, "")
VOXEL, VOXELS = "Edge of the map's voxels [m]; replaces the scenario's.", (0.02, 10, "m")
THREADS, THREAD_COUNTS = "Number of threads; the result does not depend on it. Default: one per core.", (1, 1024, "")
Seed = Annotated[int | None, typer.Option(help=SEED, callback=within(*SEEDS))]
Voxel = Annotated[
    float | None,
    typer.Option(help=VOXEL, callback=within(*VOXELS)),
]


def print_json(values: Any) -> None:
    """Print values as JSON: SI units, fractions in [0, 1], null for NaN."""
    import orjson  # imported here, so that --help is fast

    typer.echo(orjson.dumps(values, option=orjson.OPT_INDENT_2 | orjson.OPT_SERIALIZE_NUMPY).decode())


Pose = Annotated[
    str | None,
    typer.Option(
        help="Pose of the vehicle: X,Y,Z [m][,YAW[,PITCH[,ROLL]]] [deg], positive PITCH is nose down. "
        "Default: its start pose; for the first vehicle's cameras, the scenario's view."
    ),
]
VehicleName = Annotated[str | None, typer.Option("--vehicle", help="Name of the vehicle. Default: the first.")]
Threads = Annotated[int | None, typer.Option(help=THREADS, callback=within(*THREAD_COUNTS))]


@dataclass(frozen=True)
class SonarOptions(Options):
    """The options of a scenario with another sonar."""

    seed: int | None = option(None, SEED, bounds=SEEDS)
    sonar_model: str | None = option(
        None,
        "Replaces the scenario's sonar: 1 to 4 as in the protocol, a packaged model's name, or a YAML file.",
        completion="sonars",
    )
    frequency: float | None = option(
        None, "Replaces the scenario's sonar frequency [kHz], for a sonar with several.", bounds=(0.1, 1e5, "kHz")
    )

    @property
    def sonar(self) -> int | str | None:
        """The sonar: a number of the protocol, a name or a path."""
        text = self.sonar_model
        return int(text) if text is not None and text.isascii() and text.isdigit() else text

    @property
    def frequency_hz(self) -> float | None:
        """The frequency [Hz]."""
        return None if self.frequency is None else 1e3 * self.frequency

    @property
    def arguments(self) -> dict[str, Any]:
        """Those that are given, as arguments of a Simulator."""
        found = super().arguments | {"sonar_model": self.sonar, "sonar_frequency_hz": self.frequency_hz}
        return {name: value for name, value in found.items() if value is not None and name != "frequency"}


@dataclass(frozen=True)
class SimulatorOptions(SonarOptions):
    """The options of a simulator that is built for a command."""

    vehicle_model: str | None = option(
        None,
        "Replaces the model of the scenario's first vehicle: a packaged one's name, or a YAML file.",
        completion="vehicles",
    )
    mission_time_s: float | None = option(None, "Replaces the scenario's battery time [s].", bounds=(1, 1e6, "s"))
    link: str | None = option(
        None,
        "Link between station and vehicles: none, tether, ideal_acoustic, micromodem, s2cm_hs, or a YAML file. "
        "Replaces the scenario's modem.",
        completion="modems",
    )
    threads: int | None = option(None, THREADS, bounds=THREAD_COUNTS)
