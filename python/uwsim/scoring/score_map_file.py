"""Scores a map file against the world of its scenario, as `uwsim map score` does."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.table import Table

from uwsim.atomic_file import write_atomically
from uwsim.mapping.files import CLOUD_FORMATS, read_cloud
from uwsim.mapping.files.map_files import Origin, open_map
from uwsim.scenario import Scenario, build_world, load
from uwsim.scenario.build.multibeam import multibeam_model
from uwsim.scoring.map_score import MapScore, score_map
from uwsim.scoring.s44 import ORDERS, share_within
from uwsim.scoring.score_text import order_rows, score_rows
from uwsim.scoring.survey_track import TRACK, SurveyTrack


@dataclass(frozen=True, eq=False)
class ScoredMap:
    """A map's score and its track. path_known: whether the track has a path, on which coverage and recall depend."""

    score: MapScore
    track: SurveyTrack
    path_known: bool


def score_map_file(path: Path, scenario: str, track: Path | None, origin_world_m: Origin) -> ScoredMap:
    """Score a map file against a scenario's world.

    track: the survey's track file or a cloud file of the sonar's positions; by default TRACK in the map's folder.
    Without one, coverage and recall, which depend on what was visible, are not known.
    Raises ScenarioError, ValueError or OSError.
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
    """Return a table of the score, then of the seabed cells within each order of IHO S-44."""
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
    """Write the score atomically as JSON: SI units, shares in [0, 1], null for unknown values. Raises OSError."""
    score, seabed = scored.score, scored.score.seabed
    known = scored.path_known and score.visible_truth_voxels > 0
    figures: dict[str, float | int | str | None] = {
        "occupied_voxels": score.occupied_voxels,
        "false_voxels": len(score.false_centres_m),
        "precision": score.precision,
        "visible_truth_voxels": score.visible_truth_voxels if scored.path_known else None,
        "coverage": score.coverage if known else None,
        "recall": score.recall if known else None,
        "distance_mean_m": score.distance_mean_m,
        "distance_p95_m": score.distance_p95_m,
        "distance_max_m": score.distance_max_m,
        "resolution_m": score.resolution_m,
    }
    if seabed is not None:
        best = seabed.best_order
        figures |= {
            "seabed_cells": int(seabed.judged.sum()),
            "seabed_obstructed_cells": int(seabed.obstructed.sum()),
            "seabed_error_mean_m": seabed.mean_m,
            "seabed_error_p95_m": seabed.p95_m,
            "s44_order": best.name if best is not None else None,
        }
        errors, depths = seabed.errors_m, seabed.depths_m
        figures |= {f"s44_share_{order.name.lower()}": share_within(order, errors, depths) for order in ORDERS}
    values = {name: None if isinstance(v, float) and math.isnan(v) else v for name, v in figures.items()}
    write_atomically(path, (json.dumps(values, indent=2) + "\n").encode("utf-8"))


def _read_track(path: Path, scenario: Scenario) -> SurveyTrack:
    if path.suffix.lower() not in CLOUD_FORMATS:
        track = SurveyTrack.read(path)
        if track.scenario_name not in ("", scenario.name):
            raise ValueError(f"'{path}': belongs to scenario '{track.scenario_name}', not to '{scenario.name}'")
        return track
    defaults = _track_without_path(scenario)
    return SurveyTrack(read_cloud(path), defaults.area_world_m, defaults.range_max_m)


def _track_without_path(scenario: Scenario) -> SurveyTrack:
    """Return a track with an empty path, and the area and the sonar's range from the scenario."""
    if scenario.survey is None:
        raise ValueError(f"scenario '{scenario.name}': has no survey, whose area_m is the area to score")
    sonar = scenario.vehicles[0].sonar
    range_max_m = multibeam_model(sonar.loaded, sonar.frequency_khz).range_limit_m
    return SurveyTrack(np.empty((0, 3)), np.asarray(scenario.survey.area_m, np.float64), range_max_m)
