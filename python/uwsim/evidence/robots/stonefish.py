"""Vehicles and worlds of Stonefish's scenarios (.scn).

Source: Stonefish 1.6, documentation and sources of its parser, solids, thrusters and sensors. Its world is NED, its
bodies' axes are forward, starboard, down. Its drag and added mass follow from geometry by a method of its own, so they
are estimated here, too, from the parts that displace water; where the file states drag, see `stonefish_body`.
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from uwsim.evidence.robots import shapes
from uwsim.evidence.robots.robot import Found, Lump, Mesh, Robot, Thruster, plain_name
from uwsim.evidence.robots.sensors import from_optical, put_camera, put_sensor
from uwsim.evidence.robots.stonefish_body import FLIP, WetPart, body_lump, drag_about, wet_part
from uwsim.evidence.robots.xml_file import HERE, Element, Floats, Pose, read_xml

DENSITY_KG_M3 = 1031.0
"""Stonefish's water, if the file does not state another."""
ENU_FROM_NED = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
FLU_FROM_FRD = np.diag([1.0, -1.0, -1.0])
SENSORS = {"imu": "imu", "pressure": "pressure", "dvl": "dvl", "compass": "compass", "odometry": "velocity"}
ARGUMENT = re.compile(r"\$\((\w+)\s*([^)]*)\)")
FORMULA = re.compile(r"\$\{([^}]*)\}")
OPERATORS = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv}
FILES_MAX = 50
POINTS = 41


def read_stonefish(path: Path, found: Found | None = None) -> Found:
    """Return the vehicles and fixed obstacles of a scenario and what it includes, in `found` if given.

    Raises ValueError or OSError.
    """
    reader = _Reader(found or Found(plain_name(path.stem)))
    reader.read(path, {})
    if not (reader.robots or reader.found.obstacles):
        raise ValueError(f"'{path}': has no <robot> and no <static> object")
    for robot, folder in reader.robots:
        reader.robot(robot, folder)
    for document in reader.documents:
        reader.found.note_unused(document)
    return reader.found


def formula(text: str) -> float:
    """Return the value of a formula of numbers, `pi`, + - * / and parentheses. Raises ValueError."""

    def value(node: ast.expr) -> float:
        if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
            return float(node.value)
        if isinstance(node, ast.Name) and node.id == "pi":
            return math.pi
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            return -value(node.operand)
        if isinstance(node, ast.BinOp) and type(node.op) in OPERATORS:
            return float(OPERATORS[type(node.op)](value(node.left), value(node.right)))
        raise ValueError

    try:
        return value(ast.parse(text.strip(), mode="eval").body)
    except (ValueError, SyntaxError, ZeroDivisionError, RecursionError, MemoryError):
        raise ValueError(f"formula {text[:60]!r}: must consist of numbers, pi, + - * / and parentheses") from None


def _package(name: str, path: Path) -> Path | None:
    """Return the folder of a ROS package: one around a file, or beside one of those."""
    for folder in path.resolve().parents:
        if folder.name == name:
            return folder
        if (folder / name).is_dir():
            return folder / name
    return None


class _Reader:
    def __init__(self, found: Found) -> None:
        self.found = found
        found.density_kg_m3 = DENSITY_KG_M3
        self.materials: dict[str, float] = {}
        self.robots: list[tuple[Element, Path]] = []
        self.documents: list[Element] = []
        self.files = 0

    @property
    def _density(self) -> float:
        return DENSITY_KG_M3 if self.found.density_kg_m3 is None else self.found.density_kg_m3

    def read(self, path: Path, arguments: dict[str, str]) -> None:
        """Read a file and those that it includes."""
        self.files += 1
        if self.files > FILES_MAX:
            raise ValueError(f"'{path}': more than {FILES_MAX} files include each other")

        def expand(text: str) -> str:
            def argument(match: re.Match[str]) -> str:
                if match[1] == "find" and (folder := _package(match[2].strip(), path)) is not None:
                    return str(folder)
                if match[1] != "arg" or match[2].strip() not in arguments:
                    raise ValueError(f"'{path}': {match[0]}: has no value here: replace it")
                return arguments[match[2].strip()]

            return FORMULA.sub(lambda match: repr(formula(match[1])), ARGUMENT.sub(argument, text))

        root = read_xml(path, expand)
        if root.tag != "scenario":
            raise root.error("must be <scenario>")
        self.documents.append(root)
        self._ocean(root)
        for material in (each for group in root.all("materials") for each in group.all("material")):
            self.materials[material.needed("name")] = material.number(None, None, "density")
        for include in root.all("include"):
            given = {arg.needed("name"): arg.needed("value") for arg in include.all("arg")}
            self.read(path.parent / include.needed("file"), given)
        for element in root.all("*"):
            if element.tag == "static":
                self._static(element, path.parent)
            elif element.tag == "robot":
                self.robots.append((element, path.parent))
            elif element.tag in ("dynamic", "animated", "light", "comm", "cable", "actuator", "sensor", "contact"):
                self.found.dropped(element)

    def _ocean(self, root: Element) -> None:
        ocean = root.find("environment/ocean")
        if ocean is None:
            return
        self.found.density_kg_m3 = ocean.number("water", DENSITY_KG_M3, "density")
        for current in ocean.all("current"):
            velocity = current.numbers("velocity", 3, "xyz")
            if current.attribute("type") == "uniform" and velocity is not None:
                self.found.current_m_s = ENU_FROM_NED @ velocity
            else:
                self.found.dropped(current, f", of type {current.attribute('type')}")
        if ocean.number("waves", 0.0, "height") > 0.0:
            self.found.left_out(f"{ocean.path}/waves")

    def _static(self, static: Element, folder: Path) -> None:
        kind = static.needed("type")
        if kind == "plane":
            self.found.bed_z_m = -float(static.origin("world_transform").position_m[2])
            return
        if kind not in ("box", "cylinder", "sphere", "model"):
            self.found.dropped(static, f", of type {kind}")
            return
        mesh, _ = self._solid(static, folder)
        vertices, triangles = shapes.placed(mesh, static.origin("world_transform"))
        name = plain_name(static.name, [item["name"] for item in self.found.obstacles])
        self.found.meshes[name] = (vertices @ ENU_FROM_NED.T, triangles)  # NED to ENU turns, and does not mirror
        self.found.obstacles.append(
            {"kind": "mesh", "name": name, "file": f"{name}.ply", "position_m": [0.0, 0.0, 0.0]}
        )

    def _solid(self, part: Element, folder: Path) -> tuple[Mesh, float]:
        """Return a part's surface in its own frame, and the thickness of its wall, 0 for a solid [m]."""
        kind = part.needed("type")
        physical = part.find("physical") if kind == "model" else part
        if physical is None:
            raise part.error("has no <physical>")
        size = physical.find("dimensions")
        wall = physical.number("thickness", 0.0, "value") or physical.number("dimensions", 0.0, "thickness")
        if kind == "model":
            file = physical.find("mesh")
            if file is None:
                raise physical.error("has no <mesh>")
            scale = np.full(3, file.number(None, 1.0, "scale"))
            name = file.needed("filename")
            beside = [here / name for here in (folder, folder.parent / "data")]  # as in packages of stonefish_ros
            mesh = shapes.from_file(next((each for each in beside if each.is_file()), beside[0]), scale)
        elif size is None:
            raise part.error("has no <dimensions>")
        elif kind == "box":
            sides = size.numbers(None, 3, "xyz")
            if sides is None or not shapes.are_sizes(*sides):
                raise size.error("xyz must be three positive numbers [m]")
            mesh = shapes.box(sides)
        elif kind in ("cylinder", "sphere"):
            radius = size.number(None, None, "radius")
            length = 1.0 if kind == "sphere" else size.number(None, None, "height")
            if not shapes.are_sizes(radius, length):
                raise size.error("radius and height must be positive [m]")
            mesh = shapes.sphere(radius) if kind == "sphere" else shapes.cylinder(radius, length)
        else:
            raise part.error(f"type {kind}: must be box, cylinder, sphere, model or compound")
        return shapes.placed(mesh, physical.origin()), wall

    def robot(self, element: Element, folder: Path) -> None:
        """Read a robot: its links as one rigid body, its thrusters and sensors."""
        place = element.origin("world_transform")
        turn = ENU_FROM_NED @ place.turn @ FLU_FROM_FRD
        others = [robot.name for robot in self.found.robots]
        robot = Robot(plain_name(element.name, others), Pose(ENU_FROM_NED @ place.position_m, turn))
        base = element.find("base_link")
        if base is None:
            raise element.error("has no <base_link>")
        poses = self._poses(element, base)
        wet: list[tuple[Element, WetPart, bool]] = []
        for link in [base, *element.all("link")]:
            for part, at in self._parts(link):
                if (put := self._put(robot, part, folder, poses[link.needed("name")].then(at))) is not None:
                    wet.append((part, *put))
        if any(part.find("hydrodynamics") is not None for part, _, _ in wet):
            robot.drag = partial(drag_about, [each for _, each, _ in wet], self._density)
            for part in (part for part, _, is_stated in wet if not is_stated):
                self.found.assumed(f"{part.path}: drag that it does not state is Stonefish's own for its shape")
        volumes = [shapes.volume_and_centre(solid) for solid in robot.solids]
        if volumes:
            robot.volume_m3 = sum(volume for volume, _ in volumes)
            weighted = sum((volume * centre for volume, centre in volumes), start=np.zeros(3))
            robot.centre_of_buoyancy_m = weighted / robot.volume_m3
        for actuator in element.all("actuator"):
            if actuator.needed("type") in ("thruster", "simple_thruster"):
                robot.thrusters.append(self._thruster(actuator, poses, robot))
            else:
                self.found.dropped(actuator, f", of type {actuator.needed('type')}")
        for sensor in element.all("sensor"):
            self._sensor(robot, sensor, poses)
        for tag in ("comm", "light"):
            for other in element.all(tag):
                self.found.dropped(other)
        self.found.robots.append(robot)

    def _poses(self, robot: Element, base: Element) -> dict[str, Pose]:
        """Return the pose of each link in the base link's frame, with joints at zero."""
        poses, joints = {base.needed("name"): HERE}, list(robot.all("joint"))
        for _ in range(len(joints)):
            for joint in joints:
                parent, child = joint.find("parent"), joint.find("child")
                if parent is None or child is None:
                    raise joint.error("must have a parent and a child")
                if parent.needed("name") in poses and child.needed("name") not in poses:
                    poses[child.needed("name")] = poses[parent.needed("name")].then(joint.origin())
        for joint in joints:
            if joint.attribute("type") != "fixed":
                self.found.left_out(f"{joint.path}: it moves; here it is fixed at zero")
        for link in robot.all("link"):
            if link.needed("name") not in poses:
                raise link.error("no joint connects it with the base link")
        return poses

    def _parts(self, link: Element) -> Iterator[tuple[Element, Pose]]:
        if link.needed("type") != "compound":
            yield link, HERE
            return
        for part in link.all("*"):
            if part.tag in ("external_part", "internal_part"):
                yield part, part.origin("compound_transform")

    def _put(self, robot: Robot, part: Element, folder: Path, at: Pose) -> tuple[WetPart, bool] | None:
        """Add a part's mass and, if it is buoyant, its volume. Return what the water drags at; see `wet_part`."""
        mesh, wall = self._solid(part, folder)
        if part.attribute("type") == "model" and wall == 0.0:  # its winding may be mixed
            mesh = shapes.closed(mesh, part.path)
        material = part.find("material")
        name = None if material is None else material.needed("name")
        if name not in self.materials and part.find("mass") is None:
            raise part.error(f"material {name!r} is not one of {', '.join(self.materials) or 'none'}")
        own = body_lump(part, mesh, wall, self.materials.get(name or ""))
        to_body = FLIP.then(at)
        robot.lumps.append(
            Lump(own.mass_kg, to_body.points(own.centre_m), to_body.turn @ own.inertia_kg_m2 @ to_body.turn.T)
        )
        if part.attribute("buoyant") != "false" and wall > 0.0:
            volume = shapes.area_m2(mesh) * wall
            self.found.left_out(f"{part.path}: the volume of its wall, {volume:.3g} m3")
        elif part.attribute("buoyant") != "false":
            robot.solids.append(shapes.placed(mesh, to_body))
        is_wet = part.tag != "internal_part" and (part.attribute("physics") or "submerged") in ("submerged", "floating")
        return wet_part(part, mesh, own, to_body) if is_wet else None

    def _mount(self, part: Element, poses: dict[str, Pose]) -> Pose:
        link = part.find("link")
        name = None if link is None else link.needed("name")
        if name is None or name not in poses:
            raise part.error(f"link {name!r} is not one of {', '.join(poses)}")
        pose = poses[name].then(part.origin())
        return Pose(FLU_FROM_FRD @ pose.position_m, FLU_FROM_FRD @ pose.turn)

    def _thruster(self, actuator: Element, poses: dict[str, Pose], robot: Robot) -> Thruster:
        at = self._mount(actuator, poses)
        propeller, specs = actuator.find("propeller"), actuator.find("specs")
        if propeller is None or specs is None:
            raise actuator.error("must have <propeller> and <specs>")
        right = propeller.attribute("right") != "false"
        diameter = propeller.number(None, 0.2, "diameter")
        commands = np.linspace(-1.0, 1.0, POINTS)
        model = actuator.find("thrust_model")
        coefficient, advance, torque, lag = None, None, 0.0, 0.0
        if simple := actuator.needed("type") == "simple_thruster":
            low, high = specs.number(None, None, "lower_thrust_limit"), specs.number(None, None, "upper_thrust_limit")
            thrust = np.where(commands < 0.0, -low * commands, high * commands)
            inverted = specs.attribute("inverted") == "true"
        elif model is None:  # Stonefish 1.2 and before
            inverted = specs.attribute("inverted") == "true"
            coefficient, advance = specs.number(None, None, "thrust_coeff"), 1.0
            torque = diameter * specs.number(None, 0.0, "torque_coeff") / coefficient
            revolutions = commands * specs.number(None, None, "max_rpm") / 60.0
            thrust = self._density * coefficient * diameter**4 * revolutions * np.abs(revolutions)
        else:
            inverted = specs.attribute("inverted_setpoint") == "true"
            most = specs.number(None, None, "max_setpoint")
            thrust = self._thrust(model, commands * most, diameter)
            if model.needed("type") == "fluid_dynamics":
                coefficient, advance = model.number("thrust_coeff", None, "forward"), 1.0
                torque = diameter * model.number("torque_coeff", 0.0, "value") / coefficient
            lag = self._lag(actuator)
        # A left-handed screw turns the thrust round; in the model of fluid dynamics it also runs ahead the other way.
        by_blades = not simple and (model is None or model.needed("type") == "fluid_dynamics")
        backward, mirrored = inverted != (not right), inverted != (not right and by_blades)
        name = plain_name(actuator.name, [each.name for each in robot.thrusters])
        pairs = [(float(x), float(y)) for x, y in zip(commands, -thrust[::-1] if mirrored else thrust, strict=True)]
        axis = at.turn[:, 0] * (-1.0 if backward else 1.0)
        clockwise = right != backward
        return Thruster(name, at.position_m, axis, pairs, lag, diameter, coefficient, clockwise, advance, torque)

    def _lag(self, actuator: Element) -> float:
        rotor = actuator.find("rotor_dynamics")
        kind = "zero_order" if rotor is None else rotor.needed("type")
        if rotor is not None and kind == "first_order":
            return rotor.number("time_constant", None, "value")
        if kind in ("yoerger", "bessa"):
            raise actuator.error(f"rotor_dynamics of type {kind}: its setpoint is not a speed: must be another type")
        if kind != "zero_order":
            self.found.left_out(f"{actuator.path}/rotor_dynamics, of type {kind}: thrust follows at once")
        return 0.0

    def _thrust(self, model: Element, speeds: Floats, diameter: float) -> Floats:
        """Return the thrust of propeller speeds [rad/s]."""
        kind = model.needed("type")
        if kind == "quadratic":
            return model.number("thrust_coeff", None, "value") * speeds * np.abs(speeds)
        if kind == "linear_interpolation":
            given, out = model.numbers("input", None, "value"), model.numbers("output", None, "value")
            if given is None or out is None or len(given) != len(out) or (np.diff(given) <= 0.0).any():
                raise model.error("input must increase, and have as many numbers as output")
            return np.asarray(np.interp(speeds, given, out))
        ahead, back = (model.number("thrust_coeff", None, key) for key in ("forward", "reverse"))
        square = speeds * np.abs(speeds)
        if kind == "deadband":
            low, high = (model.number("deadband", None, key) for key in ("lower", "upper"))
            return np.asarray(np.where(square < low, back * (square - low), np.maximum(ahead * (square - high), 0.0)))
        if kind == "fluid_dynamics":
            return self._density * diameter**4 / (2.0 * np.pi) ** 2 * square * np.where(speeds < 0.0, back, ahead)
        raise model.error(f"type {kind}: must be quadratic, deadband, linear_interpolation or fluid_dynamics")

    def _sensor(self, robot: Robot, sensor: Element, poses: dict[str, Pose]) -> None:
        kind, rate = sensor.needed("type"), sensor.number(None, 10.0, "rate")
        if kind == "camera":
            at, specs = self._mount(sensor, poses), sensor.find("specs")
            if specs is None:
                raise sensor.error("has no <specs>")
            size = int(specs.number(None, None, "resolution_x")), int(specs.number(None, None, "resolution_y"))
            pose = Pose(at.position_m, from_optical(at.turn))
            put_camera(robot, sensor.name, pose, specs.number(None, None, "horizontal_fov"), size)
        elif kind in ("multibeam", "multibeam2d"):
            robot.sonar = self._mount(sensor, poses).position_m.tolist()
            self.found.assumed(f"{sensor.path}: its place is the multibeam's mount")
        elif kind == "fls":
            at = self._mount(sensor, poses)
            robot.imaging_sonars[plain_name(sensor.name, robot.imaging_sonars)] = {
                "kind": "forward_looking",
                "position_m": at.position_m.tolist(),
            }
            self.found.assumed(f"{sensor.path}: it looks ahead, with the parameters of `forward_looking`")
        elif kind in SENSORS:
            at = Pose(self._mount(sensor, poses).position_m, np.eye(3))
            put_sensor(robot, self.found, sensor.path, sensor.name, SENSORS[kind], at, rate)
        else:
            self.found.dropped(sensor, f", of type {kind}")
