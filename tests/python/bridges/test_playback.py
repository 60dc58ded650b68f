"""Playing a recording to ROS 2 and Foxglove sends exactly the recorded bytes."""

import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command_line import error_line, uwsim
from foxglove_client import FoxgloveClient
from ros2_tools import free_domain, peer, until
from uwsim import Simulator, recording
from uwsim.bridges.playback.feed import PlayedFeed, channels_of
from uwsim.bridges.playback.playback import play
from uwsim.bridges.requested import PlayedBridges
from uwsim.bridges.ros2 import Ros2Settings
from uwsim.recording import Recorder
from uwsim.recording.replay import Pacer

TOPICS = ("odom", "scan", "laserPointCloud", "tf_static", "sonar_ping", "clock", "telemetry")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("playback") / "run.mcap"
    sim = Simulator("pool", seed=3)
    with Recorder(sim, path, topics=TOPICS):
        sim.rov.undock()
        sim.rov.set_effort(surge=0.5)
        sim.advance(3.0)
    return path


def bridges(domain_id: int, distro: str = "jazzy") -> PlayedBridges:
    chosen = PlayedBridges(ros2=True, ros_distro=distro, ros_domain_id=domain_id, foxglove=True, foxglove_port=0)
    chosen.prepare()
    return chosen


def test_it_plays_the_recorded_bytes_to_ros_2_and_foxglove(run: Path) -> None:
    opened = recording.open(run)
    settings = Ros2Settings(domain_id=free_domain())
    said: list[str] = []
    chosen = bridges(settings.domain_id)
    playing = threading.Thread(
        target=play,
        args=(opened, Pacer(2.0)),
        kwargs={"port": 0, "wait": True, "bridges": chosen, "say": said.append},
    )
    raw: dict[str, list[bytes]] = {"odom": [], "sonar_ping": [], "tf_static": []}
    with peer(settings) as other:
        for topic in raw:
            other.listen(topic, opened.channels[topic].type, latched=topic == "tf_static")
        playing.start()
        url = until(lambda: said)[0].split()[-1]
        with FoxgloveClient(url, "/odom") as app:
            app.subscribe("/scan")
            time_ns, scan = app.next("/scan")

        def is_over() -> bool:
            for topic, found in raw.items():
                found += other.bytes(topic)
            return len(said) == 2

        until(is_over)
        playing.join(60.0)
    count = sum(opened.channels[topic].message_count for topic in TOPICS)
    assert "ROS 2 jazzy" in said[0] and said[1] == f"{count:,} messages of {len(TOPICS)} channels"
    assert scan == next(m.data for m in opened.messages("scan") if m.time_ns == time_ns)
    for topic, found in raw.items():
        known = [recorded.data for recorded in opened.messages(topic)]
        assert found and len(found) > 0.5 * len(known) and set(found) <= set(known), topic


def test_whoever_comes_late_gets_what_is_latched_and_time_goes_on(run: Path) -> None:
    opened = recording.open(run)
    channels = {channel.name: channel for channel in channels_of(opened)}
    assert set(channels) == set(TOPICS) and channels["tf_static"].delivery.latched
    assert not channels["odom"].delivery.latched
    feed, late, times = PlayedFeed(), [], []
    end = feed.listen_time(0.5, times.append)
    for recorded in opened.messages(*channels):
        feed.play(channels[recorded.topic], recorded)
    feed.listen(channels["tf_static"], late.append)
    feed.listen(channels["odom"], late.append)
    (reading,) = late
    assert reading.message.transforms and feed.newest(channels["odom"]) is None and feed.is_wanted
    assert times == [round(0.5e9 * number) for number in range(7)]
    end()
    feed.play(channels["clock"], next(opened.messages("clock")))
    assert len(times) == 7


def test_whoever_comes_late_to_a_map_gets_all_of_it(tmp_path: Path) -> None:
    path, sim = tmp_path / "map.mcap", Simulator("pool", seed=3)
    with Recorder(sim, path, topics=["map_changes", "octomap_binary"]):
        sim.rov.undock()
        sim.rov.set_effort(surge=0.8, yaw=0.3)
        sim.advance(4.0)
    opened, late = recording.open(path), []
    feed = PlayedFeed(channels_of(opened))
    changes, grown = feed.channels["map_changes"], set()
    for recorded in opened.messages("map_changes"):
        feed.play(changes, recorded)
        grown = after(recorded.message, grown)
    feed.listen(changes, late.append)
    (reading,) = late
    assert reading.message.snapshot and after(reading.message, set()) == grown and len(grown) > 100
    message, cursor = changes.delivery.catch_up(None)
    assert after(message, set()) == grown and not len(changes.delivery.catch_up(cursor)[0].cells)
    feed.play(changes, next(opened.messages("map_changes")))  # time goes backwards
    assert after(feed.newest(changes).message, set()) < grown


def after(message: Any, voxels: set[tuple[int, ...]]) -> set[tuple[int, ...]]:
    """Return the occupied voxels after applying a message's changes."""
    blocks = np.repeat(message.blocks.reshape(-1, 3), message.counts, axis=0)
    inside = message.cells[:, None].astype(int) >> np.array([0, 4, 8]) & 15
    named = [tuple(row) for row in np.hstack([blocks, inside]).tolist()]
    now = {name for name, cell in zip(named, message.cells, strict=True) if cell & 0x8000}
    return (voxels - set(named)) | now


def test_an_option_without_effect_is_refused(run: Path) -> None:
    for options, said in (
        (["--ros2"], "--ros2: needs --as-topics"),
        (["--port", "9090", "--host", "127.0.0.1"], "--port, --host: need --as-topics"),
        (["--as-topics", "--ros-domain-id", "0"], "--ros-domain-id: needs --ros2"),
        (["--as-topics", "--ros2", "--ros-peer", "rov"], "--ros-peer: needs --ros-reach subnet"),
        (["--as-topics", "--threads", "1"], "--threads: needs a replay without --as-topics"),
    ):
        done = uwsim("replay", str(run), *options)
        assert done.returncode == 2 and error_line(done) == f"uwsim: error: {said}"
