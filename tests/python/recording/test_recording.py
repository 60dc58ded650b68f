"""A recording contains a run's messages and commands, readable and replayable however the run ended."""

import itertools
import json
import logging
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from pathlib import Path

import pytest
from mcap.reader import make_reader
from rosbags.rosbag2 import Reader

from channel_tools import stamp_ns
from client_socket import connect
from command_line import UWSIM, error_line, files_limited_to, uwsim
from uwsim import Simulator, recording
from uwsim.bridges import RosbridgeServer
from uwsim.channels import Channel, Table, channels
from uwsim.channels.delivery.feed import Feed, Reading
from uwsim.channels.ros.build import message
from uwsim.channels.served import served_table
from uwsim.live import LiveSimulator
from uwsim.recording import Recorder
from uwsim.recording.capsule import pack, unpack
from uwsim.recording.cli.recording import recording as list_recording
from uwsim.recording.mcap_sink import McapSink
from uwsim.recording.moments import picture_cost_text
from uwsim.recording.replay import replay
from uwsim.scenario import load
from uwsim.scenario.fingerprint import scenario_fingerprint

NO_PICTURES = ("camera/*", "image*", "*/picture/*", "*/image")
QUICK = ("odom", "scan", "imu", "sonar_ping", "octomap_binary", "tf_static")


def fly(sim: Simulator) -> None:
    sim.rov.undock()
    sim.rov.set_effort(surge=0.6, yaw=0.1)
    sim.advance(1.0)
    sim.rov.sonar.aim(-0.6)
    sim.rov.lamps["front"].on = True
    sim.advance(1.5)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recording") / "run.mcap"
    sim = Simulator("lake", seed=3)
    with Recorder(sim, path, without=NO_PICTURES):
        fly(sim)
    return path


def test_a_light_recording_omits_pictures_maps_and_what_is_published_twice(tmp_path: Path) -> None:
    sim = Simulator("pool", seed=3)
    kept = {}
    for is_light in (False, True):
        path = tmp_path / f"{is_light}.mcap"
        with Recorder(sim, path, is_light=is_light):
            pass
        with path.open("rb") as file:
            summary = make_reader(file).get_summary()
        assert summary is not None
        schemas = summary.schemas
        kept[is_light] = {channel.topic: schemas[channel.schema_id].name for channel in summary.channels.values()}
    omitted = kept[False].items() - kept[True].items()
    twice = {f"/{name}" for name in Table(sim).published}
    heavy = [(topic, kind) for topic, kind in omitted if topic not in twice]
    kinds = {"CompressedImage", "Image", "CameraInfo", "ProjectedSonarImage", "Octomap", "MapChanges"}
    assert {kind.rpartition("/")[2] for _, kind in heavy} == kinds
    assert not [kind for kind in kept[True].values() if kind.rpartition("/")[2] in kinds]
    assert "/depthArray" in twice and not twice & kept[True].keys()
    assert {"/sonar_ping", "/odom", "/scan", "/uwsim/commands"} <= kept[True].keys()
    assert "5 cameras" in picture_cost_text(sim)


def test_every_channel_is_in_it_at_its_rate_in_simulated_time(run: Path) -> None:
    opened = recording.open(run)
    sim = Simulator("lake", seed=3)
    usual = [c for c in channels(sim) if c.direction == "out" and not c.delivery.on_request]
    said = {c.name for c in usual if not c.delivery.late}
    assert set(opened.channels) == said | {"uwsim/commands", "sonar_ping"}
    times = [recorded.time_ns for recorded in opened.messages("odom")]
    assert times == list(range(0, 2_500_000_001, 20_000_000))
    odometry = next(opened.messages("/odom")).message
    assert stamp_ns(odometry) == 0 and odometry.child_frame_id == "base_footprint"
    commands = [(0, "undock"), (0, "set_effort"), (200, "aim"), (200, "set_lamp")]
    assert [(c.tick, c.name) for c in opened.commands()] == commands
    assert opened.complete and not opened.dropped


def test_mcap_and_rosbags_read_it_with_schemas_hashes_and_qos(run: Path) -> None:
    counts = Counter(recorded.topic for recorded in recording.open(run).messages())
    with run.open("rb") as file:
        summary = make_reader(file, validate_crcs=True).get_summary()
        assert summary is not None and summary.statistics is not None
        assert summary.statistics.message_count == counts.total()
        assert {index.compression for index in summary.chunk_indexes} == {"lz4"}
        assert {index.name for index in summary.metadata_indexes} >= {"rosbag2"}
        scan = next(c for c in summary.channels.values() if c.topic == "/scan")
        assert scan.metadata["topic_type_hash"].startswith("RIHS01_")
        assert "reliable" in scan.metadata["offered_qos_profiles"]
    with Reader(run) as reader:
        assert {c.topic.removeprefix("/"): c.msgcount for c in reader.connections if c.msgcount} == dict(counts)
        (static,) = (c for c in reader.connections if c.topic == "/tf_static")
        assert static.ext.offered_qos_profiles[0].durability.name == "TRANSIENT_LOCAL"
        assert sum(1 for _ in reader.messages()) == counts.total()


def test_a_replay_says_the_same_bytes_and_ends_in_the_same_state(run: Path) -> None:
    result = replay(run)
    assert result.difference is None and result.state_compared and result.commands == 4
    assert result.messages.total() == sum(info.message_count for info in recording.open(run).channels.values()) - 4


def test_a_changed_byte_is_found_and_said_by_how_much(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from uwsim.recording import replay as module

    execute = module._Replay._execute

    def weaker(self: object, command: recording.Command) -> None:
        if "surge" in command.arguments:
            command = command._replace(arguments={**command.arguments, "surge": 0.59})
        execute(self, command)

    monkeypatch.setattr(module._Replay, "_execute", weaker)
    result = replay(run)
    assert result.difference is not None and result.difference.startswith("tick ")
    assert " and " in result.difference


def test_a_run_of_another_thread_s_commands_with_resets_replays(tmp_path: Path) -> None:
    path = tmp_path / "live.mcap"
    with LiveSimulator("lake", speed="max", paused=True) as live:
        state = live.read(lambda sim: sim.save_state()).result()
        live.step(30)  # a recording may start at any time
        with Recorder(live, path, topics=QUICK):
            live.rov.undock()
            live.rov.set_effort(heave=-0.5)
            live.step(101)
            live.call(lambda sim: sim.rov.sonar.aim(0.2)).result()
            live.command("set_parameter", name="rov.drag.linear.surge", value=44.5).result()
            live.step(33)
            live.reset(state)
            live.rov.release()
            live.step(50)
            live.call(lambda sim: sim.reset(seed=11)).result()
            live.step(40)
    result = replay(path)
    assert result.difference is None and result.state_compared
    assert result.sim.seed == 11 and result.sim.tick == 40


def test_a_recording_that_begins_in_the_middle_of_a_run_replays(tmp_path: Path) -> None:
    path = tmp_path / "late.mcap"
    with LiveSimulator("lake", speed="max", paused=True) as live:
        shared = Table(live.simulator)
        named = {channel.name: channel for channel in shared.channels}
        live.rov.undock()
        for name in ("scan", "octomap_binary"):  # another subscriber is already listening
            live.every(1.0 / (named[name].rate_hz or 1.0), named[name].read, lambda message: None)
        live.step(37)
        with Recorder(live, path, topics=QUICK, shared=shared):
            live.rov.set_effort(surge=0.4)
            live.step(100)
    result = replay(path)
    assert result.difference is None and result.state_compared
    assert result.not_compared == ["octomap_binary"]  # it includes a ping from before the recording


def test_on_the_wall_clock_a_slow_disk_costs_messages_and_never_a_step(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    stuck = threading.Event()
    write = McapSink.write
    monkeypatch.setattr(McapSink, "write", lambda *arguments: stuck.wait(180) and write(*arguments))
    path = tmp_path / "slow.mcap"
    with LiveSimulator("lake", speed=2.0) as live, caplog.at_level(logging.WARNING):
        recorder = Recorder(live, path, topics=QUICK, queue_bytes=20_000).start()
        tick = live.simulator.tick
        live.rov.undock()
        live.clock.wait(1.0)
        assert live.simulator.tick >= tick + 200
        stuck.set()
        recorder.close()
    assert recorder.dropped.total() > 0 and "left out" in caplog.text
    opened = recording.open(path)
    assert opened.dropped == dict(recorder.dropped)
    assert [command.name for command in opened.commands()] == ["undock"]  # commands are never left out
    result = replay(path)
    assert result.difference is None and result.left_out.total() > 0


CHILD = """
import sys
from uwsim import Simulator
from uwsim.recording import Recorder
sim = Simulator("pool", seed=3)
with Recorder(sim, sys.argv[1], topics=["odom", "scan", "imu"]):
    sim.rov.undock()
    sim.rov.set_effort(surge=0.4)
    while True:
        sim.advance(0.5)
        print(sim.time_ns, flush=True)
"""


def test_after_a_kill_all_but_the_last_second_reads_and_replays(tmp_path: Path) -> None:
    path = tmp_path / "killed.mcap"
    process = subprocess.Popen([sys.executable, "-c", CHILD, str(path)], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    process.stdout.readline()
    size = path.stat().st_size
    # Until at least one flush is complete
    while path.stat().st_size < size + 50_000 or "odom" not in recording.open(path).channels:
        process.stdout.readline()
    process.send_signal(signal.SIGKILL)
    process.wait()
    opened = recording.open(path)
    assert not opened.complete and opened.channels["odom"].message_count > 10
    times = [recorded.time_ns for recorded in opened.messages("odom")]
    assert times == list(range(0, times[-1] + 1, 20_000_000))
    result = replay(opened)
    assert result.difference is None and not result.state_compared
    whole = path.read_bytes()
    last = -1
    for size in range(len(whole) // 2, len(whole), len(whole) // 7):
        cut = tmp_path / f"{size}.mcap"
        cut.write_bytes(whole[:size])
        odom = recording.open(cut).channels.get("odom")  # None if cut before the first chunk
        counted = odom.message_count if odom else 0
        assert counted >= last
        last = counted


@pytest.mark.parametrize("name", ["lake", "pair"])
def test_a_scenario_comes_back_from_a_recording_alone(name: str, tmp_path: Path) -> None:
    scenario = load(name)
    contents = pack(scenario)
    plain = json.loads(contents["scenario.json"])
    for mesh in (plain["station"]["mesh"], *(vehicle["model"]["mesh"] for vehicle in plain["vehicles"])):
        mesh["path"] = "/nowhere/mesh.obj"
    contents["scenario.json"] = json.dumps(plain).encode()
    assert scenario_fingerprint(unpack(contents, tmp_path)) == scenario_fingerprint(scenario)


def test_debian_s_rosbag_reads_a_bag_of_ros_1(tmp_path: Path) -> None:
    path = tmp_path / "run.bag"
    sim = Simulator("lake", seed=3)
    with Recorder(sim, path, topics=["odom", "scan", "tf*"]):
        fly(sim)
    script = (
        "import rosbag, sys\n"
        "with rosbag.Bag(sys.argv[1]) as bag:\n"
        "    found = [(topic, m) for topic, m, _ in bag.read_messages()]\n"
        "scans = [m for topic, m in found if topic == '/scan']\n"
        "assert [m.header.seq for m in scans] == list(range(len(scans)))\n"
        "print(sum(topic == '/odom' for topic, _ in found), len(scans[-1].ranges))\n"
    )
    python = "/usr/bin/python3"
    if subprocess.run([python, "-c", "import rosbag"], capture_output=True, check=False).returncode:
        pytest.skip("Debian's python3-rosbag is not installed")
    done = subprocess.run([python, "-c", script, str(path)], capture_output=True, text=True, check=False)
    assert done.stdout.split() == ["126", "513"], done.stderr


def test_mistakes_are_met_at_the_door(tmp_path: Path) -> None:
    sim = Simulator("lake")
    taken = tmp_path / "taken.mcap"
    taken.write_bytes(b"mine")
    with pytest.raises(FileExistsError, match=r"taken.mcap': exists already"):
        Recorder(sim, taken).start()
    assert "taken.mcap': exists already" in error_line(uwsim("serve", "pool", "--port", "0", "--record", taken))
    assert taken.read_bytes() == b"mine"
    with pytest.raises(OSError, match=r"nowhere.*cannot be written: No such file"):
        Recorder(sim, tmp_path / "nowhere" / "run.mcap").start()
    with pytest.raises(ValueError, match=r"must end in \.mcap, or in \.bag"):
        Recorder(sim, tmp_path / "run.txt")
    with pytest.raises(ValueError, match="topic 'scam': no channel has that name; there are"):
        Recorder(sim, tmp_path / "run.mcap", topics=["scam"])
    with pytest.raises(ValueError, match="was not written by uwsim"):
        recording.open(taken)
    assert list(tmp_path.iterdir()) == [taken]


def test_a_full_disk_ends_the_recording_and_not_the_run(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", CHILD.replace("while True", "for _ in range(6)"), str(tmp_path / "run.mcap")],
        capture_output=True, text=True, check=False, preexec_fn=files_limited_to(200_000),
    )  # fmt: skip
    assert done.stdout.split()[-1] == str(3_000_000_000)
    assert "OSError" in done.stderr and "run.mcap" in done.stderr.splitlines()[-1]
    assert not recording.open(tmp_path / "run.mcap").complete


def test_uwsim_recording_lists_what_a_file_holds(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    list_recording(run)
    said = capsys.readouterr().out
    assert "scenario lake, seed 3" in said and "from 0 s to 2.5 s" in said and "1 undock" in said
    assert " 126  /odom " in said and "nav_msgs/msg/Odometry" in said
    list_recording(run, as_json=True)
    values = json.loads(capsys.readouterr().out)
    assert (values["scenario"], values["seed"], values["to_s"], values["commands"]["undock"]) == ("lake", 3, 2.5, 1)
    assert values["channels"]["/odom"]["messages"] == 126 and values["is_whole"]


def test_uwsim_replay_says_what_it_found(run: Path, tmp_path: Path) -> None:
    done = uwsim("replay", str(run), "--until", "1.0")
    assert done.returncode == 0 and done.stdout.startswith("the same bytes: "), done.stderr
    found = json.loads(uwsim("replay", str(run), "--until", "1.0", "--json").stdout)
    assert found["same"] and found["difference"] is None and found["channels"]["/odom"] == 51
    assert "must be 0 or more" in error_line(uwsim("replay", str(run), "--from", "2", "--until", "1"))
    assert "No such file" in error_line(uwsim("replay", str(tmp_path / "none.mcap")))


def test_a_recording_plays_to_rosbridge_clients(run: Path) -> None:
    heard: list[dict[str, object]] = []
    command = [*UWSIM, "replay", str(run), "--as-topics", "--port", "0", "--wait", "--speed", "2", "--from", "0.5"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    url = process.stdout.readline().split()[-1]
    with connect(url) as client:
        for topic in ("/tf_static", "/odom"):
            client.send(json.dumps({"op": "subscribe", "topic": topic}))
        for _ in range(40):
            heard.append(json.loads(client.recv(timeout=180)))
        output, _ = process.communicate(timeout=180)
    topics = Counter(str(message["topic"]) for message in heard)
    assert topics["/tf_static"] == 1 and topics["/odom"] == 39  # latched messages are included even from before --from
    assert "messages of" in output and process.returncode == 0


def test_other_sinks_get_the_recorded_readings(tmp_path: Path) -> None:
    numbers, heard = itertools.count(), list[Reading]()
    counted = Channel(
        "counted", "std_msgs/msg/UInt32", "out", "", rate_hz=10.0,
        read=lambda sim: message("std_msgs/msg/UInt32", data=next(numbers)),
    )  # fmt: skip
    path = tmp_path / "shared.mcap"
    with LiveSimulator("pool", speed="max") as live:
        feed, table = Feed(live), Table(live.simulator)
        table.channels = [counted]
        with Recorder(live, path, topics=["counted"], shared=table, feed=feed):
            end = feed.listen(counted, heard.append)
            deadline_s = time.monotonic() + 180.0
            while len(heard) <= 10 and time.monotonic() < deadline_s:
                time.sleep(0.01)
            end()
    recorded = {found.message.data: (found.time_ns, found.data) for found in recording.open(path).messages("counted")}
    assert len(heard) > 10
    for reading in heard[1:]:  # the first subscriber in a tick causes the reading
        assert recorded[reading.message.data] == (reading.time_ns, reading.cdr)


def test_a_run_flown_over_rosbridge_replays_to_the_same_bytes(tmp_path: Path) -> None:
    path = tmp_path / "flown.mcap"
    with LiveSimulator("lake", speed=2.0) as live:
        table, feed = served_table(live), Feed(live)
        recorder = Recorder(live, path, topics=[*QUICK, "diagnostics", "cmd_vel"], shared=table, feed=feed)
        server = RosbridgeServer(
            live, channels=recorder.record_received(table.channels), services=table.services, feed=feed
        )
        with recorder, server, connect(server.url) as client:

            def send(**operation: object) -> None:
                client.send(json.dumps(operation))

            send(op="subscribe", topic="/scan")  # another client reads the same pings
            send(op="call_service", service="/undock")
            send(op="publish", topic="/cmd_vel", msg={"linear": {"x": 0.5}, "angular": {"z": 0.1}})
            live.clock.wait(1.0)
            send(op="publish", topic="/cmd_tilt", msg={"data": 0.4})
            send(op="call_service", service="/lights/front", args={"data": True})
            live.clock.wait(1.0)
            send(op="call_service", service="/simulation/reset")
            while not any(entry.name == "reset" for entry in live.log):
                time.sleep(0.02)
            time.sleep(0.2)
    opened = recording.open(path)
    names = Counter(command.name for command in opened.commands())
    assert names["undock"] == names["aim"] == names["set_lamp"] == names["restore_state"] == 1
    assert names["set_effort"] >= 20  # from the control loop of /cmd_vel
    assert [heard.message.linear.x for heard in opened.messages("cmd_vel")] == [0.5]
    result = replay(opened)
    assert result.difference is None and result.state_compared and result.not_compared == ["diagnostics"]
