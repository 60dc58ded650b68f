"""The sonar suite passes, and each of its checks can fail."""

from __future__ import annotations

from pathlib import Path

import pytest

from uwsim import _core
from uwsim.validate import refraction, sonar, sonar_depth
from uwsim.validate.check import Check
from uwsim.validate.sonar_depth import ARRAYS, FREQUENCIES_KHZ, TABLE_M, Cell, Fit, fit_table
from uwsim.validate.sonar_instrument import detection_rate, half_detected_m


@pytest.fixture(scope="module")
def fit() -> Fit:
    return fit_table()


def misses(checks: list[Check]) -> list[Check]:
    return [check for check in checks if not check.passed]


def test_six_constants_fit_the_twenty_cells_of_the_table(fit: Fit) -> None:
    checks = sonar.table_checks(fit)
    assert len(checks) == len(TABLE_M) == 20
    assert misses(checks) == []
    assert len(fit.constants_db) + 1 == 6


def test_each_constant_agrees_with_the_model_files(fit: Fit) -> None:
    checks = sonar.constant_checks(fit)
    assert len(checks) == 6
    assert misses(checks) == []


@pytest.mark.parametrize("khz", FREQUENCIES_KHZ)
def test_a_constant_with_an_error_of_four_decibels_fails(fit: Fit, khz: int) -> None:
    wrong = Fit({**fit.constants_db, khz: fit.constants_db[khz] + 4}, fit.array_difference_db)
    assert misses(sonar.constant_checks(wrong))
    assert misses(sonar.table_checks(wrong))


def test_warmer_water_does_not_fit_the_table(fit: Fit, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sonar_depth, "TEMPERATURE_DEG_C", 10.0)
    assert misses(sonar.table_checks(fit_table()))


def test_physics_mode_reaches_the_depth_of_its_formula_and_no_deeper() -> None:
    cells = [Cell(ARRAYS[0], 700, "ocean"), Cell(ARRAYS[1], 200, "fresh")]
    found = {cell: half_detected_m(cell) for cell in cells}
    assert misses(sonar.instrument_checks(found)) == []
    assert misses(sonar.instrument_checks({cell: 1.06 * depth_m for cell, depth_m in found.items()}))


def test_the_detection_rate_falls_with_depth() -> None:
    rates = detection_rate(Cell(ARRAYS[0], 400, "ocean"), [150.0, 290.0, 308.0, 330.0, 500.0])
    assert rates == sorted(rates, reverse=True)
    assert rates[0] > 0.99 and rates[-1] < 0.01


def test_refraction_follows_snells_law_and_its_check_can_fail(monkeypatch: pytest.MonkeyPatch) -> None:
    assert misses(refraction.refraction_checks()) == []
    monkeypatch.setattr(refraction, "circle", lambda dip_rad: (1.0, 0.03))
    assert misses(refraction.refraction_checks())


def test_figures_are_drawn(tmp_path: Path, fit: Fit) -> None:
    from uwsim.validate.sonar_curves import draw_depths, draw_detections, draw_smile

    draw_smile(tmp_path / "smile.png")
    assert (tmp_path / "smile.png").stat().st_size > 10_000
    draw_depths(fit, dict(TABLE_M), tmp_path / "depths.png")
    draw_detections(tmp_path / "detections.png")
    assert (tmp_path / "depths.png").stat().st_size > 10_000
    assert (tmp_path / "detections.png").stat().st_size > 10_000


def test_absorption_agrees_with_reference_data() -> None:
    for khz, db_km in ((100, 33.4), (200, 54.1), (300, 72.8)):
        assert _core.absorption_db_km(1e3 * khz, 10.0, 35.0, 50.0) == pytest.approx(db_km, abs=0.06)
