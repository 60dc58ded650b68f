"""A scenario from the published simulator's Unity project: its lake, station, gates, pipelines and vehicle."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from uwsim.base.atomic_file import write_atomically
from uwsim.base.axes import AXES
from uwsim.base.own_files import require_own
from uwsim.base.reader import Reader
from uwsim.base.texts.yaml_document import read_yaml
from uwsim.exchange.hulls.draft import drafted
from uwsim.exchange.robots.written import require_simulable
from uwsim.exchange.scenario_source import Made
from uwsim.exchange.unity.project import Bed, Project, read_bed
from uwsim.exchange.unity.scene import Piece, read_scene
from uwsim.scenario.dump import yaml_text
from uwsim.scenario.read.assets import find_yaml
from uwsim.scenario.read.mesh_file import TURNS_UP
from uwsim.scenario.read.note import Note
from uwsim.scenario.spec.fields import NAME

FROM_UNITY = np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""The published wire's axes (west, up, south) to east, north, up; and its body's axes (aft, up, starboard) to forward,
left, up: ForceControls.cs."""
SURFACE_M = 75.3
"""Height of the published water's surface: WaterController.cs."""
SCENE, TERRAIN, STATION, WATER = "LawnTest", "SolidTerrain", "ControlStation", "water"
PLAIN = np.full(3, 0.8)  # sRGB, of a piece without a colour among coloured ones: that of a new material in Unity
START_M, SURVEY_M, SURVEY_MIN_M = 5.0, 20.0, 2.0
"""Depth of a start that is not the one of `paper`, where the bed is deep enough; half the width of its survey."""
KEPT = ("water", "optics", "ground", "station", "warnings", "survey", "mission_time_s")
"""Keys of the packaged scenario `paper` that hold for this lake, too."""


def scenario_from(
    project: Project,
    scene: Path,
    out: Path,
    *,
    terrain: str = TERRAIN,
    size_m: float | None = None,
    centre_m: tuple[float, float] = (0.0, 0.0),
) -> Made:
    """Write a scenario, its meshes, terrain and vehicle into the folder `out`.

    scene: a scene of the project. terrain: the top-level object whose meshes are the bed. size_m: the largest edge of
    the bed; obstacles that lie beyond it are left out. centre_m: the new origin, east and north of the scene's own.
    The station, water, optics and survey are those of the packaged scenario `paper`. Raises ValueError or OSError.
    """
    read = read_scene(project, scene)
    notes = read.left_out
    if read.pictures:
        colour = "one colour, the picture's mean"
        notes.append(Note("assumed", f"each of {read.pictures} materials with a picture has {colour}"))
    groups: dict[str, list[Piece]] = {}
    for piece in (_moved(each, centre_m) for each in read.pieces):
        groups.setdefault(piece.body[0] if piece.body else piece.path[0], []).append(piece)
    for name in [name for name in groups if WATER in name.lower()]:
        del groups[name]
        notes.append(Note("left out", f"{name}: the water is the scenario's"))
    bodies = [name for name, pieces in groups.items() if pieces[0].body is not None]
    if len(bodies) != 1:
        raise ValueError(f"'{scene}': has {len(bodies)} rigid bodies with meshes ({', '.join(bodies)}): must be one")
    if terrain not in groups:
        raise ValueError(f"'{scene}': has no object '{terrain}' with meshes for the bed, of {', '.join(groups)}")
    written = _Files(out)
    hull, station = groups.pop(bodies[0]), groups.pop(STATION, None)
    bed = read_bed(_joined(groups.pop(terrain), _in_world), size_m)
    for name in [name for name, pieces in groups.items() if size_m is not None and _is_beyond(bed, pieces)]:
        del groups[name]
        notes.append(Note("left out", f"{name}: it lies beyond --size = {size_m:g} m"))
    notes.append(Note("assumed", f"the bed is flat at z = {bed.fill_m:.1f} m where {terrain} has none"))
    written.add("terrain.asc", bed.text)
    hull_file = written.mesh("vehicle", hull, _in_body(hull[0]))
    paper = read_yaml(find_yaml("paper", "scenarios")).values
    _move(paper, centre_m)
    values: dict[str, Any] = {
        "name": scene.stem.lower().replace(" ", "_"),
        "description": f"{scene.name} of a Unity project, with uwsim's sonar and map",
        **{key: paper[key] for key in KEPT},
        "terrain": {"source": "raster", "file": "terrain.asc", "crs": "local", "water_level_m": 0.0, "centre": [0, 0],
                    "interpolation": "linear"},
        "vehicles": [{"name": "rov", "model": "vehicle.yaml", "start": "station",
                      "sonar": {"model": 2, "tilt_deg": 60}}],
        "obstacles": [],
    }  # fmt: skip
    if station is None:
        notes.append(Note("left out", f"{STATION}: the scene has none, so the packaged one is used"))
    else:
        place = np.array(values["station"]["position_m"])
        values["station"]["mesh"] = written.mesh("station", station, lambda points: _in_world(points) - place)
    for k, (name, pieces) in enumerate(groups.items()):
        file = written.mesh(f"obstacle_{k}", pieces, _in_world)
        values["obstacles"].append(
            {"kind": "mesh", "name": _name(name, k, values["obstacles"]), "file": file, "position_m": [0, 0, 0]}
        )
    notes += _over(bed, values)
    text, drafting = written.drafted(hull_file)
    written.add("vehicle.yaml", text.encode())
    written.add(f"{values['name']}.yaml", yaml_text(values).encode())
    written.write(values["name"])
    return Made(out / f"{values['name']}.yaml", notes + drafting)


class _Files:
    """Files that are written together, once all of them have been made."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._contents = folder, dict[str, bytes]()

    def add(self, name: str, content: bytes) -> None:
        require_own(self._folder / name)
        if name in self._contents:
            raise ValueError(f"'{self._folder / name}': would be written twice: rename the scene")
        self._contents[name] = content

    def mesh(self, name: str, pieces: list[Piece], placed: Any) -> str:
        """Add the file of all pieces, placed by a function, and return its name: glTF if any has a colour, else PLY."""
        from uwsim.base.whole_trimesh import trimesh

        def merged(some: Iterable[Piece]) -> trimesh.Trimesh:
            mesh = trimesh.Trimesh(*_joined(some, placed), process=False)
            mesh.merge_vertices(merge_tex=True, merge_norm=True)
            return mesh

        if not any(np.isfinite(piece.colour).all() for piece in pieces):
            self.add(f"{name}.ply", cast(bytes, merged(pieces).export(file_type="ply")))
            return f"{name}.ply"
        by_colour: dict[tuple[float, ...], list[Piece]] = {}
        for piece in pieces:
            colour = piece.colour if np.isfinite(piece.colour).all() else PLAIN
            by_colour.setdefault(tuple(colour.tolist()), []).append(piece)
        scene, visual = cast(Any, trimesh.Scene()), cast(Any, trimesh.visual)
        for shade, some in by_colour.items():
            mesh = merged(some)
            mesh.vertices = mesh.vertices @ np.array(TURNS_UP["y"], np.float64)  # from z up to glTF's y up
            factor = [*(float(((c + 0.055) / 1.055) ** 2.4 if c > 0.04045 else c / 12.92) for c in shade), 1.0]
            material = visual.material.PBRMaterial(baseColorFactor=factor, metallicFactor=0.0)
            mesh.visual = visual.TextureVisuals(material=material)
            scene.add_geometry(mesh)
        self.add(f"{name}.glb", cast(bytes, scene.export(file_type="glb")))
        return f"{name}.glb"

    def drafted(self, hull: str) -> tuple[str, list[Note]]:
        """Return the text of the vehicle's file, drafted from its mesh, and notes. Raises ValueError."""
        with TemporaryDirectory() as folder:
            mesh = Path(folder).resolve() / hull
            mesh.write_bytes(self._contents[hull])
            draft = drafted(mesh, AXES, None, "metres", "x")
        return draft.text.replace(str(mesh), hull), [
            Note("", f"vehicle: {note.replace(str(mesh), hull)}") for note in draft.notes
        ]

    def write(self, scenario: str) -> None:
        require_simulable(scenario, self._contents)
        self._folder.mkdir(parents=True, exist_ok=True)
        for name, content in self._contents.items():
            write_atomically(self._folder / name, content)


def _moved(piece: Piece, centre_m: tuple[float, float]) -> Piece:
    """Return a piece as seen from an origin east and north of the scene's own."""
    back = FROM_UNITY.T @ (*centre_m, 0.0)
    body = piece.body and (piece.body[0], piece.body[1] - np.pad(back, (0, 1))[:, None] * (0.0, 0.0, 0.0, 1.0))
    return replace(piece, vertices=piece.vertices - back, body=body)


def _move(paper: dict[str, Any], centre_m: tuple[float, float]) -> None:
    """Move the station and the survey of `paper` likewise."""
    station, survey = paper["station"], paper["survey"]
    station["position_m"] = np.subtract(station["position_m"], (*centre_m, 0.0)).tolist()
    survey["area_m"] = np.subtract(survey["area_m"], centre_m).tolist()


def _in_world(points: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(points @ FROM_UNITY.T - (0.0, 0.0, SURFACE_M))


def _is_beyond(bed: Bed, pieces: Iterable[Piece]) -> bool:
    """Return whether any part of pieces lies beyond the bed's edge."""
    vertices, _ = _joined(pieces, _in_world)
    return bool(np.abs(vertices[:, :2]).max() > bed.reach_m)


def _in_body(piece: Piece) -> Any:
    """Return the function from Unity's world to the frame of the piece's body, without that body's scale."""
    assert piece.body is not None
    world_from_body = piece.body[1]
    turn = world_from_body[:3, :3] / np.linalg.norm(world_from_body[:3, :3], axis=0)
    return lambda points: (points - world_from_body[:3, 3]) @ turn @ FROM_UNITY.T


def _joined(pieces: Iterable[Piece], placed: Any) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the vertices and triangles of all pieces, placed by a function."""
    vertices, triangles, count = [], [], 0
    for piece in pieces:
        vertices.append(placed(piece.vertices))
        triangles.append(piece.triangles + count)
        count += len(piece.vertices)
    return np.concatenate(vertices), np.concatenate(triangles)


def _over(bed: Bed, values: dict[str, Any]) -> list[Note]:
    """Move start and survey over the bed if those of `paper` are not; return notes."""
    station, survey = values["station"], values["survey"]
    east, north, _ = np.add(station["position_m"], station["dock_m"])
    if bed.is_under(east, north) and all(bed.reaches(*corner) for corner in survey["area_m"]):
        return []
    x, y, z = bed.open_water()
    start = [x, y, max(-START_M, 0.5 * z)]
    values["vehicles"][0]["start"] = {"position_m": start}
    half_m = min(SURVEY_M, bed.reach_m - max(abs(x), abs(y)))
    west, south, east, north = x - half_m, y - half_m, x + half_m, y + half_m
    del values["survey"]
    if half_m >= SURVEY_MIN_M:
        values["survey"] = survey | {"area_m": [[west, south], [east, south], [east, north], [west, north]]}
    where = ", ".join(f"{value:g}" for value in start)
    beyond = "since `paper` starts or surveys beyond the bed or on land"
    return [Note("assumed", f"the vehicle starts at ({where}) m, {beyond}")]


def _name(text: str, number: int, others: list[dict[str, Any]]) -> str:
    """Return a name as scenarios have it, unlike those of others."""
    plain = "".join(letter if letter.isascii() and letter.isalnum() else "_" for letter in text.lower()).strip("_")
    if NAME.fullmatch(plain) and plain not in [other["name"] for other in others]:
        return plain
    return f"obstacle_{number}"


def _make(path: Path, out: Path | None, options: Mapping[str, Any]) -> Made:
    scene = options.get("scene", SCENE)
    scenes = sorted(file for file in (path / "Assets").rglob("*.unity"))
    found = [file for file in scenes if file.stem == scene]
    if not found:
        names = ", ".join(file.stem for file in scenes)
        raise ValueError(f"--scene = {scene!r}: must be one of {names}" if scenes else f"'{path}': has no scenes")
    folder = out or Path(scene.lower().replace(" ", "_"))
    return scenario_from(
        Project(path),
        found[0],
        folder,
        terrain=options.get("terrain", TERRAIN),
        size_m=options.get("size"),
        centre_m=options.get("centre", (0.0, 0.0)),
    )


OPTIONS = ("scene", "terrain", "size", "centre")
UNITY = Reader(
    "the checkout of a Unity project, with a folder Assets",
    lambda path, head: (path / "Assets").is_dir(),
    _make,
    OPTIONS,
)
