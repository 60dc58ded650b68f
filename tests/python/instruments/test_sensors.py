"""Sensors in Python: readings, samples, units, and their settings in a vehicle's YAML file."""

import re
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from uwsim import Simulator, _core
from uwsim.instruments.readings import Reading
from uwsim.scenario import ScenarioError, load, load_vehicle
from uwsim.scenario.build.equipment import sensor_spec
from uwsim.scenario.read.assets import assets_folder
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.sensor import Noise, SensorMount

SENSORS = [
    *("imu", "velocity", "acceleration", "depth", "pressure", "temperature", "altitude", "dvl", "usbl", "compass"),
    *("contact", "proximity_port", "proximity_starboard", "proximity_fore", "proximity_below"),
]


def mount(**keys: Any) -> SensorMount:
    return SensorMount.model_validate(keys)


def pool_with(sensors: dict[str, SensorMount], *, kept: bool = False, seed: int = 0) -> Simulator:
    """Return the pool with a vehicle that carries these sensors, in addition to its own if `kept`."""
    scenario = load("pool")
    vehicle = scenario.vehicles[0]
    carried = {**(vehicle.model.sensors if kept else {}), **sensors}
    model = vehicle.model.model_copy(update={"sensors": carried})
    vehicles = (vehicle.model_copy(update={"model": model}),)
    return Simulator(scenario.model_copy(update={"vehicles": vehicles, "seed": seed}))


def flat(value: float | Reading) -> list[float]:
    parts = value.to_dict().values() if isinstance(value, Reading) else [value]
    return [float(number) for part in parts for number in np.atleast_1d(part)]


def log(sim: Simulator, names: list[str], every: int = 400, steps: int = 1200) -> list[list[float]]:
    """Return the sensors' readings at regular intervals."""
    sim.rov.release()
    sim.rov.set_effort(surge=0.4, yaw=0.1)
    rows = []
    for _ in range(steps // every):
        sim.step(every)
        rows.append([number for name in names for number in flat(sim.rov.sensors[name].read())])
    return rows


# The published vehicle carries only the published instruments; a boat and a glider carry few.
OTHERS = {"paper", "paper_buoyant", "otter", "slocum"}
VEHICLES = sorted(path for path in (assets_folder() / "vehicles").glob("*.yaml") if path.stem not in OTHERS)


@pytest.mark.parametrize("path", VEHICLES, ids=lambda path: path.stem)
def test_every_packaged_vehicle_carries_the_sensors(path: Path) -> None:
    sensors = load_vehicle(str(path)).sensors
    assert set(SENSORS) <= set(sensors)
    for name, sensor in sensors.items():
        sensor_spec(name, sensor)


def test_readings_have_values_units_and_meanings() -> None:
    sim = Simulator("pool")
    rov, sensors = sim.rov, sim.rov.sensors
    log(sim, [], 600, 600)
    for sensor in sensors.values():
        sample, value = sensor.sample(), sensor.read()
        assert flat(sample.value) == flat(value)
        assert 0 <= sample.stamp_ns <= sim.time_ns
        assert sample.stamp_s == pytest.approx(sample.stamp_ns * 1e-9)
        assert sensor.meaning
        if isinstance(value, float):
            assert isinstance(sensor.unit, str)
        else:
            assert isinstance(sensor.unit, dict) and sensor.unit.keys() == vars(value).keys()
    velocity = sensors["velocity"].read(noise=False).linear_velocity_m_s
    np.testing.assert_allclose(velocity, rov.velocity.linear_body_m_s, atol=1e-12)
    np.testing.assert_allclose(sensors["imu"].read(noise=False).orientation_xyzw, rov.pose.orientation_xyzw, atol=1e-12)
    heading = sensors["compass"].read(noise=False)
    assert np.cos(heading - (np.pi / 2 - rov.pose.yaw_rad)) > np.cos(np.radians(2.0)), "clockwise from north"
    assert sensors["dvl"].unit["velocity_m_s"] == "m/s"


def test_neither_reads_nor_other_sensors_nor_threads_change_a_sensors_samples() -> None:
    own, names = load("pool").vehicles[0].model.sensors, ["dvl", "depth"]
    few = {name: own[name] for name in names}
    alone, among_others = log(pool_with(few), names), log(pool_with({}, kept=True), names)
    often = log(Simulator("pool", threads=2), [*names, *(set(SENSORS) - set(names))], every=10)
    assert alone == among_others == [row[: len(alone[0])] for row in often[39::40]]
    assert log(pool_with(few, seed=1), names) != alone


def test_contact_and_proximity_detect_the_pools_bed() -> None:
    sim = Simulator("pool")
    rov = sim.rov
    rov.place([0.0, 0.0, -2.0])
    contact, below = rov.sensors["contact"], rov.sensors["proximity_below"].read()
    assert contact.read() == 0.0
    assert below + 0.35 == pytest.approx(rov.sensors["altitude"].read(noise=False))
    rov.place([0.0, 0.0, -4.6], velocity_body=[0, 0, -0.5, 0, 0, 0])
    assert any(sim.step() or contact.read() == 1.0 for _ in range(100))


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"kind": "sonnar"}, r"kind = 'sonnar': must be one of imu, .*"),
        ({"kind": "dvl", "beam_slant": 30}, r"beam_slant: unknown key; did you mean 'beam_slant_deg'\?"),
        ({"kind": "dvl", "beam_slant_deg": 80}, r"beam_slant_deg = 80 deg: must be in \[5, 60\] deg"),
        ({"kind": "dvl", "range_max_m": "far"}, r"range_max_m = 'far': must be a number"),
        ({"kind": "proximity"}, r"range_max_m: missing"),
        ({"kind": "compass", "hard_iron_ut": [1, 2]}, r"hard_iron_ut = \[1, 2\]: must have 3 values"),
        ({"kind": "imu", "channels": {"gyro": {}}}, r"channels.gyro = 'gyro': must be one of angular_velocity.*"),
        ({"kind": "depth", "rate_hz": 0}, r"rate_hz = 0 Hz: must be in \[0.0001, 100000\] Hz"),
        ({"kind": "depth", "drop_out": 1.0}, r"drop_out = 1: must be in \[0, 0.999\]"),
        ({"kind": "depth", "noise": {"bias_std": 1.0}}, r"noise.bias_time_s: missing: .*"),
        ({"kind": "depth", "noise": {"limits": [2, 1]}}, r"noise.limits = \[2.0, 1.0\]: must be the lower, .*"),
        ({"kind": "depth", "noise": {}, "noise_std": 1.0}, r"noise_std = 1: give either noise or noise_std"),
    ],
)
def test_an_error_in_a_sensor_names_the_key(keys: dict[str, object], message: str, tmp_path: Path) -> None:
    text = (assets_folder() / "vehicles" / "rov.yaml").read_text()
    head, _ = text.split("\nsensors:\n")
    path = tmp_path / "odd.yaml"
    path.write_text(f"{head}\nsensors:\n  odd: {yaml_flow(keys)}\n")
    with pytest.raises(ScenarioError, match=rf"odd\.yaml:\d+: sensors\.odd\.{message}$"):
        load_vehicle(str(path))


def yaml_flow(value: object) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {yaml_flow(item)}" for key, item in value.items()) + "}"
    return str(value)


def test_noise_std_is_short_for_white_noise_on_every_channel() -> None:
    short, long = (mount(kind="compass", **noise) for noise in ({"noise_std": 0.1}, {"noise": Noise(std=0.1)}))
    assert log(pool_with({"s": short}), ["s"], 10, 100) == log(pool_with({"s": long}), ["s"], 10, 100)


def test_kinds_list_their_fields_and_parameters() -> None:
    for kind in map(_core.sensor_kind, _core.sensor_kinds()):
        assert kind.name in _core.sensor_kinds() and kind.fields and kind.meaning
    with pytest.raises(ValueError, match="must be one of imu"):
        _core.sensor_kind("sonnar")


def test_a_set_of_sensors_is_packaged_or_beside_the_vehicles_file(tmp_path: Path) -> None:
    head, _ = (assets_folder() / "vehicles" / "rov.yaml").read_text().split("\nsensors:\n")
    vehicle = tmp_path / "lean.yaml"
    (tmp_path / "lean_sensors.yaml").write_text("name: lean\nsensors: {depth: {kind: depth}}\n")
    vehicle.write_text(f"{head}\nsensors: lean_sensors.yaml\n")
    assert set(load_vehicle(str(vehicle)).sensors) == {"depth"}
    vehicle.write_text(f"{head}\nsensors: bluerov\n")
    with pytest.raises(ScenarioError, match=r"unknown sensor 'bluerov': expected one of .*; did you mean 'bluerov2'\?"):
        load_vehicle(str(vehicle))


def test_the_limits_of_noise_do_not_apply_to_missing_measurements() -> None:
    sim = pool_with({"altitude": mount(kind="altitude", range_max_m=2.0, noise={"limits": [0.0, 100.0]})})
    sample = sim.rov.sensors["altitude"].sample()  # 3 m above the bed
    assert sample.value == np.inf
    assert not sample.valid


@pytest.mark.parametrize(
    ("keys", "refused"),
    [
        ({"kind": "imu"}, "angular_velocity [rad/s], linear_acceleration [m/s2], orientation [rad]"),
        ({"kind": "dvl"}, "beam_velocity [m/s], beam_range [m]"),
        ({"kind": "usbl", "channels": {"range": {"std": 1.0}}}, ""),
        ({"kind": "depth"}, ""),
        ({"kind": "dvl", "noise_std": 0.0}, ""),
    ],
)
def test_one_noise_for_several_units_is_refused(keys: dict[str, Any], refused: str) -> None:
    rule = f"has no single unit: give channels, each with its noise, for {refused}"
    with nullcontext() if not refused else pytest.raises(ScenarioError, match=re.escape(rule)):
        validated(SensorMount, {"noise_std": 0.1, **keys})
