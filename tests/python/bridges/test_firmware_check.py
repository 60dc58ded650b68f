"""`uwsim ardusub check`: a log beside the model that made it, tables of flights, and what is refused."""

import math
from collections.abc import Iterator
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flight_logs import binary_log
from servo_standin import mixed
from uwsim import Simulator
from uwsim.base.options import WithoutEffectError
from uwsim.bridges.ardusub.ardusub import prepared
from uwsim.bridges.cli.ardusub_check import ardusub_check
from uwsim.bridges.firmware import check
from uwsim.bridges.firmware.check import UNITS, Flown, sides_of, with_battery
from uwsim.bridges.firmware.dataflash_log import DEPTH_M, QUANTITIES, SAMPLE_S, compared, open_water, read_servo_log
from uwsim.bridges.firmware.firmware import FirmwareError
from uwsim.bridges.firmware.report import log_rows, side_rows, write_flights
from uwsim.bridges.mavlink.earth import FRD, NED_FROM_ENU
from uwsim.scenario import Scenario, load

pytest.importorskip("pymavlink", reason="needs the extra mavlink")

FORMATS = {
    "FMT": ("BBnNZ", ["Type", "Length", "Name", "Format", "Columns"]),
    "RCOU": ("Q" + "H" * 14, ["TimeUS", *(f"C{n}" for n in range(1, 15))]),
    "ATT": ("Qfff", ["TimeUS", "Roll", "Pitch", "Yaw"]),
    "IMU": ("QBfff", ["TimeUS", "I", "GyrX", "GyrY", "GyrZ"]),
    "XKF1": ("QBffff", ["TimeUS", "C", "VN", "VE", "VD", "PD"]),
    "ARM": ("QB", ["TimeUS", "ArmState"]),
}
SECONDS = 6.0


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return prepared(load("lagoon"), "bluerov2_tank")


def test_a_log_of_the_model_is_what_the_model_does(scenario: Scenario, tmp_path: Path) -> None:
    """The model is flown, its motion written as ArduSub would log it, and read back: the two agree."""
    sim = Simulator(open_water(scenario))
    pwm = mixed("vectored", forward=0.3, yaw=0.1)
    frames = np.zeros(32, "<u2")
    frames[:6] = pwm
    rows: list[tuple[str, list[Any]]] = [("ARM", [0, 1])]
    for k in range(round(SECONDS / SAMPLE_S) + 1):
        us = round(1e6 * k * SAMPLE_S)
        ned_from_frd = NED_FROM_ENU @ sim.rov.pose.world_from_body[:3, :3] * FRD
        yaw, pitch, roll = Rotation.from_matrix(ned_from_frd).as_euler("ZYX", degrees=True)
        velocity = ned_from_frd @ (FRD * sim.rov.velocity.linear_body_m_s)
        rates = FRD * sim.rov.velocity.angular_body_rad_s
        rows += [("RCOU", [us, *pwm, *[0] * 8]), ("ATT", [us, roll, pitch, yaw]), ("IMU", [us, 0, *rates]),
                 ("IMU", [us, 1, 9, 9, 9]), ("XKF1", [us, 0, *velocity, DEPTH_M])]  # fmt: skip
        steps = round(SAMPLE_S / sim.step_s)
        sim.lockstep.play(sim, vehicle="rov", frame="vectored", from_tick=sim.tick, frames=frames.tobytes() * steps)
        sim.step(steps)
    path = tmp_path / "flight.bin"
    path.write_bytes(binary_log(FORMATS, rows))
    log = read_servo_log(path)
    assert log.outputs_us[5, :7].tolist() == [*pwm, 0] and log.depth_m[0] == DEPTH_M
    found = compared(log, scenario, 2.0)
    assert len(found.starts) == 3
    for name in QUANTITIES:
        np.testing.assert_allclose(found.modelled[name], found.logged[name], atol=2e-3, err_msg=name)
    assert np.ptp(found.logged["speed ahead"]) > 0.3 and np.ptp(found.logged["rate of yaw"]) > 5
    still = compared(log, prepared(load("lagoon"), "bluerov2_wu"), 2.0)
    assert np.std(still.modelled["speed ahead"] - still.logged["speed ahead"]) > 0.01  # another model does otherwise
    assert log_rows(found)[1][-1] == "1.00"


def test_a_log_that_lacks_something_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "short.bin"
    path.write_bytes(binary_log(FORMATS, [("ARM", [0, 1]), ("ATT", [0, 0, 0, 0])]))
    with pytest.raises(ValueError, match=r"short\.bin: has no RCOU, IMU, XKF1"):
        read_servo_log(path)
    data = bytearray(path.read_bytes())
    data[data.index(b"\xa3\x95\x80", 89) + 4] = 0  # the length of the second type of message
    path.write_bytes(data)
    with pytest.raises(ValueError, match=r"short\.bin: .* is damaged: a type of message has no length"):
        read_servo_log(path)


def test_a_program_is_no_log_and_is_not_started(tmp_path: Path) -> None:
    path, started = tmp_path / "bin" / "ardusub", tmp_path / "started"
    path.parent.mkdir()
    path.write_text(f"#!/bin/sh\necho > {started}\nexec cat > /dev/null\n")
    path.chmod(0o755)
    with pytest.raises(ValueError, match=r"bin/ardusub: must be a dataflash log \(\.bin\)"):
        read_servo_log(path)
    assert not started.exists()


@pytest.mark.parametrize(("armed", "last_s", "message"), [(0, 9, "never armed"), (1, 1e9, "must be 5 to 86400 s")])
def test_a_log_without_a_flight_is_refused(tmp_path: Path, armed: int, last_s: float, message: str) -> None:
    path = tmp_path / "damaged.bin"
    rows: list[tuple[str, list[Any]]] = [("ARM", [0, armed])]
    for us in (0, round(1e6 * last_s)):
        rows += [("RCOU", [us, *[1500] * 14]), ("ATT", [us, 0, 0, 0]), ("IMU", [us, 0, 0, 0, 0]),
                 ("XKF1", [us, 0, 0, 0, 0, 0])]  # fmt: skip
    path.write_bytes(binary_log(FORMATS, rows))
    with pytest.raises(ValueError, match=rf"damaged\.bin: .*{message}"):
        read_servo_log(path)


def flown(side: str, seed: int, power_w: float) -> Flown:
    values = {**dict.fromkeys(UNITS, math.nan), "power in POSHOLD": power_w}
    return Flown(side, seed, MappingProxyType(values), np.zeros(1), np.zeros(1))


def test_differences_are_between_flights_of_the_same_seed(tmp_path: Path) -> None:
    flights = [flown("a", 0, 10.0), flown("a", 1, 30.0), flown("b", 1, 33.0), flown("b", 0, 12.0), flown("b", 2, 99.0)]
    row = next(each for each in side_rows(flights, ["a", "b"]) if each[0] == "power in POSHOLD")
    assert row[2] == "20 ± 14" and row[4] == "2.5 ± 0.5"
    write_flights(tmp_path / "flights.csv", flights)
    lines = (tmp_path / "flights.csv").read_text().splitlines()
    assert len(lines) == 6 and {line.count(",") for line in lines} == {len(UNITS) + 1}


def test_what_cannot_be_compared_is_refused(tmp_path: Path) -> None:
    program, again, one, other = (tmp_path / name for name in ("ardusub", "again", "a.parm", "b.parm"))
    for path in (program, again, one, other):
        path.write_text("#!/bin/sh\n")
    program.chmod(0o755)
    again.chmod(0o755)
    first, second = sides_of(one, other, program)
    assert (first.binary, first.files, second.name) == (program, (one,), "b.parm")
    for paths, binary, message in (
        ((one, other), None, "need --binary"), ((one, one), program, "is given twice"),
        ((program, other), None, "must be of the same kind"),
        ((program, again), program, "cannot be given with two programs"), ((one, tmp_path / "x"), None, "no such"),
    ):  # fmt: skip
        with pytest.raises(FirmwareError, match=message):
            sides_of(*paths, binary)


def test_an_option_without_effect_is_refused(tmp_path: Path) -> None:
    with pytest.raises(WithoutEffectError, match="--binary, --seeds: need two programs or parameter files"):
        ardusub_check(first=tmp_path, binary=tmp_path, seeds="2")
    with pytest.raises(WithoutEffectError, match="--window: needs a log"):
        ardusub_check(first=tmp_path, second=tmp_path, window=2)


def test_finished_flights_are_kept_and_no_other_files_are_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    paths = [tmp_path / name for name in ("ardusub", "a.parm", "b.parm")]
    for path in paths:
        path.write_text("#!/bin/sh\n")
    paths[0].chmod(0o755)
    out = tmp_path / "out"

    def fails_after_one(*_: object) -> Iterator[Flown]:
        yield flown("a.parm", 0, 10.0)
        raise FirmwareError("has ended")

    monkeypatch.setattr(check, "checked", fails_after_one)
    with pytest.raises(FirmwareError, match="has ended"):
        ardusub_check(first=paths[1], second=paths[2], binary=paths[0], out=out)
    assert len((out / "flights.csv").read_text().splitlines()) == 2
    (out / "report.md").write_text("mine")
    with pytest.raises(FileExistsError, match=r"report\.md': exists, and uwsim did not write it"):
        ardusub_check(first=paths[1], second=paths[2], binary=paths[0], out=out)


def test_energy_is_known_from_a_battery() -> None:
    assert with_battery(prepared(load("lagoon"))).vehicles[0].battery is not None
