"""`uwsim map from`: rebuild a map from a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.cli.map import MAPS
from uwsim.cli.values import require_file, within
from uwsim.flight.raw_options import RawOptions


def from_recording(
    *,
    source: Annotated[
        Path, typer.Argument(help="A recording, FILE.mcap, of a survey or a live run; or another's bag of ROS.")
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
    topic: Annotated[
        str | None, typer.Option(help="A bag: the topic of clouds or laser scans. Default: that with most messages.")
    ] = None,
    frame: Annotated[
        str | None, typer.Option(help="A bag: the frame of the map. Default: the root of the clouds' transforms.")
    ] = None,
    voxel: Annotated[
        float | None, typer.Option(help="A bag: edge of a voxel [m]. Default: 0.2.", callback=within(0.01, 1000, "m"))
    ] = None,
    written: RawOptions,
) -> None:
    """Rebuild the map from a recording, byte for byte as in the run.

    Of a bag that others wrote (ROS 1 or 2, as .bag, .mcap, .db3 or a folder), PointCloud2 or LaserScan are inserted
    from where the transforms of their times put them; what cannot be placed is counted.
    """
    from uwsim.mapping.files.formats import MAP_FORMATS
    from uwsim.mapping.files.swath import survey_format
    from uwsim.mapping.occupancy_map import require_map_path
    from uwsim.recording.foreign_bag import VOXEL_M, foreign_bag, map_from_bag
    from uwsim.recording.mcap_sink import SURVEY
    from uwsim.recording.pings import ping_topic
    from uwsim.recording.reader import Recording

    if out.suffix not in MAP_FORMATS:
        raise ValueError(f"--out {out}: must end in {' or '.join(MAP_FORMATS)}")
    if not source.is_dir():
        require_file(source, "SOURCE")
    if (bag := foreign_bag(source)) is not None:
        for option, value in (("report", report), ("vehicle", vehicle), ("raw", written.raw)):
            if value is not None:
                raise ValueError(f"--{option}: is not for '{source}', a bag that uwsim did not write")
        if outlier_filter is not None:
            raise ValueError(f"--outlier-filter: is not for '{source}', a bag that uwsim did not write")
        require_map_path(out)
        made = map_from_bag(bag, topic=topic, frame=frame, voxel_m=voxel or VOXEL_M)
        for note in made.notes:
            typer.echo(note)
        made.map.write(out)
        typer.echo(f"{out}: {made.scans:,} clouds, voxels of {voxel or VOXEL_M:g} m")
        return
    for option, given in (("topic", topic), ("frame", frame), ("voxel", voxel)):
        if given is not None:
            raise ValueError(f"--{option}: is for bags of others; '{source}' is a recording")
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
        from uwsim.recording.survey_from import live_map

        occupancy, count = live_map(recording, vehicle, outlier_filter=outlier_filter)
        occupancy.write(out)
    if raw is not None and not has_its_pings:
        from uwsim.recording.survey_from import raw_from

        raw_from(recording, ping_topic(recording, vehicle), raw, errors, known)
    typer.echo(f"{out}: {count:,} pings" + ("" if recording.complete else "; the recording was cut off"))
