"""NMEA 0183: the sentences, their sources, and where they go."""

import json
import math
import shutil
import socket
import subprocess
from datetime import UTC, datetime, timedelta

import pytest

from uwsim import Simulator
from uwsim.bridges.actions import actions_of
from uwsim.bridges.mavlink.plug import MavlinkOptions, MavlinkPlug
from uwsim.bridges.nmea.plug import NmeaOptions, NmeaPlug
from uwsim.bridges.nmea.readings import read
from uwsim.bridges.nmea.sentences import Fix, gga, sentence
from uwsim.bridges.nmea.wire import FORM, Wire
from uwsim.bridges.plug import Context
from uwsim.channels.delivery.feed import Feed
from uwsim.channels.served import served_table
from uwsim.live import LiveSimulator
from uwsim.mapping.files.georeference import Georeference
from uwsim.scenario import Scenario, load
from uwsim.scenario.georeference import georeference
from uwsim.scenario.read.validated import validated
from waiting import until

START = datetime(2026, 3, 1, 12, tzinfo=UTC)
SOUTH, WEST = -33.9999999999, -151.25


def clock(at_s: float) -> datetime:
    return START + timedelta(seconds=at_s)


def sea() -> Scenario:
    earth = {"latitude_deg": SOUTH, "longitude_deg": WEST}
    return validated(Scenario, {**load("lagoon").given(), "earth": earth})


def degrees(value: str, letter: str) -> float:
    whole = len(value.split(".")[0]) - 2
    return (-1 if letter in "SW" else 1) * (int(value[:whole]) + float(value[whole:]) / 60)


@pytest.fixture(scope="module")
def sim() -> Simulator:
    sim = Simulator(sea(), seed=5)
    sim.rov.undock()
    sim.rov.set_effort(surge=0.5, yaw=0.1)
    sim.advance(4.0)
    return sim


@pytest.fixture(scope="module")
def lines(sim: Simulator) -> list[str]:
    return read(sim.rov, georeference(sim.scenario), clock, sim.time_s)


def fields(lines: list[str]) -> dict[str, list[str]]:
    return {line[3:6]: line.split("*")[0].split(",")[1:] for line in lines}


def test_the_checksum_is_that_of_published_sentences() -> None:
    assert sentence("GP", "GLL", "5300.97914", "N", "00259.98174", "E", "125926", "A") == (
        "$GPGLL,5300.97914,N,00259.98174,E,125926,A*28\r\n"
    )
    assert sentence("GP", "VTG", "054.7", "T", "034.4", "M", "005.5", "N", "010.2", "K").endswith("*48\r\n")


def test_minutes_never_reach_sixty() -> None:
    _, _, latitude, ns, longitude, ew, quality, *_ = gga(START, Fix(SOUTH, 180.0 - 1e-12, 0.0)).split(",")
    assert (latitude, ns, longitude, ew, quality) == ("3400.000000", "S", "18000.000000", "E", "6")


def test_sentences_come_from_the_estimate_and_the_instruments(sim: Simulator, lines: list[str]) -> None:
    found, estimate = fields(lines), sim.rov.estimate
    place = georeference(sim.scenario)
    for at in (found["GGA"][1:5], found["RMC"][2:6]):
        assert [degrees(*at[:2]), degrees(*at[2:])] == pytest.approx(
            place.degrees(estimate.pose.position_world_m), abs=1e-8
        )
    assert (found["GGA"][0], found["RMC"][8], found["ZDA"][1:4]) == ("120004.00", "010326", ["01", "03", "2026"])
    assert float(found["HDT"][0]) == pytest.approx(90 - math.degrees(estimate.pose.yaw_rad), abs=0.006)
    east, north, _ = estimate.pose.world_from_body[:3, :3] @ estimate.velocity.linear_body_m_s
    assert float(found["VTG"][6]) / 3.6 == pytest.approx(math.hypot(east, north), abs=1e-3)
    assert math.radians(float(found["VTG"][0])) == pytest.approx(math.atan2(east, north) % math.tau, abs=1e-3)
    below_m = sim.rov.sensors["altitude"].read()
    assert [float(found["DPT"][0]), float(found["DPT"][1])] == pytest.approx(
        [below_m, sim.rov.sensors["depth"].read()], abs=0.006
    )
    assert [float(found["DBT"][k]) * unit for k, unit in ((0, 0.3048), (2, 1), (4, 1.8288))] == pytest.approx(
        [below_m] * 3, abs=0.01
    )
    fix = sim.rov.sensors["usbl"].read().position_m
    assert 1000 * float(found["TTM"][1]) == pytest.approx(math.hypot(*fix[:2]), abs=0.06)
    assert math.radians(float(found["TTM"][2])) == pytest.approx(math.atan2(fix[0], fix[1]) % math.tau, abs=1e-3)


def test_without_a_place_there_is_no_fix_but_all_else(sim: Simulator, lines: list[str]) -> None:
    nowhere = fields(read(sim.rov, Georeference(), clock, sim.time_s))
    assert nowhere["GGA"][1:7] == ["", "", "", "", "0", "00"]
    assert (nowhere["RMC"][1], nowhere["RMC"][11]) == ("V", "N")
    assert [nowhere[key] for key in ("DPT", "DBT", "HDT")] == [fields(lines)[key] for key in ("DPT", "DBT", "HDT")]


@pytest.mark.skipif(shutil.which("gpsdecode") is None, reason="needs gpsdecode (Debian: gpsd-clients)")
def test_gpsd_reads_them_without_an_error(sim: Simulator, lines: list[str]) -> None:
    done = subprocess.run(["gpsdecode", "-j"], input="".join(lines), capture_output=True, text=True, timeout=60)
    reports = [json.loads(line) for line in done.stdout.splitlines()]
    tpv = [each for each in reports if each["class"] == "TPV"][-1]
    assert [tpv["lat"], tpv["lon"]] == pytest.approx(
        georeference(sim.scenario).degrees(sim.rov.estimate.pose.position_world_m), abs=2e-8
    )
    assert tpv["depth"] == pytest.approx(sim.rov.sensors["altitude"].read(), abs=0.01)
    assert tpv["time"] == "2026-03-01T12:00:04.000Z"
    assert not done.stderr


def test_mavlink_and_nmea_are_at_the_same_place() -> None:
    pytest.importorskip("pymavlink", reason="needs the extra mavlink")
    from mavlink_station import Station

    with LiveSimulator(Simulator(sea(), seed=5), speed=20.0) as live:
        table = served_table(live, wire=None, origin="world", tf="truth", frame_prefix="")
        context = Context(table.channels, Feed(live), live, table.services, actions_of(live.simulator, table))
        nmea = NmeaPlug(NmeaOptions(nmea="tcp:127.0.0.1:0", nmea_rate=5.0))
        with nmea.open(context) as sender, MavlinkPlug(MavlinkOptions(mavlink="tcp:0")).open(context) as mavlink:
            with socket.create_connection((sender.bridge.target.host, sender.bridge.target.port), 60) as client:
                rmc = next(line for line in client.makefile() if line[3:6] == "RMC").split(",")
            endpoint = mavlink.bridge.endpoint
            station = Station(f"tcp:{endpoint.host}:{endpoint.port}")
            at = station.receive("GLOBAL_POSITION_INT")
            station.close()
    assert [at.lat / 1e7, at.lon / 1e7] == pytest.approx([SOUTH, WEST], abs=1e-3)  # 100 m
    assert [degrees(*rmc[3:5]), degrees(*rmc[5:7])] == pytest.approx([at.lat / 1e7, at.lon / 1e7], abs=1e-4)


def sent(wire: Wire) -> int:
    wire.send(["x" * 100_000])
    return wire.count


def test_a_client_that_does_not_read_is_disconnected_and_the_others_are_served() -> None:
    wire = Wire(FORM.parse("tcp:0"))
    try:
        address = wire.target.host, wire.target.port
        with socket.create_connection(address, 60) as silent:
            until(lambda: sent(wire) == 1)
            until(lambda: sent(wire) == 0)
            assert silent.recv(1)
        with socket.create_connection(address, 60) as reader:
            wire.send(["$SDDPT*00\r\n"])
            assert reader.recv(100) == b"$SDDPT*00\r\n"
    finally:
        wire.close()
