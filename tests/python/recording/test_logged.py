"""Simulator.log: a user's own values reach recordings and clients of rosbridge, and change nothing else."""

from pathlib import Path

from client_socket import connect, receive, send
from uwsim import Simulator
from uwsim.bridges import RosbridgeServer
from uwsim.live import LiveSimulator
from uwsim.recording import Recorder, Recording
from uwsim.recording.replay import replay


def test_values_are_recorded_and_the_replay_is_the_same(tmp_path: Path) -> None:
    sim, alone, path = Simulator("pool", seed=3), Simulator("pool", seed=3), tmp_path / "run.mcap"
    sim.log("/size", {"length_m": 0, "what": ""})
    with Recorder(sim, path, topics=["odom", "size/*"]):
        for k in range(3):
            sim.advance(0.1)
            sim.log("size", {"length_m": k, "what": f"fish {k}"})
    alone.advance(0.3)
    assert alone.save_state() == sim.save_state() and (repeated := replay(path)).state_compared
    found = [(each.time_ns, each.message.data) for each in Recording(path).messages("size/length_m", "size/what")]
    assert found == [(100_000_000 * (k + 1), value) for k in range(3) for value in (float(k), f"fish {k}")]
    assert repeated.difference is None and repeated.messages["odom"]


def test_a_client_of_rosbridge_gets_the_latest_value_and_those_after_it() -> None:
    with LiveSimulator("pool", paused=True) as live:
        live.simulator.log("/size", {"length_m": 1})
        with RosbridgeServer(live, port=0) as server, connect(server.url) as client:
            send(client, "subscribe", topic="/size/length_m")
            assert receive(client, op="publish")["msg"] == {"data": 1.0}
            live.read(lambda sim: sim.log("/size", {"length_m": 2.5})).result()
            assert receive(client, op="publish")["msg"] == {"data": 2.5}
