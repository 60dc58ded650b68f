"""Scores a map file against the world of its scenario, for `uwsim map score`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.table import Table

from uwsim.mapping.files import CLOUD_FORMATS, read_cloud
from uwsim.mapping.files.map_files import Origin, open_map
from uwsim.scenario import Scenario, build_world, load
from uwsim.scenario.build.multibeam import multibeam_model
from uwsim.scoring.map_score import MapScore, score_map
from uwsim.scoring.score_json import score_values, write_json
from uwsim.scoring.score_text import order_rows, score_rows
from uwsim.scoring.survey_track import TRACK, SurveyTrack


@dataclass(frozen=True, eq=False)
class ScoredMap:
    """A map's score and its track. path_known: whether the track has a path; coverage and recall require one."""

    score: MapScore
    track: SurveyTrack
    path_known: bool


def score_map_file(path: Path, scenario: str, track: Path | None, origin_world_m: Origin) -> ScoredMap:
    """Return the score of a map file against a scenario's world.

    track: the survey's track file, or a cloud file of sonar positions; by default, TRACK in the map's folder.
    Without a track, coverage and recall, which depend on the path, are unknown. Raises ScenarioError, ValueError or
    OSError.
    """
    occupancy = open_map(path, origin_world_m)
    truth = load(scenario)
    path_known = track is not None or (path.parent / TRACK).is_file()
    flown = _read_track(track or path.parent / TRACK, truth) if path_known else _track_without_path(truth)
    score = score_map(
        build_world(truth),
        occupancy.occupied_voxels(),
        occupancy.resolution_m,
        flown.path_world_m,
        flown.area_world_m,
        flown.range_max_m,
    )
    return ScoredMap(score, flown, path_known)


def score_table(scored: ScoredMap, title: str) -> Table:
    """Return a table of the score, and of the seabed cells that meet each order of IHO S-44."""
    table = Table(title=title, title_justify="left", show_header=False)
    table.add_column("figure", style="cyan", overflow="fold")
    table.add_column("value", justify="right", no_wrap=True)
    table.add_row("occupied voxels", f"{scored.score.occupied_voxels:,}")
    for name, value in score_rows(scored.score):
        table.add_row(name, value)
    for name, allowed, share in order_rows(scored.score):
        table.add_row(f"seabed cells within S-44 {name}, {allowed}", share)
    if (seabed := scored.score.seabed) is not None and seabed.judged.any():
        table.caption = f"limits of S-44 at the median depth, {np.median(seabed.depths_m):.1f} m"
        table.caption_justify = "left"
    return table


def write_score_json(path: Path, scored: ScoredMap) -> None:
    """Write the score atomically as JSON: SI units, fractions in [0, 1], null for unknown values. Raises OSError."""
    write_json(path, score_values(scored.score, path_known=scored.path_known))


def _read_track(path: Path, scenario: Scenario) -> SurveyTrack:
    if path.suffix.lower() not in CLOUD_FORMATS:
        track = SurveyTrack.read(path)
        if track.scenario_name not in ("", scenario.name):
            raise ValueError(f"'{path}': belongs to scenario '{track.scenario_name}', not to '{scenario.name}'")
        return track
    defaults = _track_without_path(scenario)
    return SurveyTrack(read_cloud(path), defaults.area_world_m, defaults.range_max_m)


def _track_without_path(scenario: Scenario) -> SurveyTrack:
    """Return a track with an empty path, and the scenario's area and sonar range."""
    if scenario.survey is None:
        raise ValueError(f"scenario '{scenario.name}': has no survey, whose area_m is the area to score")
    sonar = scenario.vehicles[0].sonar
    range_max_m = multibeam_model(sonar.loaded, sonar.frequency_khz).range_limit_m
    return SurveyTrack(np.empty((0, 3)), np.asarray(scenario.survey.area_m, np.float64), range_max_m)
