"""A tape has what a reading at each tick would have been, and a file of many messages at once is a usual one."""

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import CompressionType, Writer

from uwsim import Simulator
from uwsim.channels import Table
from uwsim.channels.ros.cdr import encode
from uwsim.recording import Recorder, mcap_file
from uwsim.recording import open as open_recording
from uwsim.recording.mcap_file import McapFile
from uwsim.recording.replay import replay
from uwsim.recording.watch import Watch

Message = tuple[str, int, bytes]


def dive(sim: Simulator) -> None:
    sim.rov.undock()
    sim.rov.set_effort(surge=0.6, yaw=0.3, heave=-0.2)
    sim.advance(0.51)
    sim.rov.sonar.aim(0.4)
    sim.advance(0.7)


def disturb(sim: Simulator) -> None:
    dive(sim)
    sim.parameters["rov.sensors.depth.on"] = False
    sim.advance(0.3)
    sim.parameters["rov.sensors.depth.on"] = True
    name = sim.faults.inject("sensor", sensor="compass", mode="bias", bias=0.1)
    sim.advance(0.3)
    sim.faults.end(name)
    next(camera for camera in sim.rov.cameras.values() if camera.mount.pan_tilt is not None).aim(pan_rad=0.2)
    sim.parameters["rov.sonar.model"] = 4  # the last ping has another number of beams
    sim.advance(0.2)
    sim.reset(seed=5)
    dive(sim)


@pytest.mark.parametrize(("scenario", "act"), [("pool", dive), ("pool", disturb), ("reef", dive)])
def test_what_is_taped_is_what_is_read_at_each_tick(scenario: str, act: Callable[[Simulator], None]) -> None:
    read: list[Message] = []
    taped: list[Message] = []
    counts = {"stretches": 0}
    for found, tapes in ((read, False), (taped, True)):
        sim = Simulator(scenario, seed=3)

        def one(channel: Any, message: Any, sim: Simulator = sim, found: list[Message] = found) -> None:
            found.append((channel.name, sim.time_ns, bytes(encode(message))))

        def many(stretches: Any) -> None:
            for channel, times_ns, data in stretches:
                counts["stretches"] += 1
                taped.extend(
                    (channel.name, time_ns, each) for time_ns, each in zip(times_ns.tolist(), data, strict=True)
                )

        chosen = [c for c in Table(sim).channels if c.taped is not None]
        assert len(chosen) > 12
        watch = Watch(sim, chosen, one, tape=many if tapes else None)
        watch.start()
        act(sim)
        watch.stop()
    assert counts["stretches"] > 12
    assert sorted(read) == sorted(taped)


def test_what_a_recorder_holds_back_is_in_order_of_time_with_commands_after_the_readings_of_their_tick(
    tmp_path: Path,
) -> None:
    sim = Simulator("pool", seed=3)
    sim.rov.undock()
    with Recorder(sim, tmp_path / "run.mcap", topics=["odom", "telemetry", "imu"]):
        for _ in range(20):
            sim.rov.set_effort(surge=0.5)
            sim.advance(0.1)
    found = [(each.time_ns, each.topic) for each in open_recording(tmp_path / "run.mcap").messages()]
    assert [time_ns for time_ns, _ in found] == sorted(time_ns for time_ns, _ in found)
    assert {topic for _, topic in found} == {"odom", "telemetry", "imu", "uwsim/commands"}
    at = [topic for time_ns, topic in found if time_ns == 1_000_000_000]
    assert at == ["odom", "telemetry", "imu", "uwsim/commands"]


def test_a_vehicle_s_description_is_recorded_once_and_when_it_changes(tmp_path: Path) -> None:
    path, sim = tmp_path / "run.mcap", Simulator("pool", seed=3)
    with Recorder(sim, path, topics=["robot_description", "link"]):
        sim.advance(1.0)
        sim.parameters["rov.mass_kg"] = 300.0
        sim.advance(1.0)
        sim.reset(seed=3)
    times_s = [1e-9 * each.time_ns for each in open_recording(path).messages("robot_description")]
    assert times_s == pytest.approx([0.0, 1.1, 0.0])
    assert replay(path).difference is None


def test_a_file_is_byte_for_byte_that_of_the_mcap_library(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mcap_file, "CHUNK_BYTES", 5000)
    ours, theirs = io.BytesIO(), io.BytesIO()
    draws = np.random.default_rng(3)
    channels, times_ns = draws.integers(1, 4, 400).tolist(), np.sort(draws.integers(0, 10**9, 400)).tolist()
    data = [bytes(draws.integers(0, 9, size).tolist()) for size in draws.integers(0, 300, 400)]
    numbers = list(range(400))

    library = Writer(theirs, chunk_size=5000, compression=CompressionType.LZ4, enable_data_crcs=True)
    library.start(profile="ros2", library="x")
    library.add_metadata("start", {"a": "b"})
    library.add_attachment(0, 0, "name", "text/plain", b"content")
    file = McapFile(ours, "ros2", "x")
    file.add_metadata("start", {"a": "b"})
    file.add_attachment("name", "text/plain", b"content")
    schema = library.register_schema("std_msgs/msg/Bool", "ros2msg", b"bool data")
    assert file.add_schema("std_msgs/msg/Bool", "ros2msg", b"bool data") == schema
    for name in "abc":
        number = library.register_channel(f"/{name}", "cdr", schema, {"k": name})
        assert file.add_channel(f"/{name}", "cdr", schema, {"k": name}) == number
    for channel, time_ns, number, each in zip(channels, times_ns, numbers, data, strict=True):
        library.add_message(channel, time_ns, each, time_ns, number)
    for part in (slice(0, 1), slice(1, 390), slice(390, 400)):
        file.add_messages(channels[part], times_ns[part], numbers[part], data[part])
    library.finish()
    file.finish()
    assert ours.getvalue() == theirs.getvalue()
