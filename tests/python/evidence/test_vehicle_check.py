"""The vehicle check builds the vehicle and reports its trim, stability and mounts, with warnings if it is unsound."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
import yaml

from command_line import uwsim
from uwsim import Simulator
from uwsim.evidence.scenario_check import CheckReport, check_file, check_part
from uwsim.evidence.vehicle.figures import VehicleFigures, rest_attitude_deg
from uwsim.evidence.vehicle.views import entered_m
from uwsim.scenario.build.hull import hull_scene
from uwsim.scenario.read.assets import assets_folder, packaged_names
from uwsim.scenario.schema import FILES
from vehicle_files import box_mesh, scenario_file, vehicle_file

REMUS = assets_folder() / "vehicles" / "remus100.yaml"


def checked(folder: Path, **changes: Any) -> CheckReport:
    return check_part(vehicle_file(folder, **changes), "vehicle")


def only_warning(report: CheckReport) -> str:
    assert report.mistakes == ()
    assert len(report.warnings) == 1, report.warnings
    return report.warnings[0]


def figures(report: CheckReport) -> VehicleFigures:
    assert report.vehicle is not None
    return report.vehicle


@pytest.mark.parametrize("name", packaged_names("vehicles"))
def test_packaged_vehicles_are_sound(name: str) -> None:
    report = check_part(name, "vehicle")
    assert (report.mistakes, report.warnings) == ((), ())
    assert report.to_dict()["vehicle"]["mass_kg"] == pytest.approx(figures(report).mass_kg)


@pytest.mark.parametrize(
    "changes",
    [{}, {"centre_of_mass_m": [3, 0, 0]}, {"centre_of_mass_m": [0.05, 0, -0.1]}, {"ballast_kg": 1.0},
     {"sonar": {"position_m": [-0.61, 0, 0]}}],
)  # fmt: skip
def test_a_scenario_with_the_vehicle_has_the_same_mistakes_and_warnings(
    changes: dict[str, Any], tmp_path: Path
) -> None:
    model = vehicle_file(tmp_path, **changes)
    alone, whole = check_part(model, "vehicle"), check_file(scenario_file(tmp_path, model))
    assert (alone.mistakes == ()) is (whole.mistakes == ()), whole.mistakes
    for warning in alone.warnings:
        assert any(warning in each for each in whole.warnings), (warning, whole.warnings)


def test_the_report_on_a_sound_vehicle_is_in_numbers(tmp_path: Path) -> None:
    report = checked(tmp_path)
    assert (report.mistakes, report.warnings) == ((), ())
    it = figures(report)
    np.testing.assert_allclose(it.size_m, (1.2, 0.8, 0.7))
    assert it.mass_kg == pytest.approx(672.0)
    assert it.righting_lever_m == pytest.approx(0.1)
    assert it.righting_nm_rad == pytest.approx(672.0 * 9.80665 * 0.1)
    assert (it.nose_down_deg, it.roll_to_starboard_deg) == (pytest.approx(0.0), pytest.approx(0.0))


def test_a_hull_that_cannot_be_built_is_a_mistake_of_the_file(tmp_path: Path) -> None:
    """The file itself is valid: only building it reveals errors in its mesh, its pieces or its centre of mass."""
    assert any("centre_of_mass_m" in told for told in checked(tmp_path, centre_of_mass_m=[3, 0, 0]).mistakes)
    model = vehicle_file(tmp_path)
    (tmp_path / "hull.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n")  # no volume
    told = check_part(model, "vehicle").mistakes
    assert len(told) == 1 and "hull.obj" in told[0]
    assert told[0].startswith(str(model))


def test_all_missing_keys_are_named_at_once(tmp_path: Path) -> None:
    absent = ("mesh", "centre_of_mass_m", "linear_damping", "max_force_n", "buoyancy")
    text = "\n".join(check_part(vehicle_file(tmp_path, without=absent), "vehicle").mistakes)
    for key in absent[:-1]:
        assert f"{key}: missing" in text
    assert "exactly one of mass_kg, density_kg_m3 and buoyancy must be given, not 0" in text
    assert text.count("\n") == 4


@pytest.mark.parametrize(
    ("centre_of_mass_m", "nose_down_deg", "to_starboard_deg"),
    [((0.05, 0, -0.1), 26.565, 0), ((-0.05, 0, -0.1), -26.565, 0), ((0, -0.05, -0.1), 0, 26.565)],
)
def test_trim_is_where_the_centres_are_above_each_other(
    centre_of_mass_m: tuple[float, float, float], nose_down_deg: float, to_starboard_deg: float, tmp_path: Path
) -> None:
    report = checked(tmp_path, centre_of_mass_m=list(centre_of_mass_m))
    it = figures(report)
    assert it.nose_down_deg == pytest.approx(nose_down_deg, abs=0.01)
    assert it.roll_to_starboard_deg == pytest.approx(to_starboard_deg, abs=0.01)
    assert "left alone it rests" in only_warning(report) and "26.6 deg" in only_warning(report)


def test_trim_is_where_the_simulator_brings_the_vehicle(tmp_path: Path) -> None:
    report = checked(tmp_path, centre_of_mass_m=[0.02, 0.03, -0.1])
    it = figures(report)
    with Simulator(scenario_file(tmp_path, tmp_path / "box.yaml")) as sim:
        sim.advance(60)
        up_body = sim.rov.pose.world_from_body[2, :3]
    nose_down_deg, roll_deg = rest_attitude_deg(up_body)
    assert it.nose_down_deg == pytest.approx(nose_down_deg, abs=0.2)
    assert it.roll_to_starboard_deg == pytest.approx(roll_deg, abs=0.2)


def test_a_boat_is_judged_as_it_floats(tmp_path: Path) -> None:
    """The metacentre of a box is its width squared over 12 draughts above its centre of buoyancy."""
    boat = {"coefficients": "afloat", "mass_kg": 336.0, "without": ("buoyancy",)}
    report = check_part(vehicle_file(tmp_path, **boat), "vehicle")
    assert figures(report).metacentric_m == pytest.approx(
        [w**2 / (12 * 0.35) - 0.175 + 0.1 for w in (0.8, 1.2)], rel=2e-3
    )
    assert report.warnings == ()
    ahead = check_part(vehicle_file(tmp_path, centre_of_mass_m=[0.02, 0, -0.1], **boat), "vehicle")
    lean_deg = np.degrees(np.arctan(0.02 / (1.2**2 / 4.2 - 0.075)))
    assert figures(ahead).nose_down_deg == pytest.approx(lean_deg, rel=0.01)
    high = check_part(vehicle_file(tmp_path, centre_of_mass_m=[0, 0, 0.05], **boat), "vehicle")
    assert "metacentre is 0.0726 m below its centre of mass: it falls over to a side" in high.warnings[0]


def test_ballast_and_trim_move_the_centre_of_mass(tmp_path: Path) -> None:
    """Ballast of half the vehicle's mass, 0.3 m ahead, moves the centre of mass 0.1 m ahead."""
    report = checked(tmp_path, ballast_kg=336.0, ballast_position_m=[0.3, 0, -0.1])
    assert figures(report).centre_of_mass_m == pytest.approx((0.1, 0, -0.1))
    assert any("nose down 45.0 deg" in warning for warning in report.warnings)


def test_inertia_out_of_scale_is_warned_of(tmp_path: Path) -> None:
    """For the box, m/12 (b2 + c2) with m = 672 kg: 63, 108 and 117 kg m2."""
    assert checked(tmp_path, inertia_kg_m2=[63, 108, 117]).warnings == ()
    grams = checked(tmp_path, inertia_kg_m2=[63e3, 108e3, 117e3]).warnings
    assert len(grams) == 3 and all("no point of its hull is farther than" in warning for warning in grams)
    small = checked(tmp_path, inertia_kg_m2=[0.063, 0.108, 0.117]).warnings
    assert len(small) == 3 and all("is the inertia in kg m2?" in warning for warning in small)


DVL = {"kind": "dvl", "position_m": [0, 0, -0.36]}
ALTITUDE = {"kind": "altitude", "position_m": [0, 0, -0.36]}
AHEAD = {"position_m": [0.61, 0, 0]}
PROXIMITY = {"kind": "proximity", "range_max_m": 9}
OF_MASS: dict[str, Any] = {"without": ("buoyancy",)}
UNSOUND: list[tuple[dict[str, Any], str | None]] = [
    ({"centre_of_mass_m": [0, 0, 0.1]}, "0.1 m above its centre of buoyancy: left alone it hangs upside down"),
    ({"centre_of_mass_m": [0.3, 0, -0.1]}, "nose down 71.6 deg"),
    ({"centre_of_mass_m": [0.3, 0, -0.1]}, "+0.3 m ahead"),
    ({"ballast_kg": 1.0, "ballast_position_m": [0, 0, -98]}, "ballast_position_m is 97.7 m away"),
    ({"mass_kg": 2000.0, **OF_MASS}, "stone"),
    ({"mass_kg": 300.0, **OF_MASS}, "cork"),
    ({"mass_kg": 640.0, **OF_MASS}, None),
    ({"mass_kg": 700.0, **OF_MASS}, None),
    ({"sensors": {"dvl": DVL}}, None),
    ({"sensors": {"dvl": DVL | {"yaw_pitch_roll_deg": [0, 0, 20]}}}, None),
    (
        {"sensors": {"dvl": DVL | {"position_m": [0, 0, 0.36], "yaw_pitch_roll_deg": [0, 0, 180]}}},
        "looks up, 180 deg off",
    ),
    (
        {"sensors": {"dvl": DVL | {"position_m": [0.7, 0, 0], "yaw_pitch_roll_deg": [0, -90, 0]}}},
        "looks sideways, 90 deg off",
    ),
    ({"sensors": {"dvl": DVL | {"position_m": [0, 0, 0.36]}}}, "sensors.dvl looks into its own hull"),
    (
        {"sensors": {"dvl": DVL | {"position_m": [0, 0, -36.15]}}},
        "sensors.dvl is 35.8 m away from its hull of 1.2 x 0.8",
    ),
    ({"sensors": {"altitude": ALTITUDE}}, None),
    ({"sensors": {"altitude": {"kind": "altitude"}}}, None),  # inside the frame
    ({"sensors": {"altitude": ALTITUDE | {"position_m": [0, 0, 0.36]}}}, "sensors.altitude looks into its own hull"),
    ({"sensors": {"p": PROXIMITY | {"position_m": [0.7, 0, 0]}}}, None),
    ({"sensors": {"p": PROXIMITY | {"position_m": [-0.7, 0, 0]}}}, "sensors.p looks into its own"),
    ({"sonar": AHEAD}, None),
    ({"sonar": {"position_m": [-0.61, 0, 0]}}, "sonar looks into its own hull"),
    ({"sonar": {"position_m": [520, 0, -220]}}, "sonar is 564 m away"),
    ({"cameras": {"front": AHEAD}}, None),
    ({"cameras": {"front": AHEAD | {"yaw_pitch_roll_deg": [180, 0, 0]}}}, "cameras.front"),
    ({"cameras": {"chase": {"position_m": [-9, 0, 3], "follows": "heading"}}}, None),
    ({"imaging_sonars": {"fls": {"kind": "forward_looking", "position_m": [-0.61, 0, 0]}}}, "imaging_sonars.fls"),
    ({"lamps": {"a": {"flux_lm": 9, "spots": [{"position_m": [0, 0, 9]}]}}}, "lamps.a is 8.65 m away"),
]


@pytest.mark.parametrize(("changes", "warning"), UNSOUND)
def test_what_is_unsound_has_one_warning(changes: dict[str, Any], warning: str | None, tmp_path: Path) -> None:
    report = checked(tmp_path, **changes)
    assert report.warnings == () if warning is None else warning in only_warning(report), report.warnings


def test_a_ray_enters_a_surface_only_from_outside() -> None:
    box = trimesh.creation.box((2, 2, 2))
    hull = hull_scene(np.asarray(box.vertices), np.asarray(box.faces))
    ahead = np.array([[1.0, 0.0, 0.0]])
    assert entered_m(hull, np.array([-3.0, 0.2, 0.3]), ahead) == pytest.approx(2.0)
    outside = {
        "within": (0.1, 0.2, 0.3),
        "on its surface": (1.0, 0.2, 0.3),
        "beside": (-3.0, 1.2, 0.3),
        "ahead": (3, 0, 0),
    }
    for where, origin_m in outside.items():
        assert np.isinf(entered_m(hull, np.array(origin_m, float), ahead)).all(), where


def remus(folder: Path, **changes: Any) -> Path:
    """Write a REMUS 100 without control gains, with changes applied; None removes a key."""
    values = yaml.safe_load(REMUS.read_text())
    values.pop("control")
    fins = values["fins"]
    for name, fin in changes.pop("fins", {}).items():
        if fin is None:
            fins.pop(name)
        else:
            fins[name] |= fin
    path = folder / "remus.yaml"
    path.write_text(yaml.safe_dump({**values, **changes}))
    return path


TAIL = ("port", "starboard", "top", "bottom")


def test_a_vehicle_without_a_tail_is_warned_of(tmp_path: Path) -> None:
    assert check_part(remus(tmp_path), "vehicle").warnings == ()
    told = "\n".join(check_part(remus(tmp_path, fins=dict.fromkeys(TAIL)), "vehicle").warnings)
    assert "nothing turns it" in told and "nothing takes it up or down" in told
    assert "it does not keep its course under way: a yaw doubles in" in told
    fixed = {name: {"deflection_max_deg": 0} for name in TAIL}
    told = "\n".join(check_part(remus(tmp_path, fins=fixed), "vehicle").warnings)
    assert "nothing turns it" in told and "keep its course" not in told  # it has a tail but no rudder


def test_a_tail_at_the_bow_does_not_hold_the_course(tmp_path: Path) -> None:
    at_bow = {"top": {"position_m": [0.73, 0, 0.1]}, "bottom": {"position_m": [0.73, 0, -0.1]}}
    warnings = check_part(remus(tmp_path, fins=at_bow), "vehicle").warnings
    assert len(warnings) == 2
    assert "without the Munk moment" in warnings[0] and "it does not keep its course" in warnings[1]


def test_a_propeller_far_from_the_hull_is_warned_of(tmp_path: Path) -> None:
    thrusters = {"propeller": {"model": "remus100_propeller", "position_m": [-98.0, 0, 0], "axis": [1, 0, 0]}}
    report = check_part(remus(tmp_path, thrusters=thrusters), "vehicle")
    assert "thrusters.propeller is 97.2 m away from its hull of 1.586" in only_warning(report)


def test_still_water_is_no_current_to_swim_against(tmp_path: Path) -> None:
    def warned(force_n: float, speed_m_s: float) -> str:
        damping = [30, 50, 50, 60, 80, 30]
        model = vehicle_file(tmp_path, max_force_n=[force_n, 300, 300], linear_damping=damping)
        water = {"current_world_m_s": [speed_m_s, 0.0, 0.0]}
        return "\n".join(check_file(scenario_file(tmp_path, model, water=water)).warnings)

    for speed_m_s in (0.0, 1e-18, 0.004):
        assert "cannot swim against" not in warned(0.0, speed_m_s)
    assert "drive it ahead" in warned(0.0, 0.0) and "drive it ahead" not in warned(800.0, 0.0)
    assert "cannot swim against the current at its start, 0.30 m/s" in warned(0.0, 0.3)


@pytest.mark.parametrize(
    ("water", "speed_m_s"),
    [
        ({"current": {"kind": "tidal", "amplitude_m_s": [4, 0, 0], "period_s": 7200}}, 3.9),  # slack water at the start
        ({"surface": {"kind": "airy", "amplitude_m": 2, "period_s": 9}}, None),  # orbital velocity is not a current
    ],
)
def test_a_tide_counts_as_a_current_and_waves_do_not(
    water: dict[str, Any], speed_m_s: float | None, tmp_path: Path
) -> None:
    path = scenario_file(tmp_path, vehicle_file(tmp_path, max_force_n=[100, 300, 300]), water=water)
    values = yaml.safe_load(path.read_text()) | {"mission_time_s": 3600}
    values["vehicles"][0]["start"]["position_m"] = [0, 0, -1]
    path.write_text(yaml.safe_dump(values))
    told = [warning for warning in check_file(path).warnings if "cannot swim against" in warning]
    assert len(told) == (speed_m_s is not None), told
    assert all(f"{speed_m_s:.1f}" in warning for warning in told)


def test_what_reaches_over_the_terrain_has_a_height_over_the_rest(tmp_path: Path) -> None:
    path = scenario_file(tmp_path, vehicle_file(tmp_path))
    values = yaml.safe_load(path.read_text())
    values["vehicles"][0]["start"]["position_m"] = [99.8, 0, -20]
    values["station"] = {"position_m": [500, 0, 0]}
    path.write_text(yaml.safe_dump(values))
    report = check_file(path)
    assert report.mistakes == ()
    assert report.scene is not None and report.scene.vehicles[0].altitude_m == pytest.approx(39.65, abs=0.1)
    told = "\n".join(report.warnings)
    assert "over the terrain's edge" in told and "the station is beside the terrain" in told
    done = uwsim("scenario", "check", str(path), cwd=tmp_path)
    assert done.returncode == 0 and "nan" not in done.stdout + done.stderr


@pytest.mark.parametrize("kind", sorted(FILES.keys() - {"scenario", "vehicle"}))  # which have tests of their own
def test_every_packaged_part_can_be_built(kind: str) -> None:
    folder = kind if kind.endswith("s") else f"{kind}s"
    for name in packaged_names(folder):
        report = check_part(name, kind)
        assert report.mistakes == (), name


def test_the_command_reports_a_vehicle(tmp_path: Path) -> None:
    done = uwsim("scenario", "check", "rov", "remus100", "--kind", "vehicle", "--json", "--strict", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    rov, torpedo = json.loads(done.stdout)
    assert rov["vehicle"]["righting_lever_m"] == pytest.approx(0.1, abs=1e-3)
    assert torpedo["vehicle"]["drives"] == ["surge", "roll", "pitch", "yaw"]
    model = vehicle_file(tmp_path, centre_of_mass_m=[0, 0, 0.1])
    done = uwsim("scenario", "check", str(model), "--kind", "vehicle", cwd=tmp_path)
    assert (
        done.returncode == 0
        and "hangs upside down" in done.stderr
        and "turns over: its centre of buoyancy is 0.1 m below" in done.stdout
    )
    assert uwsim("scenario", "check", str(model), "--kind", "vehicle", "--strict", cwd=tmp_path).returncode == 1
    box_mesh(tmp_path / "hull.obj", scale=1e3)
    assert uwsim("scenario", "check", str(model), "--kind", "vehicle", cwd=tmp_path).returncode == 1
