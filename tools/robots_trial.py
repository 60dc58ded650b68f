"""Convert robots and worlds that others published, and fly the robots: `python -m tools.robots_trial CHECKOUTS`.

CHECKOUTS: a folder with a checkout of each repository below, named OWNER+NAME. Each conversion runs in a process of its
own, with a limit of time. A robot that converts flies in deep water, with weights that let it hover: with all
thrusters that push along an axis at full thrust, and the other motions held, its speed in the end is compared with the
one at which the file's own drag equals the file's own thrust. That one is computed here from the text of the file,
without uwsim's importers. --write puts the tables into the guide.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Floats = NDArray[np.float64]
ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs/guides/published-robots.md"
MARKS = "<!-- tables -->\n", "<!-- end -->"
LIMIT_S, AXES = 400.0, {"surge": 0, "sway": 1, "heave": 2, "yaw": 5}
LEAST = np.array([0.2, 0.2, 0.2, 0.03, 0.03, 0.03])
"""A thruster with a smaller part along an axis, or a smaller lever about it [m], is not used on it."""
GZ_N, DEPTH_M = 1000.0, -20.0
"""gz-sim's own bound of thrust; the height of a flight, where water is hardly compressed."""

ROBOTS = """
uuvsimulator/uuv_simulator uuv_descriptions/robots/rexrov_default.xacro
uuvsimulator/rexrov2 rexrov2_description/robots/rexrov2_default.xacro
uuvsimulator/eca_a9 eca_a9_description/robots/eca_a9_default.urdf.xacro max_thrust=120
uuvsimulator/lauv_gazebo lauv_description/robots/default.xacro
uuvsimulator/desistek_saga desistek_saga_description/robots/desistek_saga_default.xacro
Liquid-ai/Plankton uuv_descriptions/robots/rexrov_default.xacro
HKPolyU-UAV/bluerov2 bluerov2_environ/robots/default.xacro max_thrust=40
Field-Robotics-Lab/dave urdf/robots/caldus_description/urdf/caldus.xacro max_thrust=300
Field-Robotics-Lab/dave urdf/robots/caracara_description/urdf/caracara.xacro max_thrust=100
Field-Robotics-Lab/dave urdf/robots/smilodon_description/urdf/smilodon.xacro max_thrust=300
Field-Robotics-Lab/dave urdf/robots/glider_description/urdf/glider_hybrid_whoi_default.urdf.xacro max_thrust=50
CentraleNantesROV/bluerov2 bluerov2_description/urdf/bluerov2.xacro
Robotic-Decision-Making-Lab/blue blue_description/description/bluerov2/config.xacro
Robotic-Decision-Making-Lab/blue blue_description/description/bluerov2_heavy/config.xacro
itu-auv/auv-software auv_sim/auv_sim_description/taluy_sim_description/urdf/taluy_sim.urdf.xacro namespace=taluy
kanghyunmin-bot/ROS2-mujoco-UUVsimulator kmu_hit25_ros2_ws/src/hit25_auv/urdf/rov.urdf
osrf/vrx vrx_urdf/wamv_gazebo/urdf/wamv_gazebo.urdf.xacro
osrf/vrx vrx_gz/models/roboboat01/model.sdf
clydemcqueen/bluerov2_gz models/bluerov2/model.sdf
clydemcqueen/bluerov2_gz models/bluerov2_heavy/model.sdf
clydemcqueen/orca4 orca_description/models/orca4/model.sdf
kogodemilade/bluerov2_n_gz src/bluerov2_description/models/bluerov2_ping/model.sdf
IOES-Lab/dave models/dave_robot_models/description/glider_slocum/model.sdf
IOES-Lab/dave models/dave_robot_models/description/rexrov/model.sdf
mcgill-robotics/auv-sim-gazebo assets/clarke/clarke.sdf
apenchuu/stonefish_bluerov2 stonefish_bluerov2/scenarios/bluerov2_tank.scn
patrykcieslak/stonefish Tests/Data/girona500auv_console.scn robot_name=girona500
vortexntnu/vortex-stonefish-sim stonefish_sim/scenarios/freya_no_gpu.scn
GSO-soslab/world_of_stonefish world/tank.scn.xacro
slopezba/peacetolero_stonefish scenarios/tank.scn
byu-holoocean/holoocean-ros holoocean_main/config/blueROV.json
byu-holoocean/holoocean-ros holoocean_main/config/torpedo_fossen.json
""".strip()
"""A repository, the description within, and arguments: a bound of thrust where the files state none."""
WORLDS = """
uuvsimulator/uuv_simulator uuv_gazebo_worlds/worlds/subsea_bop_panel.world
uuvsimulator/uuv_simulator uuv_gazebo_worlds/worlds/herkules_ship_wreck.world
uuvsimulator/uuv_simulator uuv_gazebo_worlds/worlds/munkholmen.world
uuvsimulator/uuv_simulator uuv_gazebo_worlds/worlds/lake.world
Field-Robotics-Lab/dave models/dave_worlds/worlds/dave_integrated.world
Field-Robotics-Lab/dave models/dave_worlds/worlds/dave_plug_and_socket_demo.world
Field-Robotics-Lab/dave models/dave_worlds/worlds/dave_graded_seabed.world
Field-Robotics-Lab/dave models/dave_worlds/worlds/valve_manipulation_demo.world
IOES-Lab/dave models/dave_worlds/worlds/dvl_world.world
IOES-Lab/dave models/dave_worlds/worlds/dave_ocean_waves.world
clydemcqueen/orca4 orca_description/worlds/sand.world
clydemcqueen/bluerov2_gz worlds/bluerov2_heavy_underwater.world
osrf/lrauv lrauv_system_tests/worlds/flat_seabed.sdf
uf-mil/mil SubjuGator/simulation/subjugator_gazebo/worlds/robosub_2022.world
itu-auv/auv-software auv_sim/auv_sim_description/auv_sim_description/worlds/pool.world
smarc-project/smarc_simulations smarc_worlds/worlds/pipe_following.world
gazebosim/gz-sim examples/worlds/auv_controls.sdf
""".strip()


@dataclass
class Trial:
    """A description, and what became of it. ratios: of the speeds flown and computed, by axis."""

    repository: str
    path: str
    arguments: list[str]
    refusal: str = ""
    outcome: str = ""
    counts: tuple[int, ...] = (0, 0)
    ratios: dict[str, float] = field(default_factory=dict)

    def row(self) -> str:
        """Return a line of the table."""
        name = " ".join(f"`{each}`" for each in ("/".join(Path(self.path).parts[-2:]), *self.arguments))
        ratios = ", ".join(f"{axis} {ratio:.3f}" for axis, ratio in self.ratios.items())
        outcome = self.refusal.replace("|", "\\|") or self.outcome
        return f"| {name} | {self.repository} | {outcome} | {self.counts[0]}, {self.counts[1]} | {ratios or '-'} |"


def trials(table: str) -> list[Trial]:
    """Return the lines of a table above."""
    parts = [line.split() for line in table.splitlines()]
    return [Trial(repository, path, arguments) for repository, path, *arguments in parts]


def run(command: list[str], checkouts: Path) -> subprocess.CompletedProcess[str]:
    """Run Python where the packages and models of UUV Simulator are found, as in a ROS workspace with them."""
    marks = {"ROS_PACKAGE_PATH": "package.xml", "GAZEBO_MODEL_PATH": "model.config"}
    found = {
        key: {str(each.parents[1]) for each in checkouts.glob(f"uuvsimulator+*/**/{mark}")}
        for key, mark in marks.items()
    }
    environment = os.environ | {key: os.pathsep.join(sorted(folders)) for key, folders in found.items()}
    command = [sys.executable, *command]
    return subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S, env=environment, cwd=ROOT)


def convert(trial: Trial, checkouts: Path, out: Path) -> None:
    """Run `uwsim scenario from`, and note what it printed."""
    source = checkouts / trial.repository.replace("/", "+") / trial.path
    given = [word for each in trial.arguments for word in ("--arg", each)]
    try:
        done = run(["-m", "uwsim", "scenario", "from", str(source), "--out", str(out), *given], checkouts)
    except subprocess.TimeoutExpired:
        trial.refusal = f"takes more than {LIMIT_S:g} s"
        return
    lines = (done.stdout + done.stderr).splitlines() or [f"exit code {done.returncode}"]
    trial.counts = tuple(sum(f" {word}: " in f" {line}" for line in lines) for word in ("left out", "assumed"))
    trial.outcome = "water only" if any("nothing fixed" in line for line in lines) else "yes"
    if done.returncode != 0:
        trial.refusal = lines[-1].replace(f"{source}", Path(trial.path).name).removeprefix("uwsim: error: ")[:200]


def try_robot(trial: Trial, checkouts: Path, out: Path) -> None:
    """Convert a robot, and compare its speeds with those of its text."""
    convert(trial, checkouts, out)
    vehicles = [each for each in sorted(out.glob("*.yaml")) if "vehicles:" not in each.read_text()]
    path = checkouts / trial.repository.replace("/", "+") / trial.path
    if trial.refusal or not vehicles or path.suffix not in (".urdf", ".xacro", ".sdf"):
        return
    text = path.read_text()
    if "ros.org/wiki/xacro" in text:
        from uwsim.evidence.robots.urdf import expanded

        switches = dict.fromkeys(re.findall(r'<xacro:arg\s+name="(\w*sim)"\s+default="false"', text), "true")
        given = {**switches, **dict(each.partition("=")[::2] for each in trial.arguments)}
        with contextlib.suppress(ValueError):
            text = expanded(path, given).decode()
    if "<robot" not in text and "<sdf" not in text:
        return
    wanted = speeds(text, bound_n(trial, text, checkouts))
    done = run(["-m", "tools.robots_trial", "--fly", str(vehicles[0]), json.dumps(wanted)], checkouts)
    if done.returncode != 0:
        trial.refusal = done.stderr.splitlines()[-1][:200]
        return
    trial.ratios = {axis: speed / wanted[axis] for axis, speed in json.loads(done.stdout.splitlines()[-1]).items()}


def parsed(text: str) -> ElementTree.Element:
    """Return the root of a text, whose prefixes need not be declared."""
    return ElementTree.fromstring(re.sub(r"(?<=[<\s/])(\w+):(?=\w)", r"\1_", text))


def number(element: ElementTree.Element, path: str, default: float = 0.0) -> float:
    """Return the number in the text at a path."""
    return float(element.findtext(path) or default)


def row_of(text: str | None) -> Floats:
    """Return the numbers in a text."""
    return np.array([float(word) for word in (text or "").split()])


def frame(xyz_rpy: str | None) -> Floats:
    """Return the matrix (4, 4) of a pose: x y z, and angles about the fixed x, y and z."""
    values = row_of(xyz_rpy or "0 0 0 0 0 0")
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = Rotation.from_euler("xyz", values[3:]).as_matrix(), values[:3]
    return matrix


def speeds(text: str, most_n: float | None) -> dict[str, float]:
    """Return the speeds at which the drag that a URDF or SDF states equals its thrust, by axis.

    most_n: the bound of thrust, where the file has none.
    """
    root = parsed(text)
    joints, links = joints_and_links(root)
    linear, quadratic, base = drag(root)
    here = np.linalg.inv(links.get(base, np.eye(4)))
    limits = {}  # of ArduPilot's plugin, at its lowest and highest output
    for each in root.iter("control"):
        ends = (number(each, "multiplier", 1.0) * (number(each, "offset") + output) for output in (0, 1))
        limits[each.findtext("jointName")] = sorted(ends)
    force = np.zeros(6)
    for plugin in root.iter("plugin"):
        name = plugin.findtext("jointName") or plugin.findtext("joint_name")
        if "thruster" not in (plugin.get("filename") or "").lower() or name not in joints:
            continue
        low, high = limits.get(name, (-GZ_N, GZ_N)) if plugin.find("conversion") is None else thrust(plugin, most_n)
        low, high = number(plugin, "min_thrust_cmd", low), number(plugin, "max_thrust_cmd", high)
        there = here @ joints[name][0]
        along = there[:3, :3] @ joints[name][1] / np.linalg.norm(joints[name][1])
        part = np.concatenate([along, np.cross(there[:3, 3], along)])
        force += np.where(np.abs(part) > LEAST, np.maximum(part * low, part * high), 0.0)
    found = {}
    for axis, k in AXES.items():
        a, b = quadratic[k], linear[k]
        if force[k] > 0.0 and a + b > 0.0:
            found[axis] = float(2.0 * force[k] / (b + np.sqrt(b * b + 4.0 * a * force[k])))
    return found


def joints_and_links(
    root: ElementTree.Element,
) -> tuple[dict[str | None, tuple[Floats, Floats]], dict[str | None, Floats]]:
    """Return the pose of each joint with its axis, and the pose of each link, in the model."""
    joints: dict[str | None, tuple[Floats, Floats]] = {}
    if root.tag == "sdf":
        links = {link.get("name"): frame(link.findtext("pose")) for link in root.iter("link")}
        for joint in root.iter("joint"):
            pose = links.get(joint.findtext("child"), np.eye(4)) @ frame(joint.findtext("pose"))
            axis = row_of(joint.findtext("axis/xyz", "0 0 1"))
            in_model = joint.findtext("axis/use_parent_model_frame") in ("1", "true")
            in_model |= joint.find("axis/xyz[@expressed_in='__model__']") is not None
            joints[joint.get("name")] = pose, pose[:3, :3].T @ axis if in_model else axis
        return joints, links
    parents = {child.get("link"): joint for joint in root.findall("joint") for child in joint.findall("child")}

    def placed(link: str | None) -> Floats:
        if (joint := parents.get(link)) is None:
            return np.eye(4)
        origin, (parent,) = joint.find("origin"), joint.findall("parent")
        at = " ".join("0 0 0" if origin is None else origin.get(key, "0 0 0") for key in ("xyz", "rpy"))
        return np.asarray(placed(parent.get("link")) @ frame(at))

    links = {link.get("name"): placed(link.get("name")) for link in root.findall("link")}
    for child, joint in parents.items():
        stated = joint.find("axis")
        joints[joint.get("name")] = links[child], row_of("1 0 0" if stated is None else stated.get("xyz"))
    return joints, links


def drag(root: ElementTree.Element) -> tuple[Floats, Floats, str | None]:
    """Return the magnitudes of linear and quadratic drag (6,) that a file states, and their link."""
    linear, quadratic, base = np.zeros(6), np.zeros(6), None
    for plugin in root.iter("plugin"):
        file = plugin.get("filename") or ""
        if "hydrodynamics" in file.lower() + (plugin.get("name") or "").lower():
            for k, (row, column) in enumerate(zip("xyzkmn", "UVWPQR", strict=True)):
                linear[k] += abs(number(plugin, row + column))
                quadratic[k] += abs(
                    number(plugin, f"{row}{column}abs{column}", number(plugin, f"{row}{column}{column}"))
                )
            base = plugin.findtext("link_name") or plugin.findtext("bodyName") or base
        for link in plugin.findall("link") if "underwater_object" in file else ():
            base = base or link.get("name")
            for key, sums in (("linear_damping", linear), ("quadratic_damping", quadratic)):
                values = row_of(link.findtext(f"hydrodynamic_model/{key}", "0 " * 6))
                own = np.abs(values if len(values) == 6 else np.diagonal(values.reshape(6, 6)))
                sums += number(link, "hydrodynamic_model/scaling_damping", 1.0) * own
            ahead = row_of(link.findtext("hydrodynamic_model/linear_damping_forward_speed", "0"))
            quadratic[0] += abs(ahead[0])
    return linear, quadratic, base


def thrust(plugin: ElementTree.Element, most_n: float | None) -> tuple[float, float]:
    """Return the lowest and highest thrust of UUV Simulator's thruster."""
    clamp, outputs = number(plugin, "clampMin", number(plugin, "clampMax")), plugin.findtext("conversion/outputValues")
    low, high = -np.inf, np.inf
    if clamp:
        inputs = sorted((number(plugin, "clampMin", -clamp), number(plugin, "clampMax", -clamp)))
        factor = number(plugin, "conversion/rotorConstant") * number(plugin, "gain", 1.0) ** 2
        low, high = (factor * each * abs(each) for each in inputs)
    elif outputs is not None:
        low, high = float(row_of(outputs).min()), float(row_of(outputs).max())
    elif most_n is not None and plugin.find("thrustMax") is None:
        low, high = -most_n, most_n
    return max(low, number(plugin, "thrustMin", -np.inf)), min(high, number(plugin, "thrustMax", np.inf))


def bound_n(trial: Trial, text: str, checkouts: Path) -> float | None:
    """Return the bound of thrust that an argument or UUV Simulator's manager states for a vehicle, if any."""
    stated = [each.partition("=")[2] for each in trial.arguments if each.startswith("max_thrust=")]
    for path in sorted((checkouts / trial.repository.replace("/", "+")).rglob("thruster_manager.yaml")):
        if re.search(rf"tf_prefix: {parsed(text).get('name')}\s", path.read_text()):
            stated += re.findall(r"max_thrust: ([\d.]+)", path.read_text())
    return float(stated[0]) if stated else None


def flown(vehicle: Path, starts: dict[str, float]) -> dict[str, float]:
    """Return the speeds of a vehicle's file at full thrust along each axis, from the speeds that it should have."""
    from uwsim.evidence.scenario_check import check_part
    from uwsim.evidence.validate.flights import deep_scenario
    from uwsim.evidence.vehicle.linear_motion import mass_matrix
    from uwsim.scenario.spec.vehicle import Trim
    from uwsim.simulator.simulator import Simulator

    check = check_part(vehicle, "vehicle")
    if check.simulator is None:
        raise ValueError(f"{vehicle}: {check.mistakes}")
    model = check.simulator.scenario.vehicles[0].model
    neutral = Trim(net_buoyancy_n=0.0)
    sim = Simulator(deep_scenario(model, trim=neutral))
    mass = mass_matrix(model, neutral, 1000.0)
    found = {}
    for axis, start in starts.items():
        k, commands = AXES[axis], {}
        for name, thruster in model.thrusters.items():
            along = np.array(thruster.axis) / np.linalg.norm(thruster.axis)
            part = np.concatenate([along, np.cross(thruster.position_m, along)])
            commands[name] = float(np.sign(part[k])) if abs(part[k]) > LEAST[k] else 0.0
        speed, before = start, np.inf
        for second in range(300):
            for _ in range(round(1.0 / sim.scenario.step_s)):
                held = speed * np.eye(6)[k]
                sim.rov.place((0.0, 0.0, DEPTH_M), velocity_body=held)
                sim.rov.set_thrusters(commands)
                sim.step()
                moved = np.concatenate([sim.rov.velocity.linear_body_m_s, sim.rov.velocity.angular_body_rad_s])
                if second > 2:  # the thrusters have started
                    speed += float(mass[k] @ (moved - held) / mass[k, k])
            if second > 3 and abs(speed - before) < 1e-4 * abs(start):
                break
            before = speed
        found[axis] = speed
    return found


def tables(robots: list[Trial], worlds: list[Trial]) -> str:
    """Return both tables with their counts."""
    converted = [each for each in robots if not each.refusal]
    moved = [np.abs(np.array([*each.ratios.values()]) - 1.0).max() for each in converted if each.ratios]
    head = "| file | repository | converts | left out, assumed | speed flown / computed |\n|---|---|---|---|---|"
    bounded = sum("max_thrust" in " ".join(each.arguments) for each in converted)
    count = (
        f"{len(converted)} of {len(robots)} robots convert, {bounded} of them with a bound of thrust as an argument. "
    )
    count += f"Of the {len(moved)} whose files state drag, "
    judged = "which judges the conversion, not the robot"
    lines = [
        f"{count}{sum(each <= 0.02 for each in moved)} move within 2 % of the speeds that it gives, {judged}:",
        "",
        head,
    ]
    lines += [each.row() for each in robots]
    whole, bare = (sum(not each.refusal and each.outcome == kind for each in worlds) for kind in ("yes", "water only"))
    lines += ["", f"{whole + bare} of {len(worlds)} worlds convert, {bare} of them as water only:", "", head]
    return "\n".join(lines + [each.row() for each in worlds]) + "\n"


def main() -> None:
    """Try all, and print the tables; or fly one vehicle."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("checkouts", type=Path, nargs="?", default=Path())
    parser.add_argument("--only", default="", help="a regular expression that finds the descriptions to try")
    parser.add_argument("--write", action="store_true", help=f"put the tables into {PAGE.relative_to(ROOT)}")
    parser.add_argument("--fly", nargs=2, metavar=("VEHICLE", "SPEEDS"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.fly is not None:
        print(json.dumps(flown(Path(options.fly[0]), json.loads(options.fly[1]))))
        return
    results: list[list[Trial]] = []
    for table, attempt in ((ROBOTS, try_robot), (WORLDS, convert)):
        results.append([])
        for trial in trials(table):
            if re.search(options.only, f"{trial.repository} {trial.path}"):
                with tempfile.TemporaryDirectory() as folder:
                    attempt(trial, options.checkouts.resolve(), Path(folder))
                print(trial.row(), flush=True)
                results[-1].append(trial)
    text = tables(*results)
    print(text)
    if options.write:
        before, _, rest = PAGE.read_text().partition(MARKS[0])
        PAGE.write_text(f"{before}{MARKS[0]}{text}{MARKS[1]}{rest.partition(MARKS[1])[2]}")


if __name__ == "__main__":
    main()
