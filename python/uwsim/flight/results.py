"""Scores a flight's map, prints the summary, and writes the results to the output folder."""

from __future__ import annotations

import tempfile
import warnings
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from uwsim.base.extras import MissingExtraError
from uwsim.flight.log import rewrite_if_lost
from uwsim.flight.record import Ashore, FlightRecord
from uwsim.flight.summary import ashore_text, flight_values, summary_table
from uwsim.flight.terminal import Silent
from uwsim.mapping import OccupancyMap
from uwsim.mapping.files.georeference import Georeference
from uwsim.scenario.georeference import georeference
from uwsim.scoring.map_score import MapScore, score_map
from uwsim.scoring.score_text import write_json
from uwsim.scoring.survey_track import TRACK
from uwsim.scoring.true_surface import SurfaceAhead
from uwsim.simulator.link_traffic import text_table
from uwsim.simulator.simulator import Simulator

if TYPE_CHECKING:
    from uwsim.figures.truth_and_map import TruthAndMap

REPORTS = ("full", "json", "none")
MAP, REPORT, SUMMARY, MAP_ASHORE = "map.bt", "report.html", "summary.json", "map_ashore.bt"
FIGURE_FILES = (
    "truth_and_map.png", "map_from_above.png", "where_it_is_wrong.png", "sonar_fan.png", "depth_profile.png",
    "map_growth.png", "track.png", "estimate.png", "estimate_budget.png",
)  # fmt: skip
RESULT_FILES = (TRACK, REPORT, SUMMARY, MAP_ASHORE, *FIGURE_FILES)


def require_report(report: str) -> None:
    """Raise ValueError for an unknown report."""
    if report not in REPORTS:
        raise ValueError(f"report = {report!r}: must be one of {', '.join(REPORTS)}")


def write_results(
    flown: FlightRecord,
    sim: Simulator | None,
    out: Path,
    report: str,
    screen: Silent,
    *,
    ahead: SurfaceAhead | None = None,
) -> FlightRecord:
    """Write map, track, samples, summary and report; return the record with the map's score. Raises OSError.

    sim: the flight's simulator, or another of the same world; None if the world is unknown. report: "full", "json" (no
    report.html) or "none" (no summary either). ahead: the part of the true surface examined so far. The map is written
    while it is being scored. The key values are printed before the other files are written, in case writing fails on a
    full disk.
    """
    if report == "full" and find_spec("matplotlib") is None:
        warnings.warn(f"no {REPORT}, which needs figures: pip install 'uwsim[figures]'", UserWarning, stacklevel=2)
        report = "json"
    with suppress(OSError):
        out.mkdir(parents=True, exist_ok=True)  # it may have been deleted in flight
    wants_score = report != "none" and sim is not None and flown.occupancy is not None
    rendered = _render_ahead(flown, sim) if wants_score and report == "full" else None
    ashore = None if flown.ashore is None or flown.occupancy is None else _map_ashore(flown.ashore, flown.occupancy)
    with ThreadPoolExecutor(1, "scoring") as pool:
        score = pool.submit(scored, flown, sim, ahead, ashore) if wants_score and sim is not None else None
        if flown.occupancy is not None:
            _write_map(flown.occupancy, out / MAP)
        if score is not None:
            with screen.status("scoring the map"):
                flown = score.result()
    try:
        _print(flown, screen, report, out)
        if ashore is not None:
            ashore.write(out / MAP_ASHORE)
        _write_files(flown, sim, out, report, screen, rendered)
    except OSError as error:
        whole = f" ({out / MAP} is complete)" if flown.occupancy is not None else ""
        raise OSError(f"{error}{whole}") from error
    screen.result("  ".join(str(out / name) for name in (MAP, REPORT, SUMMARY) if (out / name).exists()))
    return flown


def scored(
    flown: FlightRecord, sim: Simulator, ahead: SurfaceAhead | None = None, ashore: OccupancyMap | None = None
) -> FlightRecord:
    """Score the record's map and the station's map against the simulator's world; return the completed record."""
    if flown.occupancy is None or flown.area_world_m is None:
        return flown
    survey = sim.scenario.survey
    if survey is None or not np.array_equal(flown.area_world_m, survey.area_m):
        ahead = None  # `ahead` examined the survey's area, not this one
    score = _score(flown.occupancy, flown, sim, ahead, is_exact=_is_exact(flown, sim))
    ashore_score = None if ashore is None else _score(ashore, flown, sim, ahead, is_exact=False)
    return replace(flown, score=score, ashore_score=ashore_score, free_voxels=flown.occupancy.count().free)


def _score(
    occupancy: OccupancyMap, flown: FlightRecord, sim: Simulator, ahead: SurfaceAhead | None, *, is_exact: bool
) -> MapScore:
    assert flown.area_world_m is not None
    return score_map(
        sim.world, occupancy.occupied_voxels(), occupancy.resolution_m, flown.path_world_m, flown.area_world_m,
        flown.range_max_m, rays=sim.scene, ahead=ahead, occupied_were_seen=is_exact,
    )  # fmt: skip


def _is_exact(flown: FlightRecord, sim: Simulator) -> bool:
    """Return whether the map was built from exact ranges and true poses."""
    return flown.estimate == "truth" and all(
        sim.vehicles[name].sonar.mode == "geometry" for name in flown.pings_world_m
    )


def _map_ashore(ashore: Ashore, aboard: OccupancyMap) -> OccupancyMap:
    """Return the station's map at the voxel size of the onboard map."""
    return ashore.made_map(aboard.resolution_m, aboard.engine)


def _render_ahead(flown: FlightRecord, sim: Simulator | None) -> Future[TruthAndMap] | None:
    """Start rendering the report's 3D pictures on a separate thread, to run while the map is scored and written."""
    if flown.occupancy is None or flown.area_world_m is None or sim is None:
        return None
    pool = ThreadPoolExecutor(1, "render")
    rendered = pool.submit(_rendered, flown.occupancy, flown, sim)
    pool.shutdown(wait=False)
    return rendered


def _rendered(occupancy: OccupancyMap, flown: FlightRecord, sim: Simulator) -> TruthAndMap:
    from uwsim.figures.truth_and_map import render_truth_and_map  # imported here, since matplotlib takes a second

    assert flown.area_world_m is not None
    return render_truth_and_map(
        sim.world, sim.scene, flown.area_world_m, occupancy.occupied_voxels(), occupancy.resolution_m
    )


def _write_map(occupancy: OccupancyMap, path: Path) -> None:
    """Write the map; if that fails, write it to a temporary folder and raise OSError that names the paths tried."""
    try:
        occupancy.write(path)
    except OSError as error:
        tried = str(error)
        try:
            elsewhere = Path(tempfile.mkdtemp(prefix="uwsim-")) / MAP
            occupancy.write(elsewhere)
        except OSError as second:
            raise OSError(f"{tried}; nor elsewhere: {second}") from error
        raise OSError(f"{tried}; the map is in {elsewhere}") from error


def _print(flown: FlightRecord, screen: Silent, report: str, out: Path) -> None:
    """Print the key values and the reason the flight ended."""
    if report != "none":
        screen.result(summary_table(flown))
    if flown.ashore is not None and flown.ashore_score is not None:
        screen.result(text_table(flown.ashore.table()))
        screen.result(f"{ashore_text(flown, flown.ashore_score)}  {out / MAP_ASHORE}")
    screen.result(f"ended because {flown.ended_because}")
    if flown.verified is not None:
        screen.result(f"{MAP} {'is identical to' if flown.verified else 'DIFFERS from'} that of stock OctoMap")


def _place(sim: Simulator | None) -> Georeference | None:
    """Return the world's place, or None without rasterio, which knows coordinate systems."""
    with suppress(MissingExtraError):
        return None if sim is None else georeference(sim.scenario)
    return None


def _write_files(
    flown: FlightRecord, sim: Simulator | None, out: Path, report: str, screen: Silent,
    rendered: Future[TruthAndMap] | None,
) -> None:  # fmt: skip
    """Write everything except the map."""
    if sim is not None and flown.track is not None:
        flown.track.write(out / TRACK)
    if report != "none":
        write_json(out / SUMMARY, flight_values(flown))
    for name, samples in flown.samples.items():
        samples.write(out / f"track-{name}.csv", _place(sim))
    rewrite_if_lost(out, flown.events)
    if report == "full":
        with screen.status("drawing the report"):
            from uwsim.flight.report import write_report  # imported here, since matplotlib takes a second

            write_report(out / REPORT, flown, sim, rendered)
