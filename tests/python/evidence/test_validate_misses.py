"""A check of `uwsim validate` is missed when a value is wrong: by 5 % where nothing else is said."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import cache, partial

import numpy as np
import pytest

from uwsim import Simulator, _core
from uwsim.evidence.validate import camera
from uwsim.evidence.validate.check import Check
from uwsim.evidence.validate.control import response_checks
from uwsim.evidence.validate.motion import fins, thrusters
from uwsim.evidence.validate.motion.published import PUBLISHED
from uwsim.evidence.validate.motion.vehicles import vehicle_checks
from uwsim.evidence.validate.navigator import consistency, estimation
from uwsim.evidence.validate.sonars import imaging, multibeam, refraction, table
from uwsim.evidence.validate.sonars.instrument import detection_rate, half_detected_swath_m
from uwsim.evidence.validate.sonars.table import ARRAYS, DEPTH_M, FREQUENCIES_KHZ, Cell, acoustics
from uwsim.evidence.validate.step_responses import step_responses
from uwsim.instruments.sonars.imaging import ForwardLooking, SideScan
from uwsim.scenario import VehicleModel, load_vehicle
from uwsim.scenario.dump import plain
from uwsim.scenario.spec.actuator import Control
from uwsim.scenario.spec.optics import Optics

HEAVY, REMUS = "bluerov2_heavy", "remus100"
Patch = pytest.MonkeyPatch
Law = Callable[[str, VehicleModel], Iterable[Check]]
Case = tuple[str, Callable[[Patch], Iterable[Check]]]
Key = tuple[str | int, ...]
T200_BAND_US = {4: 1472, 5: 1528}  # index in the table: pulse width at one end of the dead band
KIND_LAWS: dict[str, Law] = {
    "time_constant_s": thrusters.thruster_lag,
    "diameter_m": thrusters.advance_loss,
    "bollard_coefficient": thrusters.advance_loss,
    "zero_thrust_advance_ratio": thrusters.advance_loss,
    "torque_per_thrust_m": thrusters.thruster_wrenches,
}
SIX = ("centre_of_buoyancy_m", "centre_of_mass_m", "inertia_kg_m2", "added_mass", "linear_damping", "quadratic_damping")
NARROW = ForwardLooking(rays_per_column=1000, columns_per_beam=3, beams=21, field_of_view_rad=np.radians(5.0))
AHEAD = {"source_level_db": 206.0, "bottom_strength_db": -31.0, "frequency_hz": 750e3 * 1.05,
         "vertical_width_rad": np.radians(21.0), "beam_width_rad": np.radians(1.1)}  # fmt: skip
ASIDE = {"source_level_db": 211.0, "frequency_hz": 450e3 * 1.05, "vertical_width_rad": np.radians(63.0),
         "along_width_rad": np.radians(0.55), "depression_rad": np.radians(31.5)}  # fmt: skip
OPTICAL = {
    camera.wall_against_range: ("absorption", "scattering"),
    camera.sunlight_against_depth: ("diffuse_attenuation",),
    camera.lamp_against_distance: ("absorption", "scattering"),
    camera.refraction_at_the_surface: ("refractive_index",),
}


def missed(checks: Iterable[Check]) -> Iterator[Check]:
    return (check for check in checks if not check.passed)


def of_vehicle(name: str, change: dict[str, object], _: Patch) -> Iterable[Check]:
    return vehicle_checks(name, load_vehicle(name).model_copy(update=change))


def coefficients(name: str) -> Iterator[Case]:
    """Yield each dynamic coefficient in a vehicle's file, and the mass if it is derived from the volume."""
    model, changes = load_vehicle(name), dict[str, dict[str, object]]()
    if model.mass_kg is None:
        changes["mass"] = {"buoyancy": None, "mass_kg": 1.05 * PUBLISHED[name].mass_kg}
    for key in ("mass_kg", "volume_m3"):
        if getattr(model, key) is not None:
            changes[key] = {key: 1.05 * getattr(model, key)}
    for key in SIX:
        values = np.array(getattr(model, key))
        together = key == "inertia_kg_m2" and values[0] < 0.05 * values[1]  # pitch and yaw of a slender body
        for axes in [[0], [1, 2]] if together else [[axis] for axis in np.flatnonzero(values)]:
            changed = values.copy()
            changed[axes] *= 1.05
            changes[f"{key}{axes}"] = {key: tuple(changed.tolist())}
    yield from ((f"{name}-{what}", partial(of_vehicle, name, change)) for what, change in changes.items())


def actuator_values() -> Iterator[tuple[str, Law, Key, float]]:
    """Yield the vehicle, the check that should fail, the value's path in the file, and the factor applied to it."""
    for name in (HEAVY, REMUS):
        model = load_vehicle(name)
        thrusters_of = [*model.thrusters.items()]
        for thruster, mount in (thrusters_of[0], thrusters_of[-1])[: len(thrusters_of)]:
            for k, value in enumerate(mount.position_m):
                if value:
                    alone = k == (0 if mount.axis[1] == mount.axis[2] == 0 else 2)
                    law = thrusters.thruster_heights if alone else thrusters.thruster_wrenches
                    yield name, law, ("thrusters", thruster, "position_m", k), 1.05
            if mount.axis[2] == 0 and mount.axis[1]:  # the length of an axis along x or z has no effect
                for k in (0, 1):
                    yield name, thrusters.thruster_wrenches, ("thrusters", thruster, "axis", k), 1.05
        for key, law in KIND_LAWS.items():
            yield name, law, ("model", key), 1.05
        points = next(iter(model.thrusters.values())).model.thrust_n
        for k, (_, thrust_n) in [*enumerate(points)][:: 3 if name == HEAVY else 1]:
            if thrust_n:  # at most four points are inserted before the kth of the table
                yield name, partial(thrusters.thrust_tables, points=slice(k, k + 5)), ("model", "thrust_n", k, 1), 1.05
    for band in (4, 5):  # 5 % of the band's half width of 28 us
        factor = 1 + 0.05 * (T200_BAND_US[band] - 1500) / T200_BAND_US[band]
        yield HEAVY, thrusters.thrust_tables, ("model", "thrust_n", band, 0), factor
    yield HEAVY, thrusters.thrust_tables, ("model", "pwm", "span_us"), 1.05
    fin, surface = next(iter(load_vehicle(REMUS).fins.items()))
    for key in sorted(surface.model_fields_set - {"span", "position_m"}):
        law = fins.fin_travel if key in ("deflection_max_deg", "rate_max_deg_s") else fins.fin_wrenches
        yield REMUS, law, ("fins", fin, key), 1.05
    for k in np.flatnonzero(surface.position_m).tolist():
        yield REMUS, fins.fin_wrenches, ("fins", fin, "position_m", k), 1.05


def changed_copy(name: str, path: Key, factor: float) -> VehicleModel:
    """Return the vehicle with one value multiplied by `factor`; a value of `model` changes for all its thrusters."""
    vehicle = plain(load_vehicle(name))
    tops = [vehicle] if path[0] != "model" else list(vehicle["thrusters"].values())
    for node in tops:
        for key in path[:-1]:
            node = node[key]
        node[path[-1]] *= factor
    return VehicleModel.model_validate(vehicle)


def actuators() -> Iterator[Case]:
    for name, law, path, factor in actuator_values():
        label = "-".join(map(str, (name, *path)))
        yield label, lambda _, law=law, name=name, change=(path, factor): law(name, changed_copy(name, *change))


def sonars() -> Iterator[Case]:
    """Yield the level of a sonar as it is, beside that of one with another value, and wrong tables and circles."""
    seen_ahead, seen_aside = cache(lambda: imaging.seen_ahead(NARROW)), cache(lambda: imaging.seen_aside(SideScan()))
    for key, value in AHEAD.items():
        model = replace(NARROW, **{key: value})
        yield f"bed-ahead-{key}", lambda _, model=model: [imaging.bed_ahead(model, seen_ahead())]
    for key, value in ASIDE.items():
        model = replace(SideScan(), **{key: value})
        yield f"bed-aside-{key}", lambda _, model=model: [imaging.bed_aside(model, seen_aside())]
    for khz in FREQUENCIES_KHZ:
        yield f"source-level-{khz}-kHz", partial(quiet_by_db, 8.0, Cell(ARRAYS[0], khz, "ocean"))
    yield "warm-water", warm
    depths = {cell: 1.11 * cell.depth_m() for cell in (Cell(ARRAYS[0], 700, "ocean"), Cell(ARRAYS[1], 200, "fresh"))}
    yield "depth-of-half", lambda _: multibeam.instrument_checks(depths)
    yield "snell", snell


def quiet_by_db(lost_db: float, cell: Cell, patch: Patch) -> Iterable[Check]:
    parameters = acoustics(cell.array, cell.frequency_khz).parameters
    patch.setattr(parameters, "source_level_db", parameters.source_level_db - lost_db)
    return [multibeam.in_table("depth", cell, DEPTH_M[cell], cell.depth_m())]


def warm(patch: Patch) -> Iterable[Check]:
    patch.setattr(table, "TEMPERATURE_DEG_C", 12.0)
    table._mean_absorption_db_km.cache_clear()
    found = [multibeam.in_table("depth", cell, table_m, cell.depth_m()) for cell, table_m in DEPTH_M.items()]
    table._mean_absorption_db_km.cache_clear()
    return found


def snell(patch: Patch) -> Iterable[Check]:
    patch.setattr(refraction, "travel_s", lambda dip_rad: 0.03)
    return refraction.smile_checks()


def light(law: Callable[[], list[Check]], coefficient: str, patch: Patch) -> Iterable[Check]:
    def off(light: camera.Light) -> _core.Optics:
        water = light.water
        names = ("diffuse_attenuation", "absorption", "scattering")
        factor = 0.95 if coefficient == "absorption" else 1.05  # absorption above Kd would be refused
        values = [np.asarray(getattr(water, name)) * (factor if name == coefficient else 1) for name in names]
        index = water.refractive_index * (1.05 if coefficient == "refractive_index" else 1)
        return _core.Optics(_core.WaterOptics(*values, index), np.radians(light.sun_deg), 0.7, 0.0, 0.0, 0.0, 0.0)

    patch.setattr(camera.Light, "optics", property(off))
    return law()


def distorted(patch: Patch) -> Iterable[Check]:
    lens = _core.Lens
    patch.setattr(_core, "Lens", lambda *of: lens(*of[:-1], [1.05 * k for k in of[-1]]))
    return camera.checkerboard_corners()


def cases() -> Iterator[Case]:
    for name in (HEAVY, REMUS):
        yield from coefficients(name)
    yield from actuators()
    yield from sonars()
    for law, names in OPTICAL.items():
        yield from ((f"{law.__name__}-{name}", partial(light, law, name)) for name in names)
    yield "distortion", distorted


@pytest.mark.mutation
@pytest.mark.parametrize("wrong", [pytest.param(of, id=name) for name, of in cases()])
def test_what_is_wrong_is_a_miss(wrong: Callable[[Patch], Iterable[Check]], monkeypatch: Patch) -> None:
    assert any(missed(wrong(monkeypatch)))


def test_every_field_of_thrusters_and_fins_is_a_case() -> None:
    """A new field in the YAML files needs a case, and thus a check. Thrusters are alike, and so are fins."""
    found = [(name, path) for name, _, path, _ in actuator_values()]
    for name in (HEAVY, REMUS):
        kind = next(iter(load_vehicle(name).thrusters.values())).model
        fields = kind.model_fields_set - {"name", "description", "sheets"}  # sheets: test_battery.py
        assert fields <= {path[1] for n, path in found if n == name and path[0] == "model"}
    fin, surface = next(iter(load_vehicle(REMUS).fins.items()))
    assert surface.model_fields_set - {"span"} <= {path[2] for _, path in found if path[:2] == ("fins", fin)}


@pytest.mark.parametrize("path", [("mass_kg",), ("model", "time_constant_s")])
def test_an_unchanged_copy_passes(path: Key) -> None:
    assert list(missed(thrusters.thruster_wrenches(HEAVY, changed_copy(HEAVY, path, 1.0)))) == []


def test_a_narrow_forward_looking_sonar_passes() -> None:
    assert imaging.bed_ahead(NARROW).passed


@pytest.mark.parametrize("name", [HEAVY, REMUS])
def test_the_mass_check_measures_the_mass(name: str) -> None:
    """A mass 5 % larger is measured as such, and missed; for a neutrally buoyant vehicle the volume is changed."""
    model = load_vehicle(name)
    key = "volume_m3" if model.mass_kg is None else "mass_kg"
    mass = next(iter(vehicle_checks(name, model.model_copy(update={key: 1.05 * getattr(model, key)}))))
    assert mass.got == pytest.approx(1.05 * PUBLISHED[name].mass_kg, rel=1e-3) and not mass.passed


def test_impossible_moments_of_inertia_are_refused() -> None:
    model = load_vehicle(REMUS)
    roll, pitch, yaw = model.inertia_kg_m2 or (0.0,) * 3
    for inertia in ((roll, 1.05 * pitch, yaw), (roll, pitch, 1.05 * yaw)):
        with pytest.raises(ValueError, match="must not exceed the sum of the two others"):
            next(iter(vehicle_checks(REMUS, model.model_copy(update={"inertia_kg_m2": inertia}))))


def test_bad_gains_miss() -> None:
    weak = {"position_1_s": 0.05, "velocity_1_s": 0.2, "integral_1_s2": 0.0}
    model = load_vehicle("rov").model_copy(update={"control": Control.model_validate({"surge": weak, "yaw": weak})})
    checks = [check for response in step_responses("rov", model) for check in response_checks(response)]
    axes = {check.name.split()[0] for check in missed(checks)}
    assert {"ahead", "heading"} <= axes and "sideways" not in axes


def test_a_filter_that_is_too_sure_of_itself_misses() -> None:
    honest = np.random.default_rng(0).chisquare(3, (20, 12, 3))
    nees = np.concatenate([honest.sum(axis=2, keepdims=True), honest], axis=2)
    assert all(check.passed for check in consistency.consistency_checks(nees))
    for factor in (2.0, 0.5):
        assert not any(check.passed for check in consistency.consistency_checks(factor * nees))


def test_the_closed_form_grows_with_the_cube_of_time_at_last() -> None:
    sim = Simulator("lake")
    navigator, _ = consistency.start_navigation(sim, 0)
    early, late = (np.trace(estimation.closed_form(sim, navigator, t)) for t in (500.0, 1000.0))
    assert 2.0**6 < late / early < 2.0**7  # a gyroscope's bias grows as t^3, its drift as t^3.5


def test_the_second_receiver_widens_every_coverage_by_its_tilt_and_not_without_it(monkeypatch: Patch) -> None:
    tilted, single = (Cell(ARRAYS[0], 200, "ocean", receivers=count) for count in (2, 1))
    assert tilted.coverage().width_m / single.coverage().width_m == pytest.approx(980 / 920, rel=0.03)
    flat = single.fan
    monkeypatch.setattr(table, "_packaged_fan", lambda *args: flat)
    assert tilted.coverage().width_m == pytest.approx(single.coverage().width_m, rel=1e-9)
    assert any(missed(multibeam.table_checks()))


def test_physics_mode_gains_by_the_second_receiver_what_its_formula_gains() -> None:
    single, dual = (Cell(ARRAYS[0], 200, "ocean", receivers=count) for count in (1, 2))
    depth_m = 0.55 * single.depth_m()  # where weak outer beams limit the swath, not the fan
    expected = dual.swath_m(depth_m) / single.swath_m(depth_m)
    assert expected > 1.035
    simulated = half_detected_swath_m(dual, depth_m) / half_detected_swath_m(single, depth_m)
    assert simulated - 1 == pytest.approx(expected - 1, rel=0.1)


@pytest.mark.mutation
def test_a_level_off_by_one_and_a_half_decibels_misses_the_swath_at_600_kilohertz(monkeypatch: Patch) -> None:
    cell = Cell(ARRAYS[0], 600, "ocean")
    parameters, expected_m = acoustics(cell.array, cell.frequency_khz).parameters, cell.swath_m(77.0)
    monkeypatch.setattr(parameters, "source_level_db", parameters.source_level_db - 1.5)
    assert half_detected_swath_m(cell, 77.0) < (1 - multibeam.SWATH_TOLERANCE) * expected_m


def test_the_detection_rate_falls_with_depth() -> None:
    rates = detection_rate(Cell(ARRAYS[0], 400, "ocean"), [150.0, 290.0, 308.0, 330.0, 500.0])
    assert rates == sorted(rates, reverse=True)
    assert rates[0] > 0.99 and rates[-1] < 0.01


def test_daylight_is_attenuated_by_at_least_the_absorption_and_other_water_is_refused() -> None:
    for jerlov in ("I", "IA", "IB", "II", "III", "1C", "3C", "5C", "7C", "9C"):
        water = _core.WaterOptics.jerlov(jerlov)
        assert np.all(np.asarray(water.diffuse_attenuation) >= np.asarray(water.absorption))
    rule = r"must be at most diffuse_attenuation\[2\] = 0\.2 1/m"
    values = {"diffuse_attenuation": [0.5, 0.2, 0.2], "absorption": [0.5, 0.1, 0.3], "scattering": [0.1, 0.1, 0.1]}
    with pytest.raises(ValueError, match=rf"coefficients\.absorption\[2\] = 0\.3 1/m: {rule}"):
        Optics().with_changes({"coefficients": values})
