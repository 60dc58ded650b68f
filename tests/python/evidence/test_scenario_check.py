"""A check reports all errors in a file at once, draws its scene, and warns of unusual values."""

import json
import warnings
from pathlib import Path

import jsonschema
import pytest

from command_line import error_line, uwsim
from uwsim import Simulator
from uwsim.evidence.scenario_check import check_file, check_part
from uwsim.flight.flyable_lanes import flyable_plan, survey_plan
from uwsim.scenario import load_vehicle, packaged_scenarios
from uwsim.scenario.build import world
from uwsim.scenario.dump import new_scenario
from uwsim.scenario.read.assets import assets_folder, packaged_names
from uwsim.scenario.read.errors import Collected
from uwsim.scenario.read.spec_file import read_yaml
from uwsim.scenario.schema import schema

COVE = (assets_folder() / "scenarios" / "cove.yaml").read_text()
EXPECTED = (
    "paper.yaml:56: vehicle 'rov' starts 4.1 m above the water",
    "paper_buoyant.yaml:47: vehicle 'rov' rises by",
    "lake_tender.yaml:30: vehicle 'rov' starts 0.6 m above the water",
    "lake_tender.yaml:30: vehicle 'rov' sinks by 6.0 N",
    "lake_tender.yaml:30: vehicle 'rov' starts 1.55 m from 'boat'",
)
"""As in the paper's own scenario, the vehicle hangs in a cage; in the other, it floats. In the last, it hangs from a
boat's A-frame by its tether, and is heavy enough to sink on it."""


SURVEYED = ("lake", "pool", "valley", "reservoir", "harbour")


def edited(path: Path, *edits: tuple[str, str]) -> str:
    text = COVE
    for old, new in edits:
        assert old in text, old
        text = text.replace(old, new, 1)
    path.write_text(text)
    return text


def test_all_mistakes_come_at_once(tmp_path: Path) -> None:
    """Errors in keys, values, rules that involve several keys, referenced files, names, and the resulting world."""
    mistakes = {
        "    size_m: [16": ("    sise_m: [-16", "obstacles[3].sise_m: unknown key; did you mean 'size_m'?"),
        "mission_time_s: 3600": ("mission_time_s: -3600", "mission_time_s = -3600 s: must be in [1, 1000000] s"),
        "    radius_m: 3\n": ("    radius_m: big\n", "obstacles[0].radius_m = 'big': must be a number"),
        "    radius_m: 0.4": ("    radius_m: 40", "obstacles[1].radius_m = 40 m: must be in [0.02, 10] m"),
        "    bar_radius_m: 0.15": ("    bar_radius_m: 2.5", "obstacles[2].bar_radius_m = 2.5 m: must be below half of"),
        "    name: gate": ("    name: terrain", "obstacles[2].name = 'terrain': is already in use"),
        "  dock_m: [0, 0, -3]\n": ("  dock_m: [0, 0, -3]\n  mesh: no.obj\n", "station.mesh = 'no.obj': no such file"),
        "sonar: {model: 2": ("sonar: {model: 7", "vehicles[1].sonar.model = 7: must be in [1, 4]"),
        "  bottom_temperature_deg_c: 14": ("  current: {kind: tidal}", "water.current.amplitude_m_s: missing"),
    }
    more = """  - {kind: gate, name: far, position_m: [0, 90], width_m: 2, height_m: 1}
vehicles:
  - {name: deep, model: rov, start: {position_m: [0, 0, -30]}}
"""
    path = tmp_path / "cove.yaml"
    edited(path, *((old, new) for old, (new, _) in mistakes.items()), ("vehicles:\n", more))
    report = check_file(path)
    expected = [message for _, message in mistakes.values()] + [
        "obstacles[3].sise_m[0] = -16 m: must be in [0.01, 10000] m",  # found under the intended key name
        "obstacle 'far': (0, 89) m lies outside the terrain",
        "vehicle 'deep' starts at (0, 0, -30) m: must be above the bed",
    ]
    told = "\n".join(report.mistakes)
    missing = [message for message in expected if not any(message in found for found in report.mistakes)]
    assert missing == [], told
    assert len(report.mistakes) == len(expected), told
    assert all(found.startswith(f"{path}:") for found in report.mistakes)


def test_a_mistake_has_the_line_of_its_item_though_others_are_left_out(tmp_path: Path) -> None:
    path = tmp_path / "cove.yaml"
    text = edited(path, ("    length_m: 12\n", ""), ("    name: quay\n", "    name: quay\n    on_bed: 5\n"),
                  ("    points_m: [[-20, -6]", "    points_m: [[-200, -6]"))  # fmt: skip
    report = check_file(path)
    lines = [int(found.removeprefix(f"{path}:").split(":")[0]) for found in report.mistakes]
    culprits = [text.splitlines()[line - 1] for line in lines]
    assert ["kind: cylinder" in culprits[0], "on_bed" in culprits[1], "kind: pipeline" in culprits[2]] == [True] * 3


def test_a_value_under_a_misspelt_key_is_checked_though_others_are_missing(tmp_path: Path) -> None:
    survey = "survey:\n  area_m: [-20, 20]\n  altitude: 3m\n  speed_m_s: 9\nvehicles:\n"
    edited(tmp_path / "cove.yaml", ("vehicles:\n", survey), ("water:\n", "water:\n  current: [0.2, 0, 0]\n"))
    told = "\n".join(check_file(tmp_path / "cove.yaml").mistakes)
    for message in (
        "survey.altitude: unknown key; did you mean 'altitude_m'?",
        "survey.altitude = '3m': must be a number",
        "survey.speed_m_s = 9 m/s: must be in [0.05, 5] m/s",
        "survey.line_spacing_m: missing",
        "survey.area_m[0] = -20: must be a list",
        "water.current = [0.2, 0, 0]: must be a current with its kind, or a list of them; a velocity alone",
    ):
        assert message in told
    assert "speed_m_s: missing" not in told


def test_nothing_follows_from_a_mistake_that_is_told(tmp_path: Path) -> None:
    vehicle = (assets_folder() / "vehicles" / "bluerov2_heavy.yaml").read_text()
    path = tmp_path / "mine.yaml"
    path.write_text(vehicle.replace("mass_kg: 13.5 ", "mass_kg: -3 "))
    assert [message.split(": ", 1)[1] for message in check_part(path, "vehicle").mistakes] == [
        "mass_kg = -3 kg: must be in [0.01, 1000000] kg"
    ]


def test_what_a_cast_lacks_comes_once_though_the_world_and_its_vehicles_need_it(tmp_path: Path) -> None:
    (tmp_path / "good.csv").write_text("depth_m,temperature_deg_c\n0,15\n9,12\nEND_DATA\n")
    (tmp_path / "bad.csv").write_text("depth_m,temperature_deg_c\n0,15\n9,warm\n")
    for name in ("good", "bad"):
        (tmp_path / f"{name}.yaml").write_text(
            f"name: a\nwater: {{profile: {{kind: table, file: {name}.csv, salinity_psu: 35}}}}\n"
            "terrain: {source: noise, size_m: [60, 60], bed_depth_m: 20}\n"
            "vehicles: [{name: rov, model: bluerov2_heavy, start: {position_m: [0, 0, -5]}}]\n"
        )
    (mistake,) = check_file(tmp_path / "bad.yaml").mistakes
    assert "bad.csv':3: temperature_deg_c = 'warm'" in mistake
    with warnings.catch_warnings(record=True) as issued:
        found = check_file(tmp_path / "good.yaml").warnings
    assert [each for each in (*found, *issued) if "END_DATA" in str(each)] == list(found) != []


@pytest.mark.parametrize("name", packaged_scenarios())
def test_packaged_scenarios_have_no_mistakes_fly_and_are_large_enough_for_every_vehicle(name: str) -> None:
    report = check_file(name)
    assert report.mistakes == () and report.simulator is not None
    if name in SURVEYED:
        plan = survey_plan(report.simulator.scenario.survey)
        assert flyable_plan(report.simulator, plan) == (plan, None), "every lane can be flown"
    assert [warning for warning in report.warnings if not warning.startswith(EXPECTED)] == []
    sim, found = report.simulator, Collected()
    for vehicle in sim.vehicles.values():
        vehicle.release()
        sim.step(2)
        for sonar in vehicle.sonars.values():
            sonar.ping()
    terrain = world.build_terrain(sim.scenario.terrain)
    for model in map(load_vehicle, packaged_names("vehicles")):
        other = sim.scenario.with_changes(vehicle_model=model)
        world._require_inside(other, terrain.window(other.terrain.window_m), found)
        world._require_free_starts(sim.world, terrain, other, found)
    found.raise_any()


@pytest.mark.parametrize(
    ("old", "new", "warning"),
    [
        ("position_m: [-8, 18, -4]", "position_m: [-8, 18, -28]", "box 'quay' is all below the bed"),
        ("position_m: [-8, 18, -4]", "position_m: [-8, 18, 9]", "box 'quay' is all above the water"),
        ("size_m: [16, 1, 12]", "size_m: [1, 1, 1]", "box 'quay' hangs 4."),
        ("start: station", "start: {position_m: [-16, -14, -7.2]}", "vehicle 'rov' starts 0."),
        ("start: station", "start: station\n    trim: {net_buoyancy_n: -50}", "sinks by 50.0 N"),
        ("start: station", "start: station\n    trim: {net_buoyancy_n: -900}", "more than its thrusters can lift"),
        ("water:\n", "optics: {jerlov: 7C}\nwater:\n", "vehicle 'rov''s cameras see 1.7 m in this water"),
        ("water:\n", "water:\n  current_world_m_s: [4, 0, 0]\n", "cannot swim against the current"),
        ("dock_m: [0, 0, -3]", "dock_m: [0, 0, -3]\n  exit_m: [0, 0, -6.9]", "vehicle 'rov' cannot leave the dock"),
        ("vehicles:\n", "vehicles:\n  - {name: two, model: rov, start: {position_m: [-15, -14, -3]}}\n", "1.00 m from"),
    ],
)
def test_what_may_surprise_is_told(old: str, new: str, warning: str, tmp_path: Path) -> None:
    edited(tmp_path / "cove.yaml", (old, new))
    report = check_file(tmp_path / "cove.yaml")
    assert report.mistakes == ()
    assert len(report.warnings) == 1, report.warnings
    assert warning in report.warnings[0]
    assert report.warnings[0].startswith(f"{tmp_path / 'cove.yaml'}:")


FAULTS = {
    "kind: leak, kg_per_s: 500, at_s: 1": "in a hull of",
    "kind: leak, kg_per_s: 1, for_s: 400, rate_per_h: 1": "in a hull of",
    "kind: leak, kg_per_s: 0.1, kg_max: 300, at_s: 1": "in a hull of",
    "kind: leak, kg_per_s: 0.1, kg_max: 1, at_s: 1, position_m: [500, 0, 0]": "bounding box",
    "kind: leak, kg_per_s: 0.01, at_s: 1": "",
    "kind: battery, thrust: 0.5, at_s: 1": "",
}


def test_a_fault_that_would_stop_its_flight_is_a_mistake(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(
        "name: a\nterrain: {source: noise, size_m: [60, 60], spacing_m: 2, bed_depth_m: 20}\n"
        "vehicles: [{name: rov, model: bluerov2_heavy, start: {position_m: [0, 0, -5]}}]\nfaults:\n"
        + "".join(f"  - {{{fault}, name: fault_{k}}}\n" for k, fault in enumerate(FAULTS))
    )
    expected = [(k, rule) for k, rule in enumerate(FAULTS.values()) if rule]
    for found, (k, rule) in zip(check_file(tmp_path / "a.yaml").mistakes, expected, strict=True):
        assert f"a.yaml:{5 + k}: faults[{k}]: while it lasts: " in found and rule in found


def test_the_scene_is_measured(tmp_path: Path) -> None:
    edited(tmp_path / "cove.yaml", ("position_m: [-8, 18, -4]", "position_m: [-8, 18, 0.5]\n    on_bed: true"))
    scene = check_file(tmp_path / "cove.yaml").scene
    assert scene is not None
    quay = next(obstacle for obstacle in scene.obstacles if obstacle.name == "quay")
    assert quay.clearance_m == pytest.approx(0.5, abs=0.02)
    rov = scene.vehicles[0]
    assert rov.net_buoyancy_n == pytest.approx(0.0, abs=1e-6)
    assert rov.altitude_m == pytest.approx(-3.0 - scene.station_bed_m, abs=1.5)  # the bed is a slope


@pytest.mark.parametrize("like", [None, "valley"])
def test_a_new_scenario_has_no_mistakes_and_names_its_schema(like: str | None, tmp_path: Path) -> None:
    path = new_scenario("my_water", tmp_path / "my_water.yaml", like)
    first = path.read_text().splitlines()[0]
    named = Path(first.removeprefix("# yaml-language-server: $schema=file://"))
    assert json.loads(named.read_text()) == json.loads(json.dumps(schema()))
    jsonschema.validate(read_yaml(path, path.name).values, schema())
    report = check_file(path)
    assert (report.mistakes, report.warnings) == ((), ())
    assert report.scene is not None and report.scene.name == "my_water"
    with pytest.raises(FileExistsError):
        new_scenario("my_water", path)
    with pytest.raises(ValueError, match="name 'my water'"):
        new_scenario("my water")


def test_the_template_can_be_flown(tmp_path: Path) -> None:
    with Simulator(new_scenario("mine", tmp_path / "mine.yaml")) as sim:
        sim.rov.undock()
        sim.advance(0.1)
        assert sim.rov.sonar.ping().valid.any()


def test_the_command_checks_files_as_json_with_a_picture_and_an_exit_code(tmp_path: Path) -> None:
    edited(tmp_path / "bad.yaml", ("spacing_m: 0.5", "spacing_m: half"))
    done = uwsim("scenario", "check", "pool", "bad.yaml", "--json", cwd=tmp_path)
    assert done.returncode == 1
    pool, bad = json.loads(done.stdout)
    assert (pool["ok"], bad["ok"]) == (True, False)
    assert pool["scene"]["bed"]["lowest_m"] == -5.0
    assert bad["mistakes"][0].startswith("bad.yaml:")
    done = uwsim("scenario", "check", "pool", "--picture", "pool.png", cwd=tmp_path)
    assert done.returncode == 0 and (tmp_path / "pool.png").read_bytes().startswith(b"\x89PNG")
    done = uwsim("scenario", "check", "pool", "lake", "--picture", "pool.png", cwd=tmp_path)
    assert done.returncode == 2 and "--picture" in error_line(done)
    assert uwsim("scenario", "check", "paper", "--strict", cwd=tmp_path).returncode == 1
    assert "must be one of scenario, vehicle" in error_line(uwsim("scenario", "check", "pool", "--kind", "ship"))
