"""Frames follow REP 105, and two simulators or vehicles in one graph share no name by accident."""

import json
import subprocess

import numpy as np
import pytest

from channel_tools import chain, table
from client_socket import connect
from command_line import UWSIM
from uwsim import Simulator
from uwsim.channels import Channel, Table
from uwsim.channels.names import SHARED, channels_in, services_in


def parents(found: dict[str, Channel], sim: Simulator) -> dict[str, str]:
    """Return each frame's parent. A second one would tear the tree."""
    above: dict[str, str] = {}
    for name in ("tf", "tf_static"):
        for transform in found[name].read(sim).transforms:
            assert transform.child_frame_id not in above, transform.child_frame_id
            above[transform.child_frame_id] = transform.header.frame_id
    return above


def roots(above: dict[str, str]) -> set[str]:
    return set(above.values()) - above.keys()


@pytest.fixture(scope="module")
def sim() -> Simulator:
    sim = Simulator("pool", seed=3)
    _ = sim.rov.estimate  # which starts at the true pose
    sim.rov.release()
    sim.rov.set_effort(surge=0.5, yaw=0.2)
    sim.advance(3.0)
    return sim


@pytest.mark.parametrize("tf", ["truth", "odom", "none"])
def test_the_tree_is_world_map_odom_base_link_and_the_truth_and_the_estimate_have_topics(
    sim: Simulator, tf: str
) -> None:
    found = table(sim, tf=tf, origin="published")
    above, path = parents(found, sim), ["base_link"]

    def position_m(name: str) -> list[float]:
        point = found[name].read(sim).pose.pose.position
        return [point.x, point.y, point.z - 75.3]

    truth_m, estimate_m = sim.rov.pose.position_world_m, sim.rov.estimate.pose.position_world_m
    assert position_m("ground_truth/odom") == pytest.approx(truth_m, abs=1e-12)
    assert position_m("odometry/estimate") == pytest.approx(estimate_m, abs=1e-12)
    assert np.abs(truth_m - estimate_m).max() > 1e-6
    assert "odometry/filtered" not in found, "that is robot_localization's"
    if tf == "none":  # others may publish the motion
        assert roots(above) == {"world", "base_link"} and above["base_footprint"] == "base_link"
        assert "odom" not in above and "odom" not in above.values() and "odom" not in found
        assert above["map"] == "world"
        return
    while path[-1] in above:
        path.append(above[path[-1]])
    assert [frame for frame in path if frame != "base_footprint"] == ["base_link", "odom", "map", "world"]
    assert roots(above) == {"world"} and {"base_footprint", "base_scan", "imu_link"} <= above.keys()
    assert position_m("odom") == position_m({"truth": "ground_truth/odom", "odom": "odometry/estimate"}[tf])
    where = sim.rov.pose if tf == "truth" else sim.rov.estimate.pose
    np.testing.assert_allclose(chain(sim, found, "base_link"), where.world_from_body, atol=1e-9)


def names_and_frames(sim: Simulator, namespace: str) -> tuple[set[str], set[str]]:
    own = Table(sim, frame_prefix=f"{namespace}/")
    channels = channels_in(namespace, own.channels)
    frames = {channel.frame_id for channel in channels if channel.frame_id}
    above = parents({channel.name: channel for channel in channels}, sim)
    names = {channel.name for channel in channels} | {service.name for service in services_in(namespace, own.services)}
    return names, frames | above.keys() | set(above.values())


def test_two_simulators_in_their_namespaces_share_what_ros_shares_and_the_world(sim: Simulator) -> None:
    (first, first_frames), (second, second_frames) = (names_and_frames(sim, name) for name in ("auv_1", "fleet/auv_2"))
    assert first & second == SHARED - {"diagnostics"} and first_frames & second_frames == {"world"}
    assert "auv_1/scan" in first and "fleet/auv_2/simulation/pause" in second
    for name in ("9a", "a b", "a//b", "a-b", "ä"):
        with pytest.raises(ValueError, match=r"namespace = '.*': must be letters, digits and _"):
            channels_in(name, [])


def test_two_vehicles_are_in_their_own_namespaces_below_one_map() -> None:
    sim = Simulator("pair")
    found = table(sim)
    above = parents(found, sim)
    assert above["rov/odom"] == above["scout/odom"] == "map" and roots(above) == {"world"}
    own = [name for name in found if not name.startswith(("rov/", "scout/"))]
    assert set(own) <= {*SHARED, *(name for name in own if name.startswith(("camera/", "image")))}


def test_serve_takes_namespace_and_tf() -> None:
    arguments = [*UWSIM, "serve", "pool", "--port", "0", "--namespace", "/auv/", "--tf", "odom"]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            url = next(word.strip(",;:") for word in process.stdout.readline().split() if word.startswith("ws://"))
            with connect(url) as client:
                client.send(json.dumps({"op": "subscribe", "topic": "/auv/odom", "type": "nav_msgs/Odometry"}))
                message = json.loads(client.recv(180.0))["msg"]
        finally:
            process.terminate()
    assert (message["header"]["frame_id"], message["child_frame_id"]) == ("auv/odom", "auv/base_footprint")
    assert max(message["pose"]["covariance"]) > 0.0, "an estimate, not the truth"
