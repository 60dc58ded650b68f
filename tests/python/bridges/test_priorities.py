"""Stops, sticks and telemetry come before what can wait, however much of that there is."""

import itertools
import json
import struct
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from functools import partial
from typing import Any

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.channels import Table
from uwsim.channels.served import served_table
from uwsim.link import Carrier
from uwsim.live import LiveSimulator
from uwsim.live.requests import Request

pytest.importorskip("pymavlink", reason="needs the extra mavlink")
from pymavlink.dialects.v20 import ardupilotmega as dialect

from client_socket import connect, send
from foxglove_client import FoxgloveClient
from mavlink_station import DONE, FAILED, GUIDED, MANUAL, PATIENCE_S, Station, lagoon, station_at
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.bridge import Bridge
from uwsim.bridges.foxglove import FoxgloveServer
from uwsim.bridges.foxglove.session import CALLS_MAX
from uwsim.bridges.mavlink import MavlinkVehicle
from uwsim.bridges.mavlink.backlog import WAITING_MAX, Backlog
from waiting import until

STOP, ARM = dialect.MAV_CMD_DO_FLIGHTTERMINATION, dialect.MAV_CMD_COMPONENT_ARM_DISARM
SLOW_S = 0.05  # a parameter that takes this long to set, as on large terrain
FLOOD = 100
STOP_S = 4.0  # 0.1 s when the machine is idle; the flood takes 5 s, and so would a stop that waits for it
BEAT_S = 4.0


@pytest.fixture(scope="module")
def live() -> Iterator[LiveSimulator]:
    with lagoon() as live:
        live.speed = 1.0
        yield live


@pytest.fixture
def station(vehicle: MavlinkVehicle, live: LiveSimulator) -> Iterator[Station]:
    station = station_at(vehicle)
    station.drain()
    yield station
    station.close()


@pytest.fixture(autouse=True)
def released(live: LiveSimulator) -> Iterator[None]:
    yield
    live.command("all_stop", vehicle="rov", on=False).result()


@pytest.fixture
def slow(live: LiveSimulator, monkeypatch: pytest.MonkeyPatch) -> None:
    """Make parameters slow to set."""
    answer = live._loop.answer

    def slowly(request: Request) -> None:
        if request.name == "set_parameter":
            time.sleep(SLOW_S)
        answer(request)

    monkeypatch.setattr(live._loop, "answer", slowly)


def stopped_after_s(live: LiveSimulator, stop: Callable[[], object]) -> float:
    assert not live.rov.all_stopped
    begun_s = time.monotonic()
    stop()
    until(lambda: live.rov.all_stopped, limit_s=10.0)
    return time.monotonic() - begun_s


def test_a_stop_comes_before_all_commands_that_wait(live: LiveSimulator, slow: None) -> None:
    orders = [live.command("set_parameter", name="rov.mass_kg", value=13.5) for _ in range(FLOOD)]
    delay_s = stopped_after_s(live, lambda: live.command("all_stop", vehicle="rov", on=True))
    assert delay_s < STOP_S and not orders[-1].done()
    tick, done = live.tick, sum(order.done() for order in orders)
    orders[done + 20].result()
    assert live.tick - tick > 10, "no steps while commands wait"
    for order in orders:
        order.cancel()


def test_a_stop_is_not_undone_by_what_it_overtakes(live: LiveSimulator, slow: None) -> None:
    live.command("all_stop", vehicle="rov", on=True).result()
    waiting = [live.command("set_parameter", name="rov.mass_kg", value=13.5) for _ in range(5)]
    release = live.command("all_stop", vehicle="rov", on=False)
    live.command("all_stop", vehicle="rov", on=True).result()
    with pytest.raises(RuntimeError, match="before it could be released"):
        release.result()
    assert live.rov.all_stopped
    [each.result() for each in waiting]
    live.command("all_stop", vehicle="rov", on=False).result()
    returning = threading.Thread(target=live.reset)  # to a state in which nothing is stopped
    with holding(live):
        returning.start()
        until(lambda: any(request.name == "reset" for request in list(live._loop._requests)))
        stop = live.command("all_stop", vehicle="rov", on=True)
    stop.result()
    returning.join()
    live.read(lambda sim: None).result()
    assert live.rov.all_stopped


def flood(station: Station, kind: str) -> Callable[[], None]:
    numbers = itertools.count()
    target = 0b110111111000, 1.0, 1.0, 3.0, *[0.0] * 8
    sends: dict[str, Callable[[], None]] = {
        "PARAM_SET": lambda: station.mav.param_set_send(1, 1, b"MASS_KG", 13.0 + next(numbers) % 2, 9),
        "PARAM_REQUEST_LIST": lambda: station.mav.param_request_list_send(1, 1),
        "modes": lambda: station.mav.set_mode_send(1, 1, MANUAL),
        "sticks": lambda: station.mav.manual_control_send(1, 0, 0, 500, 0, 0),
        "targets": lambda: station.mav.set_position_target_local_ned_send(0, 1, 1, 1, *target),
        "missions": lambda: station.mav.mission_count_send(1, 1, 5),
    }
    return sends[kind]


@pytest.mark.parametrize("kind", ["PARAM_SET", "PARAM_REQUEST_LIST", "modes", "sticks", "targets", "missions"])
def test_a_flood_delays_neither_stops_nor_sticks_nor_heartbeats(
    live: LiveSimulator, other: Station, station: Station, slow: None, kind: str
) -> None:
    assert station.arm() == DONE and station.mode(GUIDED if kind == "targets" else MANUAL) == DONE
    send = flood(other, kind)
    for _ in range(FLOOD):
        send()
    station.heard.clear()
    station.receive("HEARTBEAT", lambda beat: beat.get_srcComponent() == 1, limit_s=BEAT_S)
    station.receive("ATTITUDE", limit_s=BEAT_S)
    if kind not in ("sticks", "targets"):
        station.mav.manual_control_send(1, 1000, 0, 500, 0, 0)
        until(lambda: np.any(live.rov.effort), limit_s=STOP_S)
    delay_s = stopped_after_s(live, lambda: station.mav.command_long_send(1, 1, STOP, 0, 1.0, *[0.0] * 6))
    assert delay_s < STOP_S


def test_what_a_stop_overtakes_does_not_arm_or_release(
    live: LiveSimulator, vehicle: MavlinkVehicle, station: Station, slow: None
) -> None:
    send = flood(station, "PARAM_SET")
    for _ in range(20):
        send()
    time.sleep(0.1)
    for command, value in ((dialect.MAV_CMD_COMPONENT_ARM_DISARM, 1.0), (STOP, 0.0), (STOP, 1.0)):
        station.mav.command_long_send(1, 1, command, 0, value, *[0.0] * 6)
    results = [station.receive("COMMAND_ACK") for _ in range(3)]
    assert sorted((ack.command, ack.result) for ack in results) == [(STOP, DONE), (STOP, FAILED), (400, FAILED)]
    assert live.rov.all_stopped and not vehicle._flight.is_armed


def test_each_peer_has_its_turn_and_its_bound() -> None:
    dropped: list[int] = []
    backlog = Backlog(lambda stop: None, lambda peer, message: dropped.append(message.seq))
    request = dialect.MAVLink_mission_request_int_message
    noisy, quiet = ("127.0.0.1", 1), ("127.0.0.1", 2)
    backlog.sort((noisy, request(1, 1, seq)) for seq in range(WAITING_MAX + 2))
    backlog.sort([(quiet, request(1, 1, 0))])
    assert dropped == [WAITING_MAX, WAITING_MAX + 1]
    assert [turn[0] for turn in (backlog.take() for _ in range(3)) if turn] == [noisy, quiet, noisy]


def test_of_many_stops_all_stop_comes_first_and_each_is_handled_once() -> None:
    stops: list[int] = []
    backlog = Backlog(lambda message: stops.append(message.command), lambda peer, message: None)
    noisy, quiet = ("127.0.0.1", 1), ("127.0.0.1", 2)

    def stop(command: int, value: float) -> Any:
        return dialect.MAVLink_command_long_message(1, 1, command, 0, value, *[0.0] * 6)

    backlog.sort((noisy, stop(ARM, 0.0)) for _ in range(WAITING_MAX))
    backlog.sort([(quiet, stop(STOP, 1.0))])
    assert stops == [STOP], "all stop is set at once, before its turn"
    taken = [each[0] for each in iter(lambda: backlog.take(only_urgent=True), None)]
    assert taken == [quiet, noisy]


def test_no_number_of_disarms_hides_all_stop(live: LiveSimulator, other: Station, station: Station) -> None:
    for _ in range(FLOOD):
        other.mav.command_long_send(1, 1, ARM, 0, 0.0, *[0.0] * 6)
    assert station.command(STOP, 1.0) == DONE
    assert live.rov.all_stopped


@contextmanager
def holding(live: LiveSimulator) -> Iterator[None]:
    """Let commands wait meanwhile."""
    begun, going_on = threading.Event(), threading.Event()
    live.read(lambda sim: (begun.set(), going_on.wait(PATIENCE_S)))
    begun.wait()
    try:
        yield
    finally:
        going_on.set()


def is_next(live: LiveSimulator) -> bool:
    """Return whether the next command is a stop."""
    waiting = list(live._loop._requests)
    return bool(waiting) and waiting[0].stops == "rov"


def test_a_stop_by_a_service_waits_for_no_releases(live: LiveSimulator) -> None:
    table, answers = served_table(live), list[bool]()
    live.command("all_stop", vehicle="rov", on=True).result()
    with Bridge("priorities", live, table.channels, table.services) as bridge:
        with holding(live):
            for on in (*[False] * 10, True):
                bridge.call(bridge.services["all_stop"], {"data": on}, lambda done, values: answers.append(done))
            assert is_next(live)
            assert not any(request.releases for request in live._loop._requests)
        until(lambda: len(answers) == 11)
    assert sorted(answers) == [False] * 10 + [True] and live.rov.all_stopped


def test_a_foxglove_clients_own_calls_do_not_have_its_stop_refused(live: LiveSimulator) -> None:
    table = served_table(live)
    setting = json.dumps({"op": "setParameters", "parameters": [{"name": "rov.mass_kg", "value": 13.5}]})
    with (
        FoxgloveServer(live, table.channels, table.services) as server,
        FoxgloveClient(server.url, "/odom") as client,
    ):
        client.until(lambda: "/all_stop" in client.services)
        stop = b"\x02" + struct.pack("<III", client.services["/all_stop"]["id"], 1, 4) + b'json{"data": true}'
        with holding(live):
            for _ in range(CALLS_MAX):
                client.socket.send(setting)
            client.socket.send(stop)
            until(lambda: is_next(live))


def test_a_stop_over_a_link_comes_before_all_commands_that_wait() -> None:
    sim = Simulator("pool", link="tether")
    with LiveSimulator(sim, paused=True) as live, Carrier(live, Table(sim)) as carrier:
        far = carrier.remote()
        with holding(live):
            live.command("set_parameter", name="rov.mass_kg", value=13.5)
            release, _ = (far.command("all_stop", vehicle="rov", on=on) for on in (False, True))
            assert is_next(live)
        with pytest.raises(RuntimeError, match="before it could be released"):
            release.result()
        live.step(100)
        assert live.rov.all_stopped


def test_a_stop_while_a_command_waits_ends_that_command(
    live: LiveSimulator, vehicle: MavlinkVehicle, station: Station, monkeypatch: pytest.MonkeyPatch
) -> None:
    held: Future[None] = Future()
    waits = threading.Event()
    begin = vehicle._craft.begin

    def holding(name: str, **given: object) -> Future[None]:
        if name != "hold":
            return begin(name, **given)
        waits.set()
        return held

    assert station.arm() == DONE
    monkeypatch.setattr(vehicle._craft, "begin", holding)
    station.mav.command_long_send(1, 1, dialect.MAV_CMD_DO_SET_MODE, 0, 1, GUIDED, *[0.0] * 5)
    assert waits.wait(PATIENCE_S)
    station.mav.command_long_send(1, 1, STOP, 0, 1.0, *[0.0] * 6)
    assert station.receive("COMMAND_ACK", lambda ack: ack.command == STOP).result == DONE
    held.set_result(None)
    ack = station.receive("COMMAND_ACK", lambda ack: ack.command == dialect.MAV_CMD_DO_SET_MODE)
    assert ack.result == FAILED and not vehicle._flight.is_armed
    assert vehicle._flight.mode == MANUAL


@pytest.mark.parametrize("kind", ["set_param", "publish", "call"])
def test_a_flood_by_a_rosbridge_client_delays_no_stop_of_another(live: LiveSimulator, slow: None, kind: str) -> None:
    parameter = {"name": "/rov/mass_kg", "value": "13.5"}
    operations: dict[str, dict[str, Any]] = {
        "set_param": {"op": "call_service", "service": "/rosapi/set_param", "args": parameter},
        "publish": {"op": "publish", "topic": "/cmd_vel", "msg": {}},
        "call": {"op": "call_service", "service": "/hold", "args": {}},
    }
    with RosbridgeServer(live) as server, connect(server.url) as foe, connect(server.url) as station:
        for _ in range(FLOOD):
            send(foe, **operations[kind])
        time.sleep(0.3)
        stop = partial(send, station, "call_service", service="/all_stop", args={"data": True})
        assert stopped_after_s(live, stop) < STOP_S


def test_a_flood_by_a_foxglove_client_delays_no_stop_of_another(live: LiveSimulator, slow: None) -> None:
    table = served_table(live)
    flooding = json.dumps({"op": "setParameters", "parameters": [{"name": "rov.mass_kg", "value": 13.5}]})
    with (
        FoxgloveServer(live, table.channels, table.services) as server,
        FoxgloveClient(server.url, "/odom") as foe,
        FoxgloveClient(server.url, "/odom") as station,
    ):
        station.until(lambda: "/all_stop" in station.services)
        number = station.services["/all_stop"]["id"]
        for _ in range(FLOOD):
            foe.socket.send(flooding)
        time.sleep(0.3)
        call = b"\x02" + struct.pack("<III", number, 1, 4) + b"json" + b'{"data": true}'
        assert stopped_after_s(live, lambda: station.socket.send(call)) < STOP_S
