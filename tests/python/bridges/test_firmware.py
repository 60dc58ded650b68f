"""The program ArduSub as a child process, with a stand-in in its place: started, aided in navigation, always ended."""

import json
import os
import re
import signal
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.bridges.ardusub.ardusub import ArduSub, SilentAutopilotError, prepared
from uwsim.bridges.ardusub.options import ArduSubOptions, ProgramOptions
from uwsim.bridges.firmware import firmware as module
from uwsim.bridges.firmware import link
from uwsim.bridges.firmware.firmware import Firmware, FirmwareError, Serials
from uwsim.bridges.firmware.flight import checked_address, firmware_flying
from uwsim.bridges.mavlink.earth import HOME, NED_FROM_ENU
from uwsim.mapping.files.georeference import Home
from uwsim.scenario import Scenario, load
from uwsim.scenario.read.validated import validated
from waiting import until

pytest.importorskip("pymavlink", reason="needs the extra mavlink")
from pymavlink.dialects.v20 import ardupilotmega as dialect

ROOT = Path(__file__).parents[3]
STANDIN = Path(__file__).with_name("firmware_standin.py")
FULL_LM = 1500.0
FRAME_BYTES = 40


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return prepared(load("lagoon"), "bluerov2_heavy_outfit")


@pytest.fixture
def sim(scenario: Scenario) -> Simulator:
    return Simulator(scenario)


def living(folder: Path, **life: Any) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "standin.json").write_text(json.dumps(life))
    return folder


def sent(*messages: Any) -> str:
    mav = dialect.MAVLink(None, srcSystem=1, srcComponent=1)
    return b"".join(message.pack(mav) for message in messages).hex()


def heard(folder: Path) -> list[Any]:
    mav = dialect.MAVLink(None)
    data = bytes.fromhex((folder / "received.txt").read_text().replace("\n", ""))
    return mav.parse_buffer(data) or []


HEARTBEAT = dialect.MAVLink_heartbeat_message(12, 3, 0, 0, 0, 3)


def test_the_program_flies_with_what_its_navigation_needs(sim: Simulator, binary: Path, tmp_path: Path) -> None:
    """ODOMETRY is the estimate at 20 Hz, in ArduSub's axes; the origin is sent until the firmware confirms it."""
    folder = living(tmp_path / "own", message=sent(HEARTBEAT), pwm=[1560] * 4 + [1500] * 4)
    theirs = tmp_path / "theirs.parm"
    theirs.write_text("GPS1_TYPE 1\n")
    with ArduSub(sim, port=0) as ardusub, firmware_flying(ardusub, binary, files=[theirs], folder=folder) as program:
        sim.advance(1.5)
        estimate = sim.rov.estimate
        at_ned_m = NED_FROM_ENU @ estimate.pose.position_world_m
        sim.step(20)
        assert program.files == [theirs]
    messages = heard(folder)
    kinds = [message.get_type() for message in messages]
    assert kinds.count("ODOMETRY") in (29, 30) and kinds.count("SET_GPS_GLOBAL_ORIGIN") == 1
    last = [message for message in messages if message.get_type() == "ODOMETRY"][-1]
    assert (last.frame_id, last.child_frame_id, last.get_srcSystem()) == (20, 12, 1)
    np.testing.assert_allclose((last.x, last.y, last.z), at_ned_m, atol=1e-3)
    shown = [each.param_value for each in messages if each.get_type() == "PARAM_SET"]
    assert shown[0] == pytest.approx(3.0, abs=0.01)  # as at the surface, for which the firmware takes it at first
    origin = next(message for message in messages if message.get_type() == "SET_GPS_GLOBAL_ORIGIN")
    assert (origin.latitude, origin.longitude) == (round(1e7 * HOME.lat_deg), round(1e7 * HOME.lon_deg))
    parameters = dict(line.split() for line in (folder / module.PARAMETERS).read_text().splitlines())
    assert (parameters["FRAME_CONFIG"], parameters["GPS1_TYPE"], parameters["EK3_SRC1_POSXY"]) == ("2", "0", "6")


def test_a_confirmed_origin_is_not_sent_again(sim: Simulator, binary: Path, tmp_path: Path) -> None:
    confirmed = dialect.MAVLink_gps_global_origin_message(0, 0, 0)
    folder = living(tmp_path / "own", message=sent(HEARTBEAT, confirmed))
    with ArduSub(sim, port=0) as ardusub, firmware_flying(ardusub, binary, folder=folder):
        sim.advance(1.1)
    assert {message.get_type() for message in heard(folder)} == {"ODOMETRY", "PARAM_SET"}


def test_the_barometer_shows_the_pressure_under_waves(
    binary: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """ArduSub makes 101325 Pa + 1024 kg/m3 * 9.80665 m/s2 per metre below its own height, plus SIM_BARO_GLITCH."""
    monkeypatch.setattr(link, "BOOT_NS", 0)
    path, salinity = tmp_path / "waves.yaml", "  salinity_psu: 35\n"
    waves = f"{salinity}  surface: {{kind: airy, amplitude_m: 0.4, period_s: 4}}\n"
    path.write_text((ROOT / "assets/scenarios/lagoon.yaml").read_text().replace(salinity, waves))
    sim = Simulator(prepared(load(path)))
    folder = living(tmp_path / "own", message=sent(HEARTBEAT))
    expected_m = []
    with ArduSub(sim, port=0) as ardusub, firmware_flying(ardusub, binary, folder=folder):
        for _ in range(24):
            sim.step(20)
            depth_m = (sim.rov.sensors["pressure"].read(noise=False) - 101325) / (1024 * 9.80665)
            expected_m.append(-depth_m - sim.rov.pose.position_world_m[2])
        sim.step(5)
    shown_m = [each.param_value for each in heard(folder) if each.get_type() == "PARAM_SET"]
    assert np.ptp(shown_m) == pytest.approx(np.ptp(expected_m), abs=0.01) and np.ptp(shown_m) > 0.1


def words_of(program: Firmware) -> dict[str, str]:
    words = Path(f"/proc/{program.pid}/cmdline").read_text().split("\0")
    return dict(word[2:].split("=", 1) for word in words if word.startswith("--"))


def test_the_origin_is_the_scenarios(scenario: Scenario, binary: Path, tmp_path: Path) -> None:
    pytest.importorskip("rasterio", reason="needs the extra geotiff")
    earth = {"latitude_deg": 60.25, "longitude_deg": 5.5}
    sim = Simulator(validated(Scenario, {**scenario.given(), "earth": earth}))
    folder = living(tmp_path / "own", message=sent(HEARTBEAT))
    with ArduSub(sim, port=0) as ardusub, firmware_flying(ardusub, binary, folder=folder) as program:
        home = [float(each) for each in words_of(program)["home"].split(",")]
        sim.advance(1.1)
    assert home == pytest.approx([60.25, 5.5, 0, 0], abs=1e-6)
    origin = next(each for each in heard(folder) if each.get_type() == "SET_GPS_GLOBAL_ORIGIN")
    assert (origin.latitude, origin.longitude) == pytest.approx((602500000, 55000000), abs=1)


def test_another_program_cannot_take_the_firmwares_place(
    sim: Simulator, binary: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Neither by a message before its first one nor by one after it."""
    folder = living(tmp_path / "own", message=sent(HEARTBEAT))
    origin = bytes.fromhex(sent(dialect.MAVLink_gps_global_origin_message(0, 0, 0)))
    starts = Firmware.__enter__
    with udp() as stranger, ArduSub(sim, port=0) as ardusub:

        def spoken(firmware: Firmware) -> Firmware:
            host, port = firmware._options["serial1"].removeprefix("udpclient:").split(":")
            stranger.connect((host, int(port)))
            stranger.send(origin)
            return starts(firmware)

        monkeypatch.setattr(Firmware, "__enter__", spoken)
        with firmware_flying(ardusub, binary, folder=folder):
            sim.step(21)
            stranger.send(origin)
            sim.advance(1.1)
            stranger.setblocking(False)
            with pytest.raises(BlockingIOError):
                stranger.recv(100)
    assert "SET_GPS_GLOBAL_ORIGIN" in {message.get_type() for message in heard(folder)}


def test_a_firmware_that_starts_again_is_aided_again(sim: Simulator, binary: Path, tmp_path: Path) -> None:
    confirmed = dialect.MAVLink_gps_global_origin_message(0, 0, 0)
    folder = living(tmp_path / "own", message=sent(HEARTBEAT, confirmed), restarts=210)
    with ArduSub(sim, port=0) as ardusub, firmware_flying(ardusub, binary, folder=folder):
        sim.step(209)
        before = len(heard(folder))
        sim.step(191)
    kinds = [message.get_type() for message in heard(folder)[before:]]
    assert kinds.count("ODOMETRY") >= 7  # of 10; those to the last sockets are lost


def test_messages_are_sent_only_to_a_firmware_that_waits(
    sim: Simulator, binary: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with ArduSub(sim, port=0, patience_s=0.01) as ardusub, pytest.raises(SilentAutopilotError):
        ardusub.is_ready()
    monkeypatch.setattr(ArduSub, "is_ready", lambda self: False)
    folder = living(tmp_path / "own", message=sent(HEARTBEAT))
    with ArduSub(sim, port=0) as ardusub, firmware_flying(ardusub, binary, folder=folder):
        sim.advance(0.2)
    assert not heard(folder)


def test_a_folder_is_used_by_one_run_and_loses_nothing(scenario: Scenario, binary: Path, tmp_path: Path) -> None:
    folder, home, serials = tmp_path / "a, b", Home(1, 2), Serials("127.0.0.1:9", "127.0.0.1:9")
    with udp() as silent:
        port = silent.getsockname()[1]
        with Firmware(binary, port, serials, home, folder=folder, parameters={"X": 1016.04751}) as program:
            assert words_of(program)["defaults"] == module.PARAMETERS
            with (
                pytest.raises(FirmwareError, match="another run is using it"),
                Firmware(binary, port, serials, home, folder=folder),
            ):
                pass
        assert (folder / module.PARAMETERS).read_text() == "X 1016.04751\n"
        for name in (module.PARAMETERS, module.OUTPUT):
            with Firmware(binary, port, serials, home, folder=folder):  # replaces what it wrote itself
                pass
            (folder / name).write_text("mine")
            with (
                pytest.raises(FirmwareError, match="uwsim did not write it"),
                Firmware(binary, port, serials, home, folder=folder),
            ):
                pass
            assert (folder / name).read_text() == "mine"
            (folder / name).unlink()


def test_a_program_that_ends_ends_the_step_with_its_last_line(sim: Simulator, binary: Path, tmp_path: Path) -> None:
    folder = living(tmp_path / "own", frames=20, last="PANIC: out of memory", code=3)
    with (
        pytest.raises(
            FirmwareError, match=r"ardusub: the firmware of system 1 has ended with exit code 3: PANIC: out of m"
        ),
        ArduSub(sim, port=0) as ardusub,
        firmware_flying(ardusub, binary, folder=folder),
    ):
        sim.advance(1.0)
    assert sim.tick == 20


def test_it_is_ended_even_if_it_ignores_sigterm_and_with_its_parent(
    scenario: Scenario, binary: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "PATIENCE_S", 0.05)
    folder = living(tmp_path / "own", ignores=True)
    sim = Simulator(scenario)
    with ArduSub(sim, port=0) as ardusub, firmware_flying(ardusub, binary, folder=folder) as program:
        pid = program.pid
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    killed = (
        "import sys; from pathlib import Path; from uwsim.bridges.firmware.firmware import *; port = int(sys.argv[3]); "
        "f = Firmware(Path(sys.argv[1]), port, Serials(*[f'127.0.0.1:{port}'] * 2), Home(1, 2), "
        "folder=Path(sys.argv[2])).__enter__(); print(f.pid, flush=True); sys.stdin.read()"
    )
    with udp() as silent:  # receives its first frame, for whose answer it then waits
        command = [sys.executable, "-c", killed, str(binary), str(folder), str(silent.getsockname()[1])]
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as parent:
            assert parent.stdout is not None
            child = int(parent.stdout.readline())
            while len(silent.recv(100)) != FRAME_BYTES:
                pass
            assert is_alive(child)
            parent.send_signal(signal.SIGKILL)
        until(lambda: not is_alive(child))


def udp() -> socket.socket:
    made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    made.bind(("127.0.0.1", 0))
    made.settimeout(180)
    return made


def is_alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.parametrize(
    ("content", "mode", "message"),
    [
        (None, 0, "no such file"),
        ("#!/bin/sh\n", 0o644, r"is not executable: run chmod \+x"),
        ("neither a script nor a program", 0o755, "cannot be started: Exec format error"),
        ("#!/bin/sh\necho 'bind failed on port 5501'; exit 1\n", 0o755, "has ended with exit code 1: bind failed on"),
        ("#!/bin/sh\nkill -SEGV $$\n", 0o755, r"has ended with signal 11 \(SIGSEGV\)"),
    ],
)
def test_a_program_that_cannot_fly_is_refused_in_one_line(
    sim: Simulator, tmp_path: Path, content: str | None, mode: int, message: str
) -> None:
    path = tmp_path / "ardusub"
    if content is not None:
        path.write_text(content)
        path.chmod(mode)
    with (
        pytest.raises(FirmwareError, match=f"{re.escape(str(path))}: .*{message}"),
        ArduSub(sim, port=0) as ardusub,
        firmware_flying(ardusub, path),
    ):
        pass
    assert sim.tick == 0 and sim.lockstep.is_free


def test_a_vehicle_of_choice_is_trimmed_and_has_a_frame() -> None:
    standard = prepared(load("lake"), "bluerov2_tank").vehicles[0].model
    assert (standard.name, standard.trim.net_buoyancy_n) == ("bluerov2_tank", 2.0)  # type: ignore[union-attr]
    assert prepared(load("lake")).vehicles[0].model.name == "bluerov2_heavy_outfit"  # the lake's has no thrusters
    assert prepared(load("lagoon")).vehicles[0].model.name == "bluerov2_heavy"


def test_lamps_dim_with_their_output(sim: Simulator, binary: Path, tmp_path: Path) -> None:
    folder = living(tmp_path / "own", pwm=[1500] * 12 + [1300])
    with ArduSub(sim, port=0, lights=13) as ardusub, firmware_flying(ardusub, binary, folder=folder):
        sim.step(3)
    lamp = sim.rov.lamps["front"]
    assert lamp.on and lamp.spec.flux_lm == pytest.approx(FULL_LM / 4)  # 1100 to 1900 us


def test_options_need_the_program() -> None:
    with pytest.raises(ValueError, match="--ardusub-folder: needs --ardusub-binary"):
        ArduSubOptions(ardusub=True, ardusub_folder="x")
    with pytest.raises(ValueError, match="--ardusub-host: cannot be given with --ardusub-binary"):
        ArduSubOptions(ardusub=True, ardusub_binary=STANDIN, ardusub_host="0.0.0.0")
    with pytest.raises(ValueError, match="station = 'localhost:1': must be an IPv4 address and a port"):
        checked_address("localhost:1")
    assert "ardusub" not in ProgramOptions.flags()
    assert ProgramOptions().of(STANDIN).ardusub_vehicle == "bluerov2_heavy_outfit"
