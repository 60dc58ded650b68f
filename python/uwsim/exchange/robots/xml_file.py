"""Descriptions in XML: elements, numbers and poses, with errors that give the path of the element and the rule."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from uwsim.exchange.xml_text import xml_root

Floats = NDArray[np.float64]
BYTES_MAX = 20_000_000


class Pose(NamedTuple):
    """A place in the frame of a parent. turn: rotation matrix (3, 3), from the own frame to the parent's."""

    position_m: Floats
    turn: Floats

    def then(self, inner: Pose) -> Pose:
        """Return the pose of a frame that has the pose `inner` in this one."""
        return Pose(self.position_m + self.turn @ inner.position_m, self.turn @ inner.turn)

    def inverse(self) -> Pose:
        """Return the pose of the parent in this frame."""
        return Pose(-self.turn.T @ self.position_m, self.turn.T)

    def points(self, points: Floats) -> Floats:
        """Return points (n, 3) of this frame in the parent's."""
        return np.asarray(points @ self.turn.T + self.position_m)


HERE = Pose(np.zeros(3), np.eye(3))


def turned(roll: float, pitch: float, yaw: float) -> Floats:
    """Return the rotation by roll, pitch and yaw [rad] about the parent's fixed x, y and z, as SDF and URDF have it."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(angle), math.sin(angle)) for angle in (roll, pitch, yaw))
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def by_quaternion(words: Floats, of: Element) -> Floats:
    """Return the rotation by a quaternion x y z w of any length. Raises ValueError for one of none."""
    if not (size := float(np.linalg.norm(words))) > 0.0:
        raise of.error("its quaternion must not be zero")
    x, y, z, w = words / size
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + 2.0 * (w * across + across @ across))


def is_yes(text: str | None) -> bool:
    """Return whether a text is a true boolean of SDF, in which case does not matter."""
    return (text or "").lower() in ("true", "1")


def yaw_pitch_roll_deg(turn: Floats) -> list[float]:
    """Return the angles of a rotation, as scenarios have them."""
    level = math.hypot(turn[0, 0], turn[1, 0])
    pitch = math.atan2(-turn[2, 0], level)
    if level < 1e-9:  # upright: roll and yaw turn about the same axis
        return [math.degrees(math.atan2(-turn[0, 1], turn[1, 1])), math.degrees(pitch), 0.0]
    return [
        math.degrees(math.atan2(turn[1, 0], turn[0, 0])),
        math.degrees(pitch),
        math.degrees(math.atan2(turn[2, 1], turn[2, 2])),
    ]


class Element:
    """An element of a document, with its path for messages, such as `model 'rov'/link 'base'`.

    The document notes which elements and attributes were asked for by name; `unused` lists the others.
    """

    def __init__(self, node: ElementTree.Element, file: Path, path: str, used: set[tuple[int, str]]) -> None:
        self._node, self.file, self.path = node, file, path
        self._used = used  # (id, attribute), or (id, "") for an element

    @property
    def tag(self) -> str:
        """The element's tag."""
        return self._node.tag

    @property
    def name(self) -> str:
        """Its attribute `name`, or its tag."""
        return self._node.get("name") or self._node.tag

    def error(self, rule: str) -> ValueError:
        """Return the error that this element breaks a rule."""
        return ValueError(f"'{self.file}': {self.path}: {rule}")

    def attribute(self, key: str) -> str | None:
        """Return an attribute's text, if any."""
        self._used |= {(id(self._node), key), (id(self._node), "")}
        return self._node.get(key)

    def needed(self, key: str) -> str:
        """Return an attribute's text. Raises ValueError."""
        text = self.attribute(key)
        if text is None:
            raise self.error(f"has no attribute {key}")
        return text

    def text(self, path: str | None = None) -> str | None:
        """Return the text of this element, or of the one at a path of tags below it; None if there is none."""
        node = self._node if path is None else self._node.find(path)
        if node is None:
            return None
        self._used.add((id(node), ""))
        return (node.text or "").strip()

    def find(self, path: str) -> Element | None:
        """Return the first element at a path of tags, if any."""
        node = self._node.find(path)
        if node is None:
            return None
        self._used.add((id(node), ""))
        return self._below(node)

    def all(self, tag: str) -> Iterator[Element]:
        """Yield the children with a tag; `*` is any, which are not used by that."""
        for node in self._node.findall(tag):
            if tag != "*":
                self._used.add((id(node), ""))
            yield self._below(node)

    def _below(self, node: ElementTree.Element) -> Element:
        named = node.get("name")
        return Element(node, self.file, f"{self.path}/{node.tag}" + (f" '{named}'" if named else ""), self._used)

    def use_all(self) -> None:
        """Note this element and all below it as used, such as those that a message has named."""
        for node in self._node.iter():
            self._used |= {(id(node), ""), *((id(node), key) for key in node.attrib)}

    def unused(self) -> Iterator[tuple[str, str, str]]:
        """Yield the elements and attributes below this one that were not asked for: a kind, a path and a value.

        The kind is that of the nearest element with a filename or a type, such as "sensor of type camera", and the
        path leads there from it, such as "camera/image/format" or "axis/xyz@expressed_in".
        """
        yield from self._unused(self._node, self._node.tag, "")

    def _unused(self, node: ElementTree.Element, kind: str, path: str) -> Iterator[tuple[str, str, str]]:
        for key, value in node.attrib.items():
            if key not in ("name", "filename", "type", "version") and (id(node), key) not in self._used:
                yield kind, f"{path}@{key}", value
        for child in node:
            inner, below = kind, f"{path}/{child.tag}" if path else child.tag
            if (of := child.get("filename") or child.get("type")) is not None:
                inner, below = f"{child.tag} of {'file' if child.get('filename') else 'type'} {of}", ""
            if not any((id(each), "") in self._used for each in child.iter()):
                text = "" if len(child) else " ".join((child.text or "").split())
                yield kind, f"{path}/{child.tag}" if path else child.tag, text
            else:
                yield from self._unused(child, inner, below)

    def numbers(self, path: str | None, count: int | None = None, key: str | None = None) -> Floats | None:
        """Return the finite numbers in a text, or in the attribute `key`, or None if absent. Raises ValueError."""
        element = self if path is None else self.find(path)
        text = None if element is None else element.text() if key is None else element.attribute(key)
        if element is None or text is None:
            return None
        try:
            found = np.array([float(word) for word in text.replace(",", " ").split()])
        except ValueError:
            found = np.array([np.nan])
        if not np.isfinite(found).all() or (count is not None and len(found) != count):
            many = "finite numbers" if count is None else f"{count} finite number{'s' * (count > 1)}"
            raise element.error(f"{f'{key} = ' if key else ''}{text[:60]!r}: must be {many}")
        return found

    def number(self, path: str | None, default: float | None = None, key: str | None = None) -> float:
        """Return a number of a text or attribute, or the default. Raises ValueError if it is missing without one."""
        found = self.numbers(path, 1, key)
        if found is not None:
            return float(found[0])
        if default is None:
            raise self.error(f"has no {'/'.join(part for part in (path, key) if part)}")
        return default

    def bound(self, key: str, default: float) -> float:
        """Return a number of an element or attribute that may be infinite, or the default. Raises ValueError."""
        text = self.text(key) if self.find(key) is not None else self.attribute(key)
        try:
            value = default if text is None else float(text)
        except ValueError:
            value = math.nan
        if math.isnan(value):
            raise self.error(f"{key}: {text!r}: must be a number")
        return value

    def relative_to(self) -> str | None:
        """Return the name of the frame in which this element's pose is stated, if that is not its parent's."""
        stated = self.find("pose")
        return None if stated is None else stated.attribute("relative_to") or stated.attribute("frame") or None

    def pose(self, *, of_frame: bool = False) -> Pose:
        """Return SDF's pose, by default the parent's: x y z, and roll pitch yaw [rad, deg] or a quaternion x y z w.

        of_frame: of the frame that the pose names; without it, a name is refused. Raises ValueError.
        """
        stated = self.find("pose")
        if stated is None:
            return HERE
        if not of_frame and (frame := self.relative_to()) is not None:
            raise stated.error(f"relative_to = {frame!r}: its frame cannot be another's here")
        form, in_degrees = stated.attribute("rotation_format"), is_yes(stated.attribute("degrees"))
        if form not in (None, "", "euler_rpy", "quat_xyzw") or (in_degrees and form == "quat_xyzw"):
            rule = "must be euler_rpy or quat_xyzw, the latter without degrees"
            raise stated.error(f"rotation_format = {form!r}: {rule}")
        found = stated.numbers(None, 7 if form == "quat_xyzw" else 6) if stated.text() else None
        if found is None:
            return HERE
        if form == "quat_xyzw":
            return Pose(found[:3], by_quaternion(found[3:], stated))
        return Pose(found[:3], turned(*(np.radians(found[3:]) if in_degrees else found[3:])))

    def origin(self, path: str = "origin") -> Pose:
        """Return URDF's origin, attributes xyz and rpy or quat_xyzw, by default that of the parent."""
        position, angles = self.numbers(path, 3, "xyz"), self.numbers(path, 3, "rpy")
        quaternion = self.numbers(path, 4, "quat_xyzw")
        if angles is not None and quaternion is not None:
            raise self.error(f"{path}: has rpy and quat_xyzw: must have one of them")
        turn = np.eye(3) if angles is None else turned(*angles)
        return Pose(
            np.zeros(3) if position is None else position,
            turn if quaternion is None else by_quaternion(quaternion, self),
        )


def read_xml(path: Path, expand: Callable[[str], str] | None = None, content: bytes | None = None) -> Element:
    """Return the root of an XML file. Entities of its own, which may expand without bound, are refused.

    Prefixes such as gz: are parts of names, as simulators read them, and need not be declared. expand: applied to the
    value of each attribute. content: in place of the file's own, such as after its macros. Raises ValueError for what
    is not XML, is too large or too deep, and OSError.
    """
    if path.exists() and not path.is_file():  # a pipe or a device may never end
        raise ValueError(f"'{path}': must be a regular file")
    if content is None:
        with path.open("rb") as file:
            content = file.read(BYTES_MAX + 1)
    if len(content) > BYTES_MAX:
        raise ValueError(f"'{path}': has {max(path.stat().st_size, len(content))} bytes: must have at most {BYTES_MAX}")
    root = xml_root(content, f"'{path}'")
    if expand is not None:
        for node in root.iter():
            for key, value in node.attrib.items():
                node.attrib[key] = expand(value)
    named = root.get("name")
    return Element(root, path, root.tag + (f" '{named}'" if named else ""), set())
