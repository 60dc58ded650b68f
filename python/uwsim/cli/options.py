"""Arguments and options that several commands share, and parsers for their values."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from uwsim.cli.bounds import within
from uwsim.cli.values import modems, scenarios, sonars, vehicle_models

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
Seed = Annotated[int | None, typer.Option(help="Replaces the scenario's seed.", callback=within(0, 2**63 - 1))]
Voxel = Annotated[
    float | None,
    typer.Option(help="Edge of the map's voxels [m]; replaces the scenario's.", callback=within(0.02, 10, "m")),
]
VehicleModel = Annotated[
    str | None,
    typer.Option(
        "--vehicle-model",
        help="Replaces the model of the scenario's first vehicle: a packaged one's name, or a YAML file.",
        autocompletion=vehicle_models,
    ),
]
SonarModel = Annotated[
    str | None,
    typer.Option(
        help="Replaces the scenario's sonar: 1 to 4 as in the protocol, a packaged model's name, or a YAML file.",
        autocompletion=sonars,
    ),
]
Frequency = Annotated[
    float | None,
    typer.Option(
        help="Replaces the scenario's sonar frequency [kHz], for a sonar with several.",
        callback=within(0.1, 1e5, "kHz"),
    ),
]


def print_json(values: Any) -> None:
    """Print values as JSON: SI units, fractions in [0, 1], null for NaN."""
    import orjson  # imported here, so that --help is fast

    typer.echo(orjson.dumps(values, option=orjson.OPT_INDENT_2 | orjson.OPT_SERIALIZE_NUMPY).decode())


def hertz(frequency_khz: float | None) -> float | None:
    """Convert the value of --frequency, which is in kHz, if it is given."""
    return None if frequency_khz is None else 1e3 * frequency_khz


Pose = Annotated[
    str | None,
    typer.Option(
        help="Pose of the vehicle: X,Y,Z [m][,YAW[,PITCH[,ROLL]]] [deg], positive PITCH is nose down. "
        "Default: its start pose."
    ),
]
VehicleName = Annotated[str | None, typer.Option("--vehicle", help="Name of the vehicle. Default: the first.")]
MissionTime = Annotated[
    float | None, typer.Option(help="Replaces the scenario's battery time [s].", callback=within(1, 1e6, "s"))
]
Link = Annotated[
    str | None,
    typer.Option(
        help="Link between station and vehicles: none, tether, ideal_acoustic, micromodem, s2cm_hs, or a YAML file. "
        "Replaces the scenario's modem.",
        autocompletion=modems,
    ),
]
Record = Annotated[
    Path | None, typer.Option(help="Record the run into a new file: FILE.mcap, or FILE.bag for ROS 1 (no replay).")
]
RecordTopics = Annotated[
    list[str] | None,
    typer.Option(
        "--record-topic", help="Channels to record, such as scan or 'camera/*'. Default: all but pictures and maps."
    ),
]
RecordAll = Annotated[
    bool,
    typer.Option(
        "--record-all", help="Also record pictures and maps; prints first how much processor time that takes."
    ),
]
SurveyTopics = Annotated[
    list[str] | None,
    typer.Option(
        "--record-topic",
        help="Channels to record, such as odom or 'proximity_*'. Default: all but pictures and channels derived "
        "from pings: scan, ping, laserPointCloud, points, depthArray, map_changes and octomap_binary.",
    ),
]
Threads = Annotated[
    int | None,
    typer.Option(
        help="Number of threads; the result does not depend on it. Default: one per core.", callback=within(1, 1024)
    ),
]


def sonar_model(text: str | None) -> int | str | None:
    """Convert a protocol number to int; return a name or path unchanged."""
    return int(text) if text is not None and text.isascii() and text.isdigit() else text
