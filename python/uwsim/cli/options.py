"""Arguments and options that several commands share, and parsers for their values, such as --seeds."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from uwsim.base.options import OptionError, Options, option
from uwsim.cli.values import scenarios, within

MOST, MOST_LISTED = 100_000, 1000


def parsed_seeds(text: str, option: str) -> list[int]:
    """Return the seeds that a text means: 30 (0 to 29), 3,7 or 100-129; a single one is written 5-5.

    option: its name, for messages. Raises ValueError.
    """
    rule = f"{option} {text}: must be how many, such as 30, or a list, such as 0,1,2 or 100-129"
    seeds: list[int] = []
    try:
        if "," not in text and "-" not in text:
            text = f"0-{int(text) - 1}"
        for part in text.split(","):
            first, last = (int(end) for end in (part.split("-") if "-" in part else (part, part)))
            if not 0 <= first <= last < 2**32 or last - first >= MOST:
                raise ValueError
            seeds += range(first, last + 1)
    except ValueError:
        raise ValueError(rule) from None
    return seeds


def listed_seeds(text: str, option: str) -> list[int]:
    """Return the different seeds of a list with ranges, such as 1,2,5-20; a single number is a seed.

    option: its name, for messages. Raises OptionError.
    """
    found: list[int] = []
    for part in text.split(","):
        low, dash, high = part.strip().partition("-")
        if not (low.isdigit() and (high.isdigit() if dash else not high)) or len(low + high) > 12:
            raise OptionError(f"{option} {text}: '{part.strip()}': must be a whole number, or two as 5-20")
        found += range(int(low), int(high if dash else low) + 1)
        if not found or len(found) > MOST_LISTED:
            raise OptionError(f"{option} {text}: must be 1 to {MOST_LISTED} seeds, and a range's smaller number first")
    if len(set(found)) < len(found):
        raise OptionError(f"{option} {text}: must be different seeds")
    return found


def seeds_in(path: Path) -> list[int]:
    """Return the seeds of a file: lines as for listed_seeds; # begins a comment. Raises OptionError or OSError."""
    lines = [line.partition("#")[0].strip() for line in path.read_text(errors="replace").splitlines()]
    return listed_seeds(",".join(line for line in lines if line), f"--seeds {path}:")


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
