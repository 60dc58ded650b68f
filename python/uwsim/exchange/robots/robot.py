"""A vehicle and its world as a description in another format states them, in uwsim's frames and units."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats
from uwsim.exchange.robots.xml_file import Element, Pose
from uwsim.scenario.read.note import Grade, Note
from uwsim.scenario.spec.scenario import RESERVED_NAMES

GRADES: tuple[Grade, Grade, Grade] = ("motion", "senses", "looks")
"""The grades of notes by what they are about, in the order in which notes are printed."""
MOTION, SENSES, LOOKS = GRADES
BEYOND = "its numbers are too large, or zero, to compute with"
SHORT = 12
"""Characters of a value that a note on what was not asked for has."""
OF_LOOKS = re.compile(
    r"^robot material\b|\b(visuali?z?e?|lights?|meta|gui|scene|looks?|sky|sun|atmosphere|shadows|texture|render|retro"
    r"|projector|particles?|emitter|audio|actor|colou?r|transparency)\b"
)
OF_SENSES = re.compile(
    r"\b(sensors?|(multi)?cameras?|sonar|lidar|imu|dvl|gps|navsat|altimeter|magnetometer|pressure|odom|odometry"
    r"|publisher|comms?|modem|noise|coordinates|magnetic)\b"
)
"""Words of elements, plugins and attributes that change no motion; any other may."""
Mesh = tuple[Floats, NDArray[np.int64]]
"""Vertices (n, 3) [m] and triangles (m, 3)."""


class Lump(NamedTuple):
    """A rigid part. mass_kg; centre_m: centre of mass; inertia_kg_m2: (3, 3), about it. Frame: the vehicle's body."""

    mass_kg: float
    centre_m: Floats
    inertia_kg_m2: Floats


class Thruster(NamedTuple):
    """A thruster. axis: of positive thrust. thrust_n: pairs of a command in [-1, 1] and a thrust. Frame: the body.

    force: `buoyancy` for an engine that changes the displaced volume, as in a vehicle's file.
    """

    name: str
    position_m: Floats
    axis: Floats
    thrust_n: list[tuple[float, float]]
    time_constant_s: float
    diameter_m: float
    bollard_coefficient: float | None
    clockwise: bool
    zero_thrust_advance_ratio: float | None = None
    torque_per_thrust_m: float = 0.0
    force: str | None = None


class Fin(NamedTuple):
    """A lifting surface. span: the direction about which it turns, right-handed. Frame: the body.

    density_area_kg_m: its area times the density for which its lift is stated. stall_deg: None for one that does not
    stall. travel_deg: 0 for a fixed one.
    """

    name: str
    position_m: Floats
    span: Floats
    density_area_kg_m: float
    aspect_ratio: float
    stall_deg: float | None
    travel_deg: float


@dataclass
class Robot:
    """A vehicle. Body frame: x forward, y left, z up; its origin is that of the base link.

    lumps: the rigid parts of its mass. solids: closed parts that displace water. volume_m3, centre_of_buoyancy_m: of
    the displaced water, by default those of the solids. added_mass, linear, quadratic: (6, 6), magnitudes; estimated
    from the hull where they are None. drag: instead of linear and quadratic, returns the diagonals (6,) of both for
    motions through a point of the body [m]. sensors, cameras, imaging_sonars: as in a vehicle's file. sonar: the
    multibeam's mount. place: where it starts in the world.
    """

    name: str
    place: Pose
    lumps: list[Lump] = field(default_factory=list)
    solids: list[Mesh] = field(default_factory=list)
    volume_m3: float | None = None
    centre_of_buoyancy_m: Floats | None = None
    added_mass: Floats | None = None
    linear: Floats | None = None
    quadratic: Floats | None = None
    drag: Callable[[Floats], tuple[Floats, Floats]] | None = None
    thrusters: list[Thruster] = field(default_factory=list)
    fins: list[Fin] = field(default_factory=list)
    sensors: dict[str, dict[str, Any]] = field(default_factory=dict)
    cameras: dict[str, dict[str, Any]] = field(default_factory=dict)
    imaging_sonars: dict[str, dict[str, Any]] = field(default_factory=dict)
    sonar: list[float] | None = None
    model: str | None = None

    def summary(self) -> str:
        """Return in a line how much of a vehicle was found."""
        if self.model is not None:
            return f"vehicle '{self.name}': the packaged '{self.model}'"
        mass_kg = sum(lump.mass_kg for lump in self.lumps)
        counts = {
            "solid": len(self.solids), "thruster": len(self.thrusters), "fin": len(self.fins),
            "sensor": len(self.sensors), "camera": len(self.cameras),
            "imaging sonar": len(self.imaging_sonars), "multibeam": int(self.sonar is not None),
        }  # fmt: skip
        parts = [f"{count} {what}{'s' * (count > 1)}" for what, count in counts.items() if count]
        return f"vehicle '{self.name}': {', '.join([f'{mass_kg:.4g} kg', *parts])}"

    def whole(self) -> Lump:
        """Return all lumps as one rigid part (Steiner). Raises ValueError if they have no mass."""
        if not sum(lump.mass_kg for lump in self.lumps) > 0.0:
            raise ValueError(f"vehicle '{self.name}': has no mass")
        return merged(self.lumps)


@dataclass(frozen=True)
class Given:
    """Values that a user states beside a file.

    arguments: of xacro and of Stonefish, by name. data: the folder to which Stonefish's paths are relative. outfit: a
    use for which each vehicle gets what it lacks, `survey`: a multibeam and an altimeter. calibrations: of cameras.
    progress: called with a line for each mesh before it is read, which may take seconds.
    """

    arguments: Mapping[str, str] = field(default_factory=dict)
    data: Path | None = None
    outfit: str | None = None
    calibrations: tuple[Path, ...] = ()
    progress: Callable[[str], None] | None = None


@dataclass
class Description:
    """A scenario as a file describes it: what a reader found.

    The law of all formats: an element that is stated is used, or noted as left out, with its value and the reason, or
    replaced by what is noted as assumed; one that breaks a rule never refuses those beside it.

    obstacles, objects, pingers: as in a scenario. station: its place [m], if it is known. notes: one for each element
    that was left out or assumed. density_kg_m3: of the water, if stated. current_m_s: its velocity, likewise. bed_z_m:
    of a flat bed, likewise. bed_plane: a point and the normal of a sloped one. refusals: the errors of the vehicles
    that were left out. opened: how many meshes were read.
    """

    name: str
    given: Given = field(default_factory=Given)
    robots: list[Robot] = field(default_factory=list)
    obstacles: list[dict[str, Any]] = field(default_factory=list)
    objects: list[dict[str, Any]] = field(default_factory=list)
    pingers: list[dict[str, Any]] = field(default_factory=list)
    station: list[float] | None = None
    meshes: dict[str, Mesh] = field(default_factory=dict)
    density_kg_m3: float | None = None
    current_m_s: Floats | None = None
    bed_z_m: float | None = None
    bed_plane: tuple[Floats, Floats] | None = None
    notes: list[Note] = field(default_factory=list)
    refusals: list[Exception] = field(default_factory=list)
    opened: int = 0

    def all_notes(self) -> list[Note]:
        """Return what was read, a note for each vehicle, and all others, those on the motion first."""
        read = [Note("read", robot.summary()) for robot in self.robots]
        return [*read, *sorted(self.notes, key=lambda note: (*GRADES, "").index(note.grade))]

    @contextmanager
    def beside(self, element: Element) -> Iterator[None]:
        """Leave out an element without which those beside it stand, with the rule that it breaks."""
        try:
            yield
        except (ValueError, OSError, ArithmeticError) as error:
            rule = BEYOND if isinstance(error, ArithmeticError) else str(error).removeprefix(f"'{element.file}': ")
            self.left_out(
                rule if rule.startswith(element.path) else f"{element.path}: {rule}",
                graded(f"{element.path} {element.attribute('filename') or ''}"),
            )
            element.use_all()

    @contextmanager
    def vehicle(self, element: Element) -> Iterator[None]:
        """Leave out a vehicle as `beside` does, with all that was found of it."""
        count = len(self.robots)
        with self.beside(element):
            try:
                yield
            except (ValueError, OSError, ArithmeticError) as error:
                del self.robots[count:]
                self.refusals.append(element.error(BEYOND) if isinstance(error, ArithmeticError) else error)
                raise

    def refuse(self, robot: Robot, error: Exception) -> None:
        """Leave out a vehicle that breaks a rule. Raises the error for the last one."""
        if len(self.robots) == 1:
            raise error
        self.robots.remove(robot)
        self.left_out(str(error))

    def require_any(self, root: Element, rule: str) -> None:
        """Raise ValueError where no vehicle is left of those that there were, or one by a rule where nothing is."""
        if self.refusals and not self.robots:
            raise self.refusals[0]
        if not (self.robots or self.obstacles):
            raise root.error(rule)

    def body_name(self, text: str) -> str:
        """Return a text as a name for a fixed body that is none of the others' and none that scenarios reserve."""
        return plain_name(text, [*RESERVED_NAMES, *self.meshes])

    def opens(self, mesh: Path) -> None:
        """Report a mesh that is about to be read."""
        self.opened += 1
        self.goes_on(f"mesh {self.opened}: '{mesh.name}'")

    def goes_on(self, what: str) -> None:
        """Report what is about to be done, which may take seconds."""
        if self.given.progress is not None:
            self.given.progress(what)

    def noted(self, note: Note) -> None:
        """Note what is worth knowing, once."""
        if note not in self.notes:
            self.notes.append(note)

    def left_out(self, what: str, grade: Grade = MOTION) -> None:
        """Note an element that is not used, once."""
        self.noted(Note("left out", what, grade))

    def dropped(self, element: Element, more: str = "") -> None:
        """Note an element that is not used, with all below it. more: follows its path."""
        self.left_out(f"{element.path}{more}", graded(element.path + more))
        element.use_all()

    def note_unused(self, root: Element) -> None:
        """Note what was not asked for in a document, a line for each kind of element, with how often it occurs."""
        kinds: dict[tuple[str, Grade], Counter[str]] = {}
        values: dict[tuple[str, str], set[str]] = {}
        for kind, path, value in root.unused():
            kinds.setdefault((kind, graded(f"{kind}/{path}")), Counter())[path] += 1
            values.setdefault((kind, path), set()).add(value)
        for (kind, grade), paths in kinds.items():
            each = []
            for path, count in sorted(paths.items()):
                one, *others = values[kind, path]
                stated = f" = {one}" if not others and 0 < len(one) <= SHORT else ""
                each.append(f"{path}{stated}{f' ({count})' * (count > 1)}")
            self.left_out(f"{kind}: {', '.join(each)}", grade)

    def assumed(self, what: str, grade: Grade = MOTION) -> None:
        """Note a value that the file does not state, once."""
        self.noted(Note("assumed", what, grade))


def graded(path: str) -> Grade:
    """Return what an element changes, by the words of its path without names: the motion, unless it is known not to."""
    words = " ".join(re.findall("[A-Z]?[a-z]+|[A-Z]+", re.sub("'[^']*'", "", path))).lower()
    return LOOKS if OF_LOOKS.search(words) else SENSES if OF_SENSES.search(words) else MOTION


def merged(lumps: list[Lump]) -> Lump:
    """Return lumps of some mass as one rigid part (Steiner)."""
    mass = sum(lump.mass_kg for lump in lumps)
    centre = sum((lump.mass_kg * lump.centre_m for lump in lumps), start=np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for lump in lumps:
        off = lump.centre_m - centre
        inertia += lump.inertia_kg_m2 + lump.mass_kg * (off @ off * np.eye(3) - np.outer(off, off))
    return Lump(mass, centre, inertia)


def plain_name(text: str, others: Any = ()) -> str:
    """Return a text as a name that scenarios accept and that is not among others."""
    plain = "".join(c if c.isascii() and (c.isalnum() or c in "-_") else "_" for c in text).strip("_-")
    plain = (plain if plain[:1].isalpha() else f"n_{plain}")[:36].rstrip("_-")
    number, name = 2, plain
    while name in others:
        name, number = f"{plain}_{number}", number + 1
    return name


def unlike_zero(matrix: Floats) -> bool:
    """Return whether a matrix has entries beside its diagonal."""
    return bool(np.any(matrix != np.diag(np.diagonal(matrix))))
