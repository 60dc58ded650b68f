"""The validation passes, and would not if a coefficient were off."""

import math
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import pytest
from ruamel.yaml import YAML
from typer.testing import CliRunner

from uwsim import validate
from uwsim.cli import app
from uwsim.scenario import VehicleModel, load_vehicle
from uwsim.scenario.paths import assets_folder
from uwsim.validate import actuators, closed_forms, contact, fins
from uwsim.validate.check import Check, along, relative, within
from uwsim.validate.published import PUBLISHED
from uwsim.validate.vehicles import vehicle_checks

HEAVY, REMUS = "bluerov2_heavy", "remus100"


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


def coefficients(name: str) -> Iterator[tuple[str, dict[str, object]]]:
    """Each figure that a vehicle's file gives for its motion, 5 % larger; and its mass, where its volume says that."""
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
    """So that pitch and yaw inertia cannot differ by 5 %: no body has such moments, and none is made."""
    return inertia_kg_m2[0] < 0.05 * inertia_kg_m2[1]


def test_moments_of_inertia_of_no_body_are_refused_before_any_check() -> None:
    model = load_vehicle(REMUS)
    assert model.inertia_kg_m2 is not None
    roll, pitch, yaw = model.inertia_kg_m2
    for inertia in ((roll, 1.05 * pitch, yaw), (roll, pitch, 1.05 * yaw)):
        with pytest.raises(ValueError, match="must not exceed the sum of the two others"):
            vehicle_checks(REMUS, model.model_copy(update={"inertia_kg_m2": inertia}))


@pytest.mark.parametrize(
    ("name", "change"),
    [pytest.param(name, change, id=f"{name}-{what}") for name in PUBLISHED for what, change in coefficients(name)],
)
def test_a_coefficient_five_percent_off_is_a_miss(name: str, change: dict[str, object]) -> None:
    checks, _ = vehicle_checks(name, load_vehicle(name).model_copy(update=change))
    assert misses(checks)


@pytest.mark.parametrize("name", PUBLISHED)
def test_the_mass_is_weighed_by_a_push(name: str) -> None:
    """Five percent more is seen as five percent more, of a neutral vehicle by its volume."""
    model = load_vehicle(name)
    key = "volume_m3" if model.mass_kg is None else "mass_kg"
    heavier = model.model_copy(update={key: 1.05 * getattr(model, key)})
    for used, factor in ((model, 1.0), (heavier, 1.05)):
        (mass,) = [check for check in vehicle_checks(name, used)[0] if check.name == "mass"]
        assert mass.got == pytest.approx(factor * PUBLISHED[name].mass_kg, rel=1e-3)
        assert mass.passed == (factor == 1.0)


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

    _, curves = vehicle_checks(HEAVY)
    draw_decays(curves, tmp_path / "decay.png")
    draw_turning(curves[-1], tmp_path / "turning.png")
    assert (tmp_path / "decay.png").stat().st_size > 10_000
    assert (tmp_path / "turning.png").stat().st_size > 10_000


def test_thrusters_and_fins_do_as_published() -> None:
    assert misses(actuators.thruster_checks()) == []
    assert misses(fins.fin_checks()) == []


Law = Callable[[str, VehicleModel], Iterable[Check]]
T200_BAND_US = {4: 1472, 5: 1528}  # points of its table
KIND_LAWS: dict[str, Law] = {
    "time_constant_s": actuators.thruster_lag,
    "diameter_m": actuators.advance_loss,
    "bollard_coefficient": actuators.advance_loss,
    "zero_thrust_advance_ratio": actuators.advance_loss,
    "torque_per_thrust_m": actuators.thruster_wrenches,
}


def test_every_field_of_thrusters_and_fins_has_its_case_below() -> None:
    """One that is new in the YAML files must find its law."""
    cases = [(name, path) for name, _, path, _ in actuator_figures()]
    for name in (HEAVY, REMUS):
        kind = next(iter(load_vehicle(name).thrusters.values())).model
        fields = kind.model_fields_set - {"name", "description"}
        assert fields <= {path[1] for n, path in cases if n == name and path[0] == "model"}
    for fin, surface in load_vehicle(REMUS).fins.items():
        assert surface.model_fields_set - {"span"} <= {path[2] for _, path in cases if path[:2] == ("fins", fin)}


def actuator_figures() -> Iterator[tuple[str, Law, tuple[str | int, ...], float]]:
    """Vehicle, the law that should see it, where the figure is, and by what to multiply it."""
    for name in actuators.MOUNTS:
        model = load_vehicle(name)
        for thruster, mount in model.thrusters.items():
            horizontal = mount.axis[2] == 0
            for k, value in enumerate(mount.position_m):
                if value:
                    alone = k == (0 if mount.axis[1] == mount.axis[2] == 0 else 2)
                    law = actuators.thruster_heights if alone else actuators.thruster_wrenches
                    yield name, law, ("thrusters", thruster, "position_m", k), 1.05
            if horizontal and mount.axis[1]:  # of an axis along x or z, a length alone says nothing
                yield name, actuators.thruster_wrenches, ("thrusters", thruster, "axis", 0), 1.05
                yield name, actuators.thruster_wrenches, ("thrusters", thruster, "axis", 1), 1.05
        if name not in (HEAVY, REMUS):
            continue
        kind = next(iter(model.thrusters.values())).model
        for key, law in KIND_LAWS.items():
            yield name, law, ("model", key), 1.05
        for k, (_, thrust_n) in enumerate(kind.thrust_n):
            if thrust_n:
                yield name, actuators.thrust_tables, ("model", "thrust_n", k, 1), 1.05
    for band in (4, 5):  # 5 % of the 28 us from the middle
        factor = 1 + 0.05 * (T200_BAND_US[band] - 1500) / T200_BAND_US[band]
        yield HEAVY, actuators.thrust_tables, ("model", "thrust_n", band, 0), factor
    yield HEAVY, actuators.thrust_tables, ("model", "pwm", "span_us"), 1.05
    for fin, surface in load_vehicle(REMUS).fins.items():
        for key in sorted(surface.model_fields_set - {"span", "position_m"}):
            law = fins.fin_travel if key in ("deflection_max_deg", "rate_max_deg_s") else fins.fin_wrenches
            yield REMUS, law, ("fins", fin, key), 1.05
        for k, value in enumerate(surface.position_m):
            if value:
                yield REMUS, fins.fin_wrenches, ("fins", fin, "position_m", k), 1.05


def changed_copy(folder: Path, name: str, path: tuple[str | int, ...], factor: float) -> VehicleModel:
    """The vehicle of a copied YAML file in which one figure is `factor` times what it was."""
    yaml = YAML(typ="safe")
    vehicle = yaml.load(assets_folder() / "vehicles" / f"{name}.yaml")
    top = vehicle
    if path[0] == "model":
        kind = next(iter(vehicle["thrusters"].values()))["model"]
        top, path = yaml.load(assets_folder() / "thrusters" / f"{kind}.yaml"), path[1:]
        for mount in vehicle["thrusters"].values():
            mount["model"] = "changed.yaml"
    node = top
    for key in path[:-1]:
        node = node[key]
    node[path[-1]] *= factor
    if top is not vehicle:
        yaml.dump(top, folder / "changed.yaml")
    yaml.dump(vehicle, folder / "vehicle.yaml")
    return load_vehicle(folder / "vehicle.yaml")


@pytest.mark.parametrize(
    ("name", "law", "path", "factor"),
    [pytest.param(*f, id="-".join(map(str, (f[0], *f[2])))) for f in actuator_figures()],
)
def test_an_actuators_figure_five_percent_off_is_a_miss(
    tmp_path: Path, name: str, law: Law, path: tuple[str | int, ...], factor: float
) -> None:
    assert any(not check.passed for check in law(name, changed_copy(tmp_path, name, path, factor)))


@pytest.mark.parametrize("path", [("mass_kg",), ("model", "time_constant_s")])
def test_a_copied_file_alone_is_no_miss(tmp_path: Path, path: tuple[str, ...]) -> None:
    assert misses(list(actuators.thruster_wrenches(HEAVY, changed_copy(tmp_path, HEAVY, path, 1.0)))) == []
