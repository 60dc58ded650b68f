"""DUNE flies a plan with its own autopilot, navigation and maneuvers on our LAUV.

DUNE runs its configuration lauv-simulator-1 for simulations, without its simulator of the vehicle, VSIM. Everything
else is its own, also the simulated instruments, which follow our motion. An operator's connection sends the plan, a
triangle of Goto maneuvers under water, and listens to DUNE's own estimate.
"""

from __future__ import annotations

import argparse
import math
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from tools.trials.parts import bay, flown, nearest_m, running, shown

from uwsim.bridges.doors.endpoint import Endpoint
from uwsim.bridges.imc.link import Identity, ImcLink
from uwsim.bridges.imc.plug import ImcOptions, ImcPlug
from uwsim.bridges.imc.readings import Place
from uwsim.bridges.imc.wire import Message, define, fields
from uwsim.scenario.georeference import georeference

SIMULATOR_PORT, OPERATOR_PORT = 6010, 6011
OPERATOR = 0x4101
"""The operator's system number, of a console."""
LONGEST_S = 600.0
POINTS_M = ((120.0, 0.0), (120.0, 120.0), (0.0, 60.0))
"""The plan's corners, east and north of the start [m]."""
DEPTH_M, SPEED_M_S = 3.0, 1.3
NEAR_M, TOO_DEEP_M = 12.0, 1.0
"""How near to each corner the true track has to come, and how much deeper than asked it may be."""
LAUV = {"name": "lauv", "model": "lauv", "start": {"position_m": [0, 0, -0.3], "yaw_deg": 0}}
BAY = bay(40, 1020, 41.185, -8.7062) | {"vehicles": [LAUV]}
CONFIGURATION = f"""\
[Require lauv-simulator-1.ini]

[Simulators.VSIM]
Enabled = Never

[Transports.TCP.Server/Simulator]
Enabled      = Simulation
Entity Label = Simulator
Port         = {SIMULATOR_PORT}
Transports   = Heartbeat, EntityList, SetThrusterActuation, SetServoPosition

[Transports.TCP.Server/Operator]
Enabled      = Simulation
Entity Label = Operator
Port         = {OPERATOR_PORT}
Transports   = Heartbeat, EntityList, EstimatedState, PlanControl, PlanControlState, VehicleState
"""

for name, number, text in (
    ("Goto", 450, "H timeout d lat d lon f z B z_units f speed B speed_units d roll d pitch d yaw s custom"),
    ("VehicleState", 500, "B op_mode B error_count s error_ents H maneuver_type d maneuver_stime H maneuver_eta "
     "I control_loops B flags s last_error d last_error_time"),
    ("PlanSpecification", 551, "s plan_id s description s vnamespace l variables s start_man_id l maneuvers "
     "l transitions l start_actions l end_actions"),
    ("PlanManeuver", 552, "s maneuver_id m data l start_actions l end_actions"),
    ("PlanTransition", 553, "s source_man s dest_man s conditions l actions"),
    ("PlanControl", 559, "B type B op H request_id s plan_id H flags m arg s info"),
    ("PlanControlState", 560, "B state s plan_id i plan_eta f plan_progress s man_id H man_type i man_eta "
     "B last_outcome"),
):  # fmt: skip
    define(name, number, fields(text))

READY, EXECUTING, SUCCESS = 1, 3, 1
"""States of PlanControlState, and an outcome."""


class Seen(NamedTuple):
    """DUNE's messages: states of its plan, estimated depths [m], and faults."""

    states: list[Message]
    depths_m: list[float]
    faults: list[str]


def options(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("--dune", type=Path, required=True, help="DUNE's program")
    parser.add_argument("--config", type=Path, required=True, help="its folder etc, with lauv-simulator-1.ini")


def plan(place: Place) -> dict[str, Any]:
    """Return the plan as the fields of a PlanSpecification."""
    corners = []
    for number, (east_m, north_m) in enumerate(POINTS_M):
        latitude_deg, longitude_deg = place.world.degrees(np.array([east_m, north_m, 0.0])).tolist()
        corners.append((f"Goto{number}", {
            "timeout": 1000, "lat": math.radians(latitude_deg), "lon": math.radians(longitude_deg), "z": DEPTH_M,
            "z_units": 1, "speed": SPEED_M_S, "speed_units": 0,
        }))  # fmt: skip
    names = [name for name, _ in corners]
    return {
        "plan_id": "triangle",
        "start_man_id": names[0],
        "maneuvers": [("PlanManeuver", {"maneuver_id": name, "data": ("Goto", goto)}) for name, goto in corners],
        "transitions": [
            ("PlanTransition", {"source_man": one, "dest_man": other, "conditions": "ManeuverIsDone"})
            for one, other in zip(names, [*names[1:], "_done_"], strict=True)
        ],
    }


def fly(given: argparse.Namespace) -> Iterator[tuple[str, bool, str]]:
    """Fly the plan; yield whether it was flown as asked, and what was measured."""
    if not (given.config / "lauv-simulator-1.ini").is_file():
        raise SystemExit(f"--config {given.config}: has no lauv-simulator-1.ini")
    with ExitStack() as stack:
        work = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="imc-trial-")))
        for part in given.config.resolve().iterdir():
            (work / part.name).symlink_to(part)
        (work / "trial.ini").write_text(CONFIGURATION)
        command = [str(given.dune.resolve()), "-c", "trial", "-p", "Simulation", "--config-dir", str(work)]
        process = stack.enter_context(running(command, work, work / "dune.log"))
        live = stack.enter_context(flown(BAY, ImcPlug(ImcOptions(imc=(f"localhost:{SIMULATOR_PORT}",)))))
        track: list[tuple[float, float, float]] = []
        live.every(0.2, lambda sim: tuple(sim.rov.pose.position_world_m.tolist()), track.append)
        seen = Seen([], [], [])
        begun_s = time.monotonic()
        ended = operate(stack, process, Place.of(georeference(live.simulator.scenario)), seen)
        text, good = f"{time.monotonic() - begun_s:.0f} s; {ended}", False
        if len(track) < 100:
            text += f"; a track of {len(track)} points"
        else:
            good, measured = judged(np.array(track), seen)
            text += f"; {measured}"
        if not good or "is done" not in ended:
            text += "; DUNE's last words: "
            text += " | ".join((work / "dune.log").read_text(errors="replace").splitlines()[-6:])[-600:]
        yield "triangle", good and "is done" in ended, text


def operate(stack: ExitStack, process: subprocess.Popen[bytes], place: Place, seen: Seen) -> str:
    """Send the plan when the vehicle is ready, and wait until it is done; return how it ended."""
    to: list[int] = []

    def take(messages: list[Message]) -> None:
        for each in messages:
            to[:] = [each.source]
            if each.name == "PlanControlState":
                seen.states.append(each)
            elif each.name == "EstimatedState":
                seen.depths_m.append(each.content["depth"])
            elif each.name == "PlanControl" and each.content["info"]:
                seen.faults.append(each.content["info"])
            elif each.name == "VehicleState" and each.content["last_error"]:
                seen.faults.append(each.content["last_error"])

    operator = stack.enter_context(ImcLink(Endpoint("localhost", OPERATOR_PORT, "tcp"), Identity(OPERATOR), take))
    end_s, asked_s = time.monotonic() + LONGEST_S, 0.0
    is_started = False
    while time.monotonic() < end_s:
        if process.poll() is not None:
            return f"DUNE ended with exit code {process.returncode}"
        state = seen.states[-1].content if seen.states else None
        if state is not None and state["state"] == EXECUTING:
            is_started = True
        elif state is not None and state["state"] == READY and not is_started and time.monotonic() - asked_s > 5.0:
            asked_s = time.monotonic()
            request = {"op": 0, "request_id": 1, "plan_id": "triangle", "arg": ("PlanSpecification", plan(place))}
            operator.publish([("uwsim", "PlanControl", request)], to[0])
        elif state is not None and is_started and state["state"] == READY:
            return "the plan is done" if state["last_outcome"] == SUCCESS else f"the plan failed: {seen.faults[-3:]}"
        time.sleep(0.1)
    return f"not done in {LONGEST_S:.0f} s: {'flying' if is_started else 'not started'}, {seen.faults[-3:]}"


def judged(track: np.ndarray[Any, Any], seen: Seen) -> tuple[bool, str]:
    """Return whether the true track is what the plan is for, and a text with what was measured."""
    nearest = nearest_m(track[:, :2], POINTS_M)
    first, last = (int(np.linalg.norm(track[:, :2] - POINTS_M[k], axis=1).argmin()) for k in (0, -1))
    depths = -track[first:last, 2] if last > first else -track[:, 2]
    estimated_m = float(np.median(seen.depths_m)) if seen.depths_m else math.nan
    text = (
        f"corners passed at {shown(nearest)} m (at most {NEAR_M:g}); depth between them "
        f"{np.median(depths):.2f} m, at most {depths.max():.2f} (asked {DEPTH_M:g}, at most {DEPTH_M + TOO_DEEP_M:g}); "
        f"DUNE's median depth {estimated_m:.2f} m"
    )
    return max(nearest) <= NEAR_M and depths.max() <= DEPTH_M + TOO_DEEP_M and np.median(depths) > DEPTH_M / 2, text
