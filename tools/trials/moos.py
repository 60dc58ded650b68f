"""Missions of MOOS-IvP are flown unmodified, but for the lines that launch the simulator and windows.

A mission's files are copied. Of their ANTLER blocks, lines are taken out that launch uSimMarine, which uwsim replaces,
and programs with windows, and pShare's white lists; see LISTED. Ports stay as they are.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from tools.trials.parts import bay, flown, nearest_m, running, shown

from uwsim.bridges.doors.endpoint import Endpoint
from uwsim.bridges.moos.client import MoosClient
from uwsim.bridges.moos.plug import MoosOptions, MoosPlug
from uwsim.bridges.moos.wire import Message

TAKEN_OUT = re.compile(r"^\s*Run\s*=\s*(uSimMarine\w*|pMarineViewer|uMAC\w*|pRealm|pLogger)\b.*$", re.M | re.I)
LISTED = re.compile(r",\s*white_list=[^\n]*")
"""m2_berta's pShare of 2026 admits four variables at the shoreside. NODE_BROKER_PING is not among them, so that no
vehicle would be found."""
LONGEST_S, POKES, POKE_S = 600.0, 4, 3.0  # wall time
BAY = bay(60, 1026, 43.8253, -70.3304)
Tracks = dict[str, Any]
"""By vehicle, (n, 5): MOOS time [s], NAV_X, NAV_Y, NAV_DEPTH [m] and NAV_SPEED [m/s]."""
NAMES = ("NAV_X", "NAV_Y", "NAV_DEPTH", "NAV_SPEED")
Check = Callable[[Tracks], tuple[bool, str]]


class Mission(NamedTuple):
    """A mission.

    files: of communities with a vehicle. starts: x, y, depth [m], yaw [deg]. pokes: what starts it. passes: whether the
    tracks are what the mission is for. launcher: its script that makes the files; the warp follows. shore: the
    shoreside's file, whose community is poked instead of the vehicles'.
    """

    files: dict[str, str]
    starts: dict[str, tuple[float, float, float, float]]
    pokes: dict[str, str]
    lasts_s: float
    passes: Check
    launcher: tuple[str, ...] = ()
    shore: str = ""


def visits(points: list[tuple[float, float]], radius_m: float, apart_m: float = 0.0) -> Check:
    """Return the check that all tracks come near all points, and that two are never close to each other."""

    def check(tracks: Tracks) -> tuple[bool, str]:
        nearest = [distance for each in tracks.values() for distance in nearest_m(each[:, 1:3], points)]
        text = f"passes {len(points)} points at {shown(nearest)} m (at most {radius_m:g})"
        if not apart_m:
            return max(nearest) <= radius_m, text
        first, second = tracks.values()
        other = np.column_stack([np.interp(first[:, 0], second[:, 0], second[:, k]) for k in (1, 2)])
        closest = float(np.linalg.norm(first[:, 1:3] - other, axis=1).min())
        passed = max(nearest) <= radius_m and closest >= apart_m
        return passed, f"{text}, {closest:.1f} m apart (at least {apart_m:g})"

    return check


def stays(tracks: Tracks) -> tuple[bool, str]:
    """Return whether the last half of the only track stays near the station that is kept."""
    (track,) = tracks.values()
    farthest = float(np.linalg.norm(track[len(track) // 2 :, 1:3] - (20, -20), axis=1).max())
    return farthest <= 30, f"stays within {farthest:.1f} m of the station (at most 30)"


def dives(tracks: Tracks) -> tuple[bool, str]:
    """Return whether the only track has a median depth of 4 m or more, and is never deeper than 8.5 m."""
    (track,) = tracks.values()
    depths = track[len(track) // 4 :, 3]
    median, deepest, highest = float(np.median(depths)), float(depths.max()), float(depths.min())
    text = f"median depth {median:.2f} m (at least 4), from {highest:.2f} to {deepest:.2f} m (at most 8.5)"
    return median >= 4.0 and deepest <= 8.5, text


DEPLOY = {"DEPLOY": "true", "MOOS_MANUAL_OVERRIDE": "false", "MOOS_MANUAL_OVERIDE": "false"}
MISSIONS = {
    "s1_alpha": Mission(
        {"alpha": "alpha.moos"}, {"alpha": (0, -20, 3, -90)}, DEPLOY, 600,
        visits([(60, -40), (60, -160), (150, -160), (180, -100), (150, -40)], 15),
    ),
    "station-keep-uuv": Mission(
        {"davis": "davis.moos"}, {"davis": (0, 0, 3, -90)}, {**DEPLOY, "STATION_KEEP": "true"}, 400,
        stays,
    ),
    # A constant depth of 50 m, limited to 7 m with a tolerance of 1 m, and periods at the surface.
    "s4_delta": Mission({"delta": "delta.moos"}, {"delta": (0, 0, 1, -90)}, DEPLOY, 600, dives),
    # Two vehicles loiter at two places, which a script at the shoreside exchanges; they give way by COLREGS.
    "m2_berta": Mission(
        {"abe": "targ_abe.moos", "ben": "targ_ben.moos"}, {"abe": (0, 0, 3, -90), "ben": (180, 0, 3, -90)},
        {"DEPLOY_ALL": "true", "MOOS_MANUAL_OVERRIDE_ALL": "false", "AVOID_ALL": "true", "RETURN_ALL": "false"}, 600,
        visits([(0, -75), (125, -75)], 40, 5), ("./launch.sh", "--just_make", "--nogui"), "targ_shoreside.moos",
    ),
}  # fmt: skip


def options(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    help_text = "the folder with MOOSDB, pAntler, pHelmIvP and the others"
    parser.add_argument("--bin", type=Path, required=True, help=help_text)
    parser.add_argument("--missions", type=Path, required=True, help="MOOS-IvP's folder of missions")
    parser.add_argument("--warp", type=float, default=10.0, help="the time warp")
    parser.add_argument("mission", nargs="*", help=f"of {', '.join(MISSIONS)}; default: all")


def fly(given: argparse.Namespace) -> Iterator[tuple[str, bool, str]]:
    """Fly the missions; yield whether each passed, and what was measured."""
    if unknown := set(given.mission) - MISSIONS.keys():
        raise SystemExit(f"mission '{min(unknown)}': must be one of {', '.join(MISSIONS)}")
    for name in given.mission or MISSIONS:
        yield name, *fly_mission(name, MISSIONS[name], given.missions, given.bin, given.warp)


def fly_mission(name: str, mission: Mission, folder: Path, binaries: Path, warp: float) -> tuple[bool, str]:
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
            command = [str(binaries / "pAntler"), file, f"--MOOSTimeWarp={warp:g}"]
            stack.enter_context(running(command, work, work / f"{file}.log", environment))
        vehicles = [
            {"name": each, "model": "remus100", "start": {"position_m": [x, y, -depth], "yaw_deg": yaw}}
            for each, (x, y, depth, yaw) in mission.starts.items()
        ]
        there = tuple(f"{vehicle}=localhost:{port}" for vehicle, port in ports.items())
        live = stack.enter_context(flown({**BAY, "vehicles": vehicles}, MoosPlug(MoosOptions(moos=there)), warp))
        rows = {vehicle: watched(stack, port) for vehicle, port in ports.items()}
        pokers = [
            stack.enter_context(MoosClient(Endpoint("localhost", port), "poke", (), lambda _: None, lambda *_: None))
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

    stack.enter_context(MoosClient(Endpoint("localhost", port), "watch", NAMES, take, lambda *_: None))
    return rows
