"""A survey over a link: the on-board map is the same as without one; the station's has the pings that arrived."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from uwsim import Simulator
from uwsim.flight.autosave import FlightAutosave
from uwsim.flight.fly import fly, resume
from uwsim.flight.pinging import SURVEYED
from uwsim.flight.request import FlightRequest
from uwsim.flight.survey import fly_survey, run_survey
from uwsim.mapping import OccupancyMap


def pool(link: str | None = "s2cm_hs") -> Simulator:
    return Simulator("pool", link=link, threads=1)


class StopAt(FlightAutosave):
    """Save a flight at a pause, then stop it."""

    def __init__(self, pause: int) -> None:
        super().__init__(1e6)
        self.pause, self.count = pause, 0

    def due(self) -> bool:
        return False

    def stop_requested(self) -> bool:
        self.count += 1
        return self.count == self.pause


def test_the_report_tells_both_maps_and_what_became_of_the_messages(tmp_path: Path) -> None:
    record = run_survey("pool", tmp_path, link="s2cm_hs", voxel_m=0.5, report="json", autosave_s=0.0, threads=1)
    said = json.loads((tmp_path / "summary.json").read_text())
    rows = {(row["topic"], row["sender"]): row for row in said["link"]}
    told = rows["placed_ping", "rov"]
    assert told["sent"] == told["delivered"] + told["lost"] > 5
    assert told["bytes_delivered"] == 166 * told["delivered"]
    assert said["ashore"]["pings"] == told["delivered"] < said["pings"]
    assert 0.0 < said["ashore"]["coverage"] <= said["map"]["coverage"]
    assert ("ranging/usbl", "rov") in rows
    ashore = OccupancyMap.read(tmp_path / "map_ashore.bt")
    assert ashore.statistics().occupied_voxels == said["ashore"]["occupied_voxels"]
    aboard, _ = fly_survey(pool(link=None), OccupancyMap(0.5))
    assert OccupancyMap.read(tmp_path / "map.bt").to_bytes("bt") == aboard.to_bytes("bt"), "the link disturbs nothing"
    assert record.ashore.ping_count == said["ashore"]["pings"]


@pytest.mark.parametrize("pause", [1, 211])
def test_resumed_the_station_has_the_same_pings(pause: int, tmp_path: Path) -> None:
    _, whole = fly_survey(pool(), OccupancyMap(0.5))
    options = {"map": True, "map_growth": False, "voxel_m": 0.5, "carried": SURVEYED, "report": "none"}
    stopped = fly(None, "pool", tmp_path, link="s2cm_hs", threads=1, autosave=StopAt(pause), **options)
    assert stopped.interrupted
    resumed = resume(tmp_path, threads=1, report="none")
    assert resumed.ashore.save() == whole.ashore.save()
    assert resumed.ashore.table() == whole.ashore.table()


def test_a_survey_is_resumed_over_the_same_modem() -> None:
    request = FlightRequest(scenario="pool", link="s2cm_hs")
    request.require_same({"link": "s2cm_hs"})
    with pytest.raises(ValueError, match="link = tether: the flight was started with s2cm_hs"):
        request.require_same({"link": "tether"})


def test_over_a_cable_whole_pings_come_ashore() -> None:
    _, record = fly_survey(pool(link="tether"), OccupancyMap(0.5))
    (told,) = [row for row in record.ashore.table() if row.topic == "placed_ping"]
    assert told.delivered > 0.9 * record.ping_count
    assert told.bytes_delivered > 1000 * told.delivered
