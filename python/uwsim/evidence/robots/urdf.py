"""Vehicles in URDF, with the hydrodynamics and thrusters of UUV Simulator's plugins, or of gz-sim's systems.

Sources: ROS, "URDF XML specification"; UUV Simulator, documentation and sources of libuuv_underwater_object_ros_plugin
(Manhaes et al. 2016) and libuuv_thruster_ros_plugin. Its damping is negative; positive values would drive the hull.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from uwsim.evidence.robots import shapes
from uwsim.evidence.robots.lift_drag import put_uuv_fin
from uwsim.evidence.robots.links import Joint, Links, inertia
from uwsim.evidence.robots.robot import Found, Lump, Mesh, Robot, Thruster, plain_name
from uwsim.evidence.robots.sensors import put_camera, put_sensor
from uwsim.evidence.robots.xml_file import HERE, Element, Floats, Pose, read_xml

DENSITY_KG_M3 = 1028.0
"""UUV Simulator's water."""
TINY_M3 = 1e-9
"""Solids below this volume stand in for a shape that Gazebo needs, and displace nothing."""
SENSOR_PLUGINS = {"dvl": "dvl", "imu": "imu", "subsea_pressure": "pressure", "magnetometer": "compass"}
POINTS = 41
THRUST_N = 1000.0
"""Bound of a thruster that states none: of UUV Simulator's thruster manager in its own tests."""


def read_urdf(path: Path) -> Found:
    """Return the vehicle of a URDF file. Raises ValueError or OSError."""
    root = read_xml(path)
    if root.tag != "robot":
        raise root.error("must be <robot>")
    if b"xacro:" in path.read_bytes() and any("xacro" in child.tag for child in root.all("*")):
        raise root.error("has xacro's macros: expand them first, with `xacro FILE > out.urdf`")
    found = Found(plain_name(root.name), density_kg_m3=DENSITY_KG_M3)
    links = _links(root, path, found)
    base = links.base()
    robot = Robot(plain_name(root.name), Pose(np.array([0.0, 0.0, -2.0]), np.eye(3)))
    found.assumed("the vehicle starts at 2 m of depth")
    to_base = links.poses[base].inverse()
    links.put_into(robot, base)
    for extension in root.all("gazebo"):
        for plugin in extension.all("plugin"):
            _plugin(robot, found, links, plugin, base)
        link = extension.attribute("reference")
        for sensor in extension.all("sensor"):
            at = to_base.then(links.pose(link or "", extension)).then(sensor.pose())
            _sensor(robot, found, sensor, at)
    if robot.volume_m3 is None:
        found.assumed("the collision shapes displace water: no plugin states a volume")
    found.robots.append(robot)
    return found


def _links(root: Element, path: Path, found: Found) -> Links:
    links = Links(root)
    below: dict[str, list[Element]] = {}
    for joint in root.all("joint"):
        below.setdefault(_end(joint, "parent"), []).append(joint)
    elements = {link.needed("name"): link for link in root.all("link")}
    children = {_end(joint, "child") for joints in below.values() for joint in joints}
    waiting = [(name, HERE) for name in elements if name not in children]
    while waiting:
        name, pose = waiting.pop()
        if name in links.poses:
            raise root.error(f"link '{name}' is the child of more than one joint")
        if name not in elements:
            raise root.error(f"there is no link '{name}'")
        links.poses[name] = pose
        _fill(links, elements[name], name, path, found)
        for joint in below.get(name, []):
            there = pose.then(joint.origin())
            xyz = joint.numbers("axis", 3, "xyz")
            axis = there.turn @ (np.array([1.0, 0.0, 0.0]) if xyz is None else xyz)
            child = _end(joint, "child")
            limits = joint.number("limit", -np.inf, "lower"), joint.number("limit", np.inf, "upper")
            links.joints[joint.name] = Joint(joint.name, joint.needed("type"), name, child, there, axis, limits)
            waiting.append((child, there))
    if lost := [name for name in elements if name not in links.poses]:
        raise root.error(f"links {', '.join(lost)} hang together in a circle")
    return links


def _end(joint: Element, tag: str) -> str:
    end = joint.find(tag)
    if end is None:
        raise joint.error(f"has no {tag}")
    return end.needed("link")


def _fill(links: Links, link: Element, name: str, path: Path, found: Found) -> None:
    inertial = link.find("inertial")
    if inertial is not None:
        own = inertial.origin()
        moments = inertia(inertial.find("inertia"), lambda e, k: e.number(None, 0.0, k))
        links.lumps[name] = Lump(
            inertial.number("mass", None, "value"), own.position_m, own.turn @ moments @ own.turn.T
        )
    links.solids[name] = []
    for collision in link.all("collision"):
        solid = _solid(collision, path, found)
        if solid is not None and shapes.volume_and_centre(solid)[0] > TINY_M3:
            links.solids[name].append(shapes.placed(solid, collision.origin()))


def _solid(collision: Element, path: Path, found: Found) -> Mesh | None:
    geometry = collision.find("geometry")
    if geometry is None:
        raise collision.error("has no geometry")
    for shape in geometry.all("*"):
        if shape.tag == "box":
            size = shape.numbers(None, 3, "size")
            if size is None or not shapes.are_sizes(*size):
                raise shape.error("its size must be three positive numbers [m]")
            return shapes.box(size)
        if shape.tag in ("cylinder", "sphere"):
            radius = shape.number(None, None, "radius")
            length = 1.0 if shape.tag == "sphere" else shape.number(None, None, "length")
            if not shapes.are_sizes(radius, length):
                raise shape.error(f"radius and length must be positive, at most {shapes.SIZE_MAX_M:g} m")
            return shapes.sphere(radius) if shape.tag == "sphere" else shapes.cylinder(radius, length)
        if shape.tag == "mesh":
            file = _mesh_file(shape.needed("filename"), path)
            if file is None:
                found.left_out(f"{shape.path} {shape.needed('filename')}: not beside the file")
                return None
            scale = shape.numbers(None, 3, "scale")
            return shapes.from_file(file, np.ones(3) if scale is None else scale)
    return None


def _mesh_file(address: str, path: Path) -> Path | None:
    """Return the file of a mesh: package:// addresses are looked for in the folders above the description."""
    scheme, _, rest = address.partition("://") if "://" in address else ("", "", address)
    if scheme not in ("", "file", "package", "model"):
        return None
    for folder in [path.resolve().parent, *path.resolve().parents]:
        if (file := folder / rest).is_file():
            return file
    return None


def _plugin(robot: Robot, found: Found, links: Links, plugin: Element, base: str) -> None:
    file = plugin.attribute("filename") or ""
    to_base = links.poses[base].inverse()
    if "underwater_object" in file:
        if plugin.find("fluid_density"):
            found.density_kg_m3 = plugin.number("fluid_density")
        for link in plugin.all("link"):
            if link.needed("name") != base:
                raise link.error(f"must be the base link, '{base}'")
            _hydrodynamics(robot, found, link)
    elif "uuv_thruster" in file or "thruster_ros" in file:
        robot.thrusters.append(_thruster(plugin, links, to_base, robot, found))
    elif "uuv_fin" in file or "fin_ros" in file:
        put_uuv_fin(robot, plugin, links, to_base, found)
    elif (kind := next((kind for part, kind in SENSOR_PLUGINS.items() if part in file), None)) is not None:
        at = to_base.then(links.pose(plugin.text("link_name") or "", plugin))
        noise = plugin.number("noise_sigma", 0.0) if kind == "imu" else 0.0
        put_sensor(robot, found, plugin.path, kind, kind, at, plugin.number("update_rate", 10.0), noise)
    else:
        found.left_out(f"{plugin.path}, {file}")


def _hydrodynamics(robot: Robot, found: Found, link: Element) -> None:
    """Read UUV Simulator's <link>: volume, centre of buoyancy and Fossen's matrices."""
    whole = robot.whole()
    if link.text("neutrally_buoyant") in ("1", "true"):
        assert found.density_kg_m3 is not None
        robot.volume_m3 = whole.mass_kg / found.density_kg_m3
    else:
        robot.volume_m3 = link.number("volume")
    if not robot.volume_m3 > 0.0:
        raise link.error(f"volume = {robot.volume_m3:g} m3: must be positive")
    centre = link.numbers("center_of_buoyancy", 3)
    robot.centre_of_buoyancy_m = np.zeros(3) if centre is None else centre
    sides = [link.number(f"box/{side}", 0.0) for side in ("length", "width", "height")]
    if not robot.solids and all(side > 0.0 for side in sides):
        robot.solids = [shapes.box(np.array(sides))]
        found.assumed(f"{link.path}: the hull is the plugin's box, since the links have no collision shapes here")
    model = link.find("hydrodynamic_model")
    if model is None or model.text("type") != "fossen":
        kind = None if model is None else model.text("type")
        found.left_out(f"{link.path}: hydrodynamic model {kind}: only fossen is read")
        return
    if any(model.number(key, 0.0) != 0.0 for key in ("offset_added_mass", "offset_linear_damping")):
        found.left_out(f"{model.path}: its offsets")
    forward = model.numbers("linear_damping_forward_speed")
    if forward is not None and forward.any():
        found.left_out(f"{model.path}: linear_damping_forward_speed")
    scale = model.number("scaling_damping", 1.0)
    robot.added_mass = _matrix(model, "added_mass", 1.0) * model.number("scaling_added_mass", 1.0)
    robot.added_mass = 0.5 * (robot.added_mass + robot.added_mass.T)
    robot.linear = _matrix(model, "linear_damping", -scale)
    robot.quadratic = _matrix(model, "quadratic_damping", -scale)


def _matrix(model: Element, key: str, sign: float) -> Floats:
    found = model.numbers(key)
    if found is None:
        return np.zeros((6, 6))
    if len(found) not in (6, 36):
        raise model.error(f"{key}: has {len(found)} numbers: must have 6 or 36")
    matrix = sign * (np.diag(found) if len(found) == 6 else found.reshape(6, 6))
    if (np.diagonal(matrix) < 0.0).any():
        rule = "must not be negative" if sign > 0.0 else "must not be positive: it would drive the hull"
        raise model.error(f"{key}: {' '.join(f'{value:g}' for value in found[:6])}: {rule}")
    return np.asarray(matrix)


def _limits(plugin: Element, conversion: Element, found: Found) -> tuple[float, float]:
    """Return the lowest and highest input of a thruster."""
    low, high = plugin.number("clampMin", -np.inf), plugin.number("clampMax", np.inf)
    if np.isfinite(low) and np.isfinite(high):
        if not low < high:
            raise plugin.error(f"clampMin = {low:g}, clampMax = {high:g}: must increase")
        return low, high
    samples = conversion.numbers("inputValues")
    if samples is not None:
        return float(samples.min()), float(samples.max())
    if conversion.text("type") != "Basic" or not (constant := conversion.number("rotorConstant")) > 0.0:
        raise plugin.error("has no clampMin and clampMax, so its thrust has no bound")
    found.assumed(
        f"{plugin.path}: at most {THRUST_N:g} N, as UUV Simulator's thruster manager allows: it has no clampMax"
    )
    most = float(np.sqrt(THRUST_N / constant))
    return -most, most


def _thruster(plugin: Element, links: Links, to_base: Pose, robot: Robot, found: Found) -> Thruster:
    """Read UUV Simulator's thruster: a clamped input, a lag, and a conversion to thrust."""
    joint_name = plugin.text("jointName")
    if joint_name is None:
        raise plugin.error("has no jointName, which gives the thrust its direction")
    joint = links.joint(joint_name, plugin)
    at = to_base.then(links.pose(plugin.text("linkName") or "", plugin))
    conversion = plugin.find("conversion")
    if conversion is None:
        raise plugin.error("has no conversion")
    low, high = _limits(plugin, conversion, found)
    most = max(abs(low), abs(high)) * plugin.number("gain", 1.0)
    inputs = np.linspace(-1.0, 1.0, POINTS) * most
    inputs_kept = np.clip(inputs, low * plugin.number("gain", 1.0), high * plugin.number("gain", 1.0))
    thrust = _converted(conversion, inputs_kept) * plugin.number("thrust_efficiency", 1.0)
    thrust = np.clip(thrust, plugin.number("thrustMin", -np.inf), plugin.number("thrustMax", np.inf))
    dynamics = plugin.find("dynamics")
    kind = None if dynamics is None else dynamics.text("type")
    if dynamics is not None and kind not in ("ZeroOrder", "FirstOrder"):
        raise dynamics.error(f"type {kind}: must be ZeroOrder or FirstOrder")
    lag = dynamics.number("timeConstant") if dynamics is not None and kind == "FirstOrder" else 0.0
    name = plain_name(f"thruster_{plugin.text('thrusterID') or len(robot.thrusters)}", [])
    pairs = [(float(x / most), float(y)) for x, y in zip(inputs, thrust, strict=True)]
    return Thruster(name, at.position_m, to_base.turn @ joint.axis, pairs, lag, 0.2, None, clockwise=True)


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


def _sensor(robot: Robot, found: Found, sensor: Element, at: Pose) -> None:
    kind = sensor.needed("type")
    if kind not in ("camera", "depth", "rgbd_camera"):
        found.left_out(f"{sensor.path}, of type {kind}")
        return
    angle = sensor.number("camera/horizontal_fov", 1.047)
    size = int(sensor.number("camera/image/width", 320.0)), int(sensor.number("camera/image/height", 240.0))
    put_camera(robot, sensor.name, at, float(np.degrees(angle)), size)
