"""`uwsim map build`: a map from files of real or simulated surveys, clouds or scan graphs."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from uwsim.cli.map import CLOUDS, MAPS
from uwsim.cli.values import readable, within

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from uwsim.mapping.files.swath import Swath

SHARE = 0.01  # the default voxel, as a share of the first ping's median depth below its sonar
PLACES = (1.0, 2.0, 5.0)
RANGE_MAX_M = 15_000.0
REACH_VOXELS = 2**15
GRAPH, POINTS_VOXEL_M = ".graph", 0.1


def build(
    out: Annotated[Path, typer.Argument(help=f"The map to write, {' or '.join(MAPS)}.")],
    sources: Annotated[
        list[Path],
        typer.Option(
            "--from",
            help=f"A survey (.gsf, .kmall, .xtf), a cloud ({', '.join(CLOUDS)}) or scans of OctoMap (.graph); "
            "repeatable.",
            callback=readable,
        ),
    ],
    voxel: Annotated[
        float | None,
        typer.Option(
            help="Edge of a voxel [m]. Default: 1 % of the first ping's depth; of a cloud or graph 0.1.",
            callback=within(0.01, 1000, "m"),
        ),
    ] = None,
    origin: Annotated[
        tuple[float, float] | None,
        typer.Option(
            help="The map's zero: of a survey, its latitude and longitude [deg], by default the first ping's; of a "
            "cloud, its x and y [m], by default 0 0, or the cloud's middle if it is farther away than a map reaches.",
            metavar="LAT LON",
            callback=within(-1e7, 1e7, "m"),
        ),
    ] = None,
    sensor_at: Annotated[
        tuple[float, float, float] | None,
        typer.Option(
            help="A cloud: where its sensor was, in its coordinates: the rays to its points are free. Default: a "
            ".pcd's VIEWPOINT, unless that is 0 0 0.",
            metavar="X Y Z",
            callback=within(-1e7, 1e7, "m"),
        ),
    ] = None,
    occupied_only: Annotated[
        bool, typer.Option("--occupied-only", help="A cloud: its points are occupied, and nothing is free.")
    ] = False,
) -> None:
    """Build a map from a survey file, a cloud or a scan graph.

    Of a survey, travel times are traced through the file's own sound-speed profile at its attitude and offsets, and
    inserted like a simulated ping. Beams that the file flags are left out. The map is in metres east and north of its
    zero. A cloud does not state where it was seen from: --sensor-at states it, or --occupied-only does without. Scans
    in OctoMap's .graph files have their poses; the map has the bytes of its own graph2tree.
    """
    from uwsim.mapping.occupancy_map import require_map_path

    require_map_path(out)  # before long work
    kinds = {path.suffix.lower() if path.suffix.lower() in (*CLOUDS, GRAPH) else "" for path in sources}
    if len(kinds) > 1 and kinds & {"", GRAPH}:
        raise ValueError("--from: surveys, clouds and graphs cannot be mixed")
    of_cloud = bool(kinds & {*CLOUDS})
    for option, is_given, is_its in (
        ("--origin", origin is not None, kinds == {""} or of_cloud),
        ("--sensor-at", sensor_at is not None, of_cloud),
        ("--occupied-only", occupied_only, of_cloud),
    ):
        if is_given and not is_its:
            raise ValueError(f"{option}: is not for '{sources[0]}'")
    if kinds == {""}:
        _from_surveys(out, sources, voxel, origin)
    else:
        _from_points(out, sources, voxel or POINTS_VOXEL_M, origin, sensor_at, occupied_only)


def _from_points(
    out: Path,
    sources: list[Path],
    voxel_m: float,
    zero: tuple[float, float] | None,
    sensor_at: tuple[float, float, float] | None,
    occupied_only: bool,
) -> None:
    """Build a map from clouds, each seen from the same place or from nowhere, or from graphs."""
    import numpy as np

    from uwsim.mapping import OccupancyMap
    from uwsim.mapping.files.cloud_files import read_cloud, seen_from
    from uwsim.mapping.files.scan_graph import read_scans

    if sensor_at is not None and occupied_only:
        raise ValueError("--sensor-at: must not be given beside --occupied-only, which leaves nothing free")
    occupancy, origin = OccupancyMap(resolution_m=voxel_m), None if zero is None else np.array([*zero, 0.0])
    scans = points = 0
    for path in sources:
        if path.suffix.lower() == GRAPH:
            for scan in read_scans(path):
                occupancy.insert_scan(scan.points_world_m, scan.origin_m, np.inf)
                scans, points = scans + 1, points + len(scan.points_world_m)
            continue
        sensor = None if occupied_only else seen_from(path) if sensor_at is None else np.array(sensor_at)
        if sensor is None and not occupied_only:
            rule = "a cloud does not state where it was seen from: give --sensor-at X Y Z or --occupied-only"
            raise ValueError(f"--from {path}: {rule}")
        found = read_cloud(path)
        if origin is None and len(found):
            origin = _zero_m(found, occupancy.resolution_m)
        cloud = (found if origin is None else found - origin).astype(np.float32)
        scans, points = scans + 1, points + len(cloud)
        if sensor is not None:
            if sensor_at is None:
                typer.echo(f"{path}: seen from {' '.join(f'{x:g}' for x in sensor)}, its VIEWPOINT")
            occupancy.insert_scan(cloud, sensor if origin is None else sensor - origin, np.inf)
        else:
            one = np.unique(np.floor(cloud / voxel_m), axis=0, return_index=True)[1]
            each = cloud[np.sort(one)]
            occupancy.insert_scans(each, np.ones(len(each), np.int64), each.astype(np.float64), np.inf)
    if not points:
        raise ValueError(f"--from {sources[0]}: has no points")
    about = ""
    if origin is not None and origin.any():
        about = f"; zero at {' '.join(f'{x:.12g}' for x in origin)}, which the file states"
        with tempfile.NamedTemporaryFile(suffix=".ot") as whole:
            occupancy.write(whole.name)
            occupancy = OccupancyMap.read(whole.name, origin)
    occupancy.write(out)
    typer.echo(f"{out}: {scans:,} scans, {points:,} points, voxels of {voxel_m:g} m{about}")


def _zero_m(points: NDArray[np.float64], voxel_m: float) -> NDArray[np.float64]:
    """Return zero, or, where a map about it would not reach a cloud's points, their middle in whole metres."""
    import numpy as np

    low, high = points.min(axis=0), points.max(axis=0)
    far = np.maximum(np.abs(low), np.abs(high)) >= REACH_VOXELS * voxel_m
    far[:2] = far[:2].any()
    return np.where(far, np.round(0.5 * (low + high)), 0.0)


def _from_surveys(out: Path, sources: list[Path], voxel: float | None, origin: tuple[float, float] | None) -> None:
    import numpy as np  # here, since all commands are imported for completion

    from uwsim.mapping import OccupancyMap
    from uwsim.mapping.files.georeference import Georeference, metres_about
    from uwsim.mapping.map_filler import MapFiller
    from uwsim.mapping.ping_to_map import traced_beams
    from uwsim.mapping.survey_soundings import open_surveys

    surveys = open_surveys(sources, "--from")
    start = surveys[0].first
    latitude, longitude = origin or (start.latitude_deg, start.longitude_deg)
    if not (abs(latitude) <= 90.0 and abs(longitude) <= 180.0):
        raise ValueError(f"--origin {latitude:g} {longitude:g}: must be a latitude and a longitude [deg]")
    place = Georeference(metres_about((longitude, latitude)))
    occupancy = OccupancyMap(resolution_m=voxel or _voxel_m(start))
    pings = soundings = 0
    with MapFiller(occupancy, RANGE_MAX_M) as filler:
        for survey in surveys:
            for swath in survey.swaths:
                ends, sonar = traced_beams(swath, survey.profile, place)
                echoes = ends[np.isfinite(ends[:, 0])].astype(np.float32)
                filler.insert(echoes, sonar)
                pings, soundings = pings + 1, soundings + len(echoes)
    if not soundings:
        raise ValueError(f"--from {sources[0]}: no beam of its {pings} pings has a travel time that is not flagged")
    occupancy.write(out)
    typer.echo(
        f"{out}: {pings:,} pings, {soundings:,} soundings, voxels of {occupancy.resolution_m:g} m; "
        f"zero at {latitude:.7f} {longitude:.7f}"
    )


def _voxel_m(swath: Swath) -> float:
    """Return 1 % of a swath's median depth below its sonar, rounded to 1, 2 or 5 times a power of ten."""
    import numpy as np

    seen = swath.is_detected
    if not seen.any():
        return 1.0
    least_m = SHARE * max(
        1.0, float(np.median(0.5 * swath.sound_speed_m_s * swath.travel_time_s[seen] * swath.axes[seen, 2]))
    )
    power = 10.0 ** math.floor(math.log10(least_m))
    return min((each * power for each in (*PLACES, 10.0)), key=lambda each: abs(math.log(each / least_m)))
