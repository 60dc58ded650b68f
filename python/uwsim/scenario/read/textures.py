"""Reads the textures and colours of mesh files: an image, and the coordinates of each triangle on it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim.base.texts.text_file import require_regular
from uwsim.scenario.read.disk_cache import Arrays, cached_arrays
from uwsim.scenario.read.mesh_file import Y_UP_SUFFIXES, files_beside, has_places_on_images, load_mesh

TEXTURED_SUFFIXES = (".obj", ".glb", ".gltf")
MAX_SIDE = 4096
PATCH = 4
"""Width and height of a colour patch in pixels."""
UNCOLOURED = np.array([1.0, 1.0, 1.0])
"""The default base colour of a glTF material: white, as in the specification."""
SPREAD = np.array([(i, j, 21 - i - j) for i in range(1, 21, 3) for j in range(1, 21 - i, 3)]) / 21.0
"""Barycentric coordinates of points spread evenly over a triangle."""

MATT = np.array([128, 128, 255, 255, 0], np.uint8)
"""The bands beyond the colours of a surface without relief: a normal that points out of it, rough, no metal."""


class Texture(NamedTuple):
    """An image laid on a mesh of m triangles.

    image: (h, w, 3) uint8, sRGB; or (h, w, 8), followed by the normal in the image's frame (x right, y up), roughness
    and metalness, as in glTF 2.0. corners: (m, 3, 2) float32, coordinates of the triangles' corners from the lower
    left. normals: (m, 3, 3) float32 or None, unit normals of the corners along each triangle's first edge, across it
    and along the triangle's own normal.
    """

    image: NDArray[np.uint8]
    corners: NDArray[np.float32]
    normals: NDArray[np.float32] | None = None


def load_texture(path: Path) -> Texture | None:
    """Return the texture of a mesh file, whose triangles are those of load_mesh, in the same order.

    From glTF files, it has normal maps, roughness and metalness, where a material gives any of them, and the normals of
    the vertices. For a glTF file without images whose materials or vertices have colours, the image contains one patch
    per colour. Returns None for files with neither, for unreadable images, and for formats other than glTF and OBJ.
    Likewise, one per material, for an OBJ file of triangles without places on images. Several images are placed side by
    side. Images are reduced to at most 4,096 pixels per side.
    """
    suffix = path.suffix.lower()
    if suffix not in TEXTURED_SUFFIXES:
        return None
    content = path.read_bytes()
    if suffix == ".obj":
        if b"mtllib" not in content:
            return None
        return _read_texture(path) if has_places_on_images(content) else _painted(path, content)
    if b'"uri"' in content:  # it depends on other files
        return _read_texture(path)
    parts: Any = cached_arrays(lambda: _parts_of(_read_texture(path)), "texture", content)
    return Texture(*parts) if parts else None


def _painted(path: Path, content: bytes) -> Texture | None:
    """Return the colours that the materials of an OBJ file of triangles give them; None without any."""
    text = content.decode("utf-8", errors="replace")
    known: dict[str, NDArray[np.float64]] = {}
    try:
        for library in re.findall(r"^mtllib[ \t]+(.*\S)", text, re.MULTILINE):
            known |= _diffuse_colours(require_regular(path.parent / library).read_text("utf-8", "replace"))
    except (OSError, ValueError):
        return None
    now, colours = UNCOLOURED, []
    for kind, rest in re.findall(r"^[ \t]*(usemtl|f)[ \t]+(.*\S)", text, re.MULTILINE):
        if kind == "usemtl":
            now = known.get(rest, UNCOLOURED)
        else:
            colours.append(now)
    return palette_texture(np.array(colours)) if known and len(colours) == len(load_mesh(path)[1]) else None


def _diffuse_colours(library: str) -> dict[str, NDArray[np.float64]]:
    """Return the albedo (3,) of each material in a library's text that has one: Kd, taken as linear."""
    entry = r"^[ \t]*(?:newmtl[ \t]+(.*\S)|Kd[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+))"
    found, name = {}, ""
    for begun, *kd in re.findall(entry, library, re.MULTILINE):
        if begun:
            name = begun
        else:
            found[name] = np.clip([float(each) for each in kd], 0.0, 1.0)
    return found


def _parts_of(texture: Texture | None) -> Arrays:
    return tuple(part for part in texture or () if part is not None)


def _read_texture(path: Path) -> Texture | None:
    from uwsim.base.whole_trimesh import trimesh  # takes half a second

    try:
        scene = trimesh.load_scene(path, process=False, resolver=files_beside(path))
        if path.suffix.lower() in Y_UP_SUFFIXES and (colours := _face_colours(scene)) is not None:
            return _palette(colours) if len(colours) == len(load_mesh(path)[1]) else None
        mesh: Any = scene.to_mesh()
        uv = getattr(mesh.visual, "uv", None)
        image = _bands_of(mesh.visual)
        normals = _normals_of(scene)
    except Exception:  # readers raise any error for malformed files; load_mesh has already read the geometry
        return None
    if uv is None or image is None or not np.isfinite(uv).all():
        return None
    triangles = load_mesh(path)[1]
    if len(triangles) != len(mesh.faces):
        return None
    corners = np.ascontiguousarray(np.asarray(uv, np.float32)[mesh.faces])
    return Texture(image, corners, normals if normals is not None and len(normals) == len(corners) else None)


def _normals_of(scene: Any) -> NDArray[np.float32] | None:
    """Return the Texture.normals that a scene's file gives, in the order of its nodes; None without all of them."""
    parts = []
    for node in scene.graph.nodes_geometry:
        placed, name = scene.graph[node]
        part = scene.geometry[name]
        if "vertex_normals" not in part._cache or np.linalg.det(placed[:3, :3]) <= 0:
            return None
        parts.append(_in_triangles(part.vertex_normals[part.faces], part.triangles))
    return np.concatenate(parts)


def _in_triangles(normals: NDArray[np.float64], places: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return corners' normals (m, 3, 3) in the frames of their triangles, given the corners' places (m, 3, 3)."""
    first, second = places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]
    own = _unit(np.cross(first, second))
    along = _unit(first)
    axes = np.stack([along, np.cross(own, along), own], axis=1)
    found = np.einsum("mak,mck->mca", axes, _unit(normals))
    found[~(found[:, :, 2] > 0).all(axis=1)] = (0.0, 0.0, 1.0)  # normals that contradict the triangle
    return np.ascontiguousarray(found, np.float32)


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0, length, 1.0))


def _face_colours(scene: Any) -> NDArray[np.uint8] | None:
    """Return the colour of each triangle (m, 3), sRGB, for a scene with colours but no images; otherwise None."""
    parts, given = [], False
    for mesh in scene.dump(concatenate=False):
        material: Any = getattr(mesh.visual, "material", None)
        if _image_of(mesh.visual) is not None:
            return None
        factor = getattr(material, "baseColorFactor", None)
        if material is None and mesh.visual.defined:
            linear = np.asarray(mesh.visual.face_colors[:, :3], np.float64) / 255.0
        else:
            plain = UNCOLOURED if factor is None else np.asarray(material.main_color[:3], np.float64) / 255.0
            linear = np.tile(plain, (len(mesh.faces), 1))
        given = given or factor is not None or (material is None and mesh.visual.defined)
        parts.append(linear)
    if not given:
        return None
    linear = np.concatenate(parts)
    return encoded(linear)


def encoded(linear: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Return albedos in sRGB."""
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)  # IEC 61966-2-1
    return np.asarray(np.rint(255.0 * encoded), np.uint8)


def triangle_means(texture: Texture) -> NDArray[np.float64]:
    """Return the mean albedo (m, 3), linear, of each triangle of a texture, over points spread evenly over it."""
    image, corners = texture.image[:, :, :3], texture.corners
    rows, columns = image.shape[:2]
    found = np.zeros((len(corners), 3))
    for weights in SPREAD:
        across, up = np.mod(np.einsum("k,mkc->cm", weights, corners), 1.0)
        column = (across * columns).astype(int).clip(0, columns - 1)
        encoded = image[((1.0 - up) * rows).astype(int).clip(0, rows - 1), column] / 255.0
        found += np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)  # IEC 61966-2-1
    return found / len(SPREAD)


def palette_texture(albedos: NDArray[np.float64]) -> Texture:
    """Return a texture that gives each triangle its albedo (m, 3)."""
    return _palette(encoded(albedos))


def _palette(colours: NDArray[np.uint8]) -> Texture:
    """Return an image with one patch for each distinct colour among (m, 3), and corners at the patch centres."""
    known, which = np.unique(colours, axis=0, return_inverse=True)
    across = min(len(known), MAX_SIDE // PATCH)
    rows = -(-len(known) // across)
    if rows * PATCH > MAX_SIDE:
        raise ValueError(f"{len(known)} colours are too many")
    patches = np.zeros((rows * across, 3), np.uint8)
    patches[: len(known)] = known
    image = np.repeat(np.repeat(patches.reshape(rows, across, 3), PATCH, axis=0), PATCH, axis=1)
    row, column = np.divmod(which.ravel(), across)
    middle = np.column_stack([(column + 0.5) / across, 1.0 - (row + 0.5) / rows]).astype(np.float32)
    return Texture(np.ascontiguousarray(image), np.ascontiguousarray(np.repeat(middle[:, None], 3, axis=1)))


def _bands_of(visual: Any) -> NDArray[np.uint8] | None:
    """Return the bands of a Texture's image; only the colours of a material that is matt."""
    colours = _image_of(visual)
    if colours is None:
        return None
    material = visual.material
    if (factor := getattr(material, "baseColorFactor", None)) is not None:
        tint = np.asarray(factor[:3], np.float64) / (255.0 if np.asarray(factor).dtype.kind in "ui" else 1.0)
        if (tint < 1.0).any():
            shown = colours / 255.0
            linear = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)  # IEC 61966-2-1
            colours = encoded(linear * tint)
    size = (colours.shape[1], colours.shape[0])
    relief, gloss = (getattr(material, name, None) for name in ("normalTexture", "metallicRoughnessTexture"))
    factors = [getattr(material, name, None) for name in ("roughnessFactor", "metallicFactor")]
    if relief is None and gloss is None and factors in ([None, None], [None, 0.0], [1.0, 0.0]):  # matt
        return colours
    bands = np.concatenate([colours, np.broadcast_to(MATT, (*colours.shape[:2], len(MATT)))], axis=2)
    if relief is not None:
        bands[:, :, 3:6] = np.asarray(relief.convert("RGB").resize(size))
    given = np.ones((*colours.shape[:2], 2))  # roughness and metalness are 1 in glTF, unless stated
    if gloss is not None:
        given = np.asarray(gloss.convert("RGB").resize(size))[:, :, 1:3] / 255.0
    if gloss is not None or factors != [None, None]:
        bands[:, :, 6:] = np.rint(255.0 * given * [1.0 if factor is None else factor for factor in factors])
    return bands


def _image_of(visual: Any) -> NDArray[np.uint8] | None:
    material = getattr(visual, "material", None)
    image = getattr(material, "baseColorTexture", None) or getattr(material, "image", None)
    if image is None:
        return None
    image = image.convert("RGB")
    image.thumbnail((MAX_SIDE, MAX_SIDE))
    return np.ascontiguousarray(np.asarray(image, np.uint8))
