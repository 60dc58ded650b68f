"""The imaging suite, which tools/docs runs, fails if a model parameter is wrong."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from uwsim.evidence.validate import imaging as suite
from uwsim.instruments.sonars import imaging
from uwsim.instruments.sonars.imaging import ForwardLooking, SideScan


@pytest.fixture(autouse=True, scope="module")
def looked_once() -> Iterator[None]:
    """Cache each model's image of the flat bed: tests vary the expected image, not the rendered one."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("look_ahead", "look_aside"):
            patch.setattr(imaging, name, once_at_an_even_bed(getattr(imaging, name)))
        yield


def once_at_an_even_bed(look: Callable[..., Any]) -> Callable[..., Any]:
    images: dict[Any, Any] = {}

    def from_memory(place: suite.Basin, poses: Any, model: Any) -> Any:
        if len(place.strengths_db) > 1:  # there are boxes
            return look(place, poses, model)
        key = np.asarray(poses).tobytes(), model
        if key not in images:
            images[key] = look(place, poses, model)
        return images[key]

    return from_memory


NARROW = ForwardLooking(rays_per_column=1000, columns_per_beam=3, beams=21, field_of_view_rad=np.radians(5.0))


def worst_db(level: suite.Level) -> float:
    return float(np.abs(level.got - level.expected).max())


def test_a_narrow_forward_looking_sonar_passes() -> None:
    assert worst_db(suite.bed_level_ahead(NARROW)) < suite.AHEAD_TOLERANCE_DB


@pytest.mark.mutation
@pytest.mark.parametrize(
    "change",
    [
        {"source_level_db": 206.0},
        {"bottom_strength_db": -31.0},
        {"frequency_hz": 750e3 * 1.05},
        {"vertical_width_rad": np.radians(21.0)},
        {"beam_width_rad": np.radians(1.1)},
    ],
)
def test_a_wrong_value_of_a_forward_looking_sonar_fails(change: dict[str, float]) -> None:
    assert worst_db(suite.bed_level_ahead(NARROW, replace(NARROW, **change))) > suite.AHEAD_TOLERANCE_DB


@pytest.mark.mutation
@pytest.mark.parametrize(
    "change",
    [
        {"source_level_db": 211.0},
        {"frequency_hz": 450e3 * 1.05},
        {"vertical_width_rad": np.radians(63.0)},
        {"along_width_rad": np.radians(0.55)},
        {"depression_rad": np.radians(31.5)},
    ],
)
def test_a_wrong_value_of_a_side_scan_sonar_fails(change: dict[str, float]) -> None:
    assert worst_db(suite.bed_level_aside(SideScan(), replace(SideScan(), **change))) > suite.ASIDE_TOLERANCE_DB


@pytest.mark.mutation
@pytest.mark.parametrize("law", [suite.gain_checks, suite.geometry_checks, suite.profile_checks])
def test_a_head_at_a_wrong_pose_fails(law: Callable[[], list[suite.Check]], monkeypatch) -> None:
    honest = imaging.pose_matrix
    monkeypatch.setattr(
        imaging, "pose_matrix", lambda place, **turns: honest((place[0], place[1], place[2] + 0.5), **turns)
    )
    assert any(not check.passed for check in law())
