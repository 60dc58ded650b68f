"""Reads the textures and colours of mesh files: an image, and the coordinates of each triangle on it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.scenario.read.mesh_file import Y_UP_SUFFIXES, load_mesh

TEXTURED_SUFFIXES = (".obj", ".glb", ".gltf")
MAX_SIDE = 4096
PATCH = 4
"""Width and height of a colour patch in pixels."""
UNCOLOURED = np.array([1.0, 1.0, 1.0])
"""The default base colour of a glTF material: white, as in the specification."""
SPREAD = np.array([(i, j, 21 - i - j) for i in range(1, 21, 3) for j in range(1, 21 - i, 3)]) / 21.0
"""Barycentric coordinates of points spread evenly over a triangle."""

Texture = tuple[NDArray[np.uint8], NDArray[np.float32]]


def load_texture(path: Path) -> Texture | None:
    """Return a mesh file's image (h, w, 3) uint8, sRGB, and texture coordinates (m, 3, 2) float32 of the corners.

    Coordinates are measured from the lower left. For a glTF file without images whose materials or vertices have
    colours, the image contains one patch per colour. Returns None for files with neither, for unreadable images, and
    for formats other than glTF and OBJ. The triangles are those of load_mesh, in the same order. Several images are
    placed side by side. Images are reduced to at most 4,096 pixels per side.
    """
    if path.suffix.lower() not in TEXTURED_SUFFIXES:
        return None
    from uwsim.base.whole_trimesh import trimesh

    try:
        scene = trimesh.load_scene(path, process=False)
        if path.suffix.lower() in Y_UP_SUFFIXES and (colours := _face_colours(scene)) is not None:
            return _palette(colours) if len(colours) == len(load_mesh(path)[1]) else None
        mesh: Any = scene.to_mesh()
        uv = getattr(mesh.visual, "uv", None)
        image = _image_of(mesh.visual)
    except Exception:  # readers raise any error for malformed files; load_mesh has already read the geometry
        return None
    if uv is None or image is None or not np.isfinite(uv).all():
        return None
    triangles = load_mesh(path)[1]
    if len(triangles) != len(mesh.faces):
        return None
    return image, np.ascontiguousarray(np.asarray(uv, np.float32)[mesh.faces])


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
    return _encoded(linear)


def _encoded(linear: NDArray[np.float64]) -> NDArray[np.uint8]:
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)  # IEC 61966-2-1
    return np.asarray(np.rint(255.0 * encoded), np.uint8)


def triangle_means(texture: Texture) -> NDArray[np.float64]:
    """Return the mean albedo (m, 3), linear, of each triangle of a texture, over points spread evenly over it."""
    image, corners = texture
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
    return _palette(_encoded(albedos))


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
    return np.ascontiguousarray(image), np.ascontiguousarray(np.repeat(middle[:, None], 3, axis=1))


def _image_of(visual: Any) -> NDArray[np.uint8] | None:
    material = getattr(visual, "material", None)
    image = getattr(material, "baseColorTexture", None) or getattr(material, "image", None)
    if image is None:
        return None
    image = image.convert("RGB")
    image.thumbnail((MAX_SIDE, MAX_SIDE))
    return np.ascontiguousarray(np.asarray(image, np.uint8))
