"""A vehicle's file that builds on another, and the intervals that packaged ones state for their kind."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import t as student

import uwsim
from uwsim.flight.terminal import Silent
from uwsim.scenario import ScenarioError, load, load_vehicle
from uwsim.scenario.dump import write_model
from uwsim.scenario.fingerprint import scenario_fingerprint
from uwsim.scenario.read.assets import assets_folder, find_yaml


def written(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text)
    return path


def test_values_replace_those_below_and_parts_are_added_by_name(tmp_path: Path) -> None:
    mine = load_vehicle(
        written(
            tmp_path,
            "mine.yaml",
            "builds_on: bluerov2_heavy\nname: mine\nfriction: 0.1\nmass_kg: null\nbuoyancy: neutral\n"
            "sensors: {sonde: {kind: temperature}, depth: {kind: depth, rate_hz: 1}, usbl: null}\n",
        )
    )
    base = load_vehicle("bluerov2_heavy")
    assert (mine.name, mine.friction, mine.mass_kg, mine.buoyancy) == ("mine", 0.1, None, "neutral")
    assert mine.mesh == base.mesh and mine.thrusters == base.thrusters and mine.control == base.control
    assert set(mine.sensors) == set(base.sensors) - {"usbl"} | {"sonde"}
    assert mine.sensors["depth"].rate_hz == 1 and mine.sensors["imu"] == base.sensors["imu"]


def test_files_are_found_beside_the_file_that_names_them(tmp_path: Path) -> None:
    (tmp_path / "far").mkdir()
    written(tmp_path / "far", "parts.yaml", "name: parts\nsensors: {sonde: {kind: depth}}\n")
    written(tmp_path / "far", "base.yaml", "builds_on: rov\nname: base\nsensors: parts.yaml\n")
    mine = load_vehicle(written(tmp_path, "mine.yaml", "builds_on: far/base.yaml\n"))
    assert mine.name == "base" and set(mine.sensors) == {"sonde"}


def test_a_scenario_may_build_on_a_vehicle_in_place_and_is_as_if_all_were_written_out(tmp_path: Path) -> None:
    text = find_yaml("pool", "scenarios").read_text()
    inline = text.replace("model: rov", "model: {builds_on: rov, friction: 0.25}")
    built = load(written(tmp_path, "built.yaml", inline))
    whole = tmp_path / "whole.yaml"
    write_model(whole, built.vehicles[0].model)
    out = load(written(tmp_path, "out.yaml", text.replace("model: rov", "model: whole.yaml")))
    assert built.vehicles[0].model.friction == 0.25
    assert scenario_fingerprint(built) == scenario_fingerprint(out) != scenario_fingerprint(load("pool"))


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("builds_on: mine.yaml\n", "mine.yaml:1: builds_on = 'mine.yaml': must not build on itself"),
        ("builds_on: level4.yaml\n", "level0.yaml:1: builds_on = 'rov': must build on at most 5 others"),
        ("builds_on: rovv\n", "unknown vehicle 'rovv'"),
        ("builds_on: 7\n", "builds_on = 7: must be text"),
        ("builds_on: rov\nfrition: null\n", "mine.yaml:2: frition: unknown key; did you mean 'friction'?"),
        ("builds_on: rov\nsensors: {dpth: null}\n", "sensors.dpth: no such part to remove; did you mean 'depth'?"),
        ("builds_on: rov\nfrition: 0.1\n", "mine.yaml:2: frition: unknown key; did you mean 'friction'?"),
        ("builds_on: base.yaml\n", "base.yaml:3: friction = 9: must be in [0, 2]"),
    ],
)
def test_a_mistake_is_one_line_with_the_file_in_which_it_is(tmp_path: Path, text: str, line: str) -> None:
    written(tmp_path, "base.yaml", "builds_on: rov\nname: base\nfriction: 9\n")
    for level in range(5):
        written(tmp_path, f"level{level}.yaml", f"builds_on: {f'level{level - 1}.yaml' if level else 'rov'}\n")
    load_vehicle(tmp_path / "level4.yaml")
    with pytest.raises(ScenarioError) as refused:
        load_vehicle(written(tmp_path, "mine.yaml", text))
    assert len(refused.value.mistakes) == 1 and line in refused.value.mistakes[0]


def test_the_outfit_of_a_bluerov2_sees_and_maps(tmp_path: Path) -> None:
    with uwsim.Simulator("pool", vehicle_model="bluerov2_heavy_outfit", sonar_model="surveyor240-16") as sim:
        rov = sim.rov
        assert rov.control.net_buoyancy_n == pytest.approx(2.0, abs=0.02)
        scan, ahead = (rov.imaging_sonars[name].ping() for name in ("scanning", "forward_looking"))
        assert np.diff(scan.bearings_rad).max() < np.radians(1.0) and np.ptp(scan.bearings_rad) > np.radians(358.0)
        assert np.ptp(ahead.bearings_rad) == pytest.approx(np.radians(130.0))
        rov.cameras["front"].aim(0.0, np.radians(90.0))
        sim.advance(1.5)  # at 60 degrees per second
        assert rov.cameras["front"].is_aimed
    flown = uwsim.run_survey("pool", tmp_path, vehicle_model="bluerov2_heavy_outfit", report="json", screen=Silent())
    assert flown.coverage is not None and flown.coverage > 0.96  # the packaged ROV has 0.978
    assert flown.collisions == 0


def test_the_interval_of_slocums_drag_is_that_of_all_whose_flights_are_known() -> None:
    """The next of a kind of which n are known, by Student's t: the two of 2014, and those of 2008 and 2021."""
    fitted = load_vehicle("slocum").quadratic_damping[0]
    drags = np.log(fitted / np.array([1.0, 1.0, 1.46, 1.53]))
    reach = student.ppf(0.975, len(drags) - 1) * drags.std(ddof=1) * np.sqrt(1.0 + 1.0 / len(drags))
    text = (assets_folder() / "vehicles/slocum.yaml").read_text()
    found = re.search(r"{low: ([0-9.]+), high: ([0-9.]+), scale: lognormal}", text)
    assert found is not None
    ends = np.exp([drags.mean() - reach, drags.mean() + reach])
    assert [float(end) for end in found.groups()] == pytest.approx(ends, rel=0.01)
