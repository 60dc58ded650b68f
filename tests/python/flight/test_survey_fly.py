"""Surveys of pool and lake: they keep their promises, maps are reproducible, and every exit is clean."""

import os
import signal
import weakref

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.flight.record import DONE, INTERRUPTED, FlightRecord
from uwsim.flight.survey import fly_survey
from uwsim.mapping import OccupancyMap
from uwsim.mapping.map_filler import MapFiller
from uwsim.mapping.ping_to_map import PingToMap
from uwsim.missions import COVERED
from uwsim.scoring.map_score import MapScore, score_map


def score(sim: Simulator, occupancy: OccupancyMap, record: FlightRecord) -> MapScore:
    voxels, voxel_m = occupancy.occupied_voxels(), occupancy.resolution_m
    return score_map(sim.world, voxels, voxel_m, record.path_world_m, record.area_world_m, record.range_max_m)


def test_the_pool_is_covered_and_the_map_lies_on_the_true_surface() -> None:
    sim = Simulator("pool")
    occupancy, record = fly_survey(sim)
    assert (record.ended_because, record.result) == (DONE, COVERED)
    assert not record.ended_early
    assert record.collisions == 0
    assert record.ping_count == pytest.approx(10 * record.simulated_s, abs=1)
    scored = score(sim, occupancy, record)
    assert scored.coverage > 0.95
    # The centre of a voxel that the surface passes through is at most half its diagonal away.
    assert scored.distance_max_m < 0.5 * np.sqrt(3) * occupancy.resolution_m + 1e-3


def test_the_lake_survey_meets_its_promises() -> None:
    sim = Simulator("lake")
    occupancy, record = fly_survey(sim)
    assert (record.ended_because, record.collisions) == (DONE, 0)
    assert record.simulated_s >= 20 * 60
    assert sim.step_s <= 0.005
    assert record.ping_count >= 10 * record.simulated_s - 1
    assert (np.ptp(record.area_world_m, axis=0) >= (150, 100)).all()
    scored = score(sim, occupancy, record)
    assert scored.coverage >= 0.95
    assert scored.distance_p95_m < 0.5
    vertices, triangles, labels = sim.world.surface_mesh()
    gate_m = vertices[triangles[labels == sim.world.label_names.index("gate_main")]].reshape(-1, 3)
    top_m = gate_m[gate_m[:, 2].argmax()]
    assert (abs(occupancy.occupied_voxels() - top_m).max(axis=1) < 1.0).any(), "the gate's bar is in the map"


def test_scenario_and_seed_determine_the_map_to_the_byte_whatever_the_threads_and_the_engine() -> None:
    def surveyed(seed: int, threads: int, engine: str) -> OccupancyMap:
        occupancy = OccupancyMap(0.2, engine=engine)
        return fly_survey(Simulator("pool", mission_time_s=20.0, seed=seed, threads=threads), occupancy)[0]

    first, other = surveyed(3, 1, "bricks"), surveyed(3, 2, "octomap")
    assert first.to_bytes("ot") == other.to_bytes("ot")
    assert first.to_bytes("bt") == other.to_bytes("bt") == surveyed(3, 2, "bricks").to_bytes("bt")
    assert first.to_bytes("bt") != surveyed(4, 1, "bricks").to_bytes("bt"), "the sensors' noise steers the vehicle"


def test_a_survey_keeps_one_sample_ping_only() -> None:
    """Hours of pings would exhaust the memory."""
    sim = Simulator("pool", mission_time_s=11.0)
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


def test_ctrl_c_ends_the_survey_with_the_map_so_far() -> None:
    sim = Simulator("pool", threads=2)
    shares: list[float] = []

    def interrupt_after_fifty(share: float) -> None:
        shares.append(share)
        if len(shares) == 50:
            os.kill(os.getpid(), signal.SIGINT)

    occupancy, record = fly_survey(sim, on_progress=interrupt_after_fifty)
    assert record.ended_because == INTERRUPTED
    assert 50 <= record.ping_count <= 52
    assert len(occupancy.occupied_voxels()) > 0
    assert OccupancyMap(0.5).to_bytes("bt") != occupancy.to_bytes("bt")


def test_a_survey_with_another_sonar_model_decodes_its_own_beams() -> None:
    _, record = fly_survey(Simulator("pool", sonar_model=3, mission_time_s=3.0))
    assert record.sonar_model == "3"
    assert record.range_max_m == pytest.approx(94.9)
    assert record.sample_ping is None or len(record.sample_ping.ranges_m) == 1025
