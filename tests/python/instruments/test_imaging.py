"""The Python interface of imaging sonars: arrays, poses, errors. The acoustics are tested in tests/cpp."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from basin import BED_M, basin
from uwsim import Simulator
from uwsim.instruments.sonars import imaging
from uwsim.instruments.sonars.imaging import ForwardLooking, SideScan, SingleBeam

HEIGHT_M = 8.0
HEAD = imaging.pose_matrix((0.0, 0.0, BED_M + HEIGHT_M))
LOOK = ForwardLooking(beams=64, range_bins=200, rays_per_column=100)
SIDE = SideScan(range_bins=500)
WRONG: list[tuple[str, object]] = [
    *(("beams", value) for value in (0, 12.5, "many", None)),
    ("range_bins", 10**9),
    ("frequency_hz", float("nan")),
    ("range_max_m", float("inf")),
]


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
    pool = Simulator("pool")
    assert list(pool.strengths_db) == pool.label_names
    for name, of in (("terrain", pool.scenario.ground), ("box", pool.scenario.obstacles[0].material)):
        assert pool.strengths_db[name] == of.backscatter.strength_db


def packaged_part(beams: int, **changes: object) -> ForwardLooking:
    """Return the middle beams of the default sonar, without speckle."""
    usual = ForwardLooking()
    return replace(
        usual, looks=0, beams=beams, field_of_view_rad=usual.field_of_view_rad / 511 * (beams - 1), **changes
    )


def test_the_default_rays_are_as_accurate_as_eighty_times_as_many() -> None:
    sim = Simulator("lake")
    sim.rov.place((-67.0, -52.0, -26.0))  # two metres above the bed, in front of a gate
    sonar = sim.rov.imaging_sonars["forward_looking"]
    pictures = []
    for many in ({}, {"columns_per_beam": 12, "rays_per_column": 1500}):
        sonar.change(packaged_part(96, **many))
        pictures.append(sonar.look())
    error_db = pictures[0].level_db - pictures[1].level_db
    echoes = pictures[1].level_db > pictures[1].noise_db[:, None] + 3.0
    assert np.sqrt(np.mean(error_db[echoes] ** 2)) < 0.5
    assert np.mean(error_db[echoes]) == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize("upright", [True, False])
def test_a_target_of_five_centimetres_is_seen_at_ten_metres_wherever_it_is(upright: bool) -> None:
    model = packaged_part(31, range_max_m=12.0, range_bins=300)
    many = replace(model, columns_per_beam=12, rays_per_column=3000)
    size_m = (0.05, 0.05, 6.0) if upright else (0.05, 6.0, 0.05)
    for moved_m in np.arange(6) * 0.015:  # over two beams, and ten rays of a column
        sim = basin(((10.0, moved_m, -10.0) if upright else (10.0, 0.0, -10.0 + moved_m), size_m))
        images = [imaging.look_ahead(sim, imaging.pose_matrix((0.0, 0.0, -10.0)), rays) for rays in (model, many)]
        few_db, many_db = (image.level_db[np.abs(image.ranges_m - 10.0) < 0.2].max() for image in images)
        assert few_db == pytest.approx(many_db, abs=1.2)  # the two columns of a beam sample its width


def test_a_picture_is_repeatable_on_any_number_of_threads_and_changes_with_time() -> None:
    sims = [basin(), basin(threads=3)]
    image, again = (imaging.look_ahead(sim, HEAD, LOOK) for sim in sims)
    first = image.level_db
    assert (first.shape, first.dtype) == ((200, 64), np.float32) and np.isfinite(first).all()
    assert image.ranges_m[[0, -1]] == pytest.approx([0.1, 39.9])
    assert np.degrees(image.bearings_rad[[0, -1]]) == pytest.approx([-65.0, 65.0])
    assert np.array_equal(first, again.level_db)
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
    dry = imaging.look_aside(sim, [imaging.pose_matrix((0.0, 0.0, 1.0))], SIDE)
    assert np.isinf(dry.altitude_m).all() and np.isnan(dry.over_ground().picture_db()).all(), "there is no bottom"


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


def test_bad_arguments_are_refused() -> None:
    sim, ahead, aside, profile = basin(), imaging.look_ahead, imaging.look_aside, imaging.profile
    refused: list[tuple[str, Callable[[], object]]] = [
        ("angles_rad", lambda: profile(sim, HEAD, [0.0, np.nan])),
        ("angles_rad", lambda: profile(sim, HEAD, np.zeros((2, 2)))),
        ("number = -1", lambda: ahead(sim, HEAD, LOOK, number=-1)),
        ("first_ping", lambda: aside(sim, [HEAD], SIDE, first_ping=0.5)),
        (r"sonar\.detection_db", lambda: profile(sim, HEAD, [0.0], SingleBeam(detection_db=-1.0))),
        (r"sonar\.depression_rad", lambda: aside(sim, [HEAD], SideScan(depression_rad=2.0))),
        ("ForwardLooking: must be a SideScan", lambda: aside(sim, [HEAD], LOOK)),
        ("SideScan: must be a ForwardLooking", lambda: ahead(sim, HEAD, SIDE)),
        ("must be a SingleBeam", lambda: profile(sim, HEAD, [0.0], SIDE)),
        ("box7", lambda: ahead(sim, HEAD, replace(LOOK, strengths_db={"box7": 1.0}))),
        ("strengths_db", lambda: ahead(sim, HEAD, replace(LOOK, strengths_db={"terrain": float("nan")}))),
        *((rf"sonar\.{field}", partial(ahead, sim, HEAD, replace(LOOK, **{field: value}))) for field, value in WRONG),
    ]
    for words, call in refused:
        with pytest.raises(ValueError, match=words):
            call()


def test_labels_tell_which_surface_a_cell_shows() -> None:
    """A 2 m box stands on the bed, 10 m to port and 5 m below the sonar head."""
    sim = basin(((0.0, 10.0, BED_M + 1.0), (2.0, 2.0, 2.0)))
    nothing, terrain, box = (sim.world.label_names.index(name) for name in ("nothing", "terrain", "box0"))
    head, down = (imaging.pose_matrix((0.0, y, BED_M + 5.0), pitch_rad=pitch) for y, pitch in ((0, 0), (10, np.pi / 2)))
    lines = imaging.look_aside(sim, [head], SideScan(range_max_m=30.0, range_bins=300), with_labels=True)
    assert lines.port_labels is not None and lines.starboard_labels is not None
    assert lines.port_labels[0, int(np.hypot(9.0, 4.0) / 0.1)] == box
    assert set(np.unique(lines.starboard_labels)) == {nothing, terrain}
    assert (lines.port_labels[0, lines.ranges_m < 4.5] == nothing).all()  # the water column shows no surface
    over, below = (
        imaging.profile(sim, pose, [angle], SingleBeam(range_bins=200), with_labels=True).labels
        for pose, angle in ((head, np.pi / 2), (down, 0.0))
    )
    assert over is not None and not (over == box).any()  # level beams pass over the box
    assert below is not None and below[0, int(3.0 / 0.1)] == box
    assert imaging.look_aside(sim, [head]).port_labels is None
