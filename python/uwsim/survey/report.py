"""The survey's report: one HTML file that needs nothing but itself."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from pathlib import Path

from jinja2 import Environment, StrictUndefined

from uwsim.atomic_file import write_atomically
from uwsim.survey.pictures import Picture
from uwsim.survey.record import SurveyRecord
from uwsim.survey.score import MapScore
from uwsim.survey.table import coverage, distance, key_figures, minutes, order_met, order_rows, survey_warnings

TEMPLATE = Path(__file__).with_name("report.html.j2")


def write_report(
    path: Path,
    record: SurveyRecord,
    score: MapScore,
    free_voxel_count: int,
    pictures: Sequence[Picture],
) -> None:
    """Write the report atomically, with the pictures inside it as data URIs. Raises OSError where it cannot."""
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    page = environment.from_string(TEMPLATE.read_text(encoding="utf-8")).render(
        record=record,
        highlights=_highlights(record, score),
        warnings=survey_warnings(record, score),
        figures=key_figures(record, score, free_voxel_count),
        orders=order_rows(score),
        order_met=order_met(score),
        judged=_judged(score),
        setup=_setup(record),
        stages=_stages(record),
        pictures=[(picture, _data_uri(picture.path)) for picture in pictures],
    )
    write_atomically(path, page.encode("utf-8"))


def _judged(score: MapScore) -> str:
    """Say which cells of the seabed were judged, and which were not."""
    if score.seabed is None:
        return "The map is empty."
    judged, obstructed = int(score.seabed.judged.sum()), int(score.seabed.obstructed.sum())
    cell = f"{score.resolution_m:g} x {score.resolution_m:g} m"
    return f"{judged:,} cells of {cell} were judged; {obstructed:,} lie under an obstacle and were not."


def _highlights(record: SurveyRecord, score: MapScore) -> list[tuple[str, str]]:
    share = coverage(score).split(" of ")[0] if score.visible_truth_voxels else "-"
    return [
        (share, "of the visible surface mapped"),
        (distance(score.distance_mean_m), "mean distance to the truth"),
        (minutes(record.simulated_s), "simulated"),
        (f"{record.real_time_factor:.1f} x", "real time"),
    ]


def _setup(record: SurveyRecord) -> list[tuple[str, str]]:
    ping = record.sample_ping
    beams = f"{len(ping.ranges_m):,} beams, " if ping is not None else ""
    return [
        ("scenario", record.scenario_name),
        ("seed", str(record.seed)),
        ("sonar model", f"{record.sonar_model} ({beams}range {record.range_max_m:g} m)"),
        ("time step", f"{record.step_s * 1000.0:g} ms"),
        ("voxel", f"{record.voxel_m:g} m"),
        ("threads", str(record.threads)),
        ("ended because", record.stopped_because),
    ]


def _stages(record: SurveyRecord) -> list[tuple[str, str, float]]:
    """Return (stage, wall time, share of the survey's wall time in per cent), the mission last."""
    stages = {**record.stage_wall_s, "mission and the rest": record.mission_wall_s}
    if record.threads > 1 and "map" in stages:
        stages = {("map (beside the rest)" if name == "map" else name): wall_s for name, wall_s in stages.items()}
    return [(name, minutes(wall_s), 100.0 * wall_s / max(record.wall_s, 1e-9)) for name, wall_s in stages.items()]


def _data_uri(path: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode("ascii")
