"""Vehicles and worlds of Stonefish's scenarios (.scn).

Source: Stonefish 1.6, documentation and sources of its parser, solids, thrusters and sensors. Its world is NED, its
bodies' axes are forward, starboard, down. Its drag and added mass follow from geometry by a method of its own, so they
are estimated here, too, from the parts that displace water; where the file states drag, see `stonefish_parts`.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.exchange.robots import shapes
from uwsim.exchange.robots.floors import put_plane
from uwsim.exchange.robots.links import summed_volume
from uwsim.exchange.robots.robot import SENSES, Description, Lump, Mesh, Robot, Thruster, merged, plain_name
from uwsim.exchange.robots.sensors import from_optical, put_camera, put_imaging, put_sensor
from uwsim.exchange.robots.stonefish_parts import (
    FLIP,
    Fixed,
    WetPart,
    body_lump,
    drag_about,
    fixed_device,
    lump_alone,
    put_comm,
    wet_part,
)
from uwsim.exchange.robots.stonefish_text import Texts, file_named
from uwsim.exchange.robots.xml_file import HERE, Element, Floats, Pose, read_xml

DENSITY_KG_M3 = 1000.0
"""Stonefish's water, if the file does not state another."""
ENU_FROM_NED = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
FLU_FROM_FRD = np.diag([1.0, -1.0, -1.0])
SENSORS = {
    "imu": "imu",
    "pressure": "pressure",
    "dvl": "dvl",
    "compass": "compass",
    "odometry": "velocity",
    "gps": "gps",
    "ins": "ins",
}
PROPULSION = ("thruster", "simple_thruster", "push")
FREE_N = 100.0
"""Assumed: the bound of a thrust that Stonefish does not bound."""
WET = ("submerged", "floating")
YES, NO = ("true", "True", "TRUE", "1"), ("false", "False", "FALSE", "0")
FASTEST_M_S = 5.0
FILES_MAX = 50
WOUND = 0.01
"""Volumes of a closed mesh and of the one that a file has differ by less, in parts of it, if it is wound one way."""
POINTS = 41
CENTRED_M = 0.005
NOISE = {
    "imu": {
        "angle": "orientation",
        "angular_velocity": "angular_velocity",
        "linear_acceleration": "linear_acceleration",
    },
    "pressure": {"pressure": "pressure"},
    "compass": {"heading": "heading"},
    "gps": {"ned_position": "horizontal"},
    "odometry": {"velocity": "linear_velocity", "angular_velocity": "angular_velocity"},
}
"""The channels of sensors by Stonefish's names of their noise."""
SONARS = {
    "fls": (
        "forward_looking",
        {
            "beams": ("specs", "beams"),
            "range_bins": ("specs", "bins"),
            "range_max_m": ("settings", "range_max"),
            "field_of_view_deg": ("specs", "horizontal_fov"),
            "vertical_width_deg": ("specs", "vertical_fov"),
        },
    ),
    "sss": (
        "side_scan",
        {
            "range_bins": ("specs", "bins"),
            "range_max_m": ("settings", "range_max"),
            "along_width_deg": ("specs", "horizontal_beam_width"),
            "vertical_width_deg": ("specs", "vertical_beam_width"),
            "depression_deg": ("specs", "vertical_tilt"),
        },
    ),
}
"""Kinds of imaging sonars, and their parameters by element and attribute."""


def read_stonefish(path: Path, found: Description | None = None) -> Description:
    """Return the vehicles and fixed obstacles of a scenario and what it includes, in `found` if given.

    Raises ValueError or OSError.
    """
    reader = _Reader(found or Description(plain_name(path.stem)), path)
    root = reader.read(path, {})
    reader.texts.require_all()
    for document in reader.documents:
        reader.world(document)
    reader.require_water()
    for document in reader.documents:
        for robot in document.all("robot"):
            with reader.found.vehicle(robot):
                reader.robot(robot)
    for document in reader.documents:
        reader.found.note_unused(document)
    reader.found.require_any(root, "has no <robot> that a thruster moves, and no <static> object")
    return reader.found


class _Reader:
    def __init__(self, found: Description, top: Path) -> None:
        self.found = found
        self.top = top
        self.texts = Texts(found.given.arguments)
        self.materials: dict[str, float] = {}
        self.documents: list[Element] = []
        self.given: list[Mesh] = []
        self.devices: list[Fixed] = []
        self._closed = cache(lambda path, scale: shapes.closed(shapes.from_file(path, np.full(3, scale)), str(path)))

    @property
    def _density(self) -> float:
        return DENSITY_KG_M3 if self.found.density_kg_m3 is None else self.found.density_kg_m3

    def read(self, path: Path, arguments: dict[str, str]) -> Element:
        """Read a file and those that it includes. Returns its root."""
        if len(self.documents) >= FILES_MAX:
            raise ValueError(f"'{path}': more than {FILES_MAX} files include each other")
        own = {
            arg.needed("name"): arg.attribute("value") or arg.attribute("default") or ""
            for arg in read_xml(path).all("arg")
        }
        own = {name: self.found.given.arguments.get(name, value) for name, value in own.items()} | arguments
        root = read_xml(path, lambda text: self.texts.expanded(text, path, own))
        if root.tag != "scenario":
            raise root.error("must be <scenario>")
        list(root.all("arg"))  # are used
        self.documents.append(root)
        for include in root.all("include"):
            arguments = {arg.needed("name"): arg.needed("value") for arg in include.all("arg")}
            if "$(arg" in (name := include.needed("file")) or "$(param" in name:
                continue  # is missing
            with self.found.vehicle(include):  # there may be one in it
                self.read(self._file(name, include), arguments)
        return root

    def _file(self, name: str, element: Element) -> Path:
        return file_named(name, (element.file, self.top), self.found.given.data)

    def world(self, root: Element) -> None:
        """Read the water, the materials and the fixed objects of a document."""
        ocean = root.find("environment/ocean")
        if ocean is not None and self.found.density_kg_m3 is not None:
            self.found.dropped(ocean, ": Stonefish has the first file's water")
        elif ocean is not None:
            with self.found.beside(ocean):
                self._ocean(ocean)
        for material in (each for group in root.all("materials") for each in group.all("material")):
            with self.found.beside(material):
                self.materials.setdefault(material.needed("name"), material.number(None, None, "density"))
        for static in root.all("static"):
            with self.found.beside(static):
                self._static(static)
        for body in root.all("dynamic"):
            with self.found.beside(body):
                self._loose(body)
        for comm in root.all("comm"):
            with self.found.beside(comm):
                self._device(comm, comm.origin("world_transform" if comm.find("world_transform") else "origin"))
        for element in root.all("*"):
            if element.tag in ("animated", "light", "cable", "glue", "sensor", "contact"):
                self.found.dropped(element)

    def _ocean(self, ocean: Element) -> None:
        if (density := ocean.numbers("water", 1, "density")) is not None:
            if not density[0] > 0.0:
                raise ocean.error(f"water: density = {density[0]:g} kg/m3: must be positive")
            self.found.density_kg_m3 = float(density[0])
        self.require_water()
        for current in ocean.all("current"):
            with self.found.beside(current):
                velocity = current.numbers("velocity", 3, "xyz")
                if current.attribute("type") != "uniform" or velocity is None:
                    raise current.error(f"type {current.attribute('type')}: must be uniform, with a velocity")
                if (fast := float(np.linalg.norm(velocity))) > FASTEST_M_S:
                    raise current.error(f"{fast:g} m/s: must be at most {FASTEST_M_S:g} m/s")
                before = np.zeros(3) if self.found.current_m_s is None else self.found.current_m_s
                self.found.current_m_s = before + ENU_FROM_NED @ velocity
        if (height := ocean.number("waves", 0.0, "height")) > 0.0:
            self.found.left_out(f"{ocean.path}/waves, {height:g} m high")

    def require_water(self) -> None:
        """Assume the density of the water where no file states it."""
        if self.found.density_kg_m3 is None:
            self.found.assumed(f"water of {DENSITY_KG_M3:g} kg/m3, as Stonefish has it without a density")
            self.found.density_kg_m3 = DENSITY_KG_M3

    def _static(self, static: Element) -> None:
        kind = static.needed("type")
        if kind == "plane":
            at = static.origin("world_transform")
            put_plane(self.found, static.path, ENU_FROM_NED @ at.position_m, ENU_FROM_NED @ -at.turn[:, 2])
            return
        place = static.origin("world_transform")
        for comm in static.all("comm"):
            with self.found.beside(comm):
                self._device(comm, place.then(comm.origin()))
        mesh, _, _ = self._solid(static, is_body=False)
        vertices, triangles = shapes.placed(mesh, place)
        name = self.found.body_name(static.name)
        self.found.meshes[name] = (vertices @ ENU_FROM_NED.T, triangles)  # NED to ENU turns, and does not mirror
        self.found.obstacles.append(
            {"kind": "mesh", "name": name, "file": f"{name}.ply", "position_m": [0.0, 0.0, 0.0]}
        )

    def _device(self, comm: Element, place: Pose) -> None:
        self.devices.append(fixed_device(comm, ENU_FROM_NED @ place.position_m, self.found))

    def _loose(self, body: Element) -> None:
        """Read a body that water, weight and contacts move: its mass fills its volume here."""
        place, meshes, lumps = body.origin("world_transform"), [], []
        if (body.attribute("physics") or "submerged") not in WET:
            raise body.error(f"physics {body.attribute('physics')}: must be {' or '.join(WET)}")
        for part, at in self._parts(body):
            _, mesh, wall = self._solid(part)
            own = body_lump(part, mesh, wall, self._part_density(part))
            lumps.append(Lump(own.mass_kg, at.points(own.centre_m[None])[0], own.inertia_kg_m2))
            if part.tag == "internal_part":
                continue
            if part.attribute("buoyant") in NO or wall > 0.0:
                self.found.assumed(f"{part.path}: it displaces all of its volume here")
            meshes.append(shapes.placed(mesh, at))
        if not meshes:
            raise body.error("has no part that water meets")
        mesh, whole = shapes.joined(meshes), merged(lumps)
        away = float(np.linalg.norm(shapes.volume_and_centre(mesh)[1] - whole.centre_m))
        if away > CENTRED_M:
            self.found.assumed(f"{body.path}: its centre of mass is that of its volume, {away:.3g} m away")
        name, (vertices, triangles) = self.found.body_name(body.name), shapes.placed(mesh, place)
        self.found.meshes[name] = (vertices @ ENU_FROM_NED.T, triangles)
        shape = {"kind": "mesh", "name": name, "file": f"{name}.ply", "position_m": [0.0, 0.0, 0.0]}
        self.found.objects.append({"shape": shape, "mass_kg": whole.mass_kg})

    def _solid(self, part: Element, is_body: bool = True) -> tuple[Mesh, Mesh, float]:
        """Return a part's surface in its own frame, the same closed, and the thickness of its wall, 0 for a solid [m].

        A body's mesh without a wall is closed, since its winding may be mixed.
        """
        kind = part.needed("type")
        physical = part.find("physical") if kind == "model" else part
        if physical is None:
            raise part.error("has no <physical>")
        wall = physical.number("thickness", 0.0, "value") or physical.number("dimensions", 0.0, "thickness")
        if kind == "model":
            file = physical.find("mesh")
            if file is None:
                raise physical.error("has no <mesh>")
            path, scale = self._file(file.needed("filename"), file), file.number(None, 1.0, "scale")
            self.found.opens(path)
            given = shapes.from_file(path, np.full(3, scale))
            closed = self._closed(path, scale) if is_body and wall <= 0.0 else given
        else:
            given = closed = _primitive(part, kind)
        at = physical.origin()
        return shapes.placed(given, at), shapes.placed(closed, at), max(wall, 0.0)

    def robot(self, element: Element) -> None:
        """Read a robot: its links as one rigid body, its thrusters and sensors. Raises ValueError."""
        actuators = list(element.all("actuator"))
        if not any(each.attribute("type") in PROPULSION for each in actuators):
            self.found.dropped(element, ": no thruster moves it")
            return
        if element.attribute("fixed") in YES:
            self.found.left_out(f"{element.path}: fixed: its base is free here")
        place = element.origin("world_transform")
        turn = ENU_FROM_NED @ place.turn @ FLU_FROM_FRD
        others = [robot.name for robot in self.found.robots]
        robot = Robot(plain_name(element.name, others), Pose(ENU_FROM_NED @ place.position_m, turn))
        base = element.find("base_link")
        if base is None:
            raise element.error("has no <base_link>")
        poses = self._poses(element, base)
        for actuator in actuators:
            if actuator.attribute("type") in PROPULSION:
                with self.found.beside(actuator):
                    robot.thrusters.append(self._thruster(actuator, poses, robot))
            else:
                self.found.dropped(actuator, f", of type {actuator.attribute('type')}")
        if not robot.thrusters:
            raise element.error("none of its thrusters can be used, so nothing could move it: see what was left out")
        self._bodies(robot, [base, *element.all("link")], poses)
        if not robot.solids:
            raise element.error("no part of it that can be used displaces water: see what was left out")
        for sensor in element.all("sensor"):
            with self.found.beside(sensor):
                self._sensor(robot, sensor, poses)
        for comm in element.all("comm"):
            with self.found.beside(comm):
                put_comm(robot, comm, self._mount(comm, poses), self.devices, self.found)
        for light in element.all("light"):
            self.found.dropped(light)
        self.found.robots.append(robot)

    def _bodies(self, robot: Robot, links: list[Element], poses: dict[str, Pose]) -> None:
        """Add mass, volume and drag of all links."""
        wet: list[tuple[Element, WetPart, bool]] = []
        self.given = []
        for link in links:
            if (pose := poses.get(link.name)) is None:
                self.found.dropped(link, ": no joint connects it with the base link")
                continue
            is_wet = (link.attribute("physics") or "submerged") in WET
            for part, at in self._parts(link):
                with self.found.beside(part):
                    if (put := self._put(robot, part, FLIP.then(pose.then(at)), is_wet)) is not None:
                        wet.append((part, *put))
        if any(part.find("hydrodynamics") is not None for part, _, _ in wet):
            robot.drag = partial(drag_about, [each for _, each, _ in wet], self._density)
            for part in (part for part, _, is_stated in wet if not is_stated):
                self.found.assumed(f"{part.path}: drag that it does not state is Stonefish's own for its shape")
        if robot.solids:
            self._displace(robot)

    def _displace(self, robot: Robot) -> None:
        """Set the displaced volume: that of the closed meshes, or Stonefish's, if it is nearer to the mass.

        To Stonefish, what winds inward displaces a negative volume, and its files are ballasted for that.
        """
        volume, centre = summed_volume(robot.solids)
        signed, signed_centre = summed_volume(self.given)
        neutral = sum(lump.mass_kg for lump in robot.lumps) / self._density
        if abs(signed - volume) > WOUND * volume:
            if signed > 0.0 and abs(signed - neutral) < abs(volume - neutral):
                volume, centre, signed = signed, signed_centre, volume
            self.found.assumed(
                f"vehicle '{robot.name}': displaces {volume:.4g} m3, nearer to its mass than {signed:.4g} m3: its "
                "meshes wind both ways, and to Stonefish what winds inward displaces a negative volume"
            )
        robot.volume_m3, robot.centre_of_buoyancy_m = volume, centre

    def _poses(self, robot: Element, base: Element) -> dict[str, Pose]:
        """Return the pose of each link that joints connect, in the base link's frame, with joints at zero."""
        poses, joints, waiting = {base.name: HERE}, list(robot.all("joint")), [base.name]
        below: dict[str, list[tuple[Element, str]]] = {}
        for joint in joints:
            parent, child = (joint.find(each) for each in ("parent", "child"))
            if parent is not None and child is not None:
                below.setdefault(parent.name, []).append((joint, child.name))
        while waiting:
            name = waiting.pop()
            for joint, child_name in below.get(name, []):
                if child_name not in poses:
                    poses[child_name] = poses[name].then(joint.origin())
                    waiting.append(child_name)
        for joint in joints:
            ends = [joint.find(end) for end in ("parent", "child")]
            if any(end is None or end.name not in poses for end in ends):
                self.found.dropped(joint, ": it holds nothing to the base link")
            elif joint.attribute("type") != "fixed":
                self.found.left_out(f"{joint.path}: it moves; here it is fixed at zero")
        return poses

    def _parts(self, link: Element) -> Iterator[tuple[Element, Pose]]:
        if link.attribute("type") != "compound":
            yield link, HERE
            return
        for part in link.all("*"):
            if part.tag in ("external_part", "internal_part"):
                yield part, part.origin("compound_transform")

    def _put(self, robot: Robot, part: Element, to_body: Pose, link_is_wet: bool) -> tuple[WetPart, bool] | None:
        """Add a part's mass and, if it is buoyant, its volume. Return what the water drags at; see `wet_part`."""
        density = self._part_density(part)
        try:
            given, mesh, wall = self._solid(part)
        except (ValueError, OSError) as error:
            robot.lumps.append(lump_alone(part, to_body, error))
            rule = str(error).removeprefix(f"'{part.file}': ")
            self.found.assumed(f"{part.path}: {robot.lumps[-1].mass_kg:g} kg that displace nothing: {rule}")
            return None
        own = body_lump(part, mesh, wall, density)
        robot.lumps.append(
            Lump(own.mass_kg, to_body.points(own.centre_m), to_body.turn @ own.inertia_kg_m2 @ to_body.turn.T)
        )
        is_wet = link_is_wet and (part.attribute("physics") or "submerged") in WET
        if is_wet and part.attribute("buoyant") not in NO and wall > 0.0:
            volume = shapes.area_m2(mesh) * wall
            self.found.left_out(f"{part.path}: the volume of its wall, {volume:.3g} m3")
        elif is_wet and part.attribute("buoyant") not in NO:
            robot.solids.append(shapes.placed(mesh, to_body))
            self.given.append(shapes.placed(given, to_body))
        return wet_part(part, mesh, own, to_body) if is_wet and part.tag != "internal_part" else None

    def _part_density(self, part: Element) -> float:
        """Return the density of a part's material; of one that is unknown, that of the first, as in Stonefish."""
        material = part.find("material")
        name = "" if material is None else material.attribute("name") or ""
        if name in self.materials:
            return self.materials[name]
        first, density = next(iter(self.materials.items()), ("water", self._density))
        self.found.assumed(f"material {name!r}, which no file has, is {first!r}, of {density:g} kg/m3")
        return density

    def _mount(self, part: Element, poses: dict[str, Pose]) -> Pose:
        link = part.find("link")
        name = None if link is None else link.needed("name")
        if name is None or name not in poses:
            raise part.error(f"link {name!r} is not one of {', '.join(poses)}")
        pose = poses[name].then(part.origin())
        return Pose(FLU_FROM_FRD @ pose.position_m, FLU_FROM_FRD @ pose.turn)

    def _thruster(self, actuator: Element, poses: dict[str, Pose], robot: Robot) -> Thruster:
        at, kind = self._mount(actuator, poses), actuator.needed("type")
        propeller, specs = actuator.find("propeller"), actuator.find("specs")
        right = propeller is None or propeller.attribute("right") not in NO
        diameter = 0.2 if propeller is None else propeller.number(None, 0.2, "diameter")
        commands = np.linspace(-1.0, 1.0, POINTS)
        model = actuator.find("thrust_model")
        coefficient, advance, torque, lag = None, None, 0.0, 0.0
        if kind != "thruster":
            inverted = specs is not None and specs.attribute("inverted") in YES
            low, high = self._limits(actuator, specs, "thrust_limit" if kind == "simple_thruster" else "limit")
            thrust = np.where(commands < 0.0, -low * commands, high * commands)
        elif specs is None:
            raise actuator.error("has no <specs>")
        elif model is None:  # Stonefish 1.3 and before
            inverted = specs.attribute("inverted") in YES
            coefficient, advance = specs.number(None, None, "thrust_coeff"), 1.0
            back = specs.number(None, coefficient, "thrust_coeff_backward")
            torque = diameter * specs.number(None, 0.0, "torque_coeff") / coefficient
            speeds = commands * specs.number(None, None, "max_rpm") / 60.0
            thrust = self._density * diameter**4 * speeds * np.abs(speeds) * np.where(speeds < 0.0, back, coefficient)
        else:
            inverted = specs.attribute("inverted_setpoint") in YES
            specs.attribute("normalized_setpoint")  # as each command is here
            most = abs(specs.number(None, None, "max_setpoint"))
            if (knots := model.numbers("input", None, "value")) is not None and most > 0.0:
                commands = np.unique(np.round([*commands, *np.clip([*knots, *-knots], -most, most) / most], 9))
            speeds, lag = self._speeds(actuator, commands * most)
            thrust = self._thrust(model, speeds, diameter)
            if model.needed("type") == "fluid_dynamics":
                coefficient, advance = model.number("thrust_coeff", None, "forward"), 1.0
                torque = diameter * model.number("torque_coeff", 0.0, "value") / coefficient
        if not np.isfinite([*thrust, torque]).all():
            raise actuator.error("its thrust is not finite")
        # A left-handed screw turns the thrust round; in the model of fluid dynamics it also runs ahead the other way.
        by_blades = kind == "thruster" and (model is None or model.needed("type") == "fluid_dynamics")
        turned = not right and kind != "push"
        backward, mirrored = inverted != turned, inverted != (turned and by_blades)
        name = plain_name(actuator.name, [each.name for each in robot.thrusters])
        pairs = [(float(x), float(y)) for x, y in zip(commands, -thrust[::-1] if mirrored else thrust, strict=True)]
        axis = at.turn[:, 0] * (-1.0 if backward else 1.0)
        clockwise = right != backward
        return Thruster(name, at.position_m, axis, pairs, lag, diameter, coefficient, clockwise, advance, torque)

    def _limits(self, actuator: Element, specs: Element | None, what: str) -> tuple[float, float]:
        low, high = (None if specs is None else specs.numbers(None, 1, f"{side}_{what}") for side in ("lower", "upper"))
        if low is not None and high is not None and low[0] < high[0]:
            return float(low[0]), float(high[0])
        self.found.assumed(f"{actuator.path}: at most {FREE_N:g} N either way, since it states no limits")
        return -FREE_N, FREE_N

    def _speeds(self, actuator: Element, setpoints: Floats) -> tuple[Floats, float]:
        """Return the speeds at which a rotor settles [rad/s], and the time constant with which it gets there [s].

        Yoerger: dw/dt = beta u - alpha w |w|. Bessa: J dw/dt = k_t / R u - k_v1 w - k_v2 w |w|. Both have a time
        constant for small changes only, which is that at full speed. Stonefish bounds w to twice the largest setpoint.
        """
        rotor = actuator.find("rotor_dynamics")
        kind = "zero_order" if rotor is None else rotor.attribute("type")
        if rotor is None or kind == "zero_order":
            return setpoints, 0.0
        if kind == "first_order":
            return setpoints, rotor.number("time_constant", None, "value")
        if kind in ("yoerger", "bessa"):
            keys = ("alpha", "beta") if kind == "yoerger" else ("jmsp", "kv1", "kv2", "kt", "rm")
            given = {key: rotor.number(key, None, "value") for key in keys}
            if any(value < 0.0 or (value == 0.0 and key != "kv1") for key, value in given.items()):
                raise rotor.error(f"{', '.join(keys)}: must be positive")
            square = given["alpha"] if kind == "yoerger" else given["kv2"]
            pull = np.abs(setpoints) * (given["beta"] if kind == "yoerger" else given["kt"] / given["rm"])
            linear, inertia = given.get("kv1", 0.0), given.get("jmsp", 1.0)
            speeds = (np.sqrt(linear**2 + 4.0 * square * pull) - linear) / (2.0 * square)
            speeds = np.minimum(speeds, 2.0 * setpoints.max())
            lag = inertia / (linear + 2.0 * square * float(speeds.max()))
            self.found.assumed(f"{rotor.path}: {kind}: a lag of {lag:.3g} s, that of small changes at full speed")
            return np.sign(setpoints) * speeds, lag
        inertia, gain = rotor.number("rotor_inertia", 0.0, "value"), rotor.number("kp", 0.0, "value")
        lag = inertia / gain if kind == "mechanical_pi" and inertia > 0.0 and gain > 0.0 else 0.0
        self.found.left_out(
            f"{rotor.path}, of type {kind}: {f'a lag of {lag:.3g} s' if lag else 'thrust follows at once'}"
        )
        return setpoints, lag

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
        kind, specs = sensor.needed("type"), sensor.find("specs")
        if (rate := sensor.number(None, 0.0, "rate")) <= 0.0 and kind in SENSORS:
            self.found.assumed("sensors without a rate: 10 Hz; Stonefish's measure at every step", SENSES)
        if kind == "camera":
            at = self._mount(sensor, poses)
            if specs is None:
                raise sensor.error("has no <specs>")
            size = int(specs.number(None, None, "resolution_x")), int(specs.number(None, None, "resolution_y"))
            pose = Pose(at.position_m, from_optical(at.turn))
            put_camera(robot, sensor.name, pose, specs.number(None, None, "horizontal_fov"), size)
        elif kind in ("multibeam", "multibeam1d", "multibeam2d"):
            robot.sonar = self._mount(sensor, poses).position_m.tolist()
            self.found.assumed(f"{sensor.path}: its place is the multibeam's mount", SENSES)
        elif kind in SONARS:
            at = self._mount(sensor, poses)
            name, keys = SONARS[kind]
            stated = {
                key: value.item()
                for key, (tag, of) in keys.items()
                if (value := sensor.numbers(tag, 1, of)) is not None
            }
            ahead = Pose(at.position_m, from_optical(at.turn) if kind == "fls" else np.eye(3))
            put_imaging(robot, self.found, sensor.path, sensor.name, name, ahead, stated)
        elif kind in SENSORS:
            mount = self._mount(sensor, poses)
            at = Pose(mount.position_m, mount.turn @ FLU_FROM_FRD)
            put_sensor(robot, self.found, sensor.path, sensor.name, SENSORS[kind], at, rate, _errors(sensor, kind))
        else:
            self.found.dropped(sensor, f", of type {kind}")


def _primitive(part: Element, kind: str) -> Mesh:
    size = part.find("dimensions")
    if kind not in ("box", "cylinder", "sphere", "torus"):
        raise part.error(f"type {kind}: must be box, cylinder, sphere, torus or model")
    if size is None:
        raise part.error("has no <dimensions>")
    if kind == "box":
        sides = size.numbers(None, 3, "xyz")
        if sides is None or not shapes.are_sizes(*sides):
            raise size.error("xyz must be three positive numbers [m]")
        return shapes.box(sides)
    keys = {"cylinder": ("radius", "height"), "sphere": ("radius",), "torus": ("major_radius", "minor_radius")}[kind]
    radius, *other = (size.number(None, None, key) for key in keys)
    if not shapes.are_sizes(radius, *other):
        raise size.error(f"{' and '.join(keys)} must be positive [m]")
    if kind == "sphere":
        return shapes.sphere(radius)
    return shapes.cylinder(radius, other[0]) if kind == "cylinder" else shapes.torus(radius, other[0])


def _errors(sensor: Element, kind: str) -> dict[str, Any]:
    """Return the white noise that a sensor states, the largest of its axes, and the range of a DVL."""
    if kind == "dvl":
        keys = {
            "beam_slant_deg": ("specs", "beam_angle"),
            "range_min_m": ("range", "altitude_min"),
            "range_max_m": ("range", "altitude_max"),
        }
        return {
            key: value.item() for key, (tag, of) in keys.items() if (value := sensor.numbers(tag, 1, of)) is not None
        }
    channels = {}
    for key, channel in NOISE.get(kind, {}).items():
        noise = sensor.numbers("noise", None, key)
        if noise is not None and (std := float(np.abs(noise).max())) > 0.0:
            channels[channel] = {"std": std}
    return {"channels": channels} if channels else {}
