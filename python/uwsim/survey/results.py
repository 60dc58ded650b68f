"""Scores a survey's map, prints the summary, and writes the track, the figures and the report."""

from __future__ import annotations

from pathlib import Path

from uwsim.mapping import OccupancyMap
from uwsim.scoring.map_score import score_map
from uwsim.scoring.survey_track import TRACK
from uwsim.simulator import Simulator
from uwsim.survey.checkpoint import MAP
from uwsim.survey.record import SurveyRecord
from uwsim.survey.report import write_report
from uwsim.survey.report_figures import FIGURE_FILES, draw_report_figures
from uwsim.survey.summary import summary_table
from uwsim.survey.terminal import Terminal

REPORT = "report.html"
RESULT_FILES = (TRACK, REPORT, *FIGURE_FILES)


def write_results(sim: Simulator, occupancy: OccupancyMap, record: SurveyRecord, out: Path, terminal: Terminal) -> None:
    """Score the map, print the summary, then write RESULT_FILES into `out`. Raises OSError.

    The summary comes first, so that it is seen even if the disk is full.
    """
    with terminal.status("scoring the map"):
        occupied = occupancy.occupied_voxels()
        free_voxels = occupancy.statistics().free_voxels
        score = score_map(
            sim.world, occupied, occupancy.resolution_m, record.path_world_m, record.area_world_m, record.range_max_m
        )
    terminal.result(summary_table(record, score, free_voxels))
    terminal.result(f"ended because {record.stopped_because}")
    with terminal.status("drawing the report"):
        record.track.write(out / TRACK)
        figures = draw_report_figures(out, sim.world, record, score, occupied)
        write_report(out / REPORT, record, score, free_voxels, figures)
    terminal.result(f"{out / MAP}  {out / REPORT}")
