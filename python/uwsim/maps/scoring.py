"""A finished map against the world that it was made in: figures, and a picture of where it is wrong."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.table import Table

from uwsim.atomic_file import write_atomically
from uwsim.cloud_files import FORMATS, read_cloud
from uwsim.maps.files import Origin, open_map
from uwsim.scenario import Scenario, build_world, load
from uwsim.survey.error_picture import where_it_is_wrong
from uwsim.survey.s44 import ORDERS, share_within
from uwsim.survey.score import MapScore, score_map
from uwsim.survey.table import order_rows, score_figures
from uwsim.survey.track import TRACK, Track


@dataclass(frozen=True, eq=False)
class ScoredMap:
    """A map's score, the track that it was scored with, and whether that says what could have been seen."""

    score: MapScore
    track: Track
    path_known: bool


def score_file(path: Path, scenario: str, track: Path | None, origin_world_m: Origin) -> ScoredMap:
    """Score a map file against a scenario's world.

    track: what the survey left beside the map, or a cloud file of the sonar's positions; by default TRACK in the
    map's folder. Without it the figures that need to know what could have been seen are left out.
    Raises ScenarioError, ValueError or OSError.
    """
    occupancy = open_map(path, origin_world_m)
    place = load(scenario)
    known = track is not None or (path.parent / TRACK).is_file()
    flown = _track(track or path.parent / TRACK, place) if known else _from_scenario(place)
    score = score_map(
        build_world(place),
        occupancy.occupied_voxels(),
        occupancy.resolution_m,
        flown.path_world_m,
        flown.area_world_m,
        flown.range_max_m,
    )
    return ScoredMap(score, flown, known)


def score_table(scored: ScoredMap, title: str) -> Table:
    """Return the figures, then how the seabed fares by the orders of IHO S-44."""
    table = Table(title=title, title_justify="left", show_header=False)
    table.add_column("figure", style="cyan", overflow="fold")
    table.add_column("value", justify="right", no_wrap=True)
    table.add_row("occupied voxels", f"{scored.score.occupied_voxels:,}")
    for name, value in score_figures(scored.score):
        table.add_row(name, value)
    for name, allowed, share in order_rows(scored.score):
        table.add_row(f"seabed cells within S-44 {name}, {allowed}", share)
    if (seabed := scored.score.seabed) is not None and seabed.judged.any():
        table.caption = f"limits of S-44 at the median depth, {np.median(seabed.depths_m):.1f} m"
        table.caption_justify = "left"
    return table


def write_score_json(path: Path, scored: ScoredMap) -> None:
    """Write the figures in SI units and shares in [0, 1]; what is not known is null. Raises OSError."""
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
    plain = {name: None if isinstance(v, float) and math.isnan(v) else v for name, v in figures.items()}
    write_atomically(path, (json.dumps(plain, indent=2) + "\n").encode("utf-8"))


def draw_score(path: Path, scored: ScoredMap) -> None:
    """Write the picture of where the map is wrong. Raises OSError."""
    where_it_is_wrong(path, scored.score, scored.track.area_world_m)


def _track(path: Path, scenario: Scenario) -> Track:
    if path.suffix.lower() not in FORMATS:
        track = Track.read(path)
        if track.scenario_name not in ("", scenario.name):
            raise ValueError(f"'{path}': is of scenario '{track.scenario_name}', not of '{scenario.name}'")
        return track
    known = _from_scenario(scenario)
    return Track(read_cloud(path), known.area_world_m, known.range_max_m)


def _from_scenario(scenario: Scenario) -> Track:
    """Return the area and the sonar's range that the scenario gives, and no path."""
    if scenario.survey is None:
        raise ValueError(f"scenario '{scenario.name}': has no survey, whose area_m says what to score")
    sonar = scenario.vehicles[0].sonar
    range_max_m = sonar.loaded.core_model(sonar.frequency_khz).range_limit_m
    return Track(np.empty((0, 3)), np.asarray(scenario.survey.area_m, np.float64), range_max_m)
