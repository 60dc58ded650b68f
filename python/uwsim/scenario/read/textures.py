"""Textures of mesh files: an image and the place of each triangle on it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.scenario.read.mesh_file import load_mesh

TEXTURED_SUFFIXES = (".obj", ".glb", ".gltf")
MAX_SIDE = 4096

Texture = tuple[NDArray[np.uint8], NDArray[np.float32]]


def load_texture(path: Path) -> Texture | None:
    """Return a mesh file's image (h, w, 3) uint8, sRGB, and corners (m, 3, 2) float32 on it, from its lower left.

    None for a file without an image, or with one that cannot be read, and for formats other than glTF and OBJ. The
    triangles are those of load_mesh, in its order. Several images in a file are placed side by side. Images are reduced
    to at most 4,096 pixels a side.
    """
    if path.suffix.lower() not in TEXTURED_SUFFIXES:
        return None
    import trimesh

    try:
        scene = trimesh.load_scene(path, process=False)
        mesh: Any = scene.to_mesh()
        uv = getattr(mesh.visual, "uv", None)
        image = _image_of(mesh.visual)
    except Exception:  # readers raise all kinds of errors for malformed files; load_mesh has already read the geometry
        return None
    if uv is None or image is None or not np.isfinite(uv).all():
        return None
    triangles = load_mesh(path)[1]
    if len(triangles) != len(mesh.faces):
        return None
    return image, np.ascontiguousarray(np.asarray(uv, np.float32)[mesh.faces])


def _image_of(visual: Any) -> NDArray[np.uint8] | None:
    material = getattr(visual, "material", None)
    image = getattr(material, "baseColorTexture", None) or getattr(material, "image", None)
    if image is None:
        return None
    image = image.convert("RGB")
    image.thumbnail((MAX_SIDE, MAX_SIDE))
    return np.ascontiguousarray(np.asarray(image, np.uint8))
