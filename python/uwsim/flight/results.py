"""Scores the map of a flight, and writes its results into the output folder."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from uwsim.flight.checkpoint import MAP
from uwsim.flight.mission_log import rewrite_if_lost
from uwsim.flight.record import FlightRecord
from uwsim.flight.summary import flight_values
from uwsim.scoring.map_score import score_map
from uwsim.scoring.score_json import score_values, write_json
from uwsim.scoring.survey_track import TRACK, SurveyTrack
from uwsim.simulator import Simulator

REPORTS = ("full", "json", "none")
REPORT, SUMMARY = "report.html", "summary.json"
RESULT_FILES = (REPORT, SUMMARY, TRACK, MAP)
AREA_MARGIN_M = 5.0
"""The map is scored within this distance of the convex hull of the pings' positions."""


def require_report(report: str) -> None:
    """Raise ValueError for a report that is not known."""
    if report not in REPORTS:
        raise ValueError(f"report = {report!r}: must be one of {', '.join(REPORTS)}")


def write_results(
    flown: FlightRecord,
    sim: Simulator | None,
    out: Path,
    report: str,
    show: Callable[[str], AbstractContextManager[object]],
) -> FlightRecord:
    """Write map, tracks, and report or summary; return the record with the map's score. Raises OSError.

    sim: where the flight was flown, or a simulator of the same world; None if its world is not known.
    """
    out.mkdir(parents=True, exist_ok=True)  # it may have been deleted in flight
    for name, samples in flown.samples.items():
        samples.write(out / f"track-{name}.csv")
    rewrite_if_lost(out, flown.events)
    area_m = flown_area_m(flown.all_pings_world_m)
    if flown.occupancy is not None:
        flown.occupancy.write(out / MAP)
        if area_m is not None and sim is not None:
            SurveyTrack(flown.all_pings_world_m, area_m, flown.range_max_m, sim.scenario.name).write(out / TRACK)
    if report == "none":
        return flown
    if sim is not None:
        with show("scoring the map"):
            flown = scored(flown, sim)
    occupied = None if flown.occupancy is None or flown.score is None else flown.occupancy.occupied_voxels()
    values: dict[str, Any] = flight_values(flown)
    if flown.score is not None:
        values["map"] = score_values(flown.score, path_known=True)
    write_json(out / SUMMARY, values)
    if report == "full":
        with show("drawing the report"):
            from uwsim.flight.report import write_report  # here, since matplotlib takes a second to import

            write_report(out, flown, sim, area_m, occupied)
    return flown


def scored(flown: FlightRecord, sim: Simulator) -> FlightRecord:
    """Return the record with the score of its map against the simulator's world, if it has a map and pings."""
    area_m = flown_area_m(flown.all_pings_world_m)
    if flown.occupancy is None or area_m is None:
        return flown
    occupied, path_m = flown.occupancy.occupied_voxels(), flown.all_pings_world_m
    edge_m, range_m = flown.occupancy.resolution_m, flown.range_max_m
    score = score_map(
        sim.world, occupied, edge_m, path_m, area_m, range_m, rays=sim.scene, occupied_were_seen=_is_exact(flown, sim)
    )
    return replace(flown, score=score)


def _is_exact(flown: FlightRecord, sim: Simulator) -> bool:
    """Whether the map is made of exact ranges and true poses."""
    is_true = flown.estimate == "truth" and not flown.closed
    return is_true and all(sim.vehicles[name].sonar.mode == "geometry" for name in flown.pings_world_m)


def flown_area_m(path_world_m: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Return the polygon (k, 2) within AREA_MARGIN_M of the convex hull of positions (n, 3); None without any."""
    if not len(path_world_m):
        return None
    angles = np.radians(np.arange(0.0, 360.0, 22.5))
    ring = AREA_MARGIN_M * np.column_stack([np.cos(angles), np.sin(angles)])
    places = np.unique(path_world_m[:, :2].round(2), axis=0)
    with suppress(QhullError, ValueError):  # fewer than three, or on one line
        places = places[ConvexHull(places).vertices]
    around = (places[:, None] + ring).reshape(-1, 2)
    return np.asarray(around[ConvexHull(around).vertices], np.float64)
