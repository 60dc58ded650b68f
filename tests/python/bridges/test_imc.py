"""`--imc`: frames, and a vehicle that a DUNE commands or that consoles find."""

import math
import os
import socket
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, closing, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from imc_standin import StandInDune
from listening_sockets import free_port
from steered import OPEN_WATER, bay, steered_by, torpedo
from uwsim import Simulator
from uwsim.bridges.doors.datagrams import Datagrams
from uwsim.bridges.doors.endpoint import Endpoint
from uwsim.bridges.imc.announcer import CONSOLES_MAX, DISCOVERY_PORTS, Announcer
from uwsim.bridges.imc.link import Identity, ImcLink, parsed
from uwsim.bridges.imc.plug import ImcOptions, ImcPlug
from uwsim.bridges.imc.readings import Place, servos, simulated_state
from uwsim.bridges.imc.vehicle import ping
from uwsim.bridges.imc.wire import Message, decoded, encoded
from uwsim.live import LiveSimulator
from uwsim.scenario import Scenario, load_vehicle
from uwsim.scenario.georeference import georeference
from waiting import until


def member(
    scenario: Scenario | str, *addresses: str, speed: float = 1.0, **options: Any
) -> AbstractContextManager[LiveSimulator]:
    return steered_by(ImcPlug(ImcOptions(imc=addresses, **options)), scenario, speed)


@pytest.fixture
def dune() -> Iterator[StandInDune]:
    with StandInDune() as dune:
        yield dune


# Frames


def test_the_true_motion_has_imcs_frames() -> None:
    sim = Simulator(bay(torpedo()))
    place = Place.of(georeference(sim.scenario))

    def state() -> dict[str, Any]:
        name, content = simulated_state(sim, sim.rov, place)
        assert name == "SimulatedState"
        return content

    half = math.radians(60) / 2
    sim.rov.place([30, -20, -8], [0, 0, math.sin(half), math.cos(half)], [1.0, 0.2, 0.1, 0.01, 0.02, 0.03])
    found = state()
    assert (found["lat"], found["lon"]) == pytest.approx((math.radians(43.8253), math.radians(-70.3304)), abs=1e-9)
    assert (found["x"], found["y"], found["z"]) == pytest.approx((-20, 30, 8), abs=0.05)  # the grid is not quite north
    assert found["psi"] == pytest.approx(math.radians(30), abs=2e-3)
    assert [found[each] for each in "uvwpqr"] == pytest.approx([1.0, -0.2, -0.1, 0.01, -0.02, -0.03])
    half = math.radians(10) / 2
    sim.rov.place([0, 0, -8], [0, math.sin(half), 0, math.cos(half)], [0.0] * 6)  # nose down
    assert (state()["theta"], state()["phi"]) == pytest.approx((-math.radians(10), 0), abs=1e-6)
    sim.rov.place([0, 0, -8], [math.sin(half), 0, 0, math.cos(half)], [0.0] * 6)  # port side up
    assert (state()["theta"], state()["phi"]) == pytest.approx((0, math.radians(10)), abs=1e-6)


def test_offsets_are_distances_on_the_ellipsoid() -> None:
    """A degree of the meridian at 41.185 N is 111 064 m, Snyder 1987, eq. 4-19 and its series."""
    place = Place.of(georeference(bay(torpedo(), earth={"latitude_deg": 41.185, "longitude_deg": -8.7062})))
    for east, north in ((500.0, 0.0), (0.0, 2000.0), (-1500.0, 700.0)):
        x_m, y_m = place.offset_m(np.array([east, north, 0.0]))
        latitude_deg, longitude_deg = place.world.degrees(np.array([east, north, 0.0])).tolist()
        assert x_m == pytest.approx((latitude_deg - 41.185) * 111_063.9, abs=0.35)  # the earth is round
        a_degree_m = 111_412.84 * math.cos(math.radians(41.185)) - 93.5 * math.cos(3 * math.radians(41.185))
        assert y_m == pytest.approx((longitude_deg + 8.7062) * a_degree_m, abs=0.6)


def test_velocities_are_through_the_water_and_the_waters_own_is_beside_them() -> None:
    """A vehicle that drifts with a current to the east has no velocity through the water."""
    sim = Simulator(bay(torpedo(yaw_deg=0), water={"density_kg_m3": 1026, "current_world_m_s": [0.4, 0.0, 0.0]}))
    sim.rov.place([0, 0, -8], [0, 0, 0, 1], [0.4, 0, 0, 0, 0, 0])
    _, found = simulated_state(sim, sim.rov, Place.of(georeference(sim.scenario)))
    assert [found[each] for each in ("u", "v", "w")] == pytest.approx([0, 0, 0], abs=1e-9)
    assert [found[each] for each in ("svx", "svy", "svz")] == pytest.approx([0, 0.4, 0], abs=1e-3)


def test_servos_are_numbered_and_signed_as_those_of_a_lauv() -> None:
    """DUNE's VSIM: bottom, port, starboard, top; positive rudders turn to port, positive elevators nose down."""
    fins = servos(load_vehicle("remus100"))
    assert {name: each.number for name, each in fins.items()} == {"bottom": 0, "port": 1, "starboard": 2, "top": 3}
    sim = Simulator(bay(torpedo()))
    for numbers, axis, sign in (((0, 3), 5, 1.0), ((1, 2), 4, 1.0)):
        sim.rov.place([0, 0, -20], [0, 0, 0, 1], [2.0, 0, 0, 0, 0, 0])
        sim.rov.set_fins({name: each.sign * 0.15 for name, each in fins.items() if each.number in numbers})
        for _ in range(100):
            sim.step()
        turning = sim.rov.velocity.angular_body_rad_s
        assert sign * turning[axis - 3] > 0.02
        sim.rov.set_fins({})


def test_a_ping_keeps_its_ranges() -> None:
    name, found = ping(np.array([4.0, np.inf, 55.0, 0.5]), 1.5, 55.0)
    ranges_m = np.frombuffer(found["data"], "<u2") * found["scale_factor"]
    assert name == "SonarData"
    assert ranges_m == pytest.approx([4.0, 0.0, 55.0, 0.5], abs=found["scale_factor"])
    assert decoded(encoded(Message(name, found))).content["beam_config"][0][1]["beam_width"] == pytest.approx(1.5)


# With DUNE


def test_dune_gets_the_motion_and_steers(dune: StandInDune) -> None:
    with member(bay(torpedo()), f"127.0.0.1:{dune.port}", speed=5.0) as live:
        until(lambda: dune.last("SimulatedState") is not None)
        assert dune.field("SimulatedState", "z") == pytest.approx(8, abs=0.2)
        until(lambda: dune.seen["SimulatedState"][-1].source == dune.system)  # a part of its peer's system
        assert set(dune.seen) == {"Heartbeat", "EntityList", "SimulatedState"}

        def sail(rudder: float, elevator: float) -> None:
            dune.send("SetThrusterActuation", id=0, value=0.8)
            for number, angle in ((0, rudder), (1, elevator), (2, elevator), (3, rudder)):
                dune.send("SetServoPosition", id=number, value=angle)

        def turned() -> bool:
            sail(-0.1, 0.0)
            return dune.field("SimulatedState", "psi") > 0.7

        until(turned)  # to starboard

        def dived() -> bool:
            sail(0.0, 0.05)
            return dune.field("SimulatedState", "z") > 9

        until(dived)
        assert dune.field("SimulatedState", "u") > 0.5

        def is_at_its_stop() -> bool:
            sail(3.0, 0.0)  # beyond the travel, as a rounded 25 degrees of DUNE's are
            return bool(max(map(abs, live.rov.fins.values())) == pytest.approx(math.radians(travel_deg)))

        travel_deg = max(fin.deflection_max_deg for fin in load_vehicle("remus100").fins.values())

        until(is_at_its_stop)
        until(lambda: live.rov.thrusters["propeller"].command == 0)  # once it is silent
        until(lambda: all(abs(each) < 1e-9 for each in live.rov.fins.values()))


def test_instruments_have_units_and_entities_of_the_peer(dune: StandInDune) -> None:
    dune.entities = "Daemon=0;dvl=33;uwsim=40"
    scenario = bay(torpedo(), terrain={**OPEN_WATER["terrain"], "bed_depth_m": 30})
    with member(scenario, f"127.0.0.1:{dune.port}", imc_sends="instruments", speed=5.0) as live:
        names = {
            "EstimatedState", "Depth", "Pressure", "Temperature", "EulerAngles", "AngularVelocity", "Acceleration",
            "GroundVelocity", "Distance", "SonarData", "Rpm", "ServoPosition",
        }  # fmt: skip
        until(lambda: names <= dune.seen.keys())
        assert "GpsFix" not in dune.seen
        assert dune.field("Depth", "value") == pytest.approx(8, abs=0.5)
        assert dune.field("Pressure", "value") == pytest.approx(1013.25 + 0.01 * 1026 * 9.81 * 8, abs=60)  # hPa
        assert dune.field("Acceleration", "z") == pytest.approx(-9.81, abs=0.5)
        assert abs(dune.field("EulerAngles", "psi")) < 0.1
        until(lambda: dune.field("GroundVelocity", "validity") == 7)
        until(lambda: dune.seen["GroundVelocity"][-1].entity == 33)
        assert dune.seen["Depth"][-1].entity >= 128
        live.command("place", vehicle="alpha", position_world_m=[0, 0, -0.1], orientation_xyzw=[0, 0, 0, 1]).result()
        until(lambda: "GpsFix" in dune.seen)
        assert dune.field("GpsFix", "lat") == pytest.approx(math.radians(43.8253), abs=1e-5)


def test_with_a_link_dune_is_aboard_and_consoles_are_not(dune: StandInDune) -> None:
    scenario = bay(torpedo(), link="ideal_acoustic")
    with member(scenario, f"127.0.0.1:{dune.port}", imc_sends="instruments", speed=5.0) as live:
        until(lambda: {"EstimatedState", "SonarData"} <= dune.seen.keys())

        def is_driven() -> bool:
            dune.send("SetThrusterActuation", id=0, value=0.8)
            return live.rov.thrusters["propeller"].command == pytest.approx(0.8)

        until(is_driven)
    with pytest.raises(ValueError, match="consoles are ashore"), member(scenario, "announce:127.0.0.1", imc_id=1):
        pass


def test_a_system_of_our_own_lists_its_entities(dune: StandInDune) -> None:
    with member(bay(torpedo()), f"127.0.0.1:{dune.port}", imc_id=0x0D00):
        until(lambda: "SimulatedState" in dune.seen)
        dune.send("EntityList", op=1)
        until(lambda: any(each.content["op"] == 0 for each in dune.seen["EntityList"]))
        assert dune.seen["EntityList"][-1].content["list"] == "uwsim=128"
        assert dune.seen["SimulatedState"][-1].source == 0x0D00


def test_datagrams_go_both_ways() -> None:
    port = free_port(socket.SOCK_DGRAM)
    with socket.socket(type=socket.SOCK_DGRAM) as peer:
        peer.bind(("127.0.0.1", 0))
        peer.settimeout(180)
        with member(bay(torpedo()), f"udp:127.0.0.1:{peer.getsockname()[1]}", imc_port=port) as live:
            names = set()
            there = ("", 0)

            def got() -> bool:
                nonlocal there
                data, there = peer.recvfrom(1 << 16)
                names.add(decoded(data).name)
                return "SimulatedState" in names

            until(got)
            assert there == ("127.0.0.1", port)

            def moves() -> bool:
                peer.sendto(encoded(Message("SetThrusterActuation", {"id": 0, "value": 2.0}, 0xD1)), there)
                peer.sendto(b"no packet", there)
                return bool(live.rov.thrusters["propeller"].command == 1.0)

            until(moves)


class Console:
    """A console as Neptus is: it announces itself by datagrams, and listens for announcements and messages."""

    system = 0x4101

    def __init__(self) -> None:
        self.heard: dict[str, Message] = {}
        self._service, self._discovery = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
        self._service.bind(("127.0.0.1", 0))
        for port in DISCOVERY_PORTS:
            with suppress(OSError):
                self._discovery.bind(("127.0.0.1", port))
                break
        for each in (self._service, self._discovery):
            each.settimeout(0.1)

    def close(self) -> None:
        self._service.close()
        self._discovery.close()

    def send(self, port: int, name: str, **content: Any) -> None:
        self._service.sendto(encoded(Message(name, content, self.system)), ("127.0.0.1", port))

    def announce(self) -> None:
        services = f"http://127.0.0.1:8080/;imc+udp://127.0.0.1:{self._service.getsockname()[1]}/"
        for port in DISCOVERY_PORTS:
            self.send(port, "Announce", sys_name="ccu", services=services)

    def has(self, *names: str) -> bool:
        """Return whether messages of these names have been heard by now."""
        for each in (self._discovery, self._service):
            with suppress(TimeoutError):
                for _ in range(200):
                    found = decoded(each.recv(1 << 16))
                    if found.source != self.system:
                        self.heard[found.name] = found
        return set(names) <= self.heard.keys()


def test_a_console_is_answered_and_gets_the_vehicle_but_does_not_steer_it() -> None:
    port = free_port(socket.SOCK_DGRAM)
    with (
        member(bay(torpedo()), f"announce:127.0.0.1:{port}", imc_id=0x00D1) as live,
        closing(Console()) as console,
    ):
        time.sleep(0.3)
        assert not console.has("EstimatedState")  # until it announces itself
        console.announce()
        until(lambda: console.has("Announce", "EstimatedState", "Heartbeat", "Depth", "SonarData"))
        announced = console.heard["Announce"]
        assert (announced.source, announced.content["sys_name"], announced.content["sys_type"]) == (0x00D1, "alpha", 2)
        assert announced.content["services"] == f"imc+udp://127.0.0.1:{port}/"
        assert announced.content["lat"] == pytest.approx(math.radians(43.8253), abs=1e-5)
        assert "SimulatedState" not in console.heard
        console.send(port, "SetThrusterActuation", id=0, value=0.5)
        console.send(port, "EntityList", op=1)
        until(lambda: console.has("EntityList"))
        assert "navigation=" in console.heard["EntityList"].content["list"]
        assert live.rov.thrusters["propeller"].command == 0.0


def test_no_number_of_announcements_shuts_out_a_console() -> None:
    announcer = Announcer(parsed("announce:127.0.0.1:6001"), Identity(0xD1), "rov", lambda: (0.0, 0.0))

    def announces(system: int, service: Datagrams) -> None:
        services = {"sys_name": "ccu", "services": "imc+udp://127.0.0.1:9/"}
        announcer._take(decoded(encoded(Message("Announce", services, system))), ("127.0.0.1", 9), service)

    with Datagrams() as service:
        for _ in range(3):
            for system in range(1, 4 * CONSOLES_MAX):
                announces(system, service)
            announces(0x4101, service)
            assert 0x4101 in announcer.consoles and len(announcer.consoles) == CONSOLES_MAX


@pytest.mark.skipif(
    not {"UWSIM_DUNE", "UWSIM_DUNE_CONFIG"} <= set(os.environ),
    reason="needs DUNE: its program as UWSIM_DUNE, its folder etc as UWSIM_DUNE_CONFIG",
)
def test_a_dune_flies_its_plan_with_its_own_autopilot() -> None:
    trial = Path(__file__).parents[3] / "tools/trial"
    given = ["--dune", os.environ["UWSIM_DUNE"], "--config", os.environ["UWSIM_DUNE_CONFIG"]]
    done = subprocess.run([trial, "imc", *given], capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stdout + done.stderr


def test_all_stop_outranks_dune_and_what_has_no_actuator_is_reported(
    dune: StandInDune, caplog: pytest.LogCaptureFixture
) -> None:
    with member(bay(torpedo()), f"127.0.0.1:{dune.port}") as live:
        until(lambda: "SimulatedState" in dune.seen)
        dune.send("SetThrusterActuation", id=4, value=0.5)
        dune.send("SetServoPosition", id=0, value=math.nan)
        until(lambda: "thruster 4" in caplog.text and "servo 0" in caplog.text)
        live.command("all_stop", vehicle="alpha", on=True).result()
        for _ in range(5):
            dune.send("SetThrusterActuation", id=0, value=0.8)
            time.sleep(0.05)
        assert live.rov.thrusters["propeller"].command == 0


def test_a_peer_that_does_not_speak_imc_is_reported(caplog: pytest.LogCaptureFixture) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:

        def answer() -> None:
            client, _ = server.accept()
            client.sendall(b"HTTP/1.1 400 Bad Request\r\n" * 8000)
            time.sleep(0.2)
            client.close()

        threading.Thread(target=answer, daemon=True).start()
        with ImcLink(Endpoint("127.0.0.1", server.getsockname()[1], "tcp"), Identity(None), print):
            until(lambda: "is it IMC" in caplog.text)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"imc": ("a=h:1", "a=h:2")}, "must name each vehicle once"), ({"imc": ("h:x",)}, "must be"),
        ({"imc": ("announce:127.0.0.1",)}, "needs --imc-id"), ({"imc": ("announce:lab",)}, "address of this machine"),
        ({"imc": ("udp:h:1", "b=udp:h:2")}, "must have udp once"),
    ],
)  # fmt: skip
def test_wrong_options_are_refused_before_anything_is_built(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ImcPlug(ImcOptions(**options))


@pytest.mark.parametrize(
    ("scenario", "address", "message"),
    [
        (bay(torpedo()), "nemo=h:1", "vehicle 'nemo': must be one of alpha"),
        ("pool", "h:1", "no place on Earth|has no thrusters"),
    ],
)
def test_what_cannot_be_served_is_refused(scenario: Scenario | str, address: str, message: str) -> None:
    with pytest.raises(ValueError, match=message), member(scenario, address):
        pass


def test_the_doctor_listens(dune: StandInDune) -> None:
    (found,) = ImcPlug.examine(ImcOptions(imc=(f"127.0.0.1:{dune.port}",)), 5.0)
    assert (found.verdict, found.found) == ("ok", "system 0x00D1")
    (missing,) = ImcPlug.examine(ImcOptions(imc=("127.0.0.1:1",)), 1.0)
    assert missing.verdict == "wrong"
