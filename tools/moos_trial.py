"""Fly missions of MOOS-IvP unmodified, but for the lines that launch the simulator and windows; see tools/moos-trial.

A mission's files are copied. Of their ANTLER blocks, lines are taken out that launch uSimMarine, which uwsim replaces,
and programs with windows. Ports stay as they are. The vehicle is a REMUS 100 in a deep, empty bay.
"""

from __future__ import annotations

import argparse
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from uwsim import Simulator
from uwsim.bridges.actions import actions_of
from uwsim.bridges.moos.client import Address, MoosClient
from uwsim.bridges.moos.plug import MoosOptions, MoosPlug
from uwsim.bridges.moos.wire import Message
from uwsim.bridges.plug import Context
from uwsim.channels.delivery.feed import Feed
from uwsim.channels.served import served_table
from uwsim.live import LiveSimulator
from uwsim.scenario import Scenario
from uwsim.scenario.read.validated import validated

TAKEN_OUT = re.compile(r"^\s*Run\s*=\s*(uSimMarine\w*|pMarineViewer|uMAC\w*|pRealm|pLogger)\b.*$", re.M | re.I)
BAY = {
    "name": "bay", "description": "an empty bay, 60 m deep", "mission_time_s": 3600, "water": {"density_kg_m3": 1026},
    "terrain": {"source": "noise", "size_m": [800, 800], "spacing_m": 10, "bed_depth_m": 60},
    "station": {"position_m": [60, -70, 0], "dock_m": [0, 0, -2]},  # near, for the fixes of its USBL
    "earth": {"latitude_deg": 43.8253, "longitude_deg": -70.3304},
}  # fmt: skip


class Mission(NamedTuple):
    """A mission.

    files: of communities with a vehicle, by name. starts: x, y, depth [m], yaw [deg] by name. shore: the file of the
    shoreside, or "". pokes: what starts it. passes: whether a track (n, 4) of NAV_X, Y, DEPTH, SPEED is what the
    mission is for, and a text that says why.
    """

    files: dict[str, str]
    starts: dict[str, tuple[float, float, float, float]]
    shore: str
    pokes: dict[str, str]
    lasts_s: float
    passes: Callable[[Any], tuple[bool, str]]


def visits(points: list[tuple[float, float]], radius_m: float) -> Callable[[Any], tuple[bool, str]]:
    """Return the check that a track comes near all points."""

    def check(track: Any) -> tuple[bool, str]:
        nearest = [float(np.linalg.norm(track[:, :2] - each, axis=1).min()) for each in points]
        shown = ", ".join(f"{each:.1f}" for each in nearest)
        return max(nearest) <= radius_m, f"passes {len(points)} points at {shown} m (at most {radius_m:g})"

    return check


def stays(point: tuple[float, float], radius_m: float, since: float) -> Callable[[Any], tuple[bool, str]]:
    """Return the check that the last part of a track, from a share of it on, stays near a point."""

    def check(track: Any) -> tuple[bool, str]:
        last = track[int(since * len(track)) :]
        farthest = float(np.linalg.norm(last[:, :2] - point, axis=1).max())
        return farthest <= radius_m, f"stays within {farthest:.1f} m of {point} (at most {radius_m:g})"

    return check


def dives(depth_m: float, within_m: float) -> Callable[[Any], tuple[bool, str]]:
    """Return the check that the last half of a track is at a depth, in the median."""

    def check(track: Any) -> tuple[bool, str]:
        median = float(np.median(track[len(track) // 2 :, 2]))
        return abs(median - depth_m) <= within_m, f"median depth {median:.2f} m (wanted {depth_m:g})"

    return check


DEPLOY = {"DEPLOY": "true", "MOOS_MANUAL_OVERRIDE": "false", "MOOS_MANUAL_OVERIDE": "false"}
MISSIONS = {
    "s1_alpha": Mission(
        {"alpha": "alpha.moos"}, {"alpha": (0, -20, 3, -90)}, "", DEPLOY, 600,
        visits([(60, -40), (60, -160), (150, -160), (180, -100), (150, -40)], 15),
    ),
    "station-keep-uuv": Mission(
        {"davis": "davis.moos"}, {"davis": (0, 0, 3, -90)}, "", {**DEPLOY, "STATION_KEEP": "true"}, 400,
        stays((20, -20), 30, 0.5),
    ),
    "s4_delta": Mission({"delta": "delta.moos"}, {"delta": (0, 0, 1, -90)}, "", DEPLOY, 600, dives(5.0, 3.0)),
}  # fmt: skip


@contextmanager
def flown(mission: Mission, addresses: dict[str, int], warp: float) -> Iterator[LiveSimulator]:
    """Return the simulator in the communities."""
    vehicles = [
        {"name": name, "model": "remus100", "start": {"position_m": [x, y, -depth], "yaw_deg": yaw}}
        for name, (x, y, depth, yaw) in mission.starts.items()
    ]
    with LiveSimulator(Simulator(validated(Scenario, {**BAY, "vehicles": vehicles}), seed=1), speed=warp) as live:
        table = served_table(live, wire=None, origin="world", tf="truth", frame_prefix="")
        context = Context(table.channels, Feed(live), live, table.services, actions_of(live.simulator, table))
        there = tuple(f"{name}=localhost:{port}" for name, port in addresses.items())
        with MoosPlug(MoosOptions(moos=there)).open(context):
            yield live


def fly(name: str, mission: Mission, folder: Path, binaries: Path, warp: float) -> tuple[bool, str]:
    """Fly a mission; return whether it passed, and what was measured."""
    with ExitStack() as stack:
        work = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="moos-trial-"))) / name
        shutil.copytree(folder / name, work)
        ports: dict[str, int] = {}
        for vehicle, file in mission.files.items():
            text = (work / file).read_text()
            found = re.search(r"^\s*ServerPort\s*=\s*(\d+)", text, re.M | re.I)
            if found is None:
                raise ValueError(f"{file}: has no ServerPort")
            ports[vehicle] = int(found[1])
            (work / file).write_text(TAKEN_OUT.sub("", text))
        environment = {**os.environ, "PATH": f"{binaries}:{os.environ['PATH']}"}
        for file in [*mission.files.values(), *([mission.shore] if mission.shore else [])]:
            log = stack.enter_context((work / f"{file}.log").open("w"))
            process = subprocess.Popen(
                [str(binaries / "pAntler"), file, f"--MOOSTimeWarp={warp:g}"], cwd=work, env=environment, stdout=log,
                stderr=log, stdin=subprocess.DEVNULL, start_new_session=True,
            )  # fmt: skip
            stack.callback(end, process)
        live = stack.enter_context(flown(mission, ports, warp))
        tracks = {vehicle: watched(stack, vehicle, port, mission) for vehicle, port in ports.items()}
        begun_s, at_s = time.monotonic(), live.simulator.time_s
        while live.simulator.time_s - at_s < mission.lasts_s and time.monotonic() - begun_s < 600:
            time.sleep(0.2)
        flown_s, wall_s = live.simulator.time_s - at_s, time.monotonic() - begun_s
        good, texts = True, [f"{flown_s:.0f} s in {wall_s:.0f} s: {flown_s / wall_s:.1f} times real time"]
        for vehicle, track in tracks.items():
            if len(track) < 10:
                return False, f"{vehicle}: no track"
            passes, text = mission.passes(np.array(track))
            speed = float(np.median(np.array(track)[:, 3]))
            good, texts = good and passes, [*texts, f"{vehicle} {text}, median speed {speed:.2f} m/s"]
        return good, "; ".join(texts)


def watched(stack: ExitStack, vehicle: str, port: int, mission: Mission) -> list[list[float]]:
    """Start the mission and return the track, which grows."""
    track: list[list[float]] = []
    latest: dict[str, float] = {}

    def take(messages: list[Message]) -> None:
        for each in messages:
            if isinstance(each.value, float):
                latest[each.name] = each.value
        if len(latest) == len(names) and (not track or math.dist(track[-1][:3], list(latest.values())[:3]) > 0):
            track.append([latest[each] for each in names])

    names = ("NAV_X", "NAV_Y", "NAV_DEPTH", "NAV_SPEED")
    client = stack.enter_context(MoosClient(Address("", "localhost", port), "trial", names, take, lambda *_: None))
    until_s = time.monotonic() + 60
    while not client.is_met and time.monotonic() < until_s:
        time.sleep(0.05)
    time.sleep(3.0)  # until the helm has its behaviors
    client.publish(mission.pokes.items())
    return track


def end(process: subprocess.Popen[bytes]) -> None:
    """End a launcher and all that it has launched."""
    os.killpg(process.pid, signal.SIGINT)
    try:
        process.wait(5)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def main() -> int:
    """Fly the missions; return 1 if one failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--bin", type=Path, required=True, help="the folder with MOOSDB, pAntler, pHelmIvP and the others"
    )
    parser.add_argument("--missions", type=Path, required=True, help="MOOS-IvP's folder of missions")
    parser.add_argument("--warp", type=float, default=10.0, help="the time warp")
    parser.add_argument("mission", nargs="*", help=f"of {', '.join(MISSIONS)}; default: all")
    given = parser.parse_args()
    all_passed = True
    for name in given.mission or MISSIONS:
        if name not in MISSIONS:
            parser.error(f"mission '{name}': must be one of {', '.join(MISSIONS)}")
        passed, text = fly(name, MISSIONS[name], given.missions, given.bin, given.warp)
        print(f"{'ok  ' if passed else 'MISS'} {name}: {text}", flush=True)
        all_passed = all_passed and passed
    return 0 if all_passed else 1


if __name__ == "__main__":
    sys.exit(main())
