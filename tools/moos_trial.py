"""Fly missions of MOOS-IvP unmodified, but for the lines that launch the simulator and windows; see tools/moos-trial.

A mission's files are copied. Of their ANTLER blocks, lines are taken out that launch uSimMarine, which uwsim replaces,
and programs with windows, and pShare's white lists; see LISTED. Ports stay as they are. The vehicles are REMUS 100s in
a deep, empty bay.
"""

from __future__ import annotations

import argparse
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
from uwsim.bridges.aboard import aboard_of
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
LISTED = re.compile(r",\s*white_list=[^\n]*")
"""m2_berta's pShare of 2026 admits four variables at the shoreside. NODE_BROKER_PING is not among them, so that no
vehicle would be found."""
LONGEST_S, POKES, POKE_S = 600.0, 4, 3.0  # wall time
BAY = {
    "name": "bay", "description": "an empty bay, 60 m deep", "mission_time_s": 3600, "water": {"density_kg_m3": 1026},
    "terrain": {"source": "noise", "size_m": [800, 800], "spacing_m": 10, "bed_depth_m": 60},
    "station": {"position_m": [60, -70, 0], "dock_m": [0, 0, -2]},  # near, for the fixes of its USBL
    "earth": {"latitude_deg": 43.8253, "longitude_deg": -70.3304},
}  # fmt: skip


Tracks = dict[str, Any]
"""By vehicle, (n, 5): MOOS time [s], NAV_X, NAV_Y, NAV_DEPTH [m] and NAV_SPEED [m/s]."""
NAMES = ("NAV_X", "NAV_Y", "NAV_DEPTH", "NAV_SPEED")


class Mission(NamedTuple):
    """A mission.

    files: of communities with a vehicle, by name. starts: x, y, depth [m], yaw [deg] by name. pokes: what starts it.
    passes: whether the tracks are what the mission is for, and a text with what was measured. launcher: its script that
    makes the files, with the options for that; the warp follows. shore: the shoreside's file, whose community is poked
    instead of the vehicles'.
    """

    files: dict[str, str]
    starts: dict[str, tuple[float, float, float, float]]
    pokes: dict[str, str]
    lasts_s: float
    passes: Callable[[Tracks], tuple[bool, str]]
    launcher: tuple[str, ...] = ()
    shore: str = ""


def visits(points: list[tuple[float, float]], radius_m: float) -> Callable[[Tracks], tuple[bool, str]]:
    """Return the check that the only track comes near all points."""

    def check(tracks: Tracks) -> tuple[bool, str]:
        (track,) = tracks.values()
        nearest = [float(np.linalg.norm(track[:, 1:3] - each, axis=1).min()) for each in points]
        shown = ", ".join(f"{each:.1f}" for each in nearest)
        return max(nearest) <= radius_m, f"passes {len(points)} points at {shown} m (at most {radius_m:g})"

    return check


def stays(point: tuple[float, float], radius_m: float, since: float) -> Callable[[Tracks], tuple[bool, str]]:
    """Return the check that the last part of the only track, from a share of it on, stays near a point."""

    def check(tracks: Tracks) -> tuple[bool, str]:
        (track,) = tracks.values()
        last = track[int(since * len(track)) :]
        farthest = float(np.linalg.norm(last[:, 1:3] - point, axis=1).max())
        return farthest <= radius_m, f"stays within {farthest:.1f} m of {point} (at most {radius_m:g})"

    return check


def dives(least_m: float, most_m: float) -> Callable[[Tracks], tuple[bool, str]]:
    """Return the check that the only track has a median depth in a range, and is never deeper."""

    def check(tracks: Tracks) -> tuple[bool, str]:
        (track,) = tracks.values()
        depths = track[len(track) // 4 :, 3]
        median, deepest, highest = float(np.median(depths)), float(depths.max()), float(depths.min())
        shown = f"median depth {median:.2f} m, from {highest:.2f} to {deepest:.2f} m (at most {most_m:g})"
        return least_m <= median and deepest <= most_m, shown

    return check


def meet(points: list[tuple[float, float]], radius_m: float, apart_m: float) -> Callable[[Tracks], tuple[bool, str]]:
    """Return the check that both tracks come near all points, and are never close to each other."""

    def check(tracks: Tracks) -> tuple[bool, str]:
        first, second = tracks.values()
        nearest = [float(np.linalg.norm(each[:, 1:3] - p, axis=1).min()) for each in (first, second) for p in points]
        other = np.column_stack([np.interp(first[:, 0], second[:, 0], second[:, k]) for k in (1, 2)])
        closest = float(np.linalg.norm(first[:, 1:3] - other, axis=1).min())
        shown = ", ".join(f"{each:.1f}" for each in nearest)
        text = f"pass {len(points)} points at {shown} m (at most {radius_m:g}), {closest:.1f} m apart at least"
        return max(nearest) <= radius_m and closest >= apart_m, f"{text} (at least {apart_m:g})"

    return check


DEPLOY = {"DEPLOY": "true", "MOOS_MANUAL_OVERRIDE": "false", "MOOS_MANUAL_OVERIDE": "false"}
MISSIONS = {
    "s1_alpha": Mission(
        {"alpha": "alpha.moos"}, {"alpha": (0, -20, 3, -90)}, DEPLOY, 600,
        visits([(60, -40), (60, -160), (150, -160), (180, -100), (150, -40)], 15),
    ),
    "station-keep-uuv": Mission(
        {"davis": "davis.moos"}, {"davis": (0, 0, 3, -90)}, {**DEPLOY, "STATION_KEEP": "true"}, 400,
        stays((20, -20), 30, 0.5),
    ),
    # A constant depth of 50 m, limited to 7 m with a tolerance of 1 m, and periods at the surface.
    "s4_delta": Mission({"delta": "delta.moos"}, {"delta": (0, 0, 1, -90)}, DEPLOY, 600, dives(4.0, 8.5)),
    # Two vehicles loiter at two places, which a script at the shoreside exchanges; they give way by COLREGS.
    "m2_berta": Mission(
        {"abe": "targ_abe.moos", "ben": "targ_ben.moos"}, {"abe": (0, 0, 3, -90), "ben": (180, 0, 3, -90)},
        {"DEPLOY_ALL": "true", "MOOS_MANUAL_OVERRIDE_ALL": "false", "AVOID_ALL": "true", "RETURN_ALL": "false"}, 600,
        meet([(0, -75), (125, -75)], 40, 5), ("./launch.sh", "--just_make", "--nogui"), "targ_shoreside.moos",
    ),
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
        context = Context(table.channels, Feed(live), live, aboard=aboard_of(live.simulator, table))
        there = tuple(f"{name}=localhost:{port}" for name, port in addresses.items())
        with MoosPlug(MoosOptions(moos=there)).open(context):
            yield live


def fly(name: str, mission: Mission, folder: Path, binaries: Path, warp: float) -> tuple[bool, str]:
    """Fly a mission; return whether it passed, and what was measured."""
    environment = {**os.environ, "PATH": f"{binaries}:{os.environ['PATH']}"}
    with ExitStack() as stack:
        work = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="moos-trial-"))) / name
        shutil.copytree(folder / name, work)
        if mission.launcher:
            made = [*mission.launcher, f"{warp:g}"]
            subprocess.run(made, cwd=work, env=environment, stdin=subprocess.DEVNULL, check=True, capture_output=True)
        ports = {vehicle: port_of(work / file) for vehicle, file in mission.files.items()}
        for file in [*mission.files.values(), *filter(None, [mission.shore])]:
            (work / file).write_text(LISTED.sub("", TAKEN_OUT.sub("", (work / file).read_text())))
            log = stack.enter_context((work / f"{file}.log").open("w"))
            process = subprocess.Popen(
                [str(binaries / "pAntler"), file, f"--MOOSTimeWarp={warp:g}"], cwd=work, env=environment, stdout=log,
                stderr=log, stdin=subprocess.DEVNULL, start_new_session=True,
            )  # fmt: skip
            stack.callback(end, process)
        live = stack.enter_context(flown(mission, ports, warp))
        rows = {vehicle: watched(stack, port) for vehicle, port in ports.items()}
        pokers = [
            stack.enter_context(MoosClient(Address("", "localhost", port), "poke", (), lambda _: None, lambda *_: None))
            for port in ([port_of(work / mission.shore)] if mission.shore else ports.values())
        ]
        begun_s, at_s, pokes = time.monotonic(), live.simulator.time_s, 0
        while live.simulator.time_s - at_s < mission.lasts_s and time.monotonic() - begun_s < LONGEST_S:
            if pokes < POKES and time.monotonic() - begun_s > POKE_S * (pokes + 1):  # until all have their behaviors
                pokes += 1
                for each in pokers:
                    each.publish(mission.pokes.items())
            time.sleep(0.1)
        flown_s, wall_s = live.simulator.time_s - at_s, time.monotonic() - begun_s
        if any(len(track) < 100 for track in rows.values()):
            return False, f"tracks of {', '.join(str(len(track)) for track in rows.values())} points"
        tracks = {vehicle: np.array(track) for vehicle, track in rows.items()}
        good, text = mission.passes(tracks)
        speeds = ", ".join(f"{np.median(track[:, 4]):.2f}" for track in tracks.values())
        pace = f"{flown_s:.0f} s in {wall_s:.0f} s, {flown_s / wall_s:.1f} times real time"
        return good, f"{pace}; {', '.join(tracks)}: {text}, median speed {speeds} m/s"


def port_of(mission: Path) -> int:
    """Return the port of a mission's MOOSDB."""
    found = re.search(r"^\s*ServerPort\s*=\s*(\d+)", mission.read_text(), re.M | re.I)
    if found is None:
        raise ValueError(f"{mission.name}: has no ServerPort")
    return int(found[1])


def watched(stack: ExitStack, port: int) -> list[list[float]]:
    """Return the track of a vehicle, which grows."""
    rows: list[list[float]] = []
    latest: dict[str, float] = {}

    def take(messages: list[Message]) -> None:
        for each in messages:
            if isinstance(each.value, float):
                latest[each.name] = each.value
        if len(latest) == len(NAMES):
            rows.append([messages[-1].time_s, *(latest[each] for each in NAMES)])

    stack.enter_context(MoosClient(Address("", "localhost", port), "watch", NAMES, take, lambda *_: None))
    return rows


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
