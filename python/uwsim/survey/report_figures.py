"""The figures of a survey's report: draws them, and gives them titles and captions."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.figures.depth_profile import draw_depth_profile
from uwsim.figures.map_errors import draw_map_errors
from uwsim.figures.map_from_above import draw_map_from_above
from uwsim.figures.sonar_fan import sonar_fan
from uwsim.figures.truth_and_map import TruthAndMap, draw_truth_and_map, render_truth_and_map
from uwsim.scoring.map_score import MapScore
from uwsim.survey.record import SurveyRecord
from uwsim.survey.results import FIGURE_FILES


@dataclass(frozen=True)
class ReportFigure:
    """A PNG on disk, with its title and caption in the report."""

    path: Path
    title: str
    caption: str


def draw_report_figures(
    folder: Path,
    world: _core.World,
    record: SurveyRecord,
    score: MapScore,
    occupied_centres_m: NDArray[np.floating],
    *,
    rays: _core.RayScene | None = None,
    rendered: Future[TruthAndMap] | None = None,
) -> list[ReportFigure]:
    """Draw the figures into an existing folder, in the report's order; without pings there is no fan and no profile.

    rays: the world's, if there are some already. rendered: the 3D pictures, if they are under way already; otherwise
    they are rendered while the other figures are drawn.
    Raises OSError when a file cannot be written.
    """
    figures = [
        ReportFigure(
            folder / FIGURE_FILES[0],
            "Truth and map",
            "The surveyed area cut out of the true world (left) and the occupied voxels of the map (right), in the "
            "same view and coloured by height. The orange line is the sonar's path; nothing hides it.",
        ),
        ReportFigure(
            folder / FIGURE_FILES[1],
            "The map from above",
            "The highest occupied voxel of each column, with the sonar's path. Voxels of the true surface that were in "
            "line of sight and within range of the path, but are missing in the map, are marked in pink.",
        ),
        ReportFigure(
            folder / FIGURE_FILES[2],
            "Where the map is wrong",
            "The depth of each cell's occupied voxels compared with the true terrain: too deep or too shallow; and "
            "voxels that are missing or hold no true surface. Below, the share of cells within each error, and the "
            "errors that IHO S-44 allows.",
        ),
    ]
    area, path = record.area_world_m, record.path_world_m
    with ThreadPoolExecutor(1, "render") as pool:
        rendered = rendered or pool.submit(
            render_truth_and_map, world, rays or _core.RayScene(world), area, occupied_centres_m, record.voxel_m
        )
        figures += _draw_others(folder, figures, world, record, score, occupied_centres_m)
        draw_truth_and_map(figures[0].path, rendered.result(), path)
    return figures


def _draw_others(
    folder: Path,
    figures: list[ReportFigure],
    world: _core.World,
    record: SurveyRecord,
    score: MapScore,
    occupied_centres_m: NDArray[np.floating],
) -> list[ReportFigure]:
    """Draw the second and the third figure, and return those that not every survey has."""
    others = []
    draw_map_from_above(figures[1].path, record.area_world_m, record.path_world_m, score, occupied_centres_m)
    draw_map_errors(figures[2].path, score, record.area_world_m)
    if record.sample_ping is not None:
        caption = "One ping of the survey as the sonar sent it: from above over the true seabed, and from the side."
        others.append(ReportFigure(folder / FIGURE_FILES[3], "The sonar's fan", caption))
        sonar_fan(others[-1].path, world, record.sample_ping, record.range_max_m)
    if len(record.path_world_m) > 1:
        caption = "The sonar's depth along its path, and the true seabed straight below it."
        others.append(ReportFigure(folder / FIGURE_FILES[4], "Depth along the path", caption))
        draw_depth_profile(others[-1].path, world, record.path_world_m)
    return others
