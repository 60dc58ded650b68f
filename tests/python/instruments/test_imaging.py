"""The Python interface of imaging sonars: arrays, poses, errors. The acoustics are tested in tests/cpp."""

from dataclasses import replace

import numpy as np
import pytest

from basin import BED_M, basin
from uwsim import Simulator
from uwsim.instruments.sonars import imaging
from uwsim.instruments.sonars.imaging import ForwardLooking, SideScan, SingleBeam
from uwsim.scenario import load

HEIGHT_M = 8.0
HEAD = imaging.pose_matrix((0.0, 0.0, BED_M + HEIGHT_M))
LOOK = ForwardLooking(beams=64, range_bins=200, rays_per_column=100)
SIDE = SideScan(range_bins=500)


def test_surfaces_scatter_as_their_materials_unless_the_model_gives_a_strength() -> None:
    sim = basin(((10.0, 0.0, BED_M + 4.0), (1.0, 4.0, 8.0)))
    even = replace(LOOK, looks=0, noise_level_db=-200.0)
    usual_db = imaging.look_ahead(sim, HEAD, even).level_db
    sim.strengths_db = {"terrain": -40.0, "box0": -12.0}
    softer_db = imaging.look_ahead(sim, HEAD, even).level_db - usual_db
    wall = (slice(47, 48), slice(31, 33))  # the box's face, 9.5 m ahead; all other bins contain only the bed
    assert softer_db[wall] == pytest.approx(3.0, abs=0.5)
    assert softer_db[100:150, :10] == pytest.approx(-10.0, abs=1e-3)
    given = replace(even, bottom_strength_db=-30.0, strengths_db={"box0": -15.0})
    assert imaging.look_ahead(sim, HEAD, given).level_db == pytest.approx(usual_db)


def test_a_simulator_gives_surfaces_the_strengths_of_their_materials() -> None:
    strengths_db = Simulator("pool").strengths_db
    assert list(strengths_db) == Simulator("pool").label_names
    scenario = load("pool")
    assert strengths_db["terrain"] == scenario.ground.backscatter.strength_db
    for obstacle in scenario.obstacles:
        assert strengths_db[obstacle.name] == obstacle.material.backscatter.strength_db


def test_a_picture_has_a_level_for_each_range_and_bearing() -> None:
    image = imaging.look_ahead(basin(), HEAD, LOOK)
    assert image.level_db.shape == (200, 64)
    assert image.level_db.dtype == np.float32
    assert np.isfinite(image.level_db).all()
    assert image.ranges_m[[0, -1]] == pytest.approx([0.1, 39.9])
    assert np.degrees(image.bearings_rad[[0, -1]]) == pytest.approx([-65.0, 65.0])


def test_a_target_to_port_has_a_positive_bearing_and_one_behind_is_invisible() -> None:
    model = replace(LOOK, looks=0, beams=131, range_bins=400)
    for bearing_deg in (40.0, -25.0):
        bearing = np.radians(bearing_deg)
        middle = (15 * np.cos(bearing), 15 * np.sin(bearing), BED_M + HEIGHT_M)
        sim = basin((middle, (0.2, 0.2, 0.2)), ((-10.0, 0.0, -12.0), (1.0, 1.0, 1.0)))
        image = imaging.look_ahead(sim, HEAD, model)
        row, column = np.unravel_index(np.argmax(image.level_db - image.noise_db[:, None]), image.level_db.shape)
        assert image.ranges_m[row] == pytest.approx(14.9, abs=0.15)
        assert np.degrees(image.bearings_rad[column]) == pytest.approx(bearing_deg, abs=1.0)


def packaged_part(beams: int) -> ForwardLooking:
    """Return the middle beams of the default sonar, without speckle."""
    usual = ForwardLooking()
    return replace(usual, looks=0, beams=beams, field_of_view_rad=usual.field_of_view_rad / 511 * (beams - 1))


def test_the_default_rays_are_as_accurate_as_eighty_times_as_many() -> None:
    sim = Simulator("lake")
    sim.rov.release()
    sim.rov.place((-67.0, -52.0, -26.0))  # two metres above the bed, in front of a gate
    sonar = sim.rov.imaging_sonars["forward_looking"]
    pictures = []
    for many in ({}, {"columns_per_beam": 12, "rays_per_column": 1500}):
        sonar.change(replace(packaged_part(96), **many))
        pictures.append(sonar.look())
    error_db = pictures[0].level_db - pictures[1].level_db
    echoes = pictures[1].level_db > pictures[1].noise_db[:, None] + 3.0
    assert np.sqrt(np.mean(error_db[echoes] ** 2)) < 0.5
    assert np.mean(error_db[echoes]) == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize("upright", [True, False])
def test_a_target_of_five_centimetres_is_seen_at_ten_metres_wherever_it_is(upright: bool) -> None:
    model = replace(packaged_part(31), range_max_m=12.0, range_bins=300)
    many = replace(model, columns_per_beam=12, rays_per_column=3000)
    size_m = (0.05, 0.05, 6.0) if upright else (0.05, 6.0, 0.05)
    for moved_m in np.arange(6) * 0.015:  # over two beams, and ten rays of a column
        middle_m = (10.0, moved_m, -10.0) if upright else (10.0, 0.0, -10.0 + moved_m)
        sim = basin((middle_m, size_m))
        peaks_db = []
        for rays in (model, many):
            image = imaging.look_ahead(sim, imaging.pose_matrix((0.0, 0.0, -10.0)), rays)
            peaks_db.append(image.level_db[np.abs(image.ranges_m - 10.0) < 0.2].max())
        assert peaks_db[0] == pytest.approx(peaks_db[1], abs=1.2)  # the two columns of a beam sample its width


def test_the_strength_of_a_single_solid_takes_precedence() -> None:
    boxes = [((15.0, y, -12.0), (1.0, 1.0, 1.0)) for y in (-6.0, 6.0)]
    soft = replace(LOOK, looks=0, beams=131, noise_level_db=-100.0, strengths_db={"box1": -45.0})
    image = imaging.look_ahead(basin(*boxes), HEAD, soft)
    starboard, port = (image.level_db[:, side].max() for side in (image.bearings_rad < 0.0, image.bearings_rad > 0.0))
    assert starboard - port == pytest.approx(-15.0 + 45.0, abs=0.5)
    with pytest.raises(ValueError, match="box7"):
        imaging.look_ahead(basin(*boxes), HEAD, replace(LOOK, strengths_db={"box7": 1.0}))
    with pytest.raises(ValueError, match="strengths_db"):
        imaging.look_ahead(basin(*boxes), HEAD, replace(LOOK, strengths_db={"box0": float("nan")}))


def test_without_echoes_the_mean_power_is_the_noise() -> None:
    image = imaging.look_ahead(basin(), imaging.pose_matrix((0.0, 0.0, -1.0), pitch_rad=-1.0), LOOK)
    power = 10.0 ** ((image.level_db - image.noise_db[:, None]) / 10.0)
    assert power.mean() == pytest.approx(1.0, abs=0.03)  # 12,800 cells
    assert power.std() == pytest.approx(1.0, abs=0.05)


def test_a_picture_is_repeatable_on_any_number_of_threads_and_changes_with_time() -> None:
    sims = [basin(), basin(threads=3)]
    first, again = (imaging.look_ahead(sim, HEAD, LOOK).level_db for sim in sims)
    assert np.array_equal(first, again)
    sims[0].time_ns = 5_000_000
    assert not np.array_equal(first, imaging.look_ahead(sims[0], HEAD, LOOK).level_db)
    assert np.array_equal(first, imaging.look_ahead(sims[0], HEAD, LOOK, number=0).level_db)
    assert not np.array_equal(first, imaging.look_ahead(sims[1], HEAD, LOOK, name="another").level_db)


def test_a_waterfall_is_the_same_in_one_call_or_in_many() -> None:
    sim = basin()
    track = [imaging.pose_matrix((x, 0.0, -12.0)) for x in (0.0, 0.5, 1.0)]
    whole = imaging.look_aside(sim, track, SIDE)
    parts = [imaging.look_aside(sim, [pose], SIDE, first_ping=k) for k, pose in enumerate(track)]
    assert whole.picture_db().shape == (3, 1000)
    assert np.array_equal(whole.picture_db(), np.concatenate([part.picture_db() for part in parts]))
    assert whole.altitude_m == pytest.approx([8.0] * 3, abs=0.1)
    assert imaging.look_aside(sim, [], SIDE).picture_db().shape == (0, 1000)


def test_port_is_left_in_the_picture_and_over_ground_a_target_is_at_its_distance() -> None:
    sim = basin(((0.0, 25.0, BED_M + 0.25), (4.0, 0.5, 0.5)))
    waterfall = imaging.look_aside(sim, [HEAD], replace(SIDE, looks=0, solid_strength_db=0.0))
    ground = waterfall.over_ground()
    assert np.argmax(waterfall.picture_db()[0]) < 500
    slant_m, ground_m = (waterfall.ranges_m[np.nanargmax(side.port_db[0, 200:]) + 200] for side in (waterfall, ground))
    assert slant_m == pytest.approx(np.hypot(24.75, HEIGHT_M - 0.25), abs=0.3)
    assert ground_m == pytest.approx(24.75, abs=0.3)
    beyond = np.sqrt(SIDE.range_max_m**2 - HEIGHT_M**2)
    assert np.isnan(ground.starboard_db[0, waterfall.ranges_m > beyond + 0.1]).all()
    assert np.isfinite(ground.starboard_db[0, waterfall.ranges_m < beyond - 0.2]).all()


def test_without_a_bottom_the_picture_over_ground_is_empty() -> None:
    waterfall = imaging.look_aside(basin(), [imaging.pose_matrix((0.0, 0.0, 1.0))], SIDE)
    assert np.isinf(waterfall.altitude_m).all()
    assert np.isnan(waterfall.over_ground().picture_db()).all()


def test_a_single_beam_profiles_the_bed_below() -> None:
    down = imaging.pose_matrix((0.0, 0.0, BED_M + HEIGHT_M), pitch_rad=np.pi / 2)
    profiles = imaging.profile(basin(), down, np.radians([-40.0, 0.0, 30.0]))
    assert profiles.level_db.shape == (3, 2000)
    assert profiles.points_world_m[:, 2] == pytest.approx([BED_M] * 3, abs=0.15)
    assert profiles.points_world_m[2, 1] == pytest.approx(HEIGHT_M * np.tan(np.radians(30.0)), abs=0.2)
    nothing = imaging.profile(basin(), HEAD, [0.0])
    assert np.isinf(nothing.ranges_m).all()
    assert np.isnan(nothing.points_world_m).all()


def test_an_imaging_sonar_works_from_a_vehicles_pose() -> None:
    sim = Simulator("pool", seed=4)
    sim.rov.place((0.0, 0.0, -3.0))
    head = sim.rov.pose.world_from_body @ imaging.pose_matrix((0.5, 0.0, -0.2), pitch_rad=0.3)
    image = imaging.look_ahead(sim, head, replace(LOOK, range_max_m=10.0))
    over_db = image.level_db - image.noise_db[:, None]
    assert np.median(over_db[image.ranges_m > 4.0]) > 15.0


def test_poses_turn_as_rep_103_says() -> None:
    assert imaging.pose_matrix(yaw_rad=np.pi / 2)[:3, 0] == pytest.approx([0, 1, 0])
    assert imaging.pose_matrix(pitch_rad=np.pi / 2)[:3, 0] == pytest.approx([0, 0, -1])
    assert imaging.pose_matrix(roll_rad=np.pi / 2)[:3, 1] == pytest.approx([0, 0, 1])


BAD_POSES = {
    "shape": np.eye(3),
    "finite": np.full((4, 4), np.nan),
    "rotation": np.diag([2.0, 1.0, 1.0, 1.0]),
    "mirror": np.diag([-1.0, 1.0, 1.0, 1.0]),
    "last row": np.eye(4) + np.eye(4)[[3, 2, 1, 0]] * 0.1,
}


@pytest.mark.parametrize("pose", BAD_POSES.values(), ids=BAD_POSES.keys())
def test_an_invalid_pose_is_refused(pose: np.ndarray) -> None:
    with pytest.raises(ValueError, match="world_from_sonar"):
        imaging.look_ahead(basin(), pose, LOOK)
    with pytest.raises(ValueError, match=r"worlds_from_sonar\[1\]"):
        imaging.look_aside(basin(), [np.eye(4), pose], SIDE)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("beams", 0),
        ("beams", 12.5),
        ("beams", "many"),
        ("range_bins", 10**9),
        ("frequency_hz", -750e3),
        ("frequency_hz", float("nan")),
        ("field_of_view_rad", np.radians(361.0)),
        ("range_max_m", float("inf")),
        ("looks", 17),
        ("noise_level_db", None),
        ("rays_per_column", 10**6),
    ],
)
def test_a_bad_value_is_named(field: str, value: object) -> None:
    with pytest.raises(ValueError, match=rf"sonar\.{field}"):
        imaging.look_ahead(basin(), HEAD, replace(LOOK, **{field: value}))


def test_each_call_needs_its_own_kind_of_model() -> None:
    with pytest.raises(ValueError, match="ForwardLooking: must be a SideScan"):
        imaging.look_aside(basin(), [HEAD], LOOK)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="SideScan: must be a ForwardLooking"):
        imaging.look_ahead(basin(), HEAD, SIDE)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="must be a SingleBeam"):
        imaging.profile(basin(), HEAD, [0.0], SIDE)  # type: ignore[arg-type]


def test_bad_angles_and_numbers_are_refused() -> None:
    with pytest.raises(ValueError, match="angles_rad"):
        imaging.profile(basin(), HEAD, [0.0, np.nan])
    with pytest.raises(ValueError, match="angles_rad"):
        imaging.profile(basin(), HEAD, np.zeros((2, 2)))
    with pytest.raises(ValueError, match="number = -1"):
        imaging.look_ahead(basin(), HEAD, LOOK, number=-1)
    with pytest.raises(ValueError, match="first_ping"):
        imaging.look_aside(basin(), [HEAD], SIDE, first_ping=0.5)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"sonar\.detection_db"):
        imaging.profile(basin(), HEAD, [0.0], SingleBeam(detection_db=-1.0))
    with pytest.raises(ValueError, match=r"sonar\.depression_rad"):
        imaging.look_aside(basin(), [HEAD], SideScan(depression_rad=2.0))


def test_labels_tell_which_surface_a_cell_shows() -> None:
    """A 2 m box stands on the bed, 10 m to port and 5 m below the sonar head."""
    sim = basin(((0.0, 10.0, BED_M + 1.0), (2.0, 2.0, 2.0)))
    nothing, terrain, box = (sim.world.label_names.index(name) for name in ("nothing", "terrain", "box0"))
    head = imaging.pose_matrix((0.0, 0.0, BED_M + 5.0))
    lines = imaging.look_aside(sim, [head], SideScan(range_max_m=30.0, range_bins=300), with_labels=True)
    assert lines.port_labels is not None and lines.starboard_labels is not None
    face_m = np.hypot(9.0, 4.0)
    assert lines.port_labels[0, int(face_m / 0.1)] == box
    assert set(np.unique(lines.starboard_labels)) == {nothing, terrain}
    assert (lines.port_labels[0, lines.ranges_m < 4.5] == nothing).all()  # the water column shows no surface
    beams = imaging.profile(sim, head, [np.pi / 2], SingleBeam(range_bins=200), with_labels=True)
    assert beams.labels is not None and not (beams.labels == box).any()  # level beams pass over the box
    down = imaging.pose_matrix((0.0, 10.0, BED_M + 5.0), pitch_rad=np.pi / 2)
    beams = imaging.profile(sim, down, [0.0], SingleBeam(range_bins=200), with_labels=True)
    assert beams.labels is not None and beams.labels[0, int(3.0 / 0.1)] == box
    assert imaging.look_aside(sim, [head]).port_labels is None
