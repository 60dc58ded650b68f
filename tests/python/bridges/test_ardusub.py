"""The physics behind ArduPilot's JSON interface, flown by a stand-in for the firmware."""

import logging
import socket
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from servo_standin import NEUTRAL, Standin, mixed, packet
from uwsim import Simulator
from uwsim.bridges.ardusub.ardusub import ArduSub, SilentAutopilotError, prepared
from uwsim.live import LiveSimulator
from uwsim.live.command_log import replay as replay_log
from uwsim.recording import Recorder, Recording
from uwsim.recording.commands import JoinedFrames
from uwsim.recording.messages import Recorded
from uwsim.recording.real_flights.frames import frame_of, servo_motors
from uwsim.recording.replay import replay
from uwsim.scenario import Scenario, load, load_vehicle
from uwsim.simulator.lockstep import FRAME_BYTES
from waiting import until

RECORDED = Path(__file__).parents[1] / "data" / "ardusub_exchange.npz"


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return prepared(load("lagoon"))


@pytest.fixture
def sim(scenario: Scenario) -> Simulator:
    return Simulator(scenario)


@pytest.mark.parametrize(
    ("name", "frame"),
    [("bluerov2_heavy", "vectored_6dof"), ("bluerov2_heavy_cfd", "vectored_6dof"), ("bluerov2_wu", "vectored"),
     ("bluerov2_tank", "vectored")],
)  # fmt: skip
def test_each_motor_drives_the_thruster_at_its_place(name: str, frame: str) -> None:
    """Motors 1 to 4 are front right, front left, rear right, rear left; positive pulses on verticals push down."""
    thrusters = load_vehicle(name).thrusters
    assert frame_of(thrusters, name) == frame
    motors = servo_motors(frame, thrusters, name)
    assert [motor.thruster for motor in motors[:4]] == ["front_right", "front_left", "rear_right", "rear_left"]
    sides = ["vertical_right", "vertical_left"]
    if frame == "vectored_6dof":
        sides = [f"vertical_{end}_{side}" for end in ("front", "rear") for side in ("right", "left")]
    assert [motor.thruster for motor in motors[4:]] == sides
    for motor in motors:
        down = -motor.direction * thrusters[motor.thruster].axis[2]
        ahead = motor.direction * thrusters[motor.thruster].axis[0]
        assert down > 0 if motor.output >= 4 else ahead * (-1 if motor.output < 2 else 1) > 0


def test_a_frame_that_does_not_fit_is_refused(sim: Simulator) -> None:
    with pytest.raises(ValueError, match=r"frame = 'vectored': has 6 motors, .* 8 thrusters of vehicle 'rov'"):
        ArduSub(sim, frame="vectored", port=0)
    with pytest.raises(ValueError, match="vehicle 'remus': its thrusters fit none of ArduSub's frames"):
        frame_of(load_vehicle("remus100").thrusters, "remus")


@pytest.mark.parametrize(
    ("demands", "axis", "sign"),
    [({"forward": 0.5}, 0, 1), ({"lateral": 0.5}, 1, -1), ({"throttle": 0.5}, 2, 1), ({"roll": 0.3}, 3, 1),
     ({"pitch": 0.3}, 4, -1), ({"yaw": 0.3}, 5, -1)],
)  # fmt: skip
def test_each_demand_moves_the_vehicle_its_way(sim: Simulator, demands: dict[str, float], axis: int, sign: int) -> None:
    """Demands are forward, right, up, and right-handed about forward, right, down; ours are forward, left, up."""
    with ArduSub(sim, port=0) as ardusub, Standin(ardusub.port, lambda state: mixed(ardusub.frame, **demands)):
        sim.step(80)
    velocity = np.array([*sim.rov.velocity.linear_body_m_s, *sim.rov.velocity.angular_body_rad_s])
    scale = np.array([1, 1, 1, 0.2, 0.2, 0.2])
    assert sign * velocity[axis] > 0.01 * scale[axis]
    assert int(np.argmax(np.abs(velocity / scale))) == axis


def test_steps_are_frames_and_a_silent_autopilot_ends_them(sim: Simulator) -> None:
    with ArduSub(sim, port=0, patience_s=0.2) as ardusub:
        with pytest.raises(SilentAutopilotError, match=r"no frame on UDP 127\.0\.0\.1"):
            sim.step(5)
        assert sim.tick == 0
        with Standin(ardusub.port, lambda state: [NEUTRAL] * 8, frames=3) as autopilot:
            with pytest.raises(SilentAutopilotError, match=r"since 0\.0075 s"):
                sim.step(5)
            assert sim.tick == len(autopilot.lines) == 3
    sim.step(5)  # freely again
    assert sim.tick == 8


def test_the_next_autopilot_finds_the_port_free(sim: Simulator) -> None:
    with ArduSub(sim, port=0) as ardusub:
        port = ardusub.port
    with ArduSub(sim, port=port):
        assert ardusub.peer == "" and ardusub.counts.frames == 0
    with pytest.raises(ValueError, match="is closed"):
        ardusub.start()


def test_lines_are_of_the_simulated_motion(sim: Simulator) -> None:
    def dive(state: dict[str, object]) -> list[int]:
        return mixed("vectored_6dof", throttle=-0.5, yaw=0.1)

    with ArduSub(sim, port=0) as ardusub, Standin(ardusub.port, dive) as autopilot:
        sim.step(400)
    line = autopilot.lines[399]
    east, north, up = sim.rov.pose.position_world_m
    np.testing.assert_allclose(line["position"], (north, east, -up), rtol=0, atol=1e-12)
    axes = sim.rov.pose.world_from_body[:3, :3]
    east, north, up = axes @ sim.rov.velocity.linear_body_m_s
    np.testing.assert_allclose(line["velocity"], (north, east, -up), rtol=0, atol=1e-12)
    altitude = sim.rov.sensors["altitude"].read(noise=False)
    assert line["rng_1"] == pytest.approx(altitude, abs=0.02)
    w, x, y, z = line["quaternion"]  # heading from north, to the right
    heading = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    assert heading == pytest.approx(np.arctan2(axes[0, 0], axes[1, 0]), abs=1e-9)
    imu = sim.rov.sensors["imu"].read(noise=False)
    np.testing.assert_allclose(line["imu"]["gyro"], imu.angular_velocity_rad_s * (1, -1, -1), atol=1e-12)
    np.testing.assert_allclose(line["imu"]["accel_body"], imu.linear_acceleration_m_s2 * (1, -1, -1), atol=1e-12)


def wandering(frame: str = "vectored_6dof") -> Callable[[dict[str, object]], list[int]]:
    """Return an autopilot that holds a depth of 4 m by the lines it gets, and yaws to and fro."""

    def decide(state: dict[str, object]) -> list[int]:
        if not state:
            return [NEUTRAL] * 8
        down, speed = state["position"][2], state["velocity"][2]  # type: ignore[index]
        throttle = float(np.clip(1.5 * (down - 4) + 2 * speed, -0.6, 0.6))
        return mixed(frame, throttle=throttle, yaw=0.2 * float(np.sin(state["timestamp"])), forward=0.2)  # type: ignore[call-overload]

    return decide


def test_a_recording_of_its_flight_replays_to_the_byte_whatever_the_wall_clock(
    scenario: Scenario, tmp_path: Path
) -> None:
    """The servo outputs are in the recording, by their ticks: no autopilot is needed to repeat it.

    Frames that come late are written with the others: only ticks decide where a command with frames ends.
    """

    def flown(path: Path, late: dict[int, float]) -> list[Recorded]:
        sim, decide = Simulator(scenario), wandering()
        count = iter(range(10_000))

        def late_decide(state: dict[str, object]) -> list[int]:
            time.sleep(late.get(next(count), 0.0))
            return decide(state)

        with (
            Recorder(sim, path, topics=["odom", "imu"]),
            ArduSub(sim, port=0) as ardusub,
            Standin(ardusub.port, late_decide),
        ):
            sim.step(333)
            sim.rov.all_stop()
            sim.step(500)
            released_ns = sim.time_ns
            sim.rov.all_stop(False)
            sim.step(67)
        return [message for message in Recording(path).messages() if message.time_ns <= released_ns]

    one = flown(tmp_path / "1.mcap", {})
    other = flown(tmp_path / "2.mcap", {50: 0.12, 51: 0.07, 333: 0.1, 420: 0.15})
    assert one == other
    result = replay(tmp_path / "2.mcap")
    assert result.difference is None
    assert result.state_compared and result.messages["odom"] > 30


def test_pieces_of_frames_end_at_ticks_however_they_arrive() -> None:
    rng = np.random.default_rng(24)
    frames = rng.bytes(1500 * FRAME_BYTES)

    def pieces(cuts: list[int]) -> list[tuple[int, bytes]]:
        joined, found = JoinedFrames(), []
        for begin, end in zip([0, *cuts], [*cuts, 1500], strict=True):
            part = frames[begin * FRAME_BYTES : end * FRAME_BYTES]
            found += joined.add({"vehicle": "rov", "from_tick": 130 + begin, "frames": part})
        return [(piece["from_tick"], piece["frames"]) for piece in (*found, *joined.taken())]

    whole = pieces([])
    assert [tick for tick, _ in whole] == [130, 400, 800, 1200, 1600] and b"".join(part for _, part in whole) == frames
    for _ in range(20):
        assert pieces(sorted(rng.choice(np.arange(1, 1500), 30, replace=False).tolist())) == whole


def test_a_recorded_flight_of_the_firmware_ends_where_it_did(scenario: Scenario) -> None:
    """The frames of a compiled ArduSub (tools/trial), sent again: 88 s of diving, holding and moving.

    The vehicle takes the way that it took with the firmware, whose frames answered that way; positions may differ
    between kinds of CPU by rounding alone. The journalled frames lead to the same state, to the byte.
    """
    with np.load(RECORDED) as recorded:
        frames, flown = np.cumsum(recorded["differences_us"], axis=0, dtype=np.int16), recorded["positions_ned_m"]
    sent = iter(frames.tolist())
    by_packets, by_journal = Simulator(scenario), Simulator(scenario)
    for sim in (by_packets, by_journal):
        sim.rov.place((-15.0, -16.0, -1.0))
    with (
        ArduSub(by_packets, port=0) as ardusub,
        Standin(ardusub.port, lambda state: next(sent), frames=len(frames), every=400) as autopilot,
    ):
        by_packets.step(len(frames))
        counts, state = ardusub.counts, by_packets.save_state()
    padded = np.zeros((len(frames), FRAME_BYTES // 2), "<u2")
    padded[:, : frames.shape[1]] = frames
    by_journal.lockstep.play(by_journal, vehicle="rov", frame="vectored_6dof", from_tick=0, frames=padded.tobytes())
    by_journal.step(len(frames))
    assert (counts.frames, counts.lost, counts.resets) == (len(frames), 0, 0)
    np.testing.assert_allclose([line["position"] for line in autopilot.lines], flown, rtol=0, atol=1e-6)
    assert np.ptp(flown[:, 2]) > 3.0 and np.ptp(flown[:, 1]) > 0.8  # it dived, and moved
    assert by_journal.save_state() == state


def test_twice_the_same_frames_make_the_same_bytes(scenario: Scenario) -> None:
    def flown() -> bytes:
        sim = Simulator(scenario)
        with ArduSub(sim, port=0, with_noise=True) as ardusub, Standin(ardusub.port, wandering()):
            sim.step(400)
        return sim.save_state()

    assert flown() == flown()


def test_other_commands_are_refused_while_it_steers(sim: Simulator) -> None:
    with ArduSub(sim, port=0):
        with pytest.raises(ValueError, match="set_effort: has no effect while ArduSub steers"):
            sim.rov.set_effort(surge=1)
        with pytest.raises(ValueError, match="set_thrusters: has no effect while ArduSub steers"):
            sim.rov.set_thrusters({"front_left": 1})
        sim.rov.set_wrench((0, 0, 0))
        sim.rov.set_thrusters({})
        with pytest.raises(ValueError, match="vehicle 'rov': an autopilot flies it already"):
            ArduSub(sim, port=0).start()
    sim.rov.set_effort(surge=1)


@pytest.fixture
def live(sim: Simulator) -> Iterator[LiveSimulator]:
    with LiveSimulator(sim, speed="max") as live:
        yield live


def test_a_live_simulator_pauses_with_it_and_answers_meanwhile(
    live: LiveSimulator, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.WARNING)
    with ArduSub(live, port=0) as ardusub:
        at = live.tick
        until(lambda: "waits for its first frame" in caplog.text)
        assert live.tick == at
        with Standin(ardusub.port, wandering(), frames=50):
            until(lambda: live.tick == at + 50)
            until(lambda: "the world is paused" in caplog.text)
        began_s = time.monotonic()
        assert live.read(lambda sim: sim.tick).result() == at + 50
        assert time.monotonic() - began_s < 1.0
        with Standin(ardusub.port, wandering(), frames=50):
            until(lambda: live.tick == at + 100)
        assert "started again" in caplog.text and "arrive again" in caplog.text
        live.pause()
    end, state = live.tick, live.read(lambda sim: sim.save_state()).result()
    assert replay_log(Simulator(live.simulator.scenario), live.log, end).save_state() == state


def test_a_diverging_motion_ends_in_an_error_and_no_line_has_a_nan(sim: Simulator) -> None:
    with ArduSub(sim, port=0) as ardusub, Standin(ardusub.port, lambda state: [NEUTRAL] * 8) as autopilot:
        sim.step(5)
        sim.parameters["rov.drag.linear.surge"] = 1e6  # too stiff for the step
        sim.rov.place((0.0, 0.0, -5.0), velocity_body=(5.0, 0.0, 0.0, 0.0, 0.0, 0.0))
        with pytest.raises(ValueError, match=r"vehicle 'rov'.*the motion diverged"):
            sim.step(200)
    assert np.isfinite([line["position"] + line["imu"]["gyro"] for line in autopilot.lines]).all()


def test_hostile_packets_get_one_line_each(sim: Simulator, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.WARNING)
    with ArduSub(sim, port=0) as ardusub, Standin(ardusub.port, wandering()):
        sim.step(10)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as foe:
            foe.connect(("127.0.0.1", ardusub.port))
            for _ in range(3):
                for bad in (b"", b"x", packet(7, [1100] * 8)[:-1], packet(0, [1900] * 8), b"\xff" * 3000):
                    foe.send(bad)
                sim.step(10)
        assert sim.tick == 40
        counts = ardusub.counts
        assert (counts.foreign, counts.cut, counts.others, counts.lost) == (9, 3, 3, 0)
    for words in ("no servo packets", "wrong length", "second autopilot"):
        assert caplog.text.count(words) == 1, caplog.text
