"""UUV Simulator's plugins for hydrodynamics and thrusters, in URDF and SDF.

Sources: documentation and sources of libuuv_underwater_object_ros_plugin (Manhaes et al. 2016) and
libuuv_thruster_ros_plugin. Its damping is negative; positive values would drive the hull.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from uwsim.base.texts.yaml_document import read_yaml
from uwsim.exchange.robots import shapes
from uwsim.exchange.robots.links import Links, carried
from uwsim.exchange.robots.robot import Description, Robot, Thruster, plain_name
from uwsim.exchange.robots.sensors import Errors
from uwsim.exchange.robots.sources import checkout_of
from uwsim.exchange.robots.xml_file import Element, Floats, Pose, is_yes

DENSITY_KG_M3 = 1028.0
"""UUV Simulator's water."""
POINTS = 41
MANAGER = "thruster_manager.yaml"
"""UUV Simulator's file with max_thrust [N], which its manager allows each thruster of a vehicle."""
MANAGER_FOLDERS = (".", "config", "../config")
MOST = "max_thrust"
"""The key in that file, and the argument by which a user states it."""
INPUT_MAX = 1e9
FORWARD = "linear_damping_forward_speed"
"""Damping times the speed ahead; on that axis, it is quadratic."""


def is_uuv_object(file: str) -> bool:
    """Return whether a plugin's file is that of the hydrodynamics."""
    return "underwater_object" in file


def is_uuv_thruster(file: str) -> bool:
    """Return whether a plugin's file is that of a thruster."""
    return "uuv_thruster" in file or "thruster_ros" in file


def put_uuv_object(robot: Robot, found: Description, plugin: Element, links: Links, base: str) -> None:
    """Read the hydrodynamics of a vehicle: the sum over its links, of which those beside the base are carried to it."""
    if plugin.find("fluid_density"):
        found.density_kg_m3 = plugin.number("fluid_density")
    elif found.density_kg_m3 is None:
        found.density_kg_m3 = DENSITY_KG_M3
    elements, volumes, centres, models = list(plugin.all("link")), [], [], []
    for link in elements:
        with found.beside(link):
            name = link.needed("name")
            there = links.poses[base].inverse().then(links.pose(name, link))
            lump = robot.whole() if len(elements) == 1 else links.lumps.get(name)
            volume_m3 = _volume_m3(link, 0.0 if lump is None else lump.mass_kg, found)
            centre = link.numbers("center_of_buoyancy", 3)
            model = _matrices(robot, found, link)
            if name != base:
                found.assumed(f"{link.path}: it is fixed to the base link, '{base}'")
            volumes.append(volume_m3)
            centres.append(there.points(np.zeros((1, 3)) if centre is None else centre[None])[0])
            models.append([] if model is None else [carried(matrix, there) for matrix in model])
    if volume := sum(volumes):
        robot.volume_m3 = volume
        robot.centre_of_buoyancy_m = np.average(centres, axis=0, weights=volumes)
    elif centres:
        robot.volume_m3, robot.centre_of_buoyancy_m = None, centres[0]
    if stated := [model for model in models if model]:
        robot.added_mass, robot.linear, robot.quadratic = (
            sum(each, np.zeros((6, 6))) for each in zip(*stated, strict=True)
        )


def uuv_current_m_s(current: Element) -> Floats:
    """Return the mean velocity of UUV Simulator's <constant_current> in the world, from its speed and two angles."""
    speed, ahead, up = (
        current.number(f"{key}/mean", 0.0) for key in ("velocity", "horizontal_angle", "vertical_angle")
    )
    current.use_all()
    return speed * np.array([np.cos(ahead) * np.cos(up), np.sin(ahead) * np.cos(up), np.sin(up)])


def _volume_m3(link: Element, mass_kg: float, found: Description) -> float:
    """Return the volume that a link displaces, 0 for one that is not positive."""
    if is_yes(link.text("neutrally_buoyant")):
        assert found.density_kg_m3 is not None
        return mass_kg / found.density_kg_m3
    volume_m3 = link.number("volume")
    if volume_m3 > 0.0:
        return volume_m3
    found.left_out(f"{link.path}: volume = {volume_m3:g} m3: must be positive: that of the shapes is taken")
    return 0.0


def _matrices(robot: Robot, found: Description, link: Element) -> tuple[Floats, Floats, Floats] | None:
    """Return Fossen's matrices of a <link>: added mass, linear and quadratic damping, magnitudes, at its origin."""
    sides = [link.number(f"box/{side}", 0.0) for side in ("length", "width", "height")]
    if not robot.solids and all(side > 0.0 for side in sides):
        robot.solids = [shapes.box(np.array(sides))]
        found.assumed(f"{link.path}: the hull is the plugin's box, since the links have no collision shapes here")
    model = link.find("hydrodynamic_model")
    if model is None or model.text("type") != "fossen":
        kind = None if model is None else model.text("type")
        found.left_out(f"{link.path}: hydrodynamic model {kind}: only fossen is read")
        if model is not None:
            model.use_all()
        return None
    if any(model.number(key, 0.0) != 0.0 for key in ("offset_added_mass", "offset_linear_damping")):
        found.left_out(f"{model.path}: its offsets")
    scale = model.number("scaling_damping", 1.0)
    added = _matrix(model, "added_mass", 1.0, found) * model.number("scaling_added_mass", 1.0)
    quadratic = _matrix(model, "quadratic_damping", -scale, found)
    forward = _matrix(model, FORWARD, -1.0, found)
    quadratic[:, 0] += forward[:, 0]  # times the speed ahead, once more
    if forward[:, 1:].any():
        others = ", ".join(f"{value:g}" for value in np.diagonal(forward)[1:])
        found.left_out(f"{model.path}: {FORWARD}: the speed ahead times that on another axis: {others} on their own")
    return 0.5 * (added + added.T), _matrix(model, "linear_damping", -scale, found), quadratic


def uuv_errors(plugin: Element, kind: str) -> Errors:
    """Return the errors of UUV Simulator's sensors that uwsim has, too, as in a vehicle's file.

    Source: its IMUROSPlugin.cc, after RotorS: white noise, and a bias that decays within a correlation time and is
    driven by a random walk; and SubseaPressureROSPlugin.cc, in kPa.
    """
    if kind == "pressure":
        sigma_pa = 1000.0 * plugin.number("noise_sigma", 0.0)
        return {"noise": {"std": sigma_pa}} if sigma_pa > 0.0 else {}
    if kind != "imu":
        return {}
    channels: dict[str, Any] = {}
    for channel, of in (("angular_velocity", "gyroscope"), ("linear_acceleration", "accelerometer")):
        walk, time_s = plugin.number(f"{of}_random_walk", 0.0), plugin.number(f"{of}_bias_correlation_time", 0.0)
        channels[channel] = {
            "density": plugin.number(f"{of}_noise_density", 0.0),
            "turn_on_std": plugin.number(f"{of}_turn_on_bias_sigma", 0.0),
        } | ({"bias_std": walk * np.sqrt(0.5 * time_s).item(), "bias_time_s": time_s} if walk * time_s > 0.0 else {})
    channels["orientation"] = {"std": plugin.number("orientation_noise", 0.0)}
    stated = {name: errors for name, errors in channels.items() if any(errors.values())}
    return {"channels": stated} if stated else {}


def _matrix(model: Element, key: str, sign: float, found: Description) -> Floats:
    values = model.numbers(key)
    if values is None:
        return np.zeros((6, 6))
    if len(values) not in (6, 36):
        raise model.error(f"{key}: has {len(values)} numbers: must have 6 or 36")
    matrix = sign * (np.diag(values) if len(values) == 6 else values.reshape(6, 6))
    for axis in np.flatnonzero(np.diagonal(matrix) < 0.0):
        number = sign * matrix[axis, axis]
        found.assumed(f"{model.path}: {key}: {number:g} of axis {axis + 1} would drive the hull: {-number:g} is meant")
        matrix[axis, axis] *= -1.0
    return np.asarray(matrix)


def _limits(plugin: Element, conversion: Element, robot: Robot, found: Description) -> tuple[float, float]:
    """Return the lowest and highest input of a thruster. Raises ValueError for one without a bound."""
    low, high = plugin.number("clampMin", -np.inf), plugin.number("clampMax", np.inf)
    if low == high:
        raise plugin.error(f"clampMin = {low:g}, clampMax = {high:g}: must increase")
    if low > high:
        found.assumed(f"{plugin.path}: clampMin = {low:g}, clampMax = {high:g}: they are swapped")
        low, high = high, low
    if np.isfinite(low) != np.isfinite(high):
        most = abs(low if np.isfinite(low) else high)
        found.assumed(f"{plugin.path}: its input is from {-most:g} to {most:g}: it has one clamp of two")
        return -most, most
    if np.isfinite(low):
        return low, high
    samples = conversion.numbers("inputValues")
    if samples is not None:
        return float(samples.min()), float(samples.max())
    thrust_n = plugin.number("thrustMin", -np.inf), plugin.number("thrustMax", np.inf)
    if not np.isfinite(thrust_n).all():
        manager, most_n = _most_thrust_n(plugin.file, robot, found.given.arguments.get(MOST))
        if manager is None:
            raise plugin.error(
                f"the thrust at joint '{plugin.text('jointName')}' has no bound: must have clampMin and clampMax, or "
                f"thrustMin and thrustMax [N]: state it by --arg {MOST}=VALUE, or in the checkout by a {MANAGER} with "
                f"{MOST} [N] and tf_prefix '{robot.name}'"
            )
        found.assumed(f"{plugin.path}: at most {most_n:g} N either way, as {MOST} in {manager} allows")
        thrust_n = -most_n, most_n
    gain = plugin.number("gain", 1.0)
    low, high = (_input_of(plugin, conversion, each, gain) for each in thrust_n)
    return low, high


def _most_thrust_n(file: Path, robot: Robot, given: str | None) -> tuple[str | None, float]:
    """Return where the most thrust of a description's thrusters is stated, if anywhere, and how much it is [N].

    given: by the user. Else that of UUV Simulator's file beside the description, or in its checkout for its name.
    """
    if given is not None:
        return f"--arg {MOST}", _positive_n(f"--arg {MOST}", given)
    for folder in MANAGER_FOLDERS:
        path = file.resolve().parent / folder / MANAGER
        if path.is_file():
            return str(path), _positive_n(f"'{path}': {MOST}", _managed(path).get(MOST))
    checkout = checkout_of(file)
    for path in [] if checkout is None else sorted(checkout.rglob(MANAGER)):
        try:
            values = _managed(path)
        except ValueError:  # such as a template
            continue
        if str(values.get("tf_prefix")).strip("/") == robot.name:
            return str(path), _positive_n(f"'{path}': {MOST}", values.get(MOST))
    return None, 0.0


def _managed(path: Path) -> dict[str, Any]:
    """Return the parameters in a file of UUV Simulator's manager, for ROS 1 or ROS 2."""
    values: Any = read_yaml(path).values
    while isinstance(values, dict) and MOST not in values and len(values) == 1:
        (values,) = values.values()
    return values if isinstance(values, dict) else {}


def _positive_n(what: str, value: object) -> float:
    try:
        number = np.nan if isinstance(value, bool) else float(str(value))
    except ValueError:
        number = np.nan
    if not 0.0 < number < np.inf:
        raise ValueError(f"{what} = {value!r}: must be a positive number [N]")
    return number


def _input_of(plugin: Element, conversion: Element, thrust_n: float, gain: float) -> float:
    """Return the smallest input whose thrust reaches a bound. Raises ValueError if none does."""
    sign = np.sign(thrust_n)
    short, beyond = 0.0, 1.0
    while sign * _thrust_n(conversion, sign * beyond * gain) < abs(thrust_n):
        short, beyond = beyond, 2.0 * beyond
        if beyond > INPUT_MAX:
            raise plugin.error(f"no input reaches its bound of {thrust_n:g} N: must have clampMin and clampMax")
    for _ in range(60):
        middle = 0.5 * (short + beyond)
        if sign * _thrust_n(conversion, sign * middle * gain) < abs(thrust_n):
            short = middle
        else:
            beyond = middle
    return float(sign * beyond)


def _thrust_n(conversion: Element, x: float) -> float:
    return float(_converted(conversion, np.array([x]))[0])


def uuv_thruster(plugin: Element, links: Links, to_base: Pose, robot: Robot, found: Description) -> Thruster:
    """Read UUV Simulator's thruster: a clamped input, a lag, and a conversion to thrust."""
    joint_name = plugin.text("jointName")
    if joint_name is None:
        raise plugin.error("has no jointName, which gives the thrust its direction")
    joint = links.joint(joint_name, plugin)
    at = to_base.then(links.pose(plugin.text("linkName") or "", plugin))
    conversion = plugin.find("conversion")
    if conversion is None:
        raise plugin.error("has no conversion")
    commands = np.linspace(-1.0, 1.0, POINTS)
    if (width := _pulse_widths(conversion)) is not None:
        found.assumed(f"{plugin.path}: its input is a pulse width, from {width[0]:g} by {width[1]:g} to {width[2]:g}")
        inputs = np.interp(commands, [-1.0, 0.0, 1.0], width)
    else:
        gain = plugin.number("gain", 1.0)
        low, high = (gain * each for each in _limits(plugin, conversion, robot, found))
        inputs = np.clip(commands * max(abs(low), abs(high)), low, high)
    thrust = _converted(conversion, inputs) * plugin.number("thrust_efficiency", 1.0)
    thrust = np.clip(thrust, plugin.number("thrustMin", -np.inf), plugin.number("thrustMax", np.inf))
    dynamics = plugin.find("dynamics")
    kind = None if dynamics is None else dynamics.text("type")
    if dynamics is not None and kind not in ("ZeroOrder", "FirstOrder"):
        found.assumed(f"{dynamics.path}: type {kind} is neither ZeroOrder nor FirstOrder: its thrust does not lag")
        dynamics.use_all()
    lag = dynamics.number("timeConstant") if dynamics is not None and kind == "FirstOrder" else 0.0
    name = plain_name(f"thruster_{plugin.text('thrusterID') or len(robot.thrusters)}", [])
    pairs = [(float(x), float(y)) for x, y in zip(commands, thrust, strict=True)]
    return Thruster(name, at.position_m, to_base.turn @ joint.axis, pairs, lag, 0.2, None, clockwise=True)


def _pulse_widths(conversion: Element) -> tuple[float, float, float] | None:
    """Return the inputs of full thrust astern, of none and of full thrust ahead, of a table whose input is a pulse.

    Such a one has no negative input, and both directions of thrust about a middle; others have None.
    """
    inputs, outputs = conversion.numbers("inputValues"), conversion.numbers("outputValues")
    if inputs is None or outputs is None or len(inputs) != len(outputs) or inputs.min() < 0.0:
        return None
    back, ahead = sorted((int(outputs.argmin()), int(outputs.argmax())))
    still = inputs[back:ahead][outputs[back:ahead] == 0.0]
    if outputs.min() * outputs.max() >= 0.0 or not len(still):
        return None
    ends = (back, ahead) if outputs[back] < 0.0 else (ahead, back)
    return float(inputs[ends[0]]), float(0.5 * (still[0] + still[-1])), float(inputs[ends[1]])


def _converted(conversion: Element, x: Floats) -> Floats:
    """Return the thrust of inputs by a conversion function of UUV Simulator."""
    kind = conversion.text("type")
    if kind == "Basic":
        return conversion.number("rotorConstant") * x * np.abs(x)
    if kind == "Bessa":
        square = x * np.abs(x)
        low, high = conversion.number("deltaL"), conversion.number("deltaR")
        back, ahead = conversion.number("rotorConstantL"), conversion.number("rotorConstantR")
        return np.asarray(
            np.where(square <= low, back * (square - low), np.where(square >= high, ahead * (square - high), 0.0))
        )
    if kind == "LinearInterp":
        inputs, outputs = conversion.numbers("inputValues"), conversion.numbers("outputValues")
        if inputs is None or outputs is None or len(inputs) != len(outputs) or (np.diff(inputs) <= 0.0).any():
            raise conversion.error("inputValues must increase, and be as many as outputValues")
        return np.asarray(np.interp(x, inputs, outputs))
    raise conversion.error(f"type {kind}: must be Basic, Bessa or LinearInterp")
