"""`uwsim map from`: rebuild a map from a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.cli.bounds import readable
from uwsim.cli.map import MAPS
from uwsim.flight.raw_options import RawOptions


def from_recording(
    *,
    source: Annotated[
        Path, typer.Argument(help="A recording, FILE.mcap, of a survey or a live run.", callback=readable)
    ],
    out: Annotated[Path, typer.Option(help=f"The map to write, {' or '.join(MAPS)}.")] = Path("map.bt"),
    report: Annotated[
        Path | None, typer.Option(help="Also write the survey's report into this folder (of a survey only).")
    ] = None,
    vehicle: Annotated[
        str | None, typer.Option(help="Vehicle whose pings to use. Default: the first with any.")
    ] = None,
    outlier_filter: Annotated[
        bool | None,
        typer.Option(
            "--outlier-filter/--no-outlier-filter",
            help="Discard ranges with which their neighbours in the swath disagree. Default: as in the run.",
        ),
    ] = None,
    written: RawOptions,
) -> None:
    """Rebuild the map from a recording, byte for byte as in the run."""
    from uwsim.mapping.files.formats import MAP_FORMATS
    from uwsim.mapping.files.swath import survey_format
    from uwsim.recording.mcap_sink import SURVEY
    from uwsim.recording.pings import ping_topic
    from uwsim.recording.reader import Recording

    if out.suffix not in MAP_FORMATS:
        raise ValueError(f"--out {out}: must end in {' or '.join(MAP_FORMATS)}")
    raw, errors, known = written.raw, written.errors, written.known
    recording = Recording(source)
    is_survey = recording.start.kind == SURVEY
    has_its_pings = raw is not None and is_survey and survey_format(raw, "--raw").write is not None
    if is_survey:
        if vehicle is not None:
            raise ValueError("--vehicle: a survey has one vehicle")
        from uwsim.recording.survey_from import survey_from

        count = survey_from(
            recording, out, report, outlier_filter=outlier_filter, raw=raw if has_its_pings else None,
            offsets=errors, uncertainty=known,
        )  # fmt: skip
    else:
        if report is not None:
            raise ValueError(f"--report: '{source}' is no recording of a survey")
        from uwsim.recording.live_map import live_map

        occupancy, count = live_map(recording, vehicle, outlier_filter=outlier_filter)
        occupancy.write(out)
    if raw is not None and not has_its_pings:
        from uwsim.recording.raw_from import raw_from

        raw_from(recording, ping_topic(recording, vehicle), raw, errors, known)
    typer.echo(f"{out}: {count:,} pings" + ("" if recording.complete else "; the recording was cut off"))
