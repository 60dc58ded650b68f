"""One ping makes one map, wherever it is made: in flight, live, from a recording, ashore, by nodes and by planners."""

from __future__ import annotations

import pickle
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from uwsim import fly, recording
from uwsim.bridges.remote.sonar import RemotePing
from uwsim.channels import Table
from uwsim.channels.families.map import binary
from uwsim.channels.families.pings import TakenPing
from uwsim.flight.pinging import chain_of, filters_outliers
from uwsim.flight.survey import fly_survey
from uwsim.link.ashore import placed_points
from uwsim.live import LiveSimulator
from uwsim.mapping import OccupancyMap, ranging
from uwsim.mapping.map_filler import MapFiller
from uwsim.mapping.ping_to_map import PingToMap
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.planners.cells import Cells
from uwsim.missions.planners.live_map import LiveMap
from uwsim.missions.planners.wayfinder import Wayfinder
from uwsim.recording.pings import recorded_pings
from uwsim.recording.survey_from import live_map, survey_from
from uwsim.scenario import Scenario, ScenarioError, load
from uwsim.scenario.read.validated import validated
from uwsim.simulator.simulator import Simulator

VOXEL_M, NEVER_M = 0.2, 0.001  # no echo's place is as certain as the second
TOPICS = ("sonar_ping", "octomap_binary", "scan", "laserPointCloud", "depthArray", "placed_ping")
SETTINGS: dict[str, dict[str, Any]] = {
    "by default": {},
    "unfiltered": {"outlier_filter": False},
    "a limit of 5 cm": {"max_uncertainty_m": 0.05},
    "a limit that none meets": {"max_uncertainty_m": NEVER_M},
}


def lake(mode: str = "physics", **survey: Any) -> Scenario:
    """Return the lake with a vehicle over its bed, a multibeam in a mode, and changes to the survey."""
    scenario = load("lake")
    assert scenario.survey is not None
    vehicle = scenario.vehicles[0]
    data = dict(scenario.given())
    start = {"position_m": [-60.0, -60.0, -18.0]}
    data["vehicles"] = [{**vehicle.given(), "start": start, "sonar": {**vehicle.sonar.given(), "mode": mode}}]
    data["survey"] = {**scenario.survey.given(), "voxel_m": VOXEL_M, **survey}
    return validated(Scenario, data)


@dataclass
class Made:
    """Maps and numbers of mapped echoes per ping, made of the same pings, by the place that made them."""

    maps: dict[str, OccupancyMap]
    echoes: dict[str, list[int]]
    published: bytes
    published_again: bytes


@cache
def made(folder: Path, setting: str) -> Made:
    """Record a live run with a setting of the survey; map its pings at each place."""
    path, voxel = folder / f"{setting}.mcap", VOXEL_M
    with LiveSimulator(lake(**SETTINGS[setting]), speed="max", paused=True) as live:
        sim, table = live.simulator, Table(live.simulator)
        with recording.Recorder(live, path, topics=TOPICS, shared=table):
            live.rov.sonar.aim(-0.6)
            live.rov.set_effort(surge=0.4, yaw=0.3)
            live.step(500)
        table.maps["rov"].write(folder / "saved.bt")  # as the service save_map does
        run = recording.open(path)
        taken = [each for each, _ in recorded_pings(run, "sonar_ping")]
        maps = {"flight": OccupancyMap(voxel), "save_map": OccupancyMap.read(folder / "saved.bt")}
        with MapFiller(maps["flight"], sim.rov.sonar.model.range_max_m) as filler:
            chain = chain_of(sim, "rov", filler, filters_outliers(sim, "rov", None))
            flown = [len(inserted(chain, each)) for each in taken]
    maps["recording"] = live_map(run)[0]
    heard = {topic: [each.message for each in run.messages(topic)] for topic in TOPICS}
    for name in ("nodes", "ashore", "remote"):
        maps[name] = OccupancyMap(voxel)
    ashore = [placed_points(each) for each in heard["placed_ping"]]
    remote = [by_remote(scan, each) for scan, each in zip(heard["scan"], taken, strict=True)]
    nodes = [by_nodes(text, each) for text, each in zip(heard["depthArray"], taken, strict=True)]
    for name, scans in (("nodes", nodes), ("ashore", ashore), ("remote", remote)):
        for points_m, origin_m in scans:
            maps[name].insert_scan(points_m, origin_m)
    echoes = {
        "flight": flown,
        "cloud": [each.width for each in heard["laserPointCloud"]],
        "nodes": [len(points_m) for points_m, _ in nodes],
        "ashore": [len(points_m) for points_m, _ in ashore],
        "remote": [len(points_m) for points_m, _ in remote],
    }
    published, until = heard["octomap_binary"][-1], OccupancyMap(voxel)
    stamp_ns = published.header.stamp.sec * 10**9 + published.header.stamp.nanosec
    with MapFiller(until, sim.rov.sonar.model.range_max_m) as filler:
        chain = chain_of(sim, "rov", filler, filters_outliers(sim, "rov", None))
        for each in taken:
            if each.ping.time_ns <= stamp_ns:
                inserted(chain, each)
    return Made(maps, echoes, published.data.tobytes(), binary(until))


def inserted(chain: PingToMap, taken: TakenPing) -> NDArray[np.float32]:
    poses, time_s = (taken.odom_from_body, taken.odom_from_sonar), 1e-9 * taken.ping.time_ns
    return chain.insert(taken.ping.ranges_m, *poses, time_s, taken.deviation_m)


def by_nodes(text: Any, taken: TakenPing) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Return a depth string's echoes in odom, as the published nodes compute them, and the sonar's position."""
    points = ranging.to_point_cloud(ranging.to_laser_scan(ranging.decode_depth_string(text.data, 2), 2))
    return ranging.transform_points(points, taken.odom_from_sonar), taken.odom_from_sonar[:3, 3]


def by_remote(scan: Any, taken: TakenPing) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Return a scan's echoes in odom, as a remote vehicle's map receives them, and the sonar's position."""
    angles_rad = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    ping = RemotePing(scan.ranges, angles_rad, taken.odom_from_sonar, 0.0)
    return ranging.transform_points(ping.points_sonar_m[ping.valid], taken.odom_from_sonar), taken.odom_from_sonar[
        :3, 3
    ]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("one map")


@pytest.mark.parametrize("setting", SETTINGS)
def test_live_saved_and_recorded_maps_are_the_flown_one_to_the_byte(folder: Path, setting: str) -> None:
    found = made(folder, setting)
    flown = found.maps["flight"].to_bytes("bt")
    assert found.maps["save_map"].to_bytes("bt") == flown
    assert found.maps["recording"].to_bytes("bt") == flown
    assert found.published == found.published_again  # /octomap_binary, which lags behind


@pytest.mark.parametrize("setting", SETTINGS)
@pytest.mark.parametrize("place", ["nodes", "ashore", "remote"])
def test_maps_made_from_topics_have_the_echoes_of_the_flown_one(folder: Path, setting: str, place: str) -> None:
    found = made(folder, setting)
    assert found.echoes[place] == found.echoes["flight"] == found.echoes["cloud"]
    flown, here = (
        set(map(tuple, np.round(found.maps[name].occupied_voxels(), 3).tolist())) for name in ("flight", place)
    )
    assert len(flown & here) >= 0.99 * max(len(flown), len(here))  # poses and ranges are rounded in messages


def test_the_settings_matter_in_this_world(folder: Path) -> None:
    """The maps above are equal because all are filtered, not because there is nothing to filter."""
    counts = {setting: sum(made(folder, setting).echoes["flight"]) for setting in SETTINGS}
    assert counts["unfiltered"] > counts["by default"] > counts["a limit of 5 cm"] > 0
    assert counts["a limit that none meets"] == 0


def test_a_survey_s_map_is_rebuilt_from_its_recording_with_the_same_bytes(tmp_path: Path) -> None:
    path = tmp_path / "survey.mcap"
    flown = fly(None, lake(), tmp_path / "out", map=True, report="none", record=path, time_limit_s=3.0)
    assert flown.stage_wall_s["recording"] > 0.0
    survey_from(recording.open(path), tmp_path / "again.bt", None)
    assert len([*recorded_pings(recording.open(path), "sonar_ping")]) > 25
    assert (tmp_path / "again.bt").read_bytes() == (tmp_path / "out/map.bt").read_bytes()


def test_pings_inserted_one_by_one_make_the_survey_s_map() -> None:
    own = OccupancyMap(VOXEL_M)
    sim = Simulator(lake(max_uncertainty_m=0.05), mission_time_s=4.0)
    flown, record = fly_survey(sim, on_ping_taken=lambda ping, panel, body: own.insert(ping))
    assert record.ping_count > 25
    assert own.to_bytes("bt") == flown.to_bytes("bt")


def test_a_ping_that_no_sonar_took_is_refused() -> None:
    ping = Simulator("pool").rov.sonar.ping()
    with pytest.raises(ValueError, match=r"ping: does not have its sonar's chain"):
        OccupancyMap(0.2).insert(pickle.loads(pickle.dumps(ping)))


def test_a_planner_s_map_has_no_echo_that_the_survey_filters() -> None:
    occupied = {}
    for setting, survey in SETTINGS.items():
        sim = Simulator(lake(**survey))
        vehicle = OwnVehicle(sim.rov, sim)
        live = LiveMap(vehicle, VOXEL_M, Cells((0.0, 0.0), 0.0, 1.0))
        wayfinder = Wayfinder(vehicle, 2.0, 0.5, on_ping=live.add)
        wayfinder.look()
        occupied[setting] = live.map.statistics().occupied_voxels
    assert occupied["unfiltered"] > 100
    assert occupied["a limit that none meets"] == 1  # the bed below, from the altimeter


def test_a_limit_in_geometry_mode_is_refused_with_the_scenario() -> None:
    rule = r"survey.max_uncertainty_m = 0.1 m: needs a sonar with `mode: physics`"
    with pytest.raises(ScenarioError, match=rule):
        lake("geometry", max_uncertainty_m=0.1)
