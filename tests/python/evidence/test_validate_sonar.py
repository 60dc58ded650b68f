"""Checks of the sonar suite, which tools/docs runs, can fail."""

from __future__ import annotations

import pytest

from uwsim.evidence.validate import refraction, sonar, sonar_table
from uwsim.evidence.validate.check import Check
from uwsim.evidence.validate.sonar_instrument import detection_rate, half_detected_swath_m
from uwsim.evidence.validate.sonar_table import ARRAYS, DEPTH_M, FREQUENCIES_KHZ, WATERS, Cell, acoustics
from uwsim.scenario.build.multibeam import multibeam_model
from uwsim.scenario.spec.sonar import load_sonar


def misses(checks: list[Check]) -> list[Check]:
    return [check for check in checks if not check.passed]


def test_the_second_receiver_widens_every_coverage_by_its_tilt_and_not_without_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tilted = Cell(ARRAYS[0], 200, "ocean", receivers=2)
    single = Cell(ARRAYS[0], 200, "ocean")
    assert tilted.coverage().width_m / single.coverage().width_m == pytest.approx(980 / 920, rel=0.03)
    flat = multibeam_model(load_sonar(ARRAYS[0]), 200e3)
    monkeypatch.setattr(sonar_table, "_packaged_fan", lambda *args: flat)
    assert tilted.coverage().width_m == pytest.approx(single.coverage().width_m, rel=1e-9)
    assert misses(sonar.table_checks())


def test_physics_mode_gains_by_the_second_receiver_what_its_formula_gains() -> None:
    single, dual = (Cell(ARRAYS[0], 200, "ocean", receivers=count) for count in (1, 2))
    depth_m = 0.55 * single.depth_m()  # where weak outer beams limit the swath, not the fan
    expected = dual.swath_m(depth_m) / single.swath_m(depth_m)
    assert expected > 1.035
    simulated = half_detected_swath_m(dual, depth_m) / half_detected_swath_m(single, depth_m)
    assert simulated - 1 == pytest.approx(expected - 1, rel=0.1)


@pytest.mark.mutation
@pytest.mark.parametrize("khz", FREQUENCIES_KHZ)
def test_a_source_level_too_low_by_eight_decibels_misses_the_table(khz: int) -> None:
    parameters = acoustics(ARRAYS[0], khz).parameters
    parameters.source_level_db -= 8.0
    try:
        assert any(cell.depth_m() < 0.9 * DEPTH_M[cell] for cell in (Cell(ARRAYS[0], khz, water) for water in WATERS))
    finally:
        parameters.source_level_db += 8.0


@pytest.mark.mutation
def test_warmer_water_does_not_fit_the_table(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sonar_table, "TEMPERATURE_DEG_C", 12.0)
    sonar_table._mean_absorption_db_km.cache_clear()
    assert any(abs(cell.depth_m() / table_m - 1) > sonar.TABLE_TOLERANCE for cell, table_m in DEPTH_M.items())
    sonar_table._mean_absorption_db_km.cache_clear()


@pytest.mark.mutation
def test_a_depth_eleven_percent_off_is_a_miss() -> None:
    cells = [Cell(ARRAYS[0], 700, "ocean"), Cell(ARRAYS[1], 200, "fresh")]
    assert len(misses(sonar.instrument_checks({cell: 1.11 * cell.depth_m() for cell in cells}))) == len(cells)


@pytest.mark.mutation
def test_a_level_off_by_one_and_a_half_decibels_misses_the_swath_at_600_kilohertz() -> None:
    cell = Cell(ARRAYS[0], 600, "ocean")
    parameters = acoustics(cell.array, cell.frequency_khz).parameters
    expected_m = cell.swath_m(77.0)
    parameters.source_level_db -= 1.5
    try:
        assert half_detected_swath_m(cell, 77.0) < (1 - sonar.SWATH_TOLERANCE) * expected_m
    finally:
        parameters.source_level_db += 1.5


def test_the_detection_rate_falls_with_depth() -> None:
    rates = detection_rate(Cell(ARRAYS[0], 400, "ocean"), [150.0, 290.0, 308.0, 330.0, 500.0])
    assert rates == sorted(rates, reverse=True)
    assert rates[0] > 0.99 and rates[-1] < 0.01


@pytest.mark.mutation
def test_the_check_of_snells_law_can_fail(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(refraction, "circle", lambda dip_rad: (1.0, 0.03))
    assert misses(refraction.refraction_checks())
