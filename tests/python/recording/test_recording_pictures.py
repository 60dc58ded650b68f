"""Pictures of a live run, however late, equal those that a replay renders for the same simulated times."""

import itertools
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from channel_tools import stamp_ns
from client_socket import connect
from command_line import hears_ctrl_c, uwsim
from flown import with_small_cameras
from uwsim import Simulator, recording
from uwsim.channels.delivery.pictures import RATE_HZ, Pictures
from uwsim.channels.served import served_table
from uwsim.live import LiveSimulator
from uwsim.recording import Recorder
from uwsim.recording.commands import COMMANDS
from uwsim.recording.replay import replay
from uwsim.scenario.dump import write_scenario

GRID_NS = int(1e9 / RATE_HZ)
PICTURES = ("camera/front/*", "camera/down/*compressed", "camera/down/camera_info", "images/compressed")
DELAYS_NS = (30_000_000, 120_000_000, 60_000_000, 170_000_000, 260_000_000)
"""In simulated time, so independent of the machine's speed."""


class Slow(NamedTuple):
    """A renderer that is slow until `end` is called. begun_ns: the start times of the pictures so far."""

    begun_ns: list[int]
    end: Callable[[], None]

    def wait(self, live: LiveSimulator) -> None:
        """Return when several off-grid pictures have been started and, very likely, read."""
        deadline_s = time.monotonic() + 180.0
        while len(off_the_grid(self.begun_ns)) < 4:
            assert time.monotonic() < deadline_s
            live.clock.wait(0.1)
        live.clock.wait(0.5)


@pytest.fixture
def slow(monkeypatch: pytest.MonkeyPatch) -> Slow:
    return Slow(make_slow(monkeypatch.setattr), monkeypatch.undo)


def make_slow(patch: Callable[[Any, str, Any], object] = setattr) -> list[int]:
    """Delay each picture's rendering while the simulator keeps stepping; return the times at which pictures begin."""
    read_made, delays, begun_ns = Pictures.read_made, itertools.cycle(DELAYS_NS), list[int]()

    def read_slowly(self: Pictures, sim: Simulator, name: str, begin: Any, *part: Any) -> Any:
        def begin_slowly(stream: Any) -> Callable[[], Any]:
            make, moment_ns, until_ns = begin(stream), sim.time_ns, sim.time_ns + next(delays)
            begun_ns.append(moment_ns)

            def render() -> Any:
                give_up_s = time.monotonic() + 1.0  # in case the simulator stops stepping
                while moment_ns <= sim.time_ns < until_ns and time.monotonic() < give_up_s:
                    time.sleep(0.001)
                return make()

            return render

        return read_made(self, sim, name, begin_slowly, *part)

    patch(Pictures, "read_made", read_slowly)
    return begun_ns


def recorder(live: LiveSimulator, path: Path) -> Recorder:
    """Return a recorder of the pictures that a server offers."""
    return Recorder(live, path, topics=PICTURES, shared=served_table(live))


def off_the_grid(moments_ns: Iterable[int]) -> list[int]:
    """Return the times at which a replay takes no pictures of its own: not its start, not multiples of the period."""
    later = sorted(moments_ns)
    return [moment_ns for moment_ns in later if moment_ns % GRID_NS and moment_ns != later[0]]


def stamps_ns(path: Path) -> list[int]:
    """Return the time stamps of all recorded camera pictures."""
    opened = recording.open(path)
    cameras = [name for name in opened.channels if name.startswith(("camera/", "image"))]
    return [stamp_ns(each.message) for each in opened.messages(*cameras)]


def test_pictures_that_came_late_are_rendered_at_their_stamps(slow: Slow, tmp_path: Path) -> None:
    path = tmp_path / "live.mcap"
    with LiveSimulator(with_small_cameras(), speed=1.0) as live, recorder(live, path):
        live.rov.undock()
        live.rov.set_effort(surge=0.5)
        slow.wait(live)
    slow.end()
    assert off_the_grid(stamps_ns(path))
    result = replay(path)
    assert result.difference is None and result.state_compared
    recorded = recording.open(path).channels
    counts = Counter({name: info.message_count for name, info in recorded.items() if name != COMMANDS})
    assert result.messages == +counts
    assert result.messages["images/compressed"] > 1


def test_what_is_commanded_while_a_picture_is_rendered_is_not_in_it(slow: Slow, tmp_path: Path) -> None:
    """A command in the same tick as the start of a picture does not affect it either, whichever came first."""
    path = tmp_path / "live.mcap"
    with LiveSimulator(with_small_cameras(), speed=1.0) as live:
        offered = served_table(live)
        set_stream = next(each for each in offered.services if each.name == "camera/front/set_stream")
        with Recorder(live, path, topics=PICTURES, shared=offered):
            live.rov.release()
            for k in itertools.takewhile(lambda k: k < 6 or len(slow.begun_ns) < 16, range(200)):
                live.clock.wait(0.2)
                live.command("set_lamp", vehicle="rov", lamp="front", on=bool(k % 2)).result()
                live.command("set_parameter", name="rov.cameras.front.on", value=bool(k % 3)).result()
                live.clock.wait(0.15)
                live.command("set_parameter", name="rov.cameras.down.exposure", value=1.0 + 0.1 * (k % 6)).result()
                set_stream.call(live, {"width": 160 + 16 * (k % 6)})
            live.call(lambda sim: sim.reset(seed=11)).result()
            live.clock.wait(0.5)
    slow.end()
    result = replay(path)
    assert result.difference is None and result.state_compared
    assert result.messages.total() > 2


def test_a_run_flat_out_that_is_slowed_to_the_wall_clock_replays(slow: Slow, tmp_path: Path) -> None:
    path = tmp_path / "live.mcap"
    with LiveSimulator(with_small_cameras(), speed="max", paused=True) as live, recorder(live, path):
        live.step(20)
        live.speed = 1.0
        live.resume()
        slow.wait(live)
    slow.end()
    assert not recording.open(path).start.on_wall_clock
    assert recording.open(path).was_on_wall_clock
    assert replay(path).difference is None


def test_another_picture_is_found(slow: Slow, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "live.mcap"
    with LiveSimulator(with_small_cameras(), speed=1.0) as live, recorder(live, path):
        live.command("set_lamp", vehicle="rov", lamp="front", on=True).result()
        slow.wait(live)
    slow.end()
    from uwsim.recording import replay as module

    execute = module.execute
    dark = {"vehicle": "rov", "lamp": "front", "on": False}
    monkeypatch.setattr(module, "execute", lambda sim, own, it: execute(sim, own, it._replace(arguments=dark)))
    result = replay(path)
    assert result.difference is not None and "sees another picture at the time of its stamp" in result.difference


def test_uwsim_serve_with_a_slow_renderer_records_what_uwsim_replay_finds_again(tmp_path: Path) -> None:
    path = tmp_path / "served.mcap"
    write_scenario(tmp_path / "small.yaml", with_small_cameras())
    program = "from test_recording_pictures import make_slow; make_slow()\nfrom uwsim.cli import main; main()"
    places = os.pathsep.join(str(folder) for folder in Path(__file__).parents[:2])
    topics = [word for topic in PICTURES[1:] for word in ("--record-topic", topic)]
    served = ["serve", tmp_path / "small.yaml", "--port", "0", "--record", path, *topics, "--station"]
    options = {"stdout": subprocess.PIPE, "text": True, "env": os.environ | {"PYTHONPATH": places}}
    serving = subprocess.Popen([sys.executable, "-c", program, *served], preexec_fn=hears_ctrl_c, **options)
    assert serving.stdout is not None
    url = re.search(r"ws://[\d.]+:\d+", serving.stdout.readline())
    assert url is not None
    with connect(url[0], max_size=None) as client:  # another reader of the same pictures
        client.send('{"op": "subscribe", "topic": "/camera/down/image_raw/compressed"}')
        client.send('{"op": "subscribe", "topic": "/images/compressed"}')
        begun_ns = set[int]()
        while len(off_the_grid(begun_ns)) < 4:
            stamp = json.loads(client.recv(timeout=180))["msg"]["header"]["stamp"]
            begun_ns.add(stamp["secs"] * 1_000_000_000 + stamp["nsecs"])
            assert len(begun_ns) < 1000
    serving.send_signal(signal.SIGINT)
    serving.communicate(timeout=180)
    assert off_the_grid(stamps_ns(path))
    replayed = uwsim("replay", str(path))
    assert replayed.returncode == 0, replayed.stdout
    assert replayed.stdout.startswith("the same bytes: ")
    assert " and the state at the end" in replayed.stdout
