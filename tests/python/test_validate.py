"""The validation passes, and would not if a coefficient were off."""

import math
from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

from uwsim import validate
from uwsim.cli import app
from uwsim.scenario import load_vehicle
from uwsim.validate import closed_forms, contact
from uwsim.validate.check import Check, along, relative, within
from uwsim.validate.published import PUBLISHED
from uwsim.validate.vehicles import vehicle_checks

PERTURBED = "bluerov2_heavy"


def misses(checks: list[Check]) -> list[str]:
    return [f"{c.group}, {c.name}: expected {c.expected}, got {c.got}, error {c.error}" for c in checks if not c.passed]


@pytest.mark.parametrize(
    "law",
    [
        closed_forms.sphere_from_rest,
        closed_forms.terminal_speed,
        closed_forms.floating_box,
        closed_forms.tumbling,
        contact.impulses,
        contact.energy,
        contact.rest,
    ],
)
def test_closed_form(law) -> None:
    assert misses(law()) == []


@pytest.mark.parametrize("name", PUBLISHED)
def test_packaged_vehicle_moves_as_published(name: str) -> None:
    checks, curves = vehicle_checks(name)
    assert misses(checks) == []
    assert {curve.name for curve in curves} >= {"free fall", "turning circle", "decay of surge"}


def coefficients() -> Iterator[tuple[str, dict[str, object]]]:
    """Each figure that the vehicle's file gives for its motion, 5 % larger."""
    model = load_vehicle(PERTURBED)
    for key in ("mass_kg", "volume_m3"):
        yield key, {key: 1.05 * getattr(model, key)}
    for key in ("centre_of_buoyancy_m", "inertia_kg_m2", "added_mass", "linear_damping", "quadratic_damping"):
        values = getattr(model, key)
        for axis, value in enumerate(values):
            if value != 0:
                changed = tuple(1.05 * v if k == axis else v for k, v in enumerate(values))
                yield f"{key}[{axis}]", {key: changed}


@pytest.mark.parametrize(("what", "change"), [pytest.param(w, c, id=w) for w, c in coefficients()])
def test_a_coefficient_five_percent_off_is_a_miss(what: str, change: dict[str, object]) -> None:
    checks, _ = vehicle_checks(PERTURBED, load_vehicle(PERTURBED).model_copy(update=change))
    assert misses(checks), what


def test_errors_are_relative_to_their_scale_and_a_nan_is_a_miss() -> None:
    assert relative("g", "n", 2.0, 2.1, 0.04).error == pytest.approx(0.05)
    assert not relative("g", "n", 2.0, 2.1, 0.04).passed
    assert within("g", "n", 0.0, 0.1, 10.0, 0.02).passed
    worst = along("g", "n", [1.0, 2.0, 3.0], [1.0, 2.5, 3.1], 2.0, 0.3)
    assert (worst.expected, worst.got, worst.error, worst.passed) == (2.0, 2.5, 0.25, True)
    assert not relative("g", "n", 1.0, math.nan, 1.0).passed
    assert not along("g", "n", [1.0, 2.0], [1.0, math.nan], 1.0, 1.0).passed


def test_the_command_prints_a_table_draws_curves_and_fails_on_a_miss(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def short_run(out: Path | None) -> list[Check]:
        assert out is not None
        (out / "curve.png").touch()
        return [relative("g", "good", 1.0, 1.0, 0.1), *extra]

    monkeypatch.setattr("uwsim.validate.dynamics.run", short_run)
    extra: list[Check] = []
    fine = CliRunner().invoke(app, ["validate", "--out", str(tmp_path / "new")])
    assert fine.exit_code == 0
    assert "good" in fine.output and "all within tolerance" in fine.output
    assert (tmp_path / "new" / "curve.png").exists()
    extra.append(relative("g", "bad", 1.0, 2.0, 0.1))
    missed = CliRunner().invoke(app, ["validate", "dynamics", "--out", str(tmp_path)])
    assert missed.exit_code == 1
    assert "MISS" in missed.output and "1 missed" in missed.output


def test_an_unknown_suite_is_named_with_those_there_are() -> None:
    with pytest.raises(ValueError, match="'optics': unknown; there are: dynamics"):
        validate.run_suite("optics")


def test_curves_are_drawn(tmp_path: Path) -> None:
    from uwsim.validate.curves import draw_decays, draw_turning

    _, curves = vehicle_checks(PERTURBED)
    draw_decays(curves, tmp_path / "decay.png")
    draw_turning(curves[-1], tmp_path / "turning.png")
    assert (tmp_path / "decay.png").stat().st_size > 10_000
    assert (tmp_path / "turning.png").stat().st_size > 10_000
