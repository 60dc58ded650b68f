"""A survey of the pool: every ping passes through the whole chain, maps are reproducible, and every exit is clean."""

import os
import signal
import threading
import weakref

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.flight.record import BATTERY_EMPTY, DONE, INTERRUPTED
from uwsim.flight.survey import fly_survey
from uwsim.mapping import OccupancyMap
from uwsim.mapping.difference import map_difference
from uwsim.mapping.map_filler import MapFiller
from uwsim.mapping.ping_to_map import PingToMap
from uwsim.missions import COVERED
from uwsim.scoring.map_score import score_map


def survey_bytes(**options: object) -> bytes:
    occupancy, _ = fly_survey(Simulator("pool", mission_time_s=20.0, **options))
    return occupancy.to_bytes("bt")


def test_the_pool_is_covered_and_the_map_lies_on_the_true_surface() -> None:
    sim = Simulator("pool")
    occupancy, record = fly_survey(sim)
    assert (record.ended_because, record.result) == (DONE, COVERED)
    assert not record.ended_early
    assert record.collisions == 0
    assert record.ping_count == pytest.approx(10 * record.simulated_s, abs=1)
    score = score_map(
        sim.world,
        occupancy.occupied_voxels(),
        occupancy.resolution_m,
        record.path_world_m,
        record.area_world_m,
        record.range_max_m,
    )
    assert score.coverage > 0.95
    # The centre of a voxel that the surface passes through is at most half its diagonal away.
    assert score.distance_max_m < 0.5 * np.sqrt(3) * occupancy.resolution_m + 1e-3


def test_scenario_and_seed_determine_the_map_to_the_byte_whatever_the_threads() -> None:
    first = survey_bytes(seed=3, threads=1)
    assert survey_bytes(seed=3, threads=1) == first
    assert survey_bytes(seed=3, threads=2) == first
    assert survey_bytes(seed=4, threads=1) != first, "the sensors' noise steers the vehicle"


def test_both_engines_give_the_same_map_to_the_byte() -> None:
    maps = [OccupancyMap(0.2, engine=engine) for engine in ("bricks", "octomap")]
    for occupancy, threads in zip(maps, (2, 1), strict=True):
        fly_survey(Simulator("pool", mission_time_s=10.0, threads=threads), occupancy)
    assert maps[0].to_bytes("ot") == maps[1].to_bytes("ot")
    assert maps[0].to_bytes("bt") == maps[1].to_bytes("bt")


def test_a_survey_keeps_one_sample_ping_only() -> None:
    """Hours of pings would exhaust the memory."""
    sim = Simulator("pool", mission_time_s=20.0)
    pings: list[weakref.ref[object]] = []
    fly_survey(sim, on_progress=lambda share: pings.append(weakref.ref(sim.rov.sonar.ping().ranges_m)))
    assert len(pings) > 100
    assert sum(ping() is not None for ping in pings) <= 3


def test_scans_before_a_refused_one_are_in_the_map() -> None:
    hull = (np.full(3, -0.1), np.full(3, 0.1))
    ranges_m = np.full(513, 10.0, np.float32)
    far = np.eye(4)
    far[0, 3] = 1e6
    occupancy = OccupancyMap(0.5)
    with pytest.raises(ValueError, match="must be within"), MapFiller(occupancy, 95.0) as filler:
        chain = PingToMap(2, hull, filler)
        for world_from_sonar in (np.eye(4), far, np.eye(4)):
            chain.insert(ranges_m, world_from_sonar, world_from_sonar, 0.0)
    assert len(occupancy.occupied_voxels()) > 0


def test_a_corrupted_depth_string_corrupts_the_map() -> None:
    """The map is built only from the transmitted strings."""

    def nearer(text: str) -> str:
        values = text.split("a")
        values[256] = "0.75"
        return "a".join(values)

    clean, _ = fly_survey(Simulator("pool", mission_time_s=5.0, threads=1))
    corrupted, _ = fly_survey(Simulator("pool", mission_time_s=5.0, threads=1), transmit=nearer)
    assert corrupted.to_bytes("bt") != clean.to_bytes("bt")
    with pytest.raises(ValueError, match=r"513 values"):
        fly_survey(Simulator("pool", mission_time_s=5.0), transmit=lambda text: text[: len(text) // 2])


@pytest.mark.parametrize("threads", [1, 2])
def test_ctrl_c_ends_the_survey_with_the_map_so_far(threads: int) -> None:
    sim = Simulator("pool", threads=threads)
    pinged = threading.Event()
    shares: list[float] = []

    def interrupt_after_fifty(share: float) -> None:
        shares.append(share)
        if len(shares) == 50:
            pinged.set()
            os.kill(os.getpid(), signal.SIGINT)

    occupancy, record = fly_survey(sim, on_progress=interrupt_after_fifty)
    assert pinged.is_set()
    assert record.ended_because == INTERRUPTED
    assert 50 <= record.ping_count <= 52
    assert len(occupancy.occupied_voxels()) > 0
    assert OccupancyMap(0.5).to_bytes("bt") != occupancy.to_bytes("bt")


def test_a_survey_with_another_sonar_model_decodes_its_own_beams() -> None:
    _, record = fly_survey(Simulator("pool", sonar_model=3, mission_time_s=3.0))
    assert record.sonar_model == "3"
    assert record.range_max_m == pytest.approx(94.9)
    assert record.sample_ping is None or len(record.sample_ping.ranges_m) == 1025


def test_an_empty_battery_ends_the_survey() -> None:
    _, record = fly_survey(Simulator("pool", mission_time_s=4.0))
    assert record.ended_because == BATTERY_EMPTY
    assert record.simulated_s == pytest.approx(4.0, abs=0.11)


def test_a_survey_by_the_filter_maps_what_the_vehicle_believes() -> None:
    sim = Simulator("pool", mission_time_s=15.0)
    occupancy, record = fly_survey(sim, estimate="filter")
    true_map, _ = fly_survey(Simulator("pool", mission_time_s=15.0))
    assert record.estimate == "filter" and len(record.position_error_m) == record.ping_count
    assert 0.0 < record.position_error_m.max() < 1.0
    assert map_difference(occupancy, true_map).differing > 0
