"""Loop closure: a drifting track is bent until its submaps match, as far as the terrain constrains them."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import uwsim
from uwsim.flight.record import FlightRecord
from uwsim.flight.survey import run_survey
from uwsim.mapping.closure import ClosedTrack, PingTrack, close_loops
from uwsim.missions import OwnVehicle, Steps, goto

LANE_M, SPACING_M, LANES, SPEED_M_S, HEIGHT_M = 80.0, 15.0, 5, 1.0, 12.0
ACROSS_M = np.linspace(-20.0, 20.0, 161)  # where the fan meets the ground, across the track


def hills(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return 1.5 * np.sin(x / 6.0) * np.cos(y / 5.0) + np.sin(0.21 * x + 0.13 * y) - 20.0


def plain(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.full_like(x, -20.0)


def lawn_mower(ground: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> tuple[PingTrack, np.ndarray]:
    """Fly lanes with an estimate that drifts by up to 3 m; return the track and the true positions (n, 2)."""
    track, truth = PingTrack(), []
    for k in range(int(LANES * LANE_M / SPEED_M_S)):
        lane, along_m = divmod(k * SPEED_M_S, LANE_M)
        is_back = lane % 2 == 1
        true = np.array([LANE_M - along_m if is_back else along_m, SPACING_M * lane])
        y = true[1] + ACROSS_M
        points = np.column_stack([np.full_like(y, true[0]), y, ground(np.full_like(y, true[0]), y)])
        drift = np.array([2.0 * np.sin(k / 130.0), 0.0075 * k])
        heading = np.diag([-1.0, -1.0, 1.0, 1.0]) if is_back else np.eye(4)
        body = heading.copy()
        body[:3, 3] = [*(true + drift), HEIGHT_M - 20.0]
        here = heading.copy()
        here[:3, 3] = [*true, HEIGHT_M - 20.0]
        in_body = (points - here[:3, 3]) @ here[:3, :3]
        track.add(float(k), body, np.eye(4), np.zeros(1, np.float32), np.repeat(in_body, 4, axis=0), 0.1 + 0.01 * k)
        truth.append(true)
    return track, np.array(truth)


def bent_by(closed: ClosedTrack, track: PingTrack) -> np.ndarray:
    return np.array([c[:2, 3] - e[:2, 3] for c, e in zip(closed.world_from_body, track.world_from_body, strict=True)])


def misfit_m(poses: list[np.ndarray], truth: np.ndarray) -> float:
    """Return the rms error about its mean, because matching cannot determine the mean."""
    error = np.array([pose[:2, 3] for pose in poses]) - truth
    return float(np.sqrt(np.mean(np.sum((error - error.mean(axis=0)) ** 2, axis=1))))


def test_hills_take_out_most_of_the_drift() -> None:
    track, truth = lawn_mower(hills)
    closed = close_loops(track)
    assert len(closed.matches) >= 0.5 * closed.tried > 3
    assert misfit_m(closed.world_from_body, truth) < misfit_m(track.world_from_body, truth) / 3.0


def test_what_the_estimate_corrects_in_a_jump_is_corrected_before_it_too() -> None:
    track, truth = lawn_mower(hills)
    half = len(track) // 2
    for k, true in enumerate(truth):  # the estimate drifts by 3 m, jumps back, and is correct from then on
        off_m = np.array([0.0, 3.0 * k / half]) if k < half else np.zeros(2)
        track.world_from_body[k][:2, 3] = true + off_m
        track.std_m[k] = 0.1 + float(off_m[1]) / 2.0
    closed = close_loops(track)
    error_m = [np.linalg.norm(pose[:2, 3] - true) for pose, true in zip(closed.world_from_body, truth, strict=True)]
    assert max(error_m) < 1.0, "of 3 m"
    assert max(error_m[half:]) < 0.4


def test_a_plain_tells_nothing() -> None:
    track, _ = lawn_mower(plain)
    assert np.abs(bent_by(close_loops(track), track)).max() < 0.05


def test_a_flight_that_never_comes_back_stays_as_it_is() -> None:
    track, _ = lawn_mower(hills)
    lane = int(LANE_M / SPEED_M_S)
    short = PingTrack(*(values[:lane] for values in vars(track).values()))
    closed = close_loops(short)
    assert closed.tried == 0
    assert np.abs(bent_by(closed, short)).max() == pytest.approx(0.0, abs=1e-9)
    assert close_loops(PingTrack()).world_from_body == []


def test_a_survey_closes_its_loops_and_still_covers_the_pool(tmp_path: Path) -> None:
    record = run_survey("pool", tmp_path, estimate="filter", close_loops=True, report="json", threads=1)
    assert record.coverage is not None and record.coverage > 0.9
    assert len(record.position_error_m) == record.ping_count
    assert (tmp_path / "map.bt").stat().st_size > 0


def out_and_back(vehicle: OwnVehicle) -> Steps[None]:
    vehicle.undock()
    yield from goto(vehicle, (-2.0, 0.0, -2.0), speed_m_s=0.5)


def test_a_mission_closes_its_loops(tmp_path: Path) -> None:
    def flown(close: bool) -> FlightRecord:
        out, by = tmp_path / str(close), {"map": True, "estimate": "filter", "report": "json"}
        return uwsim.fly(out_and_back, "pool", out, close_loops=close, **by)

    plain, bent = flown(False), flown(True)
    closed = bent.closed["rov"]
    assert plain.closed == {} and closed.path_world_m.shape == bent.pings_world_m["rov"].shape
    assert 0.0 < closed.errors_m.max() < 0.5
    told = json.loads((tmp_path / "True" / "summary.json").read_text())["closed"]["rov"]
    assert told["overlaps"] == closed.tried == 0 and told["error_max_m"] == closed.errors_m.max()
    maps = [(tmp_path / str(close) / "map.bt").read_bytes() for close in (False, True)]
    assert maps[0] == maps[1], "nothing was seen twice, so nothing is bent"


def test_a_mission_s_loops_need_map_and_filter(tmp_path: Path) -> None:
    for wrong in ({"map": True}, {"estimate": "filter"}):
        with pytest.raises(ValueError, match="close_loops: needs map=True and estimate='filter'"):
            uwsim.fly(out_and_back, "pool", tmp_path, close_loops=True, **wrong)


def test_closing_loops_needs_an_estimated_track(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="close_loops: needs map=True and estimate='filter'"):
        run_survey("pool", tmp_path, close_loops=True)
    with pytest.raises(ValueError, match="close_loops: cannot be combined"):
        run_survey("pool", tmp_path, estimate="filter", close_loops=True, verify_map=True)
