"""Scores a survey's map, prints the summary, and writes the track, the figures and the report."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping import OccupancyMap
from uwsim.scoring.map_score import MapScore, score_map
from uwsim.scoring.score_json import score_values, write_json
from uwsim.scoring.surface_ahead import SurfaceAhead
from uwsim.scoring.survey_track import TRACK
from uwsim.simulator import Simulator
from uwsim.survey.checkpoint import MAP
from uwsim.survey.record import SurveyRecord
from uwsim.survey.summary import ashore_text, flight_values, summary_table, survey_warnings
from uwsim.survey.terminal import Terminal

if TYPE_CHECKING:
    from uwsim.figures.truth_and_map import TruthAndMap

Report = Literal["full", "json", "none"]
REPORTS: tuple[Report, ...] = ("full", "json", "none")
REPORT, SUMMARY = "report.html", "summary.json"
FIGURE_FILES = (
    "truth_and_map.png",
    "map_from_above.png",
    "where_it_is_wrong.png",
    "sonar_fan.png",
    "depth_profile.png",
)
MAP_ASHORE = "map_ashore.bt"
RESULT_FILES = (TRACK, REPORT, SUMMARY, MAP_ASHORE, *FIGURE_FILES)


class Scoring:
    """Scores a survey's map on a thread, so that the map can be written meanwhile. A context manager, which ends it."""

    def __init__(
        self,
        sim: Simulator,
        occupancy: OccupancyMap,
        record: SurveyRecord,
        ashore: OccupancyMap | None = None,
        ahead: SurfaceAhead | None = None,
    ) -> None:
        self._pool = ThreadPoolExecutor(1, "scoring")
        is_exact = sim.rov.sonar.mode == "geometry" and record.estimate == "truth"
        self._scored = self._pool.submit(_scored, sim, occupancy, record, ahead, is_exact)
        self._ashore = None if ashore is None else self._pool.submit(_scored, sim, ashore, record, ahead, False)

    def result(self) -> tuple[MapScore, NDArray[np.float64]]:
        """Wait for the score; returns it and the centres (n, 3) of the occupied voxels. Raises what score_map does."""
        return self._scored.result()

    def ashore(self) -> MapScore | None:
        """Wait for the score of the station's map, if there is one."""
        return None if self._ashore is None else self._ashore.result()[0]

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._pool.shutdown()


def _scored(
    sim: Simulator, occupancy: OccupancyMap, record: SurveyRecord, ahead: SurfaceAhead | None, is_exact: bool
) -> tuple[MapScore, NDArray[np.float64]]:
    occupied, edge_m = occupancy.occupied_voxels(), occupancy.resolution_m
    path, area, range_m = record.path_world_m, record.area_world_m, record.range_max_m
    score = score_map(
        sim.world, occupied, edge_m, path, area, range_m,
        rays=sim.scene, ahead=ahead, occupied_were_seen=is_exact,
    )  # fmt: skip
    return score, occupied


def render_ahead(sim: Simulator, occupancy: OccupancyMap, record: SurveyRecord) -> Future[TruthAndMap]:
    """Begin to render the report's 3D pictures on a thread, while the map is scored and written."""
    pool = ThreadPoolExecutor(1, "render")
    rendered = pool.submit(_rendered, sim, occupancy, record)
    pool.shutdown(wait=False)
    return rendered


def _rendered(sim: Simulator, occupancy: OccupancyMap, record: SurveyRecord) -> TruthAndMap:
    from uwsim.figures.truth_and_map import render_truth_and_map  # here, since matplotlib takes a second to import

    voxels = occupancy.occupied_voxels()
    return render_truth_and_map(sim.world, sim.scene, record.area_world_m, voxels, record.voxel_m)


def _link_values(record: SurveyRecord, ashore: MapScore | None) -> dict[str, Any]:
    if record.ashore is None or ashore is None:
        return {}
    score = {"pings": record.ashore.ping_count, **score_values(ashore, path_known=True)}
    return {"link": [row._asdict() for row in record.ashore.table()], "ashore": score}


def write_results(
    sim: Simulator,
    occupancy: OccupancyMap,
    record: SurveyRecord,
    out: Path,
    terminal: Terminal,
    report: Report,
    scoring: Scoring | None,
    rendered: Future[TruthAndMap] | None = None,
) -> float | None:
    """Print the summary, then write files into `out`; returns the coverage. Raises OSError.

    report: "full" writes the track, SUMMARY, the figures and the REPORT; "json" the track and SUMMARY; "none" the track
    alone, without scoring: the coverage is None. rendered: by render_ahead, where it was asked. The summary comes
    first, so that it is seen even if the disk is full.
    """
    if report == "none" or scoring is None:
        terminal.result(f"ended because {record.stopped_because}")
        record.track.write(out / TRACK)
        terminal.result(f"{out / MAP}")
        return None
    with terminal.status("scoring the map"):
        free_voxels = occupancy.count().free
        score, occupied = scoring.result()
        ashore = scoring.ashore()
    terminal.result(summary_table(record, score, free_voxels))
    if record.ashore is not None and ashore is not None:
        from uwsim.link.table import text_table  # here, since channels take long to import

        terminal.result(text_table(record.ashore.table()))
        terminal.result(f"{ashore_text(record, ashore)}  {out / MAP_ASHORE}")
    terminal.result(f"ended because {record.stopped_because}")
    record.track.write(out / TRACK)
    values = flight_values(record) | {"free_voxels": free_voxels} | score_values(score, path_known=True)
    values |= _link_values(record, ashore)
    write_json(out / SUMMARY, values | {"warnings": survey_warnings(record, score)})
    if report == "json":
        terminal.result(f"{out / MAP}  {out / SUMMARY}")
        return score.coverage
    with terminal.status("drawing the report"):
        from uwsim.survey.report import write_report  # here, since matplotlib takes a second to import
        from uwsim.survey.report_figures import draw_report_figures

        figures = draw_report_figures(out, sim.world, record, score, occupied, rays=sim.scene, rendered=rendered)
        write_report(out / REPORT, record, score, free_voxels, figures, ashore)
    terminal.result(f"{out / MAP}  {out / REPORT}  {out / SUMMARY}")
    return score.coverage
