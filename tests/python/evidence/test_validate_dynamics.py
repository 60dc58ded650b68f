"""The validation of the dynamics, which tools/docs runs, fails if a coefficient is 5 % off."""

from collections.abc import Iterator

import pytest

from uwsim.evidence.validate.published import PUBLISHED
from uwsim.evidence.validate.vehicles import each_check
from uwsim.scenario import load_vehicle

HEAVY, REMUS = "bluerov2_heavy", "remus100"


def coefficients(name: str) -> Iterator[tuple[str, dict[str, object]]]:
    """Yield each dynamic coefficient in a vehicle's file, 5 % larger, and the mass if it is derived from the volume."""
    model = load_vehicle(name)
    if model.mass_kg is None:
        yield "mass", {"buoyancy": None, "mass_kg": 1.05 * PUBLISHED[name].mass_kg}
    for key in ("mass_kg", "volume_m3"):
        if getattr(model, key) is not None:
            yield key, {key: 1.05 * getattr(model, key)}
    for key in (
        "centre_of_buoyancy_m",
        "centre_of_mass_m",
        "inertia_kg_m2",
        "added_mass",
        "linear_damping",
        "quadratic_damping",
    ):
        values = getattr(model, key)
        for axis, value in enumerate(values):
            if value != 0 and not (key == "inertia_kg_m2" and axis > 0 and is_slender(values)):
                changed = tuple(1.05 * v if k == axis else v for k, v in enumerate(values))
                yield f"{key}[{axis}]", {key: changed}
        if key == "inertia_kg_m2" and is_slender(values):
            yield f"{key}[1:]", {key: (values[0], 1.05 * values[1], 1.05 * values[2])}


def is_slender(inertia_kg_m2: tuple[float, ...]) -> bool:
    """Return True if a 5 % difference between pitch and yaw inertia would be physically impossible."""
    return inertia_kg_m2[0] < 0.05 * inertia_kg_m2[1]


def test_impossible_moments_of_inertia_are_refused() -> None:
    model = load_vehicle(REMUS)
    assert model.inertia_kg_m2 is not None
    roll, pitch, yaw = model.inertia_kg_m2
    for inertia in ((roll, 1.05 * pitch, yaw), (roll, pitch, 1.05 * yaw)):
        with pytest.raises(ValueError, match="must not exceed the sum of the two others"):
            next(each_check(REMUS, model.model_copy(update={"inertia_kg_m2": inertia}), []))


@pytest.mark.mutation
@pytest.mark.parametrize(
    ("name", "change"),
    [pytest.param(name, change, id=f"{name}-{what}") for name in (HEAVY, REMUS) for what, change in coefficients(name)],
)
def test_a_coefficient_five_percent_off_is_a_miss(name: str, change: dict[str, object]) -> None:
    checks = each_check(name, load_vehicle(name).model_copy(update=change), [])
    assert any(not check.passed for check in checks)


@pytest.mark.parametrize("name", [HEAVY, REMUS])
def test_the_mass_check_measures_the_mass(name: str) -> None:
    """A mass 5 % larger is measured as such, and missed; for a neutrally buoyant vehicle the volume is changed."""
    model = load_vehicle(name)
    key = "volume_m3" if model.mass_kg is None else "mass_kg"
    heavier = model.model_copy(update={key: 1.05 * getattr(model, key)})
    mass = next(check for check in each_check(name, heavier, []) if check.name == "mass")
    assert mass.got == pytest.approx(1.05 * PUBLISHED[name].mass_kg, rel=1e-3) and not mass.passed
