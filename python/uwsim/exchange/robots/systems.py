"""Plugins on a vehicle, in SDF and, within <gazebo>, in URDF: gz-sim's systems and UUV Simulator's.

Sources: gz-sim's documentation and sources of Thruster, Hydrodynamics, BuoyancyEngine, JointPositionController and
OdometryPublisher. Thrust is along the joint's axis; hydrodynamic forces act at their link's origin.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from uwsim.exchange.robots.lift_drag import is_lift_drag, put_surface, put_uuv_fin
from uwsim.exchange.robots.links import Links, carried, is_same
from uwsim.exchange.robots.motors import commanded, is_motor, is_px4_hull, motor, put_px4_hull, px4_speeds
from uwsim.exchange.robots.robot import SENSES, Description, Robot, Thruster, plain_name
from uwsim.exchange.robots.sensors import put_sensor
from uwsim.exchange.robots.uuv_plugins import is_uuv_object, is_uuv_thruster, put_uuv_object, uuv_errors, uuv_thruster
from uwsim.exchange.robots.xml_file import Element, Floats, is_yes
from uwsim.scenario.read.note import Note

ROWS, COLUMNS = "xyzkmn", "UVWPQR"
THRUST_N, DIAMETER_M = 1000.0, 0.02
"""gz-sim's defaults of Thruster's limits and propeller."""
BOLLARD = (1e-3, 10.0)
"""Coefficients that a vehicle's file may have."""
BLADDER_M3 = {"min_volume": 3e-5, "neutral_volume": 3e-4, "max_volume": 9.9e-4, "max_inflation_rate": 3e-6}
DENSITY_KG_M3, GRAVITY_M_S2 = 1000.0, 9.80665
"""gz-sim's defaults of BuoyancyEngine, but for gravity."""
SENSORS = {"dvl": "dvl", "imu": "imu", "subsea_pressure": "pressure", "magnetometer": "compass"}
"""Kinds of sensors by words in the names of UUV Simulator's plugins."""
LIKE = {"odometry-publisher": "odometry", "pose-publisher": "poses", "joint-state-publisher": "states of joints"}
"""Data that others publish by a plugin, and uwsim without one."""


def put_plugins(robot: Robot, found: Description, plugins: Iterable[Element], links: Links, base: str) -> None:
    """Read the plugins of a vehicle; one that breaks a rule is left out, with the rule.

    The hydrodynamics come first, since fins and neutral buoyancy refer to the density that they state.
    """
    reader = _Reader(robot, found, links, base, list(plugins))
    for plugin in sorted(reader.plugins, key=lambda one: "dynamics" not in (f := _file(one)) and not is_uuv_object(f)):
        with found.beside(plugin):
            reader.read(plugin)


def moves(plugin: Element) -> bool:
    """Return whether a plugin is one that could move a vehicle."""
    file = _file(plugin)
    return "thruster" in file or "buoyancy-engine" in file or is_motor(file)


def _file(plugin: Element) -> str:
    return (plugin.attribute("filename") or "").lower().replace("_system", "-system")


@dataclass
class _Reader:
    robot: Robot
    found: Description
    links: Links
    base: str
    plugins: list[Element]
    limits: dict[str, tuple[float, float]] = field(default_factory=dict)
    speeds: dict[str, tuple[float, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.to_base = self.links.poses[self.base].inverse()
        for plugin in self.plugins:
            with self.found.beside(plugin):
                self.limits.update(_autopilot_limits(plugin))
                self.speeds.update(px4_speeds(plugin))

    def read(self, plugin: Element) -> None:
        file = _file(plugin)
        readers: list[tuple[bool, Callable[[Element], None]]] = [
            (is_uuv_object(file), lambda each: put_uuv_object(self.robot, self.found, each, self.links, self.base)),
            (is_px4_hull(file), self._px4_hull),
            ("hydrodynamics" in file, self._hydrodynamics),
            (is_lift_drag(file), self._surface),
            (is_uuv_thruster(file), self._uuv_thruster),
            (is_motor(file), self._motor),
            ("thruster" in file, self._thruster),
            ("uuv_fin" in file or "fin_ros" in file, self._uuv_fin),
            ("buoyancy-engine" in file, self._engine),
            ("joint-position-controller" in file, self._servo),
        ]
        for is_its, reader in readers:
            if is_its:
                reader(plugin)
                return
        if (kind := next((kind for word, kind in SENSORS.items() if word in file), None)) is not None:
            link = plugin.text("link_name") or plugin.text("linkName") or self.base
            at = self.to_base.then(self.links.pose(link, plugin))
            rate = plugin.number("update_rate", 10.0)
            put_sensor(self.robot, self.found, plugin.path, kind, kind, at, rate, uuv_errors(plugin, kind))
        elif (what := next((what for word, what in LIKE.items() if word in file), None)) is not None:
            self.found.assumed(f"{plugin.path}: uwsim publishes {what} without a plugin", SENSES)
            plugin.use_all()
        else:
            self.found.dropped(plugin, f", {plugin.attribute('filename')}")

    def _surface(self, plugin: Element) -> None:
        put_surface(self.robot, plugin, self.links, self.to_base, self.found)

    def _uuv_fin(self, plugin: Element) -> None:
        put_uuv_fin(self.robot, plugin, self.links, self.to_base, self.found)

    def _uuv_thruster(self, plugin: Element) -> None:
        self.robot.thrusters.append(uuv_thruster(plugin, self.links, self.to_base, self.robot, self.found))

    def _hydrodynamics(self, plugin: Element) -> None:
        link = plugin.text("link_name") or self.base
        there = self.to_base.then(self.links.pose(link, plugin))
        if self.found.density_kg_m3 is None and plugin.find("water_density"):
            self.found.density_kg_m3 = plugin.number("water_density")
        added, linear, quadratic = self._derivatives(plugin)
        if is_yes(plugin.text("disable_added_mass")):
            added[:] = 0.0
        if (current := plugin.numbers("default_current", 3)) is not None:
            self.found.current_m_s = current
        if not any(matrix.any() for matrix in (added, linear, quadratic)):
            stated = any(each.tag[:1] in ROWS and each.tag[1:2] in f"{COLUMNS}D" for each in plugin.all("*"))
            why = "zero coefficients do nothing" if stated else f"'{_file(plugin)}' has a model of its own"
            self.found.dropped(plugin, f": {why}")
            return
        if link != self.base:
            self.found.assumed(f"{plugin.path}: link '{link}' is fixed to the base link, '{self.base}'")
            if quadratic.any() and not is_same(there):
                self.found.assumed(f"{plugin.path}: its quadratic drag is carried to the base link as a matrix")
            added, linear, quadratic = (carried(matrix, there) for matrix in (added, linear, quadratic))
        for key, matrix in (("added_mass", added), ("linear", linear), ("quadratic", quadratic)):
            before = getattr(self.robot, key)
            setattr(self.robot, key, matrix if before is None else before + matrix)

    def _derivatives(self, plugin: Element) -> tuple[Floats, Floats, Floats]:
        """Return added mass, linear and quadratic damping (6, 6) at the link, magnitudes."""
        matrices = np.zeros((3, 6, 6))
        known = set()
        for i, row in enumerate(ROWS):
            for j, column in enumerate(COLUMNS):
                square = f"{row}{column}abs{column}"
                if not plugin.find(square):
                    square = f"{row}{column}{column}"  # until Gazebo Garden
                for matrix, key in zip(matrices, (f"{row}Dot{column}", f"{row}{column}", square), strict=True):
                    known.add(key)
                    matrix[i, j] = -plugin.number(key, 0.0)
                    if i == j and matrix[i, j] < 0.0:
                        self.found.assumed(
                            f"{plugin.path}: {key} = {-matrix[i, j]:g} would drive the hull: {matrix[i, j]:g} is meant"
                        )
                        matrix[i, j] *= -1.0
        for element in plugin.all("*"):
            derivative = element.tag[:1] in ROWS and any(column in element.tag[1:] for column in COLUMNS)
            if derivative and element.tag not in known and element.number(None) != 0.0:
                self.found.left_out(f"{element.path} = {element.text()}")
        return matrices[0], matrices[1], matrices[2]

    def _thruster(self, plugin: Element) -> None:
        """Read gz-sim's Thruster: force at its link's origin, by a command of force, or of speed [rad/s]."""
        joint = self.links.joint(plugin.text("joint_name") or "", plugin)
        low, high = self.limits.get(joint.name, (-THRUST_N, THRUST_N))
        low, high = plugin.number("min_thrust_cmd", low), plugin.number("max_thrust_cmd", high)
        by_speed = is_yes(plugin.text("use_angvel_cmd"))
        unit = "rad/s" if by_speed else "N"
        if not low <= 0.0 < high:
            raise plugin.error(f"commands from {low:g} to {high:g} {unit}: must include 0, and some thrust ahead")
        if joint.name not in self.limits and not (plugin.find("max_thrust_cmd") and plugin.find("min_thrust_cmd")):
            self.found.assumed(f"{plugin.path}: commands from {low:g} to {high:g} {unit}, with gz-sim's defaults")
        coefficient = plugin.number("thrust_coefficient", plugin.number("alpha_1", 1.0))
        diameter, density = plugin.number("propeller_diameter", DIAMETER_M), plugin.number("fluid_density", 1000.0)
        plugin.text("velocity_control")  # of the propeller's speed, which does not change the thrust
        name = plain_name(joint.name.removesuffix("_joint"), [each.name for each in self.robot.thrusters])
        band = plugin.number("deadband", 0.0)
        if not 0.0 <= band < high:
            raise plugin.error(f"deadband = {band:g} N: must be positive, and below the largest thrust")
        gain = abs(coefficient) * density * diameter**4 if by_speed else None
        pairs = commanded(low, high, band, gain)
        what = "vel" if by_speed else "thrust"
        self._topic(plugin, f"thruster '{name}'", plugin.text("topic") or f"joint/{joint.name}/cmd_{what}")
        ahead = -1.0 if by_speed and coefficient < 0.0 else 1.0  # where the thrust of a positive command is
        self.robot.thrusters.append(
            Thruster(
                name,
                self.to_base.then(self.links.pose(joint.child, plugin)).position_m,
                self.to_base.turn @ joint.axis * ahead,
                pairs,
                0.0,
                diameter,
                self._bollard(plugin, coefficient),
                clockwise=coefficient > 0.0,
            )
        )

    def _px4_hull(self, plugin: Element) -> None:
        put_px4_hull(self.robot, self.found, plugin, self.links, self.to_base)

    def _motor(self, plugin: Element) -> None:
        self.robot.thrusters.append(motor(plugin, self.links, self.to_base, self.robot, self.found, self.speeds))

    def _bollard(self, plugin: Element, coefficient: float) -> float | None:
        """Return T / (rho n^2 D^4), n in revolutions, of gz-sim's T / (rho omega^2 D^4), if it is a propeller's."""
        found = abs(coefficient) * 4.0 * np.pi**2
        if BOLLARD[0] <= found <= BOLLARD[1]:
            return found
        self.found.left_out(
            f"{plugin.path}: thrust_coefficient = {coefficient:g}: no propeller has it; thrust is stated"
        )
        return None

    def _engine(self, plugin: Element) -> None:
        """Read a bladder: rho g (V - V_neutral), upward at its link's origin, with a limited rate of filling."""
        at = self.to_base.then(self.links.pose(plugin.text("link_name") or "", plugin))
        least, neutral, most, rate = (plugin.number(key, default) for key, default in BLADDER_M3.items())
        if not least < most or not rate > 0.0:
            raise plugin.error(f"volumes from {least:g} to {most:g} m3 at {rate:g} m3/s: must increase, at some rate")
        weight = plugin.number("fluid_density", DENSITY_KG_M3) * GRAVITY_M_S2
        low, high = (float(weight * (volume - neutral)) for volume in (least, most))
        if not low < 0.0 < high:
            raise plugin.error(f"neutral_volume = {neutral:g} m3: must be between {least:g} and {most:g} m3")
        time_s = 0.5 * (most - least) / rate
        name = plain_name("engine", [each.name for each in self.robot.thrusters])
        self.found.assumed(f"{plugin.path}: its pump lags by {time_s:.3g} s, half the time of a full stroke")
        self._topic(plugin, f"buoyancy engine '{name}'", "buoyancy_engine")
        pairs = [(-1.0, low), (0.0, 0.0), (1.0, high)]
        upward = np.array([0.0, 0.0, 1.0])
        self.robot.thrusters.append(
            Thruster(name, at.position_m, upward, pairs, time_s, DIAMETER_M, None, clockwise=True, force="buoyancy")
        )

    def _servo(self, plugin: Element) -> None:
        """Note the controller of a joint: that of a fin is the fin's own servo."""
        joint = self.links.joint(plugin.text("joint_name") or "", plugin)
        if not any(is_lift_drag(_file(each)) and each.text("link_name") == joint.child for each in self.plugins):
            self.found.dropped(plugin, f" of joint '{joint.name}': no fin is at its link; here it is fixed at zero")
            return
        self.found.assumed(f"{plugin.path}: the fin of joint '{joint.name}' turns at uwsim's rate, without its gains")
        self._topic(plugin, f"fin '{joint.name}'", plugin.text("topic") or f"joint/{joint.name}/0/cmd_pos")
        plugin.use_all()

    def _topic(self, plugin: Element, what: str, topic: str) -> None:
        """Note gz-sim's topic of commands, which a bridge to ROS 2 has mapped."""
        space = plugin.text("namespace")
        topic = f"/model/{space}/{topic}" if space else topic
        self.found.noted(Note("topic", f"{what} is commanded by {topic} in gz-sim"))


def _autopilot_limits(plugin: Element) -> Iterator[tuple[str, tuple[float, float]]]:
    """Yield the joints that ArduPilot's plugin drives by force, and their thrusts at its lowest and highest output."""
    for control in plugin.all("control"):
        if control.text("type") == "COMMAND" and "cmd_thrust" in (control.text("cmd_topic") or ""):
            multiplier, offset = control.number("multiplier", 1.0), control.number("offset", 0.0)
            low, high = sorted((multiplier * offset, multiplier * (1.0 + offset)))
            yield control.text("jointName") or "", (low, high)
