"""A scenario written to a recording or a YAML file is read back unchanged.

Unchanged means that it compares equal, has the same keys set (the presence of a key may matter), and builds an
identical simulator.
"""

from collections.abc import Iterator
from itertools import zip_longest
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from any_text import any_text
from parameter_world import world
from uwsim import Simulator
from uwsim.campaigns.sweeps import fly_again, run_sweep
from uwsim.evidence import fingerprint as module
from uwsim.evidence.fingerprint import fingerprint
from uwsim.recording import Recorder
from uwsim.recording.capsule import pack, unpack
from uwsim.recording.replay import replay
from uwsim.scenario import Scenario, load, load_vehicle
from uwsim.scenario.dump import plain, write_scenario
from uwsim.scenario.fingerprint import scenario_fingerprint
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.fields import Model
from uwsim.scenario.spec.optics import WaterCoefficients
from uwsim.scenario.spec.sonar import SonarNoise, load_sonar
from uwsim.scenario.spec.water import StillSurface, Water

SCENARIOS = ("fish_farm", "harbour", "kelp", "lake", "lake_boat", "panel", "paper", "reef", "valley")
"""Among them they have each kind of terrain, obstacle, cover, life, object, link and vehicle of the packaged ones."""
VEHICLES = ("bluerov2_heavy_alpha5", "bluerov2_tank", "lauv", "otter", "paper", "remus100", "rov", "slocum")
REPLAYED = ("kelp", "lake_boat", "panel", "paper", "remus100", "slocum")
"""Waves and life, two vehicles in wind, an arm, a wire over meshes, fins, and a pump."""
MISSION = """
from uwsim.missions import wait

def mission(vehicle, effort=0.5):
    vehicle.release()
    vehicle.set_effort(surge=effort)
    for _ in range(5):
        yield wait(0.1)
"""
PROFILE = {"kind": "linear", "surface": {"temperature_deg_c": 20}, "bottom": {"temperature_deg_c": 9}}
LOOP = {"position_1_s": 1.0}
NO_PARTS: dict[str, Any] = {"sensors": {}, "cameras": {}, "lamps": {}, "imaging_sonars": {}}
OF_THE_VEHICLE: dict[str, dict[str, Any]] = {
    "without control": {"model": {"control": None}},
    "a loop with its defaults": {"model": {"control": {"surge": LOOP, "filter_s": 0.2}}},
    "limits without loops": {"model": {"control": {"speed_max_m_s": 0.5}}},
    "sonar by name": {"sonar": {"model": "em2040-07", "frequency_hz": 400000, "range_max_m": 30}},
    "sonar by figures": {"sonar": {"model": plain(load_sonar("em2040-04")), "frequency_hz": 300000}},
    "a figure of noise with its usual value": {"sonar": {"mode": "physics", "noise": {"detection_threshold_db": 13.0}}},
    "no noise": {"sonar": {"mode": "physics", "noise": {}}},
    "sensors": {"model": {"sensors": {
        "depth": {"kind": "depth", "noise_std": 0.1, "density_kg_m3": 990},
        "imu": {"kind": "imu", "channels": {"angular_velocity": {"std": 0.1, "limits": [-1, 1]}}},
    }}},
    "no sensors": {"model": NO_PARTS},
    "imaging sonars": {"model": {"imaging_sonars": {
        "ahead": {"kind": "forward_looking", "solid_strength_db": None, "strengths_db": {"box": -20}},
        "below": {"kind": "single_beam", "yaw_pitch_roll_deg": [0, 90, 0]},
    }}},
    "free start": {"start": {"position_m": [0, 0, -2]}},
    "trim, failsafe": {"trim": {"net_buoyancy_n": 2}, "failsafe": {"silence_s": 9}},
    "material": {"model": {"material": "steel"}},
}  # fmt: skip
OF_THE_WORLD: dict[str, dict[str, Any]] = {
    "profile": {"water": {"profile": PROFILE}},
    "profile of levels": {"water": {"profile": {"kind": "table", "levels": [{"depth_m": 0, "temperature_deg_c": 9}]}}},
    "profile of none": {"water": {"profile": None}},
    "waves": {"water": {"surface": {"kind": "airy", "amplitude_m": 0.1, "period_s": 2}}},
    "one current": {"water": {"current": {"kind": "uniform", "velocity_m_s": [0.1, 0, 0]}}},
    "coefficients": {"optics": {"coefficients": {key: [0.3, 0.2, 0.1] for key in WaterCoefficients.model_fields}}},
    "link by name": {"link": "micromodem", "warnings": {"range_m": 110.0}},
    "link by figures": {"link": {"modem": {"name": "wire", "kind": "cable", "latency_s": 0.1}, "bottom": "clay"}},
    "link that carries all": {"link": {"modem": "tether", "carries": ["*"], "repeats": {"2": 3, "yes": 1}}},
    "station with a dock": {"station": {"dock_m": [1, 0, -2]}},
    "station with cameras": {"station": {"cameras": {"only": {"position_m": [0, 0, 3]}}}},
    "faults": {"faults": [{"kind": "leak", "at_s": 1, "kg_per_s": 1}, {"kind": "sonar", "rate_per_h": 3}]},
    "text, ground": {
        "description": "'no': # [x] {y}\n  - 1e3\n\ttab\x85\u2028 é \"\n", "ground": {"bed": "mud", "relief": 0.0},
    },
}  # fmt: skip
"""Changes to the pool scenario and its vehicle, by name. None removes a key of the vehicle's model."""


def in_recording(scenario: Scenario, folder: Path) -> Scenario:
    return unpack(pack(scenario), folder)


def in_yaml(scenario: Scenario, folder: Path) -> Scenario:
    write_scenario(folder / "written.yaml", scenario)
    return load(folder / "written.yaml")


def pool_with(world: dict[str, Any], vehicle: dict[str, Any] | None = None) -> Scenario:
    values = plain(load("pool"))
    change, given = vehicle or {}, values["vehicles"][0]
    model = {key: value for key, value in {**given["model"], **change.get("model", {})}.items() if value is not None}
    return validated(Scenario, values | world | {"vehicles": [given | change | {"model": model}]})


def require_same(read: Scenario, scenario: Scenario) -> None:
    assert read == scenario
    assert plain(read) == plain(scenario)
    assert scenario_fingerprint(read) == scenario_fingerprint(scenario)


def flown(scenario: Scenario) -> bytes:
    sim = Simulator(scenario)
    sim.rov.release()
    sim.rov.set_effort(surge=0.5, yaw=0.2)
    sim.step(20)
    if sim.rov.sonars:
        sim.rov.sonar.ping()
    return sim.save_state()


def require_the_same_flight_both_ways(scenario: Scenario, folder: Path) -> None:
    """Read the scenario back from a recording, and what is read from a YAML file, which flies as the first."""
    recorded = in_recording(scenario, folder)
    require_same(recorded, scenario)
    written = in_yaml(recorded, folder)
    require_same(written, scenario)
    assert flown(written) == flown(scenario)


def of_name(name: str) -> Scenario:
    """Return a packaged scenario, or the pool with a packaged vehicle."""
    is_vehicle = name in VEHICLES and name not in SCENARIOS
    return load("pool").with_changes(seed=3, vehicle_model=load_vehicle(name)) if is_vehicle else load(name)


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_packaged_scenario(name: str, tmp_path: Path) -> None:
    scenario = load(name)
    require_same(in_yaml(in_recording(scenario, tmp_path), tmp_path), scenario)


@pytest.mark.parametrize("name", VEHICLES)
def test_a_packaged_vehicle(name: str, tmp_path: Path) -> None:
    scenario = load("pool").with_changes(seed=3, vehicle_model=load_vehicle(name))
    require_the_same_flight_both_ways(scenario, tmp_path)


@pytest.mark.parametrize("names", zip_longest(OF_THE_VEHICLE, OF_THE_WORLD), ids="; ".join)
def test_a_scenario_with_a_block(names: tuple[str, str], tmp_path: Path) -> None:
    of_vehicle, of_world = names
    require_the_same_flight_both_ways(pool_with(OF_THE_WORLD[of_world], OF_THE_VEHICLE[of_vehicle]), tmp_path)


@pytest.mark.parametrize("variant", ["", "sea", "cast"])
def test_a_scenario_with_everything(variant: str, tmp_path: Path) -> None:
    require_the_same_flight_both_ways(validated(Scenario, world(variant)), tmp_path)


def keys_of(value: Any, place: tuple[str | int, ...] = ()) -> Iterator[tuple[Model, str, tuple[str | int, ...]]]:
    """Yield each field of each model: the model, the field name, and the path to it."""
    if isinstance(value, Model):
        for name in type(value).model_fields:
            yield value, name, (*place, name)
            yield from keys_of(getattr(value, name), (*place, name))
    elif isinstance(value, dict | tuple):
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            yield from keys_of(item, (*place, key))


def changed(base: Scenario, keys: list[tuple[Model, str, tuple[str | int, ...]]]) -> Scenario:
    """Leave out the keys that are given, and give others their defaults. Raises KeyError if one is in another."""
    values = plain(base)
    for owner, name, (*above, last) in sorted(keys, key=lambda key: len(key[2])):
        at = values
        for part in above:
            is_there = isinstance(at, list) or part in at
            if not is_there and len(keys) > 1:
                raise KeyError(name)
            at = at[part] if is_there else {}
        if at.pop(last, None) is None:
            at[last] = plain(
                type(owner).model_fields[name].get_default(call_default_factory=True, validated_data=dict(owner))
            )
    return Scenario.model_validate(values)


def test_a_scenario_with_any_key_left_out_or_given_with_its_default(tmp_path: Path) -> None:
    """In a scenario that sets nearly every key, change one of each model at a time; what is valid is read back.

    Keys of several models of the same class and kind are changed in the first. Where several at once are not valid,
    fewer are changed.
    """
    found: dict[tuple[object, ...], tuple[Scenario, tuple[Model, str, tuple[str | int, ...]]]] = {}
    for variant in ("cast", ""):
        base = validated(Scenario, world(variant))
        for owner, name, place in reversed([*keys_of(base)]):
            if not type(owner).model_fields[name].is_required() and (not variant or place[0] == "water"):
                found[type(owner), getattr(owner, "kind", None), name] = base, (owner, name, place)
    owners: dict[tuple[int, int], list[Any]] = {}
    for base, key in found.values():
        owners.setdefault((id(base), id(key[0])), []).append((base, key))
    rounds = [[each for each in one if each is not None] for one in zip_longest(*owners.values())]
    waiting = [
        (base, [key for at, key in one if at is base])
        for one in rounds
        for base in {id(at): at for at, _ in one}.values()
    ]
    tried = 0
    while waiting:
        base, keys = waiting.pop()
        try:
            scenario = changed(base, keys)
        except (KeyError, ValidationError):  # a key is in another, is required, or conflicts with another
            waiting += [(base, half) for half in (keys[::2], keys[1::2]) if half and len(keys) > 1]
            continue
        read = in_recording(scenario, tmp_path)
        assert read == scenario, keys
        assert plain(read) == plain(scenario), keys
        tried += len(keys)
    assert tried > 380


@settings(max_examples=8)
@given(text=any_text(20), key=any_text(5, min_size=1), number=st.floats(-100, 100), count=st.integers(0, 2**63 - 1))
def test_any_text_and_number(text: str, key: str, number: float, count: int, tmp_path_factory: Any) -> None:
    link = {"modem": "tether", "repeats": {key: 2}, "carries": [text]}
    folder = tmp_path_factory.getbasetemp()
    changes = {"description": text, "seed": count, "link": link, "station": {"position_m": [number, 0, 0]}}
    scenario = pool_with(changes, {"model": NO_PARTS})
    for way in (in_recording, in_yaml):
        require_same(way(scenario, folder), scenario)


def require_replayed(path: Path) -> None:
    result = replay(path)
    assert result.difference is None
    assert result.state_compared


@pytest.mark.parametrize("name", REPLAYED)
def test_a_recording_is_replayed(name: str, tmp_path: Path) -> None:
    sim = Simulator(of_name(name))
    with Recorder(sim, tmp_path / "run.mcap", topics=["*odom", "*imu", "*telemetry"]):
        sim.rov.release()
        sim.rov.set_effort(surge=0.5)
        sim.advance(0.2)
    require_replayed(tmp_path / "run.mcap")


def flyable(name: str, folder: Path) -> tuple[Path, Path]:
    """Write a packaged scenario and a mission; return their paths."""
    scenario, mission = folder / "scenario.yaml", folder / "push.py"
    write_scenario(scenario, load(name))
    mission.write_text(MISSION)
    return scenario, mission


@pytest.mark.usefixtures("blank_figures")
def test_a_sweep_flies_again_what_it_flew(tmp_path: Path) -> None:
    """The scenario has meshes as obstacles."""
    scenario, mission = flyable("paper", tmp_path)
    vehicle = load(scenario).vehicles[0].name
    sweep = {
        "scenario": str(scenario), "mission": str(mission), "worst": 1,
        "vary": {"mission.effort": {"choices": [0.2]}, f"{vehicle}.drag.linear.roll": {"choices": [0.6]}},
        "objective": {"metric": "simulated_s", "best": "high"},
    }  # fmt: skip
    done = run_sweep(sweep, tmp_path / "out", workers=0)
    assert done.failed == 0
    assert (tmp_path / "out" / "report.html").is_file()
    (worst,) = (tmp_path / "out" / "worst").iterdir()
    again = tmp_path / "again"
    fly_again(sweep, int(worst.name), again, report="none")
    digest = done.rows.rows[int(worst.name)]["scenario_digest"]
    for folder in (worst, again):
        assert scenario_fingerprint(load(folder / "scenario.yaml")) == digest
    require_replayed(again / "run.mcap")
    for name in ("log.jsonl", f"track-{vehicle}.csv", "scenario.yaml"):
        assert (again / name).read_bytes() == (worst / name).read_bytes(), name


def test_parameters_of_noise_count_whatever_their_values(tmp_path: Path) -> None:
    """A sonar model may replace a noise value's usual default, so setting the usual value explicitly matters."""
    loud = load_sonar("em2040-2").model_copy(update={"noise": SonarNoise(level_db=60.0, range=False)})

    def with_noise(noise: Any) -> Scenario:
        sonar = {"model": loud, "mode": "physics", "noise": noise}
        return pool_with({}, {"sonar": sonar})

    unlike = {key: with_noise(noise) for key, noise in {"none": None, "model": {}, "usual": {"level_db": 45.0}}.items()}
    assert unlike["usual"] != unlike["model"]
    assert scenario_fingerprint(unlike["usual"]) != scenario_fingerprint(unlike["model"])
    levels = {key: each.vehicles[0].sonar.loaded.noise.level_db for key, each in unlike.items()}
    assert levels == {"none": 60.0, "model": 60.0, "usual": 45.0}
    assert with_noise(SonarNoise(level_db=45.0)) == unlike["usual"]
    with Simulator(unlike["none"]) as sim:
        sim.parameters["rov.sonar.noise.range"] = True
        sim.parameters["rov.sonar.noise.level_db"] = 45.0
        assert sim.parameters["rov.sonar.noise.level_db"] == 45.0
        assert sim.parameters["rov.sonar.noise.detection_threshold_db"] == 13.0


def test_a_part_of_a_scenario_is_set_as_it_was_given() -> None:
    """Defaults must not be filled in: they would be rejected alongside the profile, or override the model's values."""
    water = Water.model_validate({"profile": PROFILE})
    with Simulator("pool") as sim:
        sim.parameters["water"] = water
        assert sim.parameters.scenario.water == water


def test_results_of_a_scenario_with_a_profile_have_a_fingerprint(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "PINGS", 1)
    assert fingerprint(pool_with({"water": {"profile": PROFILE}}), threads=1).parts


def test_a_variant_keeps_its_name_and_a_filled_default_its_content(tmp_path: Path) -> None:
    still = load("pool").model_copy(update={"water": Water(surface=StillSurface())})
    require_same(in_recording(still, tmp_path), still)
    filled = load("pool")
    filled.vehicles[0].model.fins.update(load_vehicle("remus100").fins)
    read = in_yaml(filled, tmp_path)
    assert read == filled
    assert read.vehicles[0].model.fins
