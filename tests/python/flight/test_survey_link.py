"""A survey over a link: the on-board map is the same as without one; the station's has the pings that arrived."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from uwsim import Simulator
from uwsim.flight.record import FlightRecord
from uwsim.flight.survey import fly_survey, run_survey
from uwsim.flight.terminal import Silent
from uwsim.mapping import OccupancyMap


@pytest.fixture(scope="module")
def linked(small_pool: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[FlightRecord, Path]:
    """Return the record of the small pool's survey over a modem, and its folder."""
    out = tmp_path_factory.mktemp("linked")
    options = {"link": "s2cm_hs", "report": "json", "autosave_s": 0.0, "screen": Silent()}
    return run_survey(small_pool, out, threads=1, **options), out


def test_the_report_tells_both_maps_and_what_became_of_the_messages(linked, surveyed) -> None:
    record, out = linked
    said = json.loads((out / "summary.json").read_text())
    rows = {(row["topic"], row["sender"]): row for row in said["link"]}
    told = rows["placed_ping", "rov"]
    assert told["sent"] == told["delivered"] + told["lost"] > 5
    assert told["bytes_delivered"] == 166 * told["delivered"] and told["delay_s"] > 0.0
    assert said["ashore"]["pings"] == told["delivered"] < said["pings"]
    assert 0.0 < said["ashore"]["coverage"] <= said["map"]["coverage"]
    assert ("ranging/usbl", "rov") in rows
    ashore = OccupancyMap.read(out / "map_ashore.bt")
    assert ashore.statistics().occupied_voxels == said["ashore"]["occupied_voxels"]
    assert (out / "map.bt").read_bytes() == (surveyed[1] / "map.bt").read_bytes(), "the link disturbs nothing"
    assert record.ashore.ping_count == said["ashore"]["pings"]


def test_over_a_cable_whole_pings_come_ashore() -> None:
    _, record = fly_survey(Simulator("pool", link="tether", mission_time_s=10.0), OccupancyMap(0.5))
    (told,) = [row for row in record.ashore.table() if row.topic == "placed_ping"]
    assert told.delivered > 0.9 * record.ping_count
    assert told.bytes_delivered > 1000 * told.delivered
