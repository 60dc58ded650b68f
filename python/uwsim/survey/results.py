"""Scores a survey's map, prints the summary, and writes the track, the figures and the report."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Literal

from uwsim.mapping import OccupancyMap
from uwsim.scoring.map_score import score_map
from uwsim.scoring.score_json import score_values, write_json
from uwsim.scoring.survey_track import TRACK
from uwsim.simulator import Simulator
from uwsim.survey.checkpoint import MAP
from uwsim.survey.record import SurveyRecord
from uwsim.survey.summary import flight_values, summary_table, survey_warnings
from uwsim.survey.terminal import Terminal

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
RESULT_FILES = (TRACK, REPORT, SUMMARY, *FIGURE_FILES)


def write_results(
    sim: Simulator,
    occupancy: OccupancyMap,
    record: SurveyRecord,
    out: Path,
    terminal: Terminal,
    report: Report,
) -> float | None:
    """Score the map, print the summary, then write files into `out`; returns the coverage. Raises OSError.

    report: "full" writes the track, the figures and the REPORT; "json" the track and SUMMARY; "none" the track alone,
    and does not score: the coverage is None. The summary comes first, so that it is seen even if the disk is full.
    """
    if report == "none":
        terminal.result(f"ended because {record.stopped_because}")
        record.track.write(out / TRACK)
        terminal.result(f"{out / MAP}")
        return None
    with terminal.status("scoring the map"), ThreadPoolExecutor(1, "count") as counter:
        occupied = occupancy.occupied_voxels()
        statistics = counter.submit(occupancy.statistics)
        score = score_map(
            sim.world,
            occupied,
            occupancy.resolution_m,
            record.path_world_m,
            record.area_world_m,
            record.range_max_m,
            rays=sim.scene,
        )
        free_voxels = statistics.result().free_voxels
    terminal.result(summary_table(record, score, free_voxels))
    terminal.result(f"ended because {record.stopped_because}")
    record.track.write(out / TRACK)
    if report == "json":
        values = flight_values(record) | {"free_voxels": free_voxels} | score_values(score, path_known=True)
        write_json(out / SUMMARY, values | {"warnings": survey_warnings(record, score)})
        terminal.result(f"{out / MAP}  {out / SUMMARY}")
        return score.coverage
    with terminal.status("drawing the report"):
        from uwsim.survey.report import write_report  # here, since matplotlib takes a second to import
        from uwsim.survey.report_figures import draw_report_figures

        figures = draw_report_figures(out, sim.world, record, score, occupied, rays=sim.scene)
        write_report(out / REPORT, record, score, free_voxels, figures)
    terminal.result(f"{out / MAP}  {out / REPORT}")
    return score.coverage
