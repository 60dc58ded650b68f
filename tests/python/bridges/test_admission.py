"""Admission of clients: one rule for every socket on which any part of uwsim listens."""

import os
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest
from websockets.datastructures import Headers

from forked_programs import Programs
from listening_sockets import NOTHING, listening, status, upgrade
from ros1_tools import master, ros_is_installed
from ros2_tools import free_domain
from uwsim import Simulator
from uwsim.bridges.doors.admission import Door
from uwsim.recording import Recorder

TOKEN = "correct-horse"
EVIL = "http://evil.example"
PUBLISHER_UPDATE = b"""<?xml version='1.0'?><methodCall><methodName>publisherUpdate</methodName><params>
<param><value><string>/master</string></value></param><param><value><string>/cmd_vel</string></value></param>
<param><value><array><data><value><string>http://127.0.0.1:1/</string></value></data></array></value></param>
</params></methodCall>"""

REFUSED = {401, 403, NOTHING}
NO_SUCH_THING = {404, 405, 426, 501}  # statuses by which a server rejects a method or path regardless of who asks


def hold_to_the_law(pid: int, greeting: str, *, sockets: int, websockets: int, has_token: bool = True) -> None:
    """Check each listening socket of a program against the admission rule.

    sockets: the expected number of sockets; websockets: how many of them accept WebSockets.
    """
    ports = listening(pid)
    assert len(ports) == sockets, f"{greeting}: listens on {ports}"
    right = f"/?token={TOKEN}" if has_token else "/"
    admitting = 0
    for port in sorted(ports):
        rebound = f"evil.example:{port}"
        evil = {
            "a page of another site opens a WebSocket": upgrade(port, right, Origin=EVIL),
            "a sandboxed page": upgrade(port, right, Origin="null"),
            "a page of a file": upgrade(port, right, Origin="file://"),
            "a name that was made to point here": upgrade(port, right, Host=rebound, Origin=f"http://{rebound}"),
            "... of a page or file": status(port, path=right, Host=rebound),
            "... of Dask's own": status(port, path="/json/counts.json", Host=rebound),
            "another site's page loads something": status(port, path=right, Origin=EVIL),
            "it posts what needs no leave": status(
                port, "POST", "/", PUBLISHER_UPDATE, Origin=EVIL, Content_Type="text/plain"
            ),
        }
        if has_token:
            evil["no token"] = upgrade(port)
            evil["a wrong token"] = upgrade(port, "/?token=correct-house", Origin=f"http://127.0.0.1:{port}")
        for what, answer in evil.items():
            assert answer in REFUSED | NO_SUCH_THING, f"{greeting}: port {port}: {what}: {answer}"
        own = upgrade(port, right, Origin=f"http://127.0.0.1:{port}"), upgrade(port, right)
        assert own in ((101, 101), (404, 404), (NOTHING, NOTHING), (501, 501)), f"{greeting}: port {port}: {own}"
        if own == (101, 101):
            admitting += 1
            assert {*evil.values()} <= REFUSED, f"{greeting}: port {port}: {evil}"
    assert admitting == websockets, greeting


def test_every_socket_of_serve(tmp_path: Path, programs: Programs) -> None:
    """And a page is admitted where it is named."""
    app, station = "https://app.foxglove.dev", "app://station"
    command = ["serve", "pool", "--port", "0", "--token", TOKEN, "--station", "--foxglove", "--foxglove-port", "0"]
    command += ["--ros2", "--ros-domain-id", str(free_domain()), "--page", app, "--page", station]
    with ExitStack() as stack:
        environment, sockets = dict(os.environ), 2
        if ros_is_installed():
            environment |= stack.enter_context(master(tmp_path))
            command, sockets = [*command, "--ros1"], 4  # rospy adds XML-RPC and TCPROS
        program, greeting = stack.enter_context(programs.greeted(*command, env=environment))
        hold_to_the_law(program.pid, greeting, sockets=sockets, websockets=2)
        right = f"/?token={TOKEN}"
        answers = [
            [upgrade(port, right, Origin=origin) for origin in (app, station, f"{app}.evil.example", EVIL)]
            for port in listening(program.pid)
        ]
        assert answers.count([101, 101, 403, 403]) == 2, answers


def test_the_socket_of_the_station(programs: Programs) -> None:
    with programs.greeted("station", "--no-browser", "--port", "0", "--token", TOKEN) as (program, greeting):
        hold_to_the_law(program.pid, greeting, sockets=1, websockets=1)


def test_every_socket_of_a_playback(tmp_path: Path, programs: Programs) -> None:
    run, sim = tmp_path / "run.mcap", Simulator("pool", seed=3)
    with Recorder(sim, run, topics=("odom",)):
        sim.advance(0.5)
    options = ["--as-topics", "--wait", "--port", "0", "--foxglove", "--foxglove-port", "0", "--token", TOKEN]
    options += ["--speed", "0.001"]  # it ends when all is played, which begins with the first client
    with programs.greeted("replay", run, *options) as (program, greeting):
        hold_to_the_law(program.pid, greeting, sockets=2, websockets=2)


def test_every_socket_of_workers() -> None:
    work = (
        "import signal, sys, time\nfrom uwsim.campaigns.workers.dask_workers import local_workers\n"
        "if __name__ == '__main__':\n"
        "  signal.signal(signal.SIGTERM, lambda *_: sys.exit())\n"
        "  with local_workers(1):\n    print('workers', flush=True)\n    time.sleep(600)\n"
    )
    with subprocess.Popen([sys.executable, "-c", work], stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            greeting = process.stdout.readline()
            assert greeting, "it ended"
            # Dask: the scheduler and the worker each listen on one port for Dask's protocol and one for HTTP, plus the
            # nanny's.
            ports = listening(process.pid)
            hold_to_the_law(process.pid, greeting, sockets=len(ports), websockets=0, has_token=False)
        finally:
            process.terminate()


@pytest.mark.parametrize(
    ("page", "admits", "not_even"),
    [
        ("https://station.example:8080", "https://station.example:8080", "https://station.example"),
        ("https://Station.example/", "https://station.example", "http://station.example"),
        ("file://", "file://", "null"),
        ("app://station", "app://station", "app://other"),
    ],
)
def test_a_door_admits_the_page_that_is_named(page: str, admits: str, not_even: str) -> None:
    door = Door([page], "127.0.0.1")
    fields = {origin: Headers([("Host", "127.0.0.1:9090"), ("Origin", origin)]) for origin in (admits, not_even)}
    assert door.refusal(fields[admits], names_matter=False) is None
    assert door.refusal(fields[not_even], names_matter=False) is not None


@pytest.mark.parametrize(
    "page", ["station", "null", "*", "", "https://", "http:///x", "https://a.example/b", "https://a@b"]
)
def test_what_is_no_origin_is_refused(page: str) -> None:
    with pytest.raises(ValueError, match=r"must look like 'https://station.example:8080'"):
        Door([page], "127.0.0.1")
