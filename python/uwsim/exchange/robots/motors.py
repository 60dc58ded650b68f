"""Motors that act on their own link in SDF: PX4's and gz-sim's models of propellers, and gas jets.

Sources: gz-sim's MulticopterMotorModel.cc and SpacecraftThrusterModel.cc; PX4's GenericMotorModel.cpp, and its
gazebo_motor_model.cpp for Gazebo Classic. Each applies a
force along its link's z at the link's centre of mass; a propeller that turns counter-clockwise, seen from ahead of its
thrust, turns about that z, and its torque on the vehicle is against it, thrust times `momentConstant`.

Also PX4's plugin for a hull's water (gazebo_uuv_plugin.cpp), and the speeds to which its flight stack can set motors
(gazebo_mavlink_interface.cpp). Damping is linear, at the base link; the buoyancy of a link is a share, its
compensation, of that link's weight, at a point of it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from uwsim.exchange.robots.links import Links, carried
from uwsim.exchange.robots.robot import Description, Robot, Thruster, plain_name
from uwsim.exchange.robots.xml_file import Element, Floats, Pose, is_yes
from uwsim.scenario.read.note import Note

DENSITY_KG_M3 = 1000.0
CLASSIC = "gazebo_motor_model"
MOTORS = ("motor-model", "motormodel", CLASSIC)
JETS = ("spacecraft-thruster", "spacecraftthruster")
SPEED_RAD_S, N_S2, MOMENT_M, LAG_S = 838.0, 8.54858e-06, 0.016, (1.0 / 80.0, 1.0 / 40.0)
"""Their defaults: of maxRotVelocity, motorConstant, momentConstant, timeConstantUp and timeConstantDown."""
POINTS = 81
DIAMETER_M = 0.1
EDGE = 1e-6
"""Width, in parts of the full command, of the jump at the end of a deadband."""


def is_motor(file: str) -> bool:
    """Return whether a plugin's file, in small letters, is that of such a motor."""
    return any(word in file for word in (*MOTORS, *JETS))


def commanded(low: float, high: float, band: float = 0.0, gain: float | None = None) -> list[tuple[float, float]]:
    """Return pairs of a command in [-1, 1] and the thrust [N] of a motor that is commanded by forces from low to high.

    gain: of one that is commanded by speeds, [N s2]. band: thrusts below it are none.
    """
    if gain is not None:
        steps = np.linspace(-1.0, 1.0, POINTS)
        given = np.where(steps > 0.0, high, -low) * steps
        return edged(steps, gain * given * np.abs(given), band)
    return edged(np.array([-1.0, 0.0, 1.0]), np.array([low, 0.0, high]), band)


def edged(commands: Floats, thrust: Floats, band: float) -> list[tuple[float, float]]:
    """Return pairs of commands and thrusts, with none where their thrust is below that at the end of a deadband."""
    if band <= 0.0:
        return [(float(x), float(y)) for x, y in zip(commands, thrust, strict=True)]
    ends = [float(np.interp(sign * band, thrust, commands)) for sign in (-1.0, 1.0)]
    pairs = [(float(x), float(y)) for x, y in zip(commands, thrust, strict=True) if abs(y) > band]
    pairs += [(ends[0] - EDGE, -band)] if thrust.min() < -band else []
    return sorted([*pairs, (ends[0], 0.0), (ends[1], 0.0), (ends[1] + EDGE, band)])


def motor(
    plugin: Element, links: Links, to_base: Pose, robot: Robot, found: Description,
    speeds: Mapping[str, tuple[float, float]],
) -> Thruster:  # fmt: skip
    """Read a motor, or a jet, which thrusts one way. speeds: by number, of those with bounds. Raises ValueError."""
    file = (plugin.attribute("filename") or "").lower().replace("_", "-")
    is_jet = any(word in file for word in JETS)
    link = plugin.text("link_name" if is_jet else "linkName") or ""
    at, lump = to_base.then(links.pose(link, plugin)), links.lumps.get(link)
    place = at.position_m if lump is None else at.points(lump.centre_m[None])[0]
    name = plain_name(link.removesuffix("_link"), [each.name for each in robot.thrusters])
    number = plugin.text("motorNumber") or plugin.text("actuator_number") or ""
    for key in ("jointName", "actuator_number", "rotorVelocitySlowdownSim", "robotNamespace", "motorSpeedPubTopic"):
        plugin.text(key)  # which the propeller's looks and its messages follow
    topic = plugin.text("topic" if is_jet else "commandSubTopic") or "command"
    found.noted(Note("topic", f"thruster '{name}' is commanded by an element of {topic} in gz-sim"))
    if is_jet:
        most = plugin.number("max_thrust")
        if not most > 0.0:
            raise plugin.error(f"max_thrust = {most:g} N: must be positive")
        found.assumed(f"{plugin.path}: its mean thrust: its pulses are shorter than the vehicle's motion")
        plugin.text("duty_cycle_frequency")
        return Thruster(name, place, at.turn[:, 2], [(0.0, 0.0), (1.0, most)], 0.0, DIAMETER_M, None, clockwise=True)
    kind, turning = plugin.text("motorType") or "velocity", plugin.text("turningDirection") or "cw"
    if kind not in ("velocity", "force_polynomial") or turning not in ("cw", "ccw"):
        rule = "must be velocity or force_polynomial, cw or ccw"
        raise plugin.error(f"motorType {kind!r}, turningDirection {turning!r}: {rule}")
    lag, torque, axis = 0.0, 0.0, at.turn[:, 2]
    if kind == "velocity":
        pairs, ahead = _by_speed(plugin, speeds.get(number), turning, found)
        axis, torque = ahead * axis, plugin.number("momentConstant", MOMENT_M)
        lag, slower = (
            plugin.number(f"timeConstant{way}", each) for way, each in zip(("Up", "Down"), LAG_S, strict=True)
        )
        if lag != slower:
            found.assumed(
                f"{plugin.path}: a lag of {lag:g} s, that of a growing speed; one that falls has {slower:g} s"
            )
    else:
        pairs = _by_polynomials(plugin, found)
        for key in ("motorConstant", "momentConstant", "timeConstantUp", "timeConstantDown"):
            plugin.text(key)  # which PX4 does not use for this type
    for key in ("rotorDragCoefficient", "rollingMomentCoefficient"):
        if (value := plugin.number(key, 0.0)) != 0.0:
            found.left_out(f"{plugin.path}: {key} = {value:g}, of flow across the propeller")
    return Thruster(
        name, place, axis, pairs, lag, DIAMETER_M, None, clockwise=turning == "ccw", torque_per_thrust_m=torque
    )


def _by_speed(
    plugin: Element, bounds: tuple[float, float] | None, turning: str, found: Description
) -> tuple[list[tuple[float, float]], float]:
    """Return pairs of commands and thrusts k w |w|, and 1, or -1 if a positive speed pushes against the link's z.

    To Gazebo Classic, w is the joint's, negative for a clockwise motor, and one that is not reversible pushes one way.
    bounds: of w, if a flight stack states them.
    """
    most, constant = plugin.number("maxRotVelocity", SPEED_RAD_S), plugin.number("motorConstant", N_S2)
    is_classic = CLASSIC in (plugin.attribute("filename") or "").lower()
    pushes = constant * (-1.0 if is_classic and turning == "cw" else 1.0)
    is_reversible = not is_classic or is_yes(plugin.text("reversible"))
    if not (most > 0.0 and (pushes if is_reversible and not is_classic else abs(constant)) > 0.0):
        raise plugin.error(f"maxRotVelocity = {most:g} rad/s, motorConstant = {constant:g}: must be positive")
    low, high = (-most, most) if bounds is None else np.clip(bounds, -most, most).tolist()
    if not high > 0.0:
        raise plugin.error(f"speeds from {low:g} to {high:g} rad/s: must reach above 0")
    low = min(low, 0.0) if is_reversible else 0.0
    if bounds is None and is_reversible:
        found.assumed(f"{plugin.path}: {low:g} rad/s astern, as ahead: it states no bound of that")
    found.assumed(f"{plugin.path}: at most {abs(constant) * high * high:.4g} N, at {high:g} rad/s")
    pairs = commanded(low, high, gain=abs(constant))
    return [pair for pair in pairs if low < 0.0 or pair[0] >= 0.0], np.sign(pushes).item() if is_reversible else 1.0


def _by_polynomials(plugin: Element, found: Description) -> list[tuple[float, float]]:
    """Return pairs of commands and the thrusts that PX4's polynomials have for them.

    Their argument is a share in [-1, 1] of the pulse widths between the ends, in [0, 1] of a motor that cannot turn
    back, or with `rpm` the speed up to maxRotVelocity; each direction has the polynomial of its size.
    """
    ahead = _polynomial(plugin, "positiveThrustPolynomial")
    if ahead is None:
        raise plugin.error("has no positiveThrustPolynomial")
    back, method = _polynomial(plugin, "negativeThrustPolynomial"), plugin.text("controlMethod") or "rpm"
    most, least = plugin.number("maxRotVelocity", SPEED_RAD_S), plugin.number("minCommand", 0.0)
    if method == "duty_cycle":
        ends = plugin.number("minDutyCycle"), plugin.number("maxDutyCycle")
        if not ends[0] < ends[1]:
            raise plugin.error(f"duty cycles from {ends[0]:g} to {ends[1]:g}: must increase")
        most = 1.0
    elif method != "rpm" or not most > 0.0:
        raise plugin.error(f"controlMethod {method!r} up to {most:g}: must be duty_cycle or rpm, and positive")
    for key in ("positiveTorquePolynomial", "negativeTorquePolynomial"):
        if (torque := _polynomial(plugin, key)) is not None and torque.any():
            found.left_out(f"{plugin.path}: {key}: to PX4, it is a force, not a torque")
    both_ways = method == "rpm" or is_yes(plugin.text("bidirectionalMotor"))
    x = np.linspace(-1.0 if both_ways else 0.0, 1.0, POINTS)
    size = np.abs(x) * most
    of_ahead, of_back = (
        np.polynomial.polynomial.polyval(size, each) for each in (ahead, ahead if back is None else back)
    )
    thrust = np.where(size < least, 0.0, np.where(x < 0.0, -of_back, of_ahead))
    return [(float(command), float(force)) for command, force in zip(x, thrust, strict=True)]


def _polynomial(plugin: Element, key: str) -> Floats | None:
    """Return coefficients, of the powers from 0, in brackets or not."""
    text = plugin.text(key)
    if text is None:
        return None
    try:
        found = np.array([float(word) for word in text.strip("[] ").replace(",", " ").split()])
    except ValueError:
        found = np.zeros(0)
    if not len(found) or not np.isfinite(found).all():
        raise plugin.error(f"{key}: {text[:60]!r}: must be finite numbers")
    return found


def is_px4_hull(file: str) -> bool:
    """Return whether a plugin's file is that of the hull's water."""
    return "gazebo_uuv_plugin" in file


def put_px4_hull(robot: Robot, found: Description, plugin: Element, links: Links, to_base: Pose) -> None:
    """Read the damping, added mass and buoyancy of a hull. Raises ValueError."""
    there = to_base.then(links.pose(plugin.text("baseLinkName") or "", plugin))
    if found.density_kg_m3 is None:
        found.density_kg_m3 = DENSITY_KG_M3
        found.assumed(f"{plugin.path}: water of {DENSITY_KG_M3:g} kg/m3")
    values = {}
    for key in ("addedMass", "damping"):
        parts = [plugin.numbers(f"{key}{way}", 3) for way in ("Linear", "Angular")]
        values[key] = carried(np.diag(np.concatenate([np.zeros(3) if each is None else each for each in parts])), there)
    robot.added_mass, robot.linear, robot.quadratic = values["addedMass"], values["damping"], np.zeros((6, 6))
    found.assumed(f"{plugin.path}: its added mass also resists acceleration, which Gazebo Classic leaves out")
    volumes, centres = [], []
    for each in plugin.all("buoyancy"):
        link, origin = each.text("link_name") or "", each.numbers("origin", 3)
        at, lump = to_base.then(links.pose(link, each)), links.lumps.get(link)
        volumes.append(each.number("compensation", 0.0) * (0.0 if lump is None else lump.mass_kg) / found.density_kg_m3)
        centres.append(at.points((np.zeros(3) if origin is None else origin)[None])[0])
    if sum(volumes) > 0.0:
        robot.volume_m3, robot.centre_of_buoyancy_m = sum(volumes), np.average(centres, axis=0, weights=volumes)


def px4_speeds(plugin: Element) -> Iterator[tuple[str, tuple[float, float]]]:
    """Yield the number of each motor that a flight stack drives, and its speeds at the ends of its output, -1 and 1."""
    channels = plugin.find("control_channels")
    for channel in () if channels is None else channels.all("channel"):
        offset, scale = channel.number("input_offset", 0.0), channel.number("input_scaling", 1.0)
        ends = sorted(scale * (end + offset) + channel.number("zero_position_armed", 0.0) for end in (-1.0, 1.0))
        yield channel.text("input_index") or "", (ends[0], ends[1])
