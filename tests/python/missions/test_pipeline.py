"""A pipeline is followed to its end with sonar and camera, and with either alone."""

import math
from itertools import pairwise

import cv2
import numpy as np
import pytest

import uwsim
from uwsim.missions.planners import pipeline
from uwsim.missions.planners.pipe_track import PipeTrack, crossings
from uwsim.missions.planners.pipe_view import SeenPipe, pipe_in_picture, pixels_of
from uwsim.missions.planners.pipeline import follow_pipeline

PIPE_M = np.array([[-20, -6], [-8, -9], [4, -6], [16, -10]], float)


def off_pipe_m(points_m: np.ndarray) -> np.ndarray:
    """Return the distances (n,) of points (n, 2) from the pipe's axis."""
    nearest = [
        a + np.clip((points_m - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)[:, None] * (b - a)
        for a, b in pairwise(PIPE_M)
    ]
    return np.min([np.linalg.norm(points_m - near, axis=1) for near in nearest], axis=0)


BLIND_LATER = {"kind": "sonar", "at_s": 40.0}  # before the bend
BLIND, DARK = {"kind": "sonar"}, {"kind": "camera", "camera": "down"}


@pytest.mark.parametrize(
    ("begin_m", "heading_rad", "end", "fault", "least_m"),
    [
        ((0.0, -7.0), math.pi + 0.25, 0, BLIND_LATER, 18.0),
        ((-19.0, -5.0), -0.3, -1, DARK, 25.0),
    ],
    ids=["both, then camera", "sonar"],
)
def test_a_pipeline_is_followed_to_its_end_by_sonar_and_camera_and_by_either_alone(
    begin_m, heading_rad, end, fault, least_m, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pipeline, "LOOK_PIXELS", 160)

    def mission(vehicle):
        vehicle.undock()
        return (yield from follow_pipeline(vehicle, begin_m, heading_rad))

    sim = uwsim.Simulator("cove")
    sim.faults.inject(**fault)
    flown = uwsim.fly(mission, sim)
    assert not flown.ended_early, flown.ended_because
    assert flown.collisions == 0
    track = flown.result
    assert track.by_sonar > 0 and (track.by_camera > 0) == (fault is not DARK)
    assert off_pipe_m(track.crossings_m).max() < 0.4
    assert np.linalg.norm(track.crossings_m[-1] - PIPE_M[end]) < 1.0
    assert track.length_m > least_m and track.pictures == pytest.approx(track.length_m / 5.0, abs=2.0)
    found_s = next(event.time_s for event in flown.events if event.name == "pipe_found")
    samples = flown.samples["rov"]
    on_it = (samples["time_s"] > found_s + 8.0) & (samples["time_s"] < flown.simulated_s - 25.0)
    assert on_it.sum() > 30
    assert np.sqrt(np.mean(off_pipe_m(samples.path_world_m[on_it, :2]) ** 2)) < 0.6


def test_where_there_is_no_pipe_it_says_so() -> None:
    def mission(vehicle):
        vehicle.undock()
        yield from follow_pipeline(vehicle, (-12.0, -18.0), 0.0, search_m=8.0)

    assert uwsim.fly(mission, "cove").ended_because == "no pipe was found within 8 m"


def test_a_bump_is_a_pipe_only_if_it_has_its_width() -> None:
    across_m = np.linspace(-8.0, 8.0, 400)
    bed = np.column_stack([np.full(400, 5.0), across_m, -9.0 + 0.05 * across_m])
    assert len(crossings(bed.astype(float), 0.8)) == 0
    piped = bed.copy()
    piped[np.abs(across_m - 2.0) < 0.4, 2] += 0.6
    assert crossings(piped, 0.8) == pytest.approx(np.array([[5.0, 2.0]]), abs=0.05)
    assert len(crossings(piped, 6.0)) == 0 and len(crossings(piped, 0.1)) == 0


def test_what_the_camera_sees_aside_of_the_track_shifts_what_lies_ahead() -> None:
    track = PipeTrack(np.zeros(2), 0.0, 0.8)
    for x in np.arange(0.5, 8.0, 0.5):
        across = np.linspace(-4.0, 4.0, 200)
        bump = np.abs(across) < 0.4
        assert track.add_ping(np.column_stack([np.full(200, x), across, -9.0 + 0.6 * bump]))
    beside = SeenPipe(np.array([4.0, 0.3]), np.array([-1.0, 0.0]), (-1.0, 1.0), 2.0)
    assert not track.add_picture(beside), "one picture is not enough"
    for _ in range(6):
        assert track.add_picture(beside)
    places = np.array(track.places)
    assert places[places[:, 0] > 2.5, 1] == pytest.approx(0.3, abs=0.1)
    assert places[places[:, 0] < 1.5, 1] == pytest.approx(0.0, abs=0.01)
    steep = SeenPipe(np.array([4.0, 0.0]), np.array([0.0, 1.0]), (-1.0, 1.0), 2.0)
    assert not track.add_picture(steep) and not track.add_picture(steep)


def test_pixels_are_where_opencv_has_them() -> None:
    camera = uwsim.Simulator("cove").rov.cameras["down"]
    points = np.random.default_rng(1).uniform((-3.0, -2.0, 2.0), (3.0, 2.0, 6.0), (50, 3))  # in the optical frame
    expected, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), camera.info.k, camera.info.d)
    ahead_left_up = points[:, [2, 0, 1]] * (1.0, -1.0, -1.0)
    pixels, inside = pixels_of(ahead_left_up, camera.info, np.eye(4))
    assert pixels == pytest.approx(expected[:, 0], abs=1e-6)
    assert inside.sum() == ((expected[:, 0] >= 0) & (expected[:, 0] <= (639, 359))).all(axis=1).sum()


def test_the_camera_sees_the_pipe_where_it_lies_and_none_beside_it() -> None:
    sim = uwsim.Simulator("cove", seed=1)
    rov, down = sim.rov, sim.rov.cameras["down"].resized(320)
    for lamp in rov.lamps.values():
        lamp.on = True
    for share, yaw_rad in ((0.3, 0.0), (0.6, 0.2), (0.7, 2.5)):
        on_it = PIPE_M[0] + share * (PIPE_M[1] - PIPE_M[0])
        rov.place((on_it[0] + 0.3, on_it[1] + 0.3, -5.5), (0.0, 0.0, math.sin(yaw_rad / 2.0), math.cos(yaw_rad / 2.0)))
        pipe = pipe_in_picture(down.capture(), -5.5 - rov.sensors["altitude"].read(), 0.8)
        assert pipe is not None and off_pipe_m(pipe.point_world_m[None])[0] < 0.25
        along = (PIPE_M[1] - PIPE_M[0]) / np.linalg.norm(PIPE_M[1] - PIPE_M[0])
        assert abs(pipe.direction @ along) > math.cos(math.radians(12.0))
    rov.place((0.0, -15.0, -5.5))
    assert pipe_in_picture(down.capture(), -9.0, 0.8) is None
    sim.faults.inject("camera", camera="down")
    assert pipe_in_picture(down.capture(), -9.0, 0.8) is None
