"""Scores a map file against the world of its scenario, for `uwsim map score`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from rich.table import Table

from uwsim.base.arrays import Floats
from uwsim.mapping.files import read_cloud
from uwsim.mapping.files.formats import Origin, cloud_format
from uwsim.mapping.files.map_files import open_map
from uwsim.scenario import Scenario, build_world, load
from uwsim.scenario.build.multibeam import multibeam_model
from uwsim.scoring.map_score import MapScore, score_map
from uwsim.scoring.score_text import order_rows, score_rows, score_values, write_json
from uwsim.scoring.survey_track import TRACK, SurveyTrack


@dataclass(frozen=True, eq=False)
class ScoredMap:
    """A map's score and its track. path_known: whether the track has a path; coverage and recall require one."""

    score: MapScore
    track: SurveyTrack
    path_known: bool


def score_map_file(
    path: Path,
    scenario: str,
    track: Path | None,
    origin_world_m: Origin,
    box_world_m: tuple[float, float, float, float] | None = None,
) -> ScoredMap:
    """Return the score of a map file against a scenario's world.

    track: the survey's track file, or a cloud file of sonar positions; by default, TRACK in the map's folder. Without a
    track, coverage and recall, which depend on the path, are unknown. box_world_m: west, south, east and north edge of
    the area to score; by default, the area of the track, or of the scenario's survey, or the box of the map's occupied
    voxels. Raises ScenarioError, ValueError or OSError.
    """
    occupancy = open_map(path, origin_world_m)
    occupied = occupancy.occupied_voxels()
    truth = load(scenario)
    path_known = track is not None or (path.parent / TRACK).is_file()
    area = _area_m(truth, occupied) if box_world_m is None else _corners_m(*box_world_m)
    flown = _read_track(track or path.parent / TRACK, truth, area) if path_known else _track_without_path(truth, area)
    if box_world_m is not None:
        flown = replace(flown, area_world_m=area)
        edge_m = occupancy.resolution_m  # retains the neighbours of voxels at the edge
        inside = (occupied[:, :2] >= area[0] - edge_m) & (occupied[:, :2] <= area[2] + edge_m)
        occupied = occupied[inside.all(axis=1)]
    score = score_map(
        build_world(truth),
        occupied,
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


def _read_track(path: Path, scenario: Scenario, area_world_m: Floats) -> SurveyTrack:
    if cloud_format(path) is None:
        track = SurveyTrack.read(path)
        if track.scenario_name not in ("", scenario.name):
            raise ValueError(f"'{path}': belongs to scenario '{track.scenario_name}', not to '{scenario.name}'")
        return track
    return replace(_track_without_path(scenario, area_world_m), path_world_m=read_cloud(path))


def _track_without_path(scenario: Scenario, area_world_m: Floats) -> SurveyTrack:
    """Return a track with an empty path, and the range of the scenario's sonar."""
    sonar = scenario.vehicles[0].sonar
    range_max_m = multibeam_model(sonar.loaded, sonar.frequency_hz).range_limit_m
    return SurveyTrack(np.empty((0, 3)), area_world_m, range_max_m)


def _area_m(scenario: Scenario, occupied_m: Floats) -> Floats:
    """Return the polygon (k, 2) of the scenario's survey or, if it has none, the box of the occupied voxels (n, 3)."""
    if scenario.survey is not None:
        return np.asarray(scenario.survey.area_m, np.float64)
    if not len(occupied_m):
        raise ValueError(f"scenario '{scenario.name}': has no survey, and the map no occupied voxel: pass --area")
    return _corners_m(*occupied_m[:, :2].min(axis=0), *occupied_m[:, :2].max(axis=0))


def _corners_m(west_m: float, south_m: float, east_m: float, north_m: float) -> Floats:
    if not (west_m < east_m and south_m < north_m):
        raise ValueError(
            f"area = {west_m:g} {south_m:g} {east_m:g} {north_m:g} m: west must be less than east, south than north"
        )
    return np.array([(west_m, south_m), (east_m, south_m), (east_m, north_m), (west_m, north_m)])
