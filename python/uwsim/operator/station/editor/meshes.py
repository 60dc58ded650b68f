"""Meshes from which obstacles and cover are made: the packaged ones and those in a folder, with stills, and uploads."""

from __future__ import annotations

import base64
import binascii
import io
import itertools
import os
import re
import threading
from functools import lru_cache
from pathlib import Path, PurePath
from tempfile import TemporaryDirectory

import numpy as np
from PIL import Image

from uwsim import _core
from uwsim.base.arguments import is_number
from uwsim.base.quaternions import about_y, about_z, matrix, product
from uwsim.base.texts.json_text import json_value
from uwsim.channels.guest import Values
from uwsim.scenario.build.camera import core_camera, core_optics
from uwsim.scenario.read.assets import assets_folder, find_asset
from uwsim.scenario.read.mesh_file import load_mesh
from uwsim.scenario.read.textures import load_texture
from uwsim.scenario.spec.camera import CameraMount
from uwsim.scenario.spec.optics import Optics

FOLDER = "meshes"
SUFFIXES = (".glb", ".obj", ".stl", ".ply")
"""Formats that hold a whole mesh in one file."""
MESH_BYTES_MAX = 20_000_000
MESHES_MAX = 200
NAME = re.compile(rf"{FOLDER}/[A-Za-z0-9_.-]{{1,80}}")
LIBRARY = re.compile(rb"^[ \t]*mtllib[ \t](.*)$", re.MULTILINE)
"""A line of an OBJ file that names the file of its materials."""
SIDE_PX = 120
YAW_RAD, PITCH_RAD = np.pi / 4, 0.5
"""The direction in which the camera of a still looks: to the north-east, and down."""
FIT = 2.0
"""Distance of the camera, in radii of the sphere around the mesh, which its field of view of 60 degrees needs."""


class Meshes:
    """The meshes that a scenario in a folder may name, as meshes/NAME. Methods may be called on any thread."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._lock = threading.Lock()
        self._coming, self._received = "", bytearray()

    def names(self) -> list[str]:
        """Return the names of the meshes, those in the folder first."""
        found: dict[str, None] = {}
        for folder in (self._folder, assets_folder()):
            for path in sorted((folder / FOLDER).glob("*")):
                name = f"{FOLDER}/{path.name}"
                if path.suffix.lower() in SUFFIXES and NAME.fullmatch(name) and len(found) < MESHES_MAX:
                    found[name] = None
        return list(found)

    def still(self, name: str) -> bytes:
        """Return a picture of a mesh as PNG. Raises ValueError if it cannot be read."""
        path = find_asset(Path(name), self._folder) if NAME.fullmatch(name) else None
        if path is None:
            raise ValueError(f"{name[:80]}: there is no such mesh")
        return _still(path, path.stat().st_mtime_ns)

    def receive(self, request: Values) -> Values:
        """Take a part of an upload: `name`, `size` of the whole, `at`: where it begins, `data` in Base64.

        Return the `mesh`, as a scenario names it, with the last part, and what of it is `lost`. Raises ValueError or
        OSError; a file that is no sound mesh is not kept.
        """
        name, size, at = str(request.get("name") or "")[:200], request.get("size"), request.get("at")
        suffix = PurePath(name).suffix.lower()
        if suffix not in SUFFIXES:
            raise ValueError(f"{name}: must end in {', '.join(SUFFIXES)}")
        if not is_number(size) or not 0 < size <= MESH_BYTES_MAX:
            raise ValueError(f"{name}: size = {str(size)[:20]} bytes: must be 1 to {MESH_BYTES_MAX}")
        try:
            part = base64.b64decode(str(request.get("data") or ""), validate=True)
        except (binascii.Error, ValueError):
            raise ValueError(f"{name}: data: must be Base64") from None
        with self._lock:
            if at == 0:
                self._coming, self._received = name, bytearray()
            if name != self._coming or at != len(self._received) or not part or at + len(part) > size:
                raise ValueError(f"{name}: at = {str(at)[:20]}: is not the next part: begin again")
            self._received += part
            if len(self._received) < size:
                return {"mesh": ""}
            content = bytes(self._received)
            self.forget()
        return {"mesh": self._keep(name, suffix, content), "lost": _lost(name, suffix, content)}

    def forget(self) -> None:
        """Forget an upload that was not finished."""
        self._coming, self._received = "", bytearray()

    def _keep(self, name: str, suffix: str, content: bytes) -> str:
        """Write a checked mesh under a name that no other has; return the name."""
        folder = self._folder / FOLDER
        folder.mkdir(parents=True, exist_ok=True)
        stem = re.sub(r"[^A-Za-z0-9_-]+", "_", PurePath(name).stem).strip("_")[:40] or "mesh"
        with TemporaryDirectory(prefix=".upload", dir=folder) as place:
            path = Path(place, f"{stem}{suffix}")
            path.write_bytes(_alone(name, suffix, content))
            try:
                _solid(path)
            except ValueError as error:
                raise ValueError(str(error).replace(str(path), name)) from None
            for number in itertools.count(1):
                free = f"{FOLDER}/{stem}{'' if number == 1 else f'_{number}'}{suffix}"
                if find_asset(Path(free), assets_folder()) is not None:  # which it would stand in front of
                    continue
                try:
                    os.link(path, self._folder / free)
                except FileExistsError:
                    continue
                return free
        raise AssertionError


def _lost(name: str, suffix: str, content: bytes) -> str:
    """Return what `_alone` takes from a mesh, "" for nothing."""
    found = LIBRARY.search(content) if suffix == ".obj" else None
    library = "" if found is None else found[1].decode(errors="replace").strip()[:80]
    return f"{name}: without its colours, which are in {library}: a .glb has them inside" if found else ""


def _alone(name: str, suffix: str, content: bytes) -> bytes:
    """Return a mesh's content without what it takes from other files of this machine. Raises ValueError."""
    if suffix == ".obj":
        return LIBRARY.sub(b"", content)
    if suffix == ".glb" and _names_files(content):
        raise ValueError(f"{name}: takes data from other files, or is no glTF: export it with all its data inside")
    return content


def _names_files(content: bytes) -> bool:
    """Return whether a .glb file's JSON, in any spelling, names files. True if it cannot be read."""
    try:
        tree = json_value(content[20 : 20 + int.from_bytes(content[12:16], "little")], "glTF")
        return any("uri" in each for key in ("buffers", "images") for each in tree.get(key, ()))
    except (ValueError, TypeError, AttributeError):
        return True


def _solid(path: Path) -> tuple[_core.World, int, _core.RayScene]:
    """Return a mesh alone in a world, of a size of 2 m about the origin. Raises ValueError if no solid can be made."""
    vertices, triangles = load_mesh(path)
    low, high = vertices[np.unique(triangles)].min(axis=0), vertices[np.unique(triangles)].max(axis=0)
    radius = max(float(np.linalg.norm(high - low)) / 2, 1e-9)
    world = _core.World()
    label = world.add_solid(FOLDER, (vertices - (low + high) / 2) / radius, triangles)
    return world, label, _core.RayScene(world)


@lru_cache(MESHES_MAX)
def _still(path: Path, changed_ns: int) -> bytes:
    world, label, rays = _solid(path)
    scene = _core.CameraScene(world, rays, 0)
    scene.set_appearance(label, "plain", "structure", None, *load_texture(path) or ())
    mount = CameraMount(position_m=(0, 0, 0), width=SIDE_PX, height=SIDE_PX, field_of_view_deg=60)
    turn = product(about_z(YAW_RAD), about_y(PITCH_RAD))
    place_m = -FIT * matrix(turn)[:, 0]
    picture = scene.render(core_camera(FOLDER, mount), core_optics(Optics()), place_m, turn, 0.0, 0, [])
    found = io.BytesIO()
    Image.fromarray(np.asarray(picture.rgb)).save(found, "PNG")
    return found.getvalue()
