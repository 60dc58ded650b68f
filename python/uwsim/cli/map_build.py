"""`uwsim map build`: a map from files of real or simulated surveys."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from uwsim.cli.bounds import readable, within
from uwsim.cli.map import MAPS

if TYPE_CHECKING:
    from uwsim.mapping.files.swath import Swath

SHARE = 0.01  # the default voxel, as a share of the first ping's median depth below its sonar
PLACES = (1.0, 2.0, 5.0)
RANGE_MAX_M = 15_000.0


def build(
    out: Annotated[Path, typer.Argument(help=f"The map to write, {' or '.join(MAPS)}.")],
    sources: Annotated[
        list[Path],
        typer.Option("--from", help="A survey, FILE.gsf or FILE.kmall; may be given several times.", callback=readable),
    ],
    voxel: Annotated[
        float | None,
        typer.Option(
            help="Edge of a voxel [m]. Default: 1 % of the first ping's depth.", callback=within(0.01, 1000, "m")
        ),
    ] = None,
    origin: Annotated[
        tuple[float, float] | None,
        typer.Option(
            help="Latitude and longitude [deg] of the map's zero. Default: the first ping's.",
            metavar="LAT LON",
            callback=within(-180, 180, "deg"),
        ),
    ] = None,
) -> None:
    """Build a map from a survey file.

    Travel times are traced through the file's own sound-speed profile at its attitude and offsets, and inserted like a
    simulated ping. Beams that the file flags are left out. The map is in metres east and north of its zero.
    """
    import numpy as np  # here, since all commands are imported for completion

    from uwsim.mapping import OccupancyMap
    from uwsim.mapping.files.georeference import Georeference, metres_about
    from uwsim.mapping.map_filler import MapFiller
    from uwsim.mapping.occupancy_map import require_map_path
    from uwsim.mapping.ping_to_map import traced_beams
    from uwsim.mapping.survey_soundings import open_surveys

    require_map_path(out)  # before long work
    surveys = open_surveys(sources, "--from")
    start = surveys[0].first
    latitude, longitude = origin or (start.latitude_deg, start.longitude_deg)
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
