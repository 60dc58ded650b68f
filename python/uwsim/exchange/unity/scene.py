"""The meshes of a Unity scene, each with its place in the world; the rest is named."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim.base.extras import need_extra
from uwsim.exchange.unity.project import Document, Material, Project, read_material
from uwsim.scenario.read.assimp_mesh import NodeMesh, nodes_by_assimp
from uwsim.scenario.read.note import Note

Matrix = NDArray[np.float64]
LEFT_HANDED = np.diag([-1.0, 1.0, 1.0, 1.0])
"""Unity mirrors the x of a file's points and transforms, since its frames are left-handed (y up, z forward)."""
BUILT_IN = {10202: "cube", 10206: "cylinder", 10207: "sphere", 10209: "plane"}
MAX_PREFABS, MAX_DEPTH = 10_000, 20
OFF = ("inactive", "its renderer is off")
TRANSFORMS = ("Transform", "RectTransform")
MATERIAL = re.compile(r"m_Materials\.Array\.data\[(\d+)\]")
"""The material of one part of a model's mesh, among the changes of an instance."""
FIELDS = {"m_LocalPosition": "xyz", "m_LocalRotation": "xyzw", "m_LocalScale": "xyz"}


@dataclass(frozen=True, eq=False)
class Piece:
    """A mesh in the scene. path: names from the top-level object down. vertices: (n, 3), Unity's world, left-handed.

    triangles: (m, 3), counter-clockwise from outside as seen in a right-handed frame, after mirroring. body: the name
    of the rigid body that it belongs to, and that body's world_from_body (4, 4), or None. colour: (3,), sRGB from 0 to
    1, nan if neither the scene nor the model file has one.
    """

    path: tuple[str, ...]
    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    body: tuple[str, Matrix] | None
    colour: NDArray[np.float64]


@dataclass
class Scene:
    """The pieces of a scene. prefabs: instances so far. dropped: the objects that were left out, by reason.

    materials: those of the pieces so far, by guid; None for one that cannot be read.
    """

    pieces: list[Piece] = field(default_factory=list)
    prefabs: int = 0
    materials: dict[str, Material | None] = field(default_factory=dict)
    dropped: dict[str, list[str]] = field(default_factory=dict)

    def drop(self, path: Iterable[str], reason: str) -> None:
        """Note an object that is left out."""
        self.dropped.setdefault(reason, []).append("/".join(path))

    def material(self, project: Project, guid: str) -> Material | None:
        """Return a material, which is read once."""
        if guid not in self.materials:
            self.materials[guid] = read_material(project, guid)
        return self.materials[guid]

    @property
    def pictures(self) -> int:
        """How many materials have a picture."""
        return sum(each is not None and each.has_picture for each in self.materials.values())

    @property
    def left_out(self) -> list[Note]:
        """A note for each object that was left out, and one for each file that several of them lack."""
        return [
            Note("left out", f"{name}{more}: {reason}")
            for reason, names in self.dropped.items()
            for name, more in (
                [(each, "") for each in names]
                if reason in OFF or len(names) == 1
                else [(names[0], f" and {len(names) - 1} more")]
            )
        ]


def read_scene(project: Project, path: Path) -> Scene:
    """Read a scene or prefab. Raises ValueError or OSError."""
    scene = Scene()
    try:
        _File(project, path, scene, {}).read(np.eye(4), (), None, {})
    except RecursionError:
        raise ValueError(f"'{path}': its objects are nested too deeply") from None
    except (LookupError, TypeError, AttributeError, ValueError) as error:
        if isinstance(error, ImportError) or str(project.folder) in str(error):
            raise
        raise ValueError(f"'{path}': must be as Unity writes it: {type(error).__name__} {error}") from None
    return scene


class _File:
    """A scene or prefab that is read into a Scene. models: the meshes of files read so far. depth: of prefabs."""

    def __init__(
        self, project: Project, path: Path, scene: Scene, models: dict[Path, list[NodeMesh]], depth: int = 0
    ) -> None:
        self._project, self._scene, self._models, self._depth = project, scene, models, depth
        self._documents = project.documents(path)
        self._placed: set[int] = set()
        self._parts: dict[int, list[Document]] = {}
        for document in self._documents.values():
            owner = document.values.get("m_GameObject", {}).get("fileID", 0)
            self._parts.setdefault(owner, []).append(document)
        self._prefabs: dict[int, list[dict[str, Any]]] = {}
        for document in self._of("PrefabInstance"):
            parent = document.values["m_Modification"]["m_TransformParent"]["fileID"]
            self._prefabs.setdefault(parent, []).append(document.values)

    def _of(self, *kinds: str) -> Iterator[Document]:
        return (each for each in self._documents.values() if each.kind in kinds and not each.stripped)

    def read(self, world: Matrix, path: tuple[str, ...], body: Any, changes: dict[tuple[int, str], Any]) -> None:
        """Add all objects. world: the parent's. changes: a prefab instance's, by identifier and field."""
        for identifier, each in self._documents.items():
            if each.kind in TRANSFORMS and not each.stripped and not each.values["m_Father"]["fileID"]:
                self._object(identifier, world, path, body, changes)
        for values in self._prefabs.get(0, []):
            self._prefab(values, world, path, body)

    def _object(self, identifier: int, world: Matrix, path: tuple[str, ...], body: Any, changes: Any) -> None:
        if identifier in self._placed:
            raise ValueError(f"object {identifier} is the child of several, or of itself")
        self._placed.add(identifier)
        transform = self._documents[identifier].values
        owner = transform["m_GameObject"]["fileID"]
        known = self._documents.get(owner)
        name = str(changes.get((owner, "m_Name"), known.values["m_Name"] if known else "?"))
        path = (*path, name)
        if known is not None and not int(changes.get((owner, "m_IsActive"), known.values["m_IsActive"])):
            self._scene.drop(path, OFF[0])
            return
        parts = {part.kind: part.values for part in self._parts.get(owner, [])}
        world = world @ _local(transform, identifier, changes)
        body = (name, world) if "Rigidbody" in parts else body
        if "MeshFilter" in parts:
            if int(parts.get("MeshRenderer", {}).get("m_Enabled", 0)):
                materials = parts["MeshRenderer"].get("m_Materials") or []
                self._mesh(parts["MeshFilter"]["m_Mesh"], world, path, body, materials)
            else:
                self._scene.drop(path, OFF[1])
        for child in transform["m_Children"]:
            below = self._documents.get(child["fileID"])
            if below is not None and not below.stripped:
                self._object(child["fileID"], world, path, body, changes)
        for values in self._prefabs.get(identifier, []):
            self._prefab(values, world, path, body)

    def _mesh(
        self, reference: dict[str, Any], world: Matrix, path: tuple[str, ...], body: Any, materials: list[Any]
    ) -> None:
        """Add the mesh of a MeshFilter, whose parts have these materials, one after the other."""
        number, file = reference["fileID"], self._project.path(reference.get("guid", ""))
        if number in BUILT_IN and file is None:
            mesh = _built_in(BUILT_IN[number])
            self._add(mesh, world @ LEFT_HANDED, path, body, materials[:1])
            return
        models = self._model(file, path)
        found = [mesh for mesh in models if len({each.name for each in models}) == 1 or _number(mesh.name) == number]
        for k, mesh in enumerate(found):
            self._add(mesh, world @ LEFT_HANDED, path, body, materials[k : k + 1])
        if models and not found:
            self._scene.drop(path, f"has no mesh {number} in {file and self._project.named(file)}")

    def _model(self, file: Path | None, path: tuple[str, ...]) -> list[NodeMesh]:
        """Return the meshes of a model file; none, and the reason among the dropped, if it cannot be read."""
        reason = ""
        if file is None:
            reason = "its file is not in the checkout"
        elif not file.is_file():
            reason = f"{self._project.named(file)} is missing"
        elif file not in self._models:
            try:
                self._models[file] = nodes_by_assimp(file)
            except ValueError as error:
                reason = f"{self._project.named(file)}: {error}"
        if reason:
            self._scene.drop(path, reason)
            return []
        return self._models[file]  # type: ignore[index]  # there is one without a reason

    def _prefab(self, values: dict[str, Any], world: Matrix, path: tuple[str, ...], body: Any) -> None:
        """Add an instance of a prefab or a model file."""
        changes = {
            (each["target"]["fileID"], each["propertyPath"]): each["value"]
            for each in values["m_Modification"]["m_Modifications"]
        }
        name = next((str(value) for (_, key), value in changes.items() if key == "m_Name"), "?")
        file = self._project.path(values["m_SourcePrefab"]["guid"])
        self._scene.prefabs += 1
        if self._scene.prefabs > MAX_PREFABS or self._depth >= MAX_DEPTH:
            raise ValueError(f"more than {MAX_PREFABS} prefabs, or more than {MAX_DEPTH} in each other")
        if file is not None and file.suffix == ".prefab" and file.is_file():
            _File(self._project, file, self._scene, self._models, self._depth + 1).read(world, path, body, changes)
            return
        if any(key == "m_IsActive" and not int(value) for (_, key), value in changes.items()):
            self._scene.drop((*path, name), OFF[0])
            return
        models = self._model(file, (*path, name))
        root = next((target for target, key in changes if key == "m_RootOrder"), 0)
        is_single = len({mesh.name for mesh in models}) == 1  # then Unity makes the only node the root
        materials = {
            int(number[1]): each["objectReference"]
            for each in values["m_Modification"]["m_Modifications"]
            if is_single and (number := MATERIAL.fullmatch(str(each["propertyPath"])))
        }
        for k, mesh in enumerate(models):
            node = LEFT_HANDED @ mesh.file_from_node @ LEFT_HANDED
            local = _changed(node, root, changes) if is_single else _changed(np.eye(4), root, changes) @ node
            given = [materials[k]] if k in materials else []
            self._add(mesh, world @ local @ LEFT_HANDED, (*path, name), body, given)

    def _add(
        self, mesh: NodeMesh, world_from_file: Matrix, path: tuple[str, ...], body: Any, materials: list[Any]
    ) -> None:
        vertices, triangles = mesh.placed(LEFT_HANDED @ world_from_file)  # right-handed, which decides the winding
        if not np.isfinite(vertices).all():
            raise ValueError(f"{'/'.join(path)[:200]}: has points that are not finite")
        material = self._scene.material(self._project, materials[0].get("guid", "")) if materials else None
        colour = mesh.colour if material is None else material.colour
        self._scene.pieces.append(Piece(path, vertices * (-1.0, 1.0, 1.0), triangles, body, colour))


def _number(name: str) -> int:
    """Return Unity's identifier of a model file's mesh (its fileIdsGeneration 2), which its documentation omits.

    It is the xxHash64 of type and name, as the identifiers of the published simulator's five models show.
    """
    need_extra("xxhash", "a model file with several meshes")
    import xxhash

    return int(np.uint64(xxhash.xxh64(f"Type:Mesh->{name}0".encode()).intdigest()).astype(np.int64))


def _local(transform: dict[str, Any], identifier: int, changes: dict[tuple[int, str], Any]) -> Matrix:
    """Return a Transform's parent_from_object, with a prefab instance's changes."""
    values = {
        name: [float(changes.get((identifier, f"{name}.{axis}"), transform[name][axis])) for axis in axes]
        for name, axes in FIELDS.items()
    }
    return _matrix(*values.values())


def _changed(node: Matrix, identifier: int, changes: dict[tuple[int, str], Any]) -> Matrix:
    """Return a node's transform with a prefab instance's changes."""
    scale = np.linalg.norm(node[:3, :3], axis=0)
    scale[0] *= np.sign(np.linalg.det(node[:3, :3])) or 1.0
    turn = Rotation.from_matrix(node[:3, :3] / np.where(scale == 0.0, 1.0, scale)).as_quat()
    found = dict(zip(FIELDS, (node[:3, 3], turn, scale), strict=True))
    plain = {name: dict(zip(axes, found[name].tolist(), strict=True)) for name, axes in FIELDS.items()}
    return _local(plain, identifier, changes)


def _matrix(position: list[float], turn_xyzw: list[float], scale: list[float]) -> Matrix:
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat(turn_xyzw).as_matrix() * scale
    matrix[:3, 3] = position
    return matrix


def _built_in(kind: str) -> NodeMesh:
    """Return one of Unity's own meshes: 1 m wide; the cylinder is 2 m high, the plane 10 m wide."""
    from uwsim.base.whole_trimesh import trimesh

    upright = np.array([[1.0, 0, 0, 0], [0, 0, 1.0, 0], [0, -1.0, 0, 0], [0, 0, 0, 1.0]])  # from z up to y up
    makers: dict[str, Callable[[], Any]] = {
        "cube": lambda: trimesh.creation.box((1.0, 1.0, 1.0)),
        "cylinder": lambda: trimesh.creation.cylinder(0.5, 2.0, transform=upright),
        "sphere": lambda: trimesh.creation.icosphere(radius=0.5),
        "plane": lambda: trimesh.Trimesh([[-5, 0, -5], [5, 0, -5], [5, 0, 5], [-5, 0, 5]], [[0, 2, 1], [0, 3, 2]]),
    }
    mesh = makers[kind]()
    return NodeMesh(kind, np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64), np.eye(4))
