"""Vehicles in URDF, with the hydrodynamics and thrusters of UUV Simulator's plugins, or of gz-sim's systems.

Sources: ROS, "URDF XML specification"; UUV Simulator, documentation and sources of libuuv_underwater_object_ros_plugin
(Manhaes et al. 2016) and libuuv_thruster_ros_plugin. Its damping is negative; positive values would drive the hull.
"""

from __future__ import annotations

import re
import resource
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from uwsim.base.extras import need_extra
from uwsim.exchange.robots import shapes
from uwsim.exchange.robots.links import Joint, Links, inertia, unit
from uwsim.exchange.robots.robot import Description, Lump, Mesh, Robot, plain_name
from uwsim.exchange.robots.sensors import put_gz_sensor
from uwsim.exchange.robots.sources import MANIFEST, folder_of, package_folder
from uwsim.exchange.robots.systems import DENSITY_KG_M3, put_plugins
from uwsim.exchange.robots.uuv_plugins import MOST
from uwsim.exchange.robots.xacro_process import UNKNOWN
from uwsim.exchange.robots.xml_file import HERE, Element, Pose, read_xml
from uwsim.scenario.read.contained import CPU_S, run_contained
from uwsim.scenario.read.note import Note

XACRO = b"ros.org/wiki/xacro"
"""In a document with macros."""
SWITCH = re.compile("sim|gazebo|gz|hydro|plugin", re.IGNORECASE)
"""Arguments that switch a simulator's plugins on."""
EXPANDER = Path(__file__).with_name("xacro_process.py")
FIND, LOST = re.compile(rb"\$\(find\s+(\w[\w-]*)\)"), re.compile(UNKNOWN.encode() + rb"(\w[\w-]*)")


def read_urdf(path: Path, found: Description | None = None) -> Description:
    """Return the vehicle of a URDF file, in `found` if given. Raises ValueError or OSError."""
    found = found or Description("")
    root = _document(path, found)
    if root.tag != "robot":
        raise root.error("must be <robot>")
    found.name = plain_name(root.name)
    links = _links(root, path, found)
    base = links.base(found)
    robot = Robot(plain_name(root.name), Pose(np.array([0.0, 0.0, -2.0]), np.eye(3)))
    found.assumed("the vehicle starts at 2 m of depth")
    to_base = links.poses[base].inverse()
    links.put_into(robot, base)
    found.robots.append(robot)
    extensions = list(root.all("gazebo"))
    put_plugins(robot, found, (plugin for each in extensions for plugin in each.all("plugin")), links, base)
    for extension in extensions:
        for sensor in extension.all("sensor"):
            with found.beside(sensor):
                link = extension.attribute("reference") or ""
                put_gz_sensor(robot, found, sensor, to_base.then(links.pose(link, extension)).then(sensor.pose()))
    if robot.volume_m3 is None:
        found.assumed("the collision shapes displace water: no plugin states a volume")
    if found.density_kg_m3 is None:
        found.density_kg_m3 = DENSITY_KG_M3
        found.assumed(f"water of {DENSITY_KG_M3:g} kg/m3, gz-sim's default, which its world may state otherwise")
    found.note_unused(root)
    return found


def _document(path: Path, found: Description) -> Element:
    """Return the root of a file, after xacro's macros if it has any."""
    root = read_xml(path)
    if XACRO not in path.read_bytes():
        if found.given.arguments.keys() - {MOST}:
            found.left_out("--arg: the file has no macros, which could take a value")
        return root
    need_extra("xacro", f"'{path}': xacro")
    stated = {each.name: each.attribute("default") or "" for each in root.all("xacro:arg")}
    if stated:
        given = ", ".join(f"{key}={value}" for key, value in stated.items())
        found.noted(Note("arguments", f"{given}; --arg states another"))
    content = expanded(path, found.given.arguments)
    switches = [key for key in stated if SWITCH.search(key) and stated[key].lower() in ("false", "0")]
    off = {key: "true" for key in switches if key not in found.given.arguments}
    if off and b"<plugin" not in content:
        found.assumed(f"{', '.join(f'--arg {key}=true' for key in off)}: without it, no plugin is in the description")
        content = expanded(path, {**off, **found.given.arguments})
    return read_xml(path, content=content)


def expanded(path: Path, arguments: Mapping[str, str]) -> bytes:
    """Return a file after xacro's macros, which may read the files of its checkout and of the packages that it names.

    Raises ValueError.
    """
    root, packages, begun_s = folder_of(path), dict[str, str](), _children_s()
    names = set(FIND.findall(path.read_bytes()))
    while True:
        error = None
        for name in map(bytes.decode, names):
            folder = package_folder(name, path)
            if folder is not None and (folder.is_relative_to(root) or (folder / MANIFEST).is_file()):
                packages[name] = str(folder.resolve())
        sources = (str((Path(folder) / MANIFEST).resolve().parent) for folder in packages.values())  # of links
        roots = [str(root), *packages.values(), *sources]
        settings = {"roots": roots, "packages": packages, "arguments": dict(arguments)}
        reads, cpu_s = [path, *map(Path, roots)], max(1, CPU_S - round(_children_s() - begun_s))
        try:
            found = run_contained(EXPANDER, "xacro", str(path), settings, reads=reads, cpu_s=cpu_s)
            made = found["document"].tobytes()
        except ValueError as refusal:
            made, error = str(refusal).encode(), refusal
        names, seen = set(LOST.findall(made)), names
        if names <= seen:
            break
    made = made.replace(UNKNOWN.encode(), b"package://")
    if error is None:
        return made
    rule = made.decode()
    if lacking := re.search(r"Undefined substitution argument (\w+)", rule):
        rule = f"argument {lacking[1]} has no value: state it by --arg {lacking[1]}=VALUE"
    elif lost := re.search(r"package://(\w+)", rule):
        rule = f"package '{lost[1]}' is neither around the file nor in ROS_PACKAGE_PATH or AMENT_PREFIX_PATH: {rule}"
    raise ValueError(f"'{path}': {rule}")


def _children_s() -> float:
    return sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])


def _links(root: Element, path: Path, found: Description) -> Links:
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
            axis, limits, stated, limit = there.turn[:, 0], (-np.inf, np.inf), joint.find("axis"), joint.find("limit")
            if stated is not None:
                axis = np.full(3, np.nan)
                with found.beside(stated):
                    xyz = stated.numbers(None, 3, "xyz")
                    axis = there.turn @ (np.eye(3)[0] if xyz is None else unit(xyz, stated))
            if limit is not None:
                with found.beside(limit):
                    limits = limit.bound("lower", -np.inf), limit.bound("upper", np.inf)
            child = _end(joint, "child")
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


def _fill(links: Links, link: Element, name: str, path: Path, found: Description) -> None:
    inertial = link.find("inertial")
    if inertial is not None:
        own = inertial.origin()
        moments = inertia(inertial.find("inertia"), lambda e, k: e.number(None, 0.0, k))
        mass_kg = inertial.number("mass", None, "value")
        links.lumps[name] = Lump(mass_kg, own.position_m, own.turn @ moments @ own.turn.T)
    links.solids[name] = []
    for collision in link.all("collision"):
        with found.beside(collision):
            solid = _solid(collision, path, found)
            if solid is not None and shapes.displaces(solid):
                links.solids[name].append(shapes.placed(solid, collision.origin()))


def _solid(collision: Element, path: Path, found: Description) -> Mesh | None:
    geometry = collision.find("geometry")
    if geometry is None:
        raise collision.error("has no geometry")
    for shape in geometry.all("*"):
        if shape.tag == "box":
            size = shape.numbers(None, 3, "size")
            if size is None or not shapes.are_sizes(*size):
                raise shape.error("its size must be three positive numbers [m]")
            return shapes.box(size)
        if shape.tag in ("cylinder", "sphere", "capsule"):
            radius = shape.number(None, None, "radius")
            length = 1.0 if shape.tag == "sphere" else shape.number(None, None, "length")
            if not shapes.are_sizes(radius, length):
                raise shape.error(f"radius and length must be positive, at most {shapes.SIZE_MAX_M:g} m")
            if shape.tag == "sphere":
                return shapes.sphere(radius)
            return (shapes.cylinder if shape.tag == "cylinder" else shapes.capsule)(radius, length)
        if shape.tag == "mesh":
            file = _mesh_file(shape.needed("filename"), path)
            if file is None:
                found.dropped(shape, f" {shape.needed('filename')}: not beside the file")
                return None
            scale = shape.numbers(None, 3, "scale")
            found.opens(file)
            with found.beside(shape):
                return shapes.closed(shapes.from_file(file, np.ones(3) if scale is None else scale), shape.path)
    return None


def _mesh_file(address: str, path: Path) -> Path | None:
    """Return the file of a mesh: package:// addresses are looked for in the folders above the description."""
    scheme, _, rest = address.partition("://") if "://" in address else ("", "", address)
    if scheme not in ("", "file", "package", "model"):
        return None
    for folder in [path.resolve().parent, *path.resolve().parents]:
        if (file := folder / rest).is_file():
            return file
    package, _, within = rest.partition("/")
    found = package_folder(package, path) if scheme in ("package", "model") else None
    return found / within if found is not None and (found / within).is_file() else None
