"""The thruster and fin validation, which tools/docs runs, fails if any of their values is 5 % off."""

from collections.abc import Callable, Iterable, Iterator
from functools import partial

import pytest

from uwsim.evidence.validate import fins, thrusters
from uwsim.evidence.validate.check import Check
from uwsim.scenario import VehicleModel, load_vehicle
from uwsim.scenario.dump import plain

HEAVY, REMUS = "bluerov2_heavy", "remus100"


def misses(checks: list[Check]) -> list[str]:
    return [f"{c.group}, {c.name}: expected {c.expected}, got {c.got}, error {c.error}" for c in checks if not c.passed]


Law = Callable[[str, VehicleModel], Iterable[Check]]
T200_BAND_US = {4: 1472, 5: 1528}  # index in the table: pulse width at one end of the dead band
KIND_LAWS: dict[str, Law] = {
    "time_constant_s": thrusters.thruster_lag,
    "diameter_m": thrusters.advance_loss,
    "bollard_coefficient": thrusters.advance_loss,
    "zero_thrust_advance_ratio": thrusters.advance_loss,
    "torque_per_thrust_m": thrusters.thruster_wrenches,
}


def test_every_field_of_thrusters_and_fins_has_a_case_below() -> None:
    """A new field in the YAML files needs a case, and thus a check. Thrusters are alike, and so are fins."""
    cases = [(name, path) for name, _, path, _ in actuator_figures()]
    for name in (HEAVY, REMUS):
        kind = next(iter(load_vehicle(name).thrusters.values())).model
        fields = kind.model_fields_set - {"name", "description", "sheets"}  # sheets: test_battery.py
        assert fields <= {path[1] for n, path in cases if n == name and path[0] == "model"}
    for fin, surface in [*load_vehicle(REMUS).fins.items()][:1]:
        assert surface.model_fields_set - {"span"} <= {path[2] for _, path in cases if path[:2] == ("fins", fin)}


def actuator_figures() -> Iterator[tuple[str, Law, tuple[str | int, ...], float]]:
    """Yield the vehicle, the check that should fail, the value's path in the file, and the factor applied to it."""
    for name in (HEAVY, REMUS):
        model = load_vehicle(name)
        thrusters_of = [*model.thrusters.items()]
        for thruster, mount in (thrusters_of[0], thrusters_of[-1])[: len(thrusters_of)]:
            horizontal = mount.axis[2] == 0
            for k, value in enumerate(mount.position_m):
                if value:
                    alone = k == (0 if mount.axis[1] == mount.axis[2] == 0 else 2)
                    law = thrusters.thruster_heights if alone else thrusters.thruster_wrenches
                    yield name, law, ("thrusters", thruster, "position_m", k), 1.05
            if horizontal and mount.axis[1]:  # the length of an axis along x or z has no effect
                yield name, thrusters.thruster_wrenches, ("thrusters", thruster, "axis", 0), 1.05
                yield name, thrusters.thruster_wrenches, ("thrusters", thruster, "axis", 1), 1.05
        kind = next(iter(model.thrusters.values())).model
        for key, law in KIND_LAWS.items():
            yield name, law, ("model", key), 1.05
        for k, (_, thrust_n) in [*enumerate(kind.thrust_n)][:: 3 if name == HEAVY else 1]:
            if thrust_n:  # at most four points are inserted before the kth of the table
                yield name, partial(thrusters.thrust_tables, points=slice(k, k + 5)), ("model", "thrust_n", k, 1), 1.05
    for band in (4, 5):  # 5 % of the band's half width of 28 us
        factor = 1 + 0.05 * (T200_BAND_US[band] - 1500) / T200_BAND_US[band]
        yield HEAVY, thrusters.thrust_tables, ("model", "thrust_n", band, 0), factor
    yield HEAVY, thrusters.thrust_tables, ("model", "pwm", "span_us"), 1.05
    for fin, surface in [*load_vehicle(REMUS).fins.items()][:1]:
        for key in sorted(surface.model_fields_set - {"span", "position_m"}):
            law = fins.fin_travel if key in ("deflection_max_deg", "rate_max_deg_s") else fins.fin_wrenches
            yield REMUS, law, ("fins", fin, key), 1.05
        for k, value in enumerate(surface.position_m):
            if value:
                yield REMUS, fins.fin_wrenches, ("fins", fin, "position_m", k), 1.05


def changed_copy(name: str, path: tuple[str | int, ...], factor: float) -> VehicleModel:
    """Return the vehicle with one value multiplied by `factor`; a value of `model` changes for all its thrusters."""
    vehicle = plain(load_vehicle(name))
    tops = [vehicle] if path[0] != "model" else list(vehicle["thrusters"].values())
    for node in tops:
        for key in path[:-1]:
            node = node[key]
        node[path[-1]] *= factor
    return VehicleModel.model_validate(vehicle)


@pytest.mark.mutation
@pytest.mark.parametrize(
    ("name", "law", "path", "factor"),
    [pytest.param(*f, id="-".join(map(str, (f[0], *f[2])))) for f in actuator_figures()],
)
def test_an_actuator_value_five_percent_off_is_a_miss(
    name: str, law: Law, path: tuple[str | int, ...], factor: float
) -> None:
    assert any(not check.passed for check in law(name, changed_copy(name, path, factor)))


@pytest.mark.parametrize("path", [("mass_kg",), ("model", "time_constant_s")])
def test_an_unchanged_copy_passes(path: tuple[str, ...]) -> None:
    assert misses(list(thrusters.thruster_wrenches(HEAVY, changed_copy(HEAVY, path, 1.0)))) == []
