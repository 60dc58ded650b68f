"""`--moos`: the wire against a recorded exchange and a real MOOSDB, and a vehicle that its community steers."""

import json
import math
import os
import shutil
import socket
import struct
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from listening_sockets import free_port
from moos_standin import StandInMoosDB
from steered import bay, steered_by, torpedo
from uwsim import Simulator
from uwsim.bridges.doors.endpoint import Endpoint
from uwsim.bridges.moos.client import MoosClient
from uwsim.bridges.moos.plug import MoosOptions, MoosPlug
from uwsim.bridges.moos.variables import is_true, navigation, number, ping_summary
from uwsim.bridges.moos.wire import NOTIFY, PROTOCOL, WELCOME, Message, MoosError, PacketReader, decoded, encoded
from uwsim.live import LiveSimulator
from uwsim.mapping.files.georeference import Georeference
from uwsim.scenario import Scenario
from uwsim.scenario.georeference import georeference
from waiting import until

RECORDED = json.loads((Path(__file__).parents[1] / "data/moos/exchange.json").read_text())
"""Bytes between two clients and MOOSDB (MOOS core of July 2024), time warp 8."""
MOOSDB = shutil.which("MOOSDB", path=os.environ.get("UWSIM_MOOS_BIN", os.environ.get("PATH")))


def member(
    scenario: Scenario | str, *addresses: str, speed: float = 1.0, **options: Any
) -> AbstractContextManager[LiveSimulator]:
    return steered_by(MoosPlug(MoosOptions(moos=addresses, **options)), scenario, speed)


@pytest.fixture
def db() -> Iterator[StandInMoosDB]:
    with StandInMoosDB() as db:
        yield db


# The wire


def packets() -> Iterator[tuple[str, bytes]]:
    """Yield the recorded packets, with the sender of each."""
    for each in RECORDED:
        data = bytes.fromhex(each["bytes"]).removeprefix(PROTOCOL)
        while data:
            (length,) = struct.unpack_from("<i", data)
            yield each["from"], data[:length]
            data = data[length:]


def test_every_packet_of_a_real_moosdb_is_read_and_written_alike() -> None:
    kinds: set[str] = set()
    for sender, packet in packets():
        messages = decoded(packet)
        kinds |= {f"{sender} {message.kind}" for message in messages}
        if messages[0].kind != WELCOME:  # which also has a text beside its number
            assert encoded(messages) == packet
        else:
            assert messages[0].community == "alpha"
    assert kinds == {"client i", "client R", "client T", "client N", "MOOSDB W", "MOOSDB T", "MOOSDB N"}


def test_packets_are_found_however_the_bytes_are_divided() -> None:
    sent = [Message(NOTIFY, "NAV_X", 3.5, 12.0, "uwsim", "alpha"), Message(NOTIFY, "REPORT", "Ü=1".encode(), 12.5)]
    data = b"".join(encoded([each]) for each in sent)
    for size in (1, 3, 7, len(data)):
        reader = PacketReader()
        found = [m for k in range(0, len(data), size) for m in reader.read(data[k : k + size])]
        assert [(m.name, m.value, m.time_s) for m in found] == [(m.name, m.value, m.time_s) for m in sent]


def test_damaged_packets_are_refused_and_never_raise_anything_else() -> None:
    whole = encoded([Message(NOTIFY, "NAV_X", 3.5, 12.0, "uwsim", "alpha")] * 3)
    rng = np.random.default_rng(1)
    refused = 0
    for _ in range(3000):
        damaged = bytearray(whole)
        for at in rng.integers(0, len(damaged), 3):
            damaged[at] = rng.integers(0, 256)
        try:
            decoded(bytes(damaged[: rng.integers(1, len(damaged) + 1)]))
        except MoosError:
            refused += 1
    assert refused > 2000
    with pytest.raises(MoosError, match="a packet of -5 bytes"):
        list(PacketReader().read(struct.pack("<i", -5)))
    with pytest.raises(MoosError, match="a packet of 2147483647 bytes"):
        list(PacketReader().read(struct.pack("<i", 2**31 - 1)))


# The variables


def test_the_depth_is_that_below_the_tide() -> None:
    vehicle = {"name": "alpha", "model": "bluerov2_heavy", "start": {"position_m": [30, -20, -8]}}
    sim = Simulator(bay(vehicle, water={"tide": {"constituents": [{"constituent": "M2", "amplitude_m": 1.5}]}}))
    assert abs(sim.rov.estimate.pose.position_world_m[2] + sim.rov.telemetry().depth_m) > 0.5
    sim.advance(1.0)
    found = [dict(navigation(sim.rov, Georeference(), from_truth=truth))["NAV_DEPTH"] for truth in (True, False)]
    assert found == pytest.approx([sim.rov.telemetry().depth_m] * 2, abs=0.1)


def test_navigation_has_uSimMarines_signs() -> None:  # noqa: N802
    start = {"position_m": [30, -20, -8], "yaw_deg": 0}
    sim = Simulator(bay({"name": "alpha", "model": "bluerov2_heavy", "start": start}))
    place = georeference(sim.scenario)
    east = dict(navigation(sim.rov, Georeference(), from_truth=True))
    assert (east["NAV_X"], east["NAV_Y"], east["NAV_DEPTH"]) == pytest.approx((30, -20, 8), abs=0.1)
    assert east["NAV_HEADING"] == pytest.approx(90, abs=0.5)  # the world's x axis is east
    assert east["NAV_YAW"] == pytest.approx(-math.pi / 2, abs=0.01)
    half = math.radians(10) / 2
    sim.rov.place([0, 0, -8], [0, math.sin(half), 0, math.cos(half)], [1.0, 0, 0, 0, 0, 0])  # nose down
    down = dict(navigation(sim.rov, place, from_truth=True))
    assert down["NAV_PITCH"] == pytest.approx(-math.radians(10), abs=1e-6)
    assert down["NAV_SPEED"] == pytest.approx(math.cos(math.radians(10)))
    assert (down["NAV_LAT"], down["NAV_LONG"]) == pytest.approx((43.8253, -70.3304), abs=1e-6)
    half = math.radians(-100) / 2  # from east to 10 degrees west of south
    sim.rov.place([0, 0, -8], [0, 0, math.sin(half), math.cos(half)], [1.0, 0, 0, 0, 0, 0])
    south = dict(navigation(sim.rov, Georeference(), from_truth=True))
    assert south["NAV_HEADING"] == pytest.approx(190) == south["NAV_HEADING_OVER_GROUND"]


def test_numbers_and_flags_are_read_as_moos_applications_write_them() -> None:
    assert (number(3.5), number(b"3.5"), number(b"nan"), number(b"x"), number(math.inf)) == (3.5, 3.5, None, None, None)
    assert [is_true(each) for each in (b"true", b" TRUE", 1.0, b"false", b"1", 0.0)] == [True, True, True, *[False] * 3]


def test_a_pings_summary() -> None:
    bearings = np.linspace(-1, 1, 5)
    assert ping_summary(np.array([4, np.inf, 2, 3, np.inf]), bearings, 1.5) == (
        "stamp=1.500,beams=5,echoes=3,min=2.000,mean=3.000,nadir=2.000"
    )
    assert ping_summary(np.full(5, np.inf), bearings, 0) == "stamp=0.000,beams=5,echoes=0"


# In a community


def test_a_community_gets_the_vehicle_and_steers_it(db: StandInMoosDB) -> None:
    with member(bay(torpedo()), f"127.0.0.1:{db.port}", speed=5.0) as live:
        until(lambda: db.last("NAV_X") is not None and db.last("UWSIM_SONAR") is not None)
        assert live.speed == 1.0  # the community's warp
        live.speed = 5.0
        assert db.names == ["uwsim"]
        assert db.last("NAV_HEADING") == pytest.approx(0, abs=3) or db.last("NAV_HEADING") == pytest.approx(360, abs=3)
        assert {"NAV_LAT", "NAV_LONG", "NAV_SPEED", "NAV_DEPTH", "NAV_PITCH", "UWSIM_DEPTH"} <= db.seen.keys()

        def sail(rudder: float, elevator: float) -> None:
            db.publish(DESIRED_THRUST=80.0, DESIRED_RUDDER=rudder, DESIRED_ELEVATOR=elevator)

        def turned() -> bool:
            sail(40.0, 0.0)
            return 40 < float(db.last("NAV_HEADING") or 0) < 180

        until(turned)  # to starboard
        depth_m = float(db.last("NAV_DEPTH") or 0)

        def dived() -> bool:
            sail(0.0, 5.0)
            return float(db.last("NAV_DEPTH") or 0) > depth_m + 1

        until(dived)
        assert float(db.last("NAV_SPEED") or 0) > 0.5
        until(lambda: live.rov.effort[0] == 0)  # once it is silent


def test_setpoints_are_held_by_our_own_loops(db: StandInMoosDB) -> None:
    with member(bay(torpedo()), f"127.0.0.1:{db.port}", moos_control="setpoints", moos_nav="truth") as live:
        until(lambda: db.last("NAV_X") is not None)
        live.speed = 10.0

        def arrived() -> bool:
            db.publish(DESIRED_SPEED=1.5, DESIRED_HEADING=120.0, DESIRED_DEPTH=12.0)
            off_deg = float(db.last("NAV_HEADING") or 0) - 120
            off_m = float(db.last("NAV_DEPTH") or 0) - 12
            return abs(off_deg) < 4 and abs(off_m) < 0.5 and abs(float(db.last("NAV_SPEED") or 0) - 1.5) < 0.2

        until(arrived)
        db.publish(MOOS_MANUAL_OVERRIDE=b"true")
        db.publish(DESIRED_SPEED=1.5, DESIRED_HEADING=120.0, DESIRED_DEPTH=12.0)
        until(lambda: not any(live.rov.effort))


def test_the_warp_of_the_community_is_the_speed_of_the_simulator() -> None:
    with StandInMoosDB(warp=20.0) as db, member("pool", f"127.0.0.1:{db.port}") as live:
        until(lambda: live.speed == 20.0)
        until(lambda: len(db.seen.get("UWSIM_TIME", ())) > 60)
        first, last = db.seen["UWSIM_TIME"][10], db.seen["UWSIM_TIME"][-1]
        simulated_s, community_s = float(last.value) - float(first.value), last.time_s - first.time_s
        # Never ahead of the community's clock; behind it, on a busy machine, but far from the 1/20 of no warp.
        assert 0.2 * community_s < simulated_s < community_s + 3
        db.publish(USM_SIM_PAUSED=b"true")
        until(lambda: live.paused)
        db.publish(USM_SIM_PAUSED=b"false")
        until(lambda: not live.paused)


def test_each_vehicle_has_a_community_of_its_own_which_may_come_late(db: StandInMoosDB) -> None:
    port = free_port()
    scenario = bay(torpedo("alpha"), torpedo("bravo", position_m=[0, 20, -8]))
    with member(scenario, f"alpha=127.0.0.1:{db.port}", f"bravo=127.0.0.1:{port}"):
        until(lambda: db.last("NAV_Y") is not None)
        with StandInMoosDB("bravo", port=port) as other:
            until(lambda: other.last("NAV_Y") is not None)
            assert other.last("NAV_Y") == pytest.approx(20, abs=1)
    assert db.last("NAV_Y") == pytest.approx(0, abs=1)


def apart(distance_m: float, modem: str) -> Scenario:
    """Return two torpedoes and a station near the first one, with modems."""
    terrain = {"source": "noise", "size_m": [4000, 400], "spacing_m": 20, "bed_depth_m": 60}
    other = torpedo("bravo", position_m=[-100 + distance_m, 0, -8])
    return bay(torpedo(position_m=[-100, 0, -8]), other, terrain=terrain, link=modem)


def test_node_reports_travel_by_sound_and_the_helm_is_aboard(db: StandInMoosDB) -> None:
    with StandInMoosDB("bravo") as other, StandInMoosDB("shoreside") as shore:
        there = (f"alpha=127.0.0.1:{db.port}", f"bravo=127.0.0.1:{other.port}")
        shoreside = f"127.0.0.1:{shore.port}"
        with member(apart(300, "ideal_acoustic"), *there, moos_reports=True, moos_shore=shoreside) as live:
            until(lambda: db.last("NAV_X") is not None and other.last("NAV_X") is not None and shore.names == ["uwsim"])
            reports = [f"NAME=alpha,X={number}".encode() for number in range(3)]
            for report in reports:
                db.publish(NODE_REPORT_LOCAL=report, DESIRED_THRUST=50.0)
                until(lambda: other.last("NODE_REPORT") == db.last("NODE_REPORT_LOCAL") == shore.last("NODE_REPORT"))
            assert [each.value for each in other.seen["NODE_REPORT"]] == reports
            assert db.last("NODE_REPORT") is None

            def is_steered() -> bool:
                db.publish(DESIRED_THRUST=50.0)
                return bool(live.rov.effort[0] == 0.5)

            until(is_steered)
            until(lambda: db.last("UWSIM_SONAR") is not None)  # its own, without the link
            network = live.simulator.link
            assert network is not None
            for got in [each for each in network.received("bravo") if each.topic == "node_report"]:
                assert got.arrived_s - got.given_s == pytest.approx(300 / 1500, rel=0.02)
            other.publish(NODE_REPORT_LOCAL=b"NAME=bravo")
            until(lambda: db.last("NODE_REPORT") == b"NAME=bravo" == shore.last("NODE_REPORT"))


def test_node_reports_beyond_the_modems_range_are_lost(db: StandInMoosDB) -> None:
    with StandInMoosDB("bravo") as other, StandInMoosDB("shoreside") as shore:
        there = (f"alpha=127.0.0.1:{db.port}", f"bravo=127.0.0.1:{other.port}")
        shoreside = f"127.0.0.1:{shore.port}"
        with member(apart(1500, "s2cm_hs"), *there, moos_reports=True, moos_shore=shoreside) as live:
            until(lambda: db.last("NAV_X") is not None and shore.names == ["uwsim"] == other.names)
            live.speed = 10.0
            db.publish(NODE_REPORT_LOCAL=b"NAME=alpha")
            until(lambda: shore.last("NODE_REPORT") == b"NAME=alpha")  # which is near
            network = live.simulator.link
            assert network is not None

            def report() -> tuple[int, int]:
                (found,) = [each for each in network.counts() if each.topic == "node_report"]
                return found.sent, found.delivered

            until(lambda: report() == (2, 1))
            assert other.last("NODE_REPORT") is None


def test_reports_need_a_link_and_a_shoreside_needs_reports(db: StandInMoosDB) -> None:
    at = f"127.0.0.1:{db.port}"
    with pytest.raises(ValueError, match="moos_reports: needs a link"), member("pool", at, moos_reports=True):
        pass
    with pytest.raises(ValueError, match="moos_shore = 'h:1': needs --moos-reports"):
        MoosPlug(MoosOptions(moos=(at,), moos_shore="h:1"))
    with pytest.raises(ValueError, match="must be HOST:PORT"):
        MoosPlug(MoosOptions(moos=(at,), moos_reports=True, moos_shore="a=h:1"))


def test_all_stop_and_a_pilot_outrank_the_community(db: StandInMoosDB) -> None:
    with member(bay(torpedo()), f"127.0.0.1:{db.port}") as live:
        until(lambda: db.last("NAV_X") is not None)
        live.command("all_stop", vehicle="alpha", on=True).result()
        for _ in range(5):
            db.publish(DESIRED_THRUST=80.0)
            time.sleep(0.05)
        assert live.rov.effort[0] == 0


def test_a_name_that_is_taken_is_reported_and_tried_again(db: StandInMoosDB, caplog: pytest.LogCaptureFixture) -> None:
    address = Endpoint("127.0.0.1", db.port)
    met = threading.Event()
    with MoosClient(address, "uwsim", (), print, lambda *_: met.set()):
        assert met.wait(180)
        with MoosClient(address, "uwsim", (), print, print) as second:
            until(lambda: "already exists" in caplog.text)
            assert not second.is_met


def test_a_peer_that_is_no_moosdb_is_reported(caplog: pytest.LogCaptureFixture) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:

        def answer() -> None:
            client, _ = server.accept()
            client.recv(100)
            client.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n")
            time.sleep(0.2)
            client.close()

        threading.Thread(target=answer, daemon=True).start()
        with MoosClient(Endpoint("127.0.0.1", server.getsockname()[1]), "uwsim", (), print, print):
            until(lambda: "a packet of" in caplog.text)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"moos": ("a=h:1", "a=h:2")}, "must name each vehicle once"),
        ({"moos": ("h:1",), "moos_name": "a b"}, "letters, digits and _"),
        ({"moos": ("h:x",)}, "must be"),
    ],
)
def test_wrong_options_are_refused_before_anything_is_built(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        MoosPlug(MoosOptions(**options))


def test_the_doctor_finds_the_community(db: StandInMoosDB) -> None:
    (found,) = MoosPlug.examine(MoosOptions(moos=(f"127.0.0.1:{db.port}",)), 5.0)
    assert (found.verdict, found.found) == ("ok", "community 'alpha', time warp 1")
    (missing,) = MoosPlug.examine(MoosOptions(moos=("127.0.0.1:1",)), 1.0)
    assert missing.verdict == "wrong"


@pytest.mark.skipif(MOOSDB is None, reason="needs MOOSDB (MOOS core) on PATH, or in the folder UWSIM_MOOS_BIN")
def test_a_real_moosdb(tmp_path: Path) -> None:
    port = free_port()
    mission = tmp_path / "alpha.moos"
    mission.write_text(f"ServerHost = localhost\nServerPort = {port}\nCommunity = alpha\nMOOSTimeWarp = 10\n")
    process = subprocess.Popen([str(MOOSDB), str(mission)], cwd=tmp_path, stdout=subprocess.DEVNULL)
    got: list[Message] = []
    try:
        with (
            member(bay(torpedo()), f"localhost:{port}") as live,
            MoosClient(Endpoint("localhost", port), "watch", ["NAV_X", "NAV_DEPTH"], got.extend, print) as watch,
        ):
            until(lambda: live.speed == 10.0 and len(got) > 20)
            assert {each.source for each in got} == {"uwsim"}

            def moves() -> bool:
                watch.publish([("DESIRED_THRUST", 50.0), ("DESIRED_RUDDER", "0")])
                return bool(live.rov.effort[0] == 0.5)

            until(moves)
    finally:
        process.terminate()
        process.wait(30)


@pytest.mark.skipif(
    MOOSDB is None or "UWSIM_MOOS_MISSIONS" not in os.environ,
    reason="needs MOOS-IvP: its programs in the folder UWSIM_MOOS_BIN, its missions in UWSIM_MOOS_MISSIONS",
)
def test_missions_of_moos_ivp_are_flown() -> None:
    trial = Path(__file__).parents[3] / "tools/trial"
    folders = ["--bin", os.environ["UWSIM_MOOS_BIN"], "--missions", os.environ["UWSIM_MOOS_MISSIONS"]]
    done = subprocess.run([trial, "moos", *folders, "s1_alpha"], capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stdout + done.stderr
