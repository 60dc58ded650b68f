"""The terrain `image`: heights from the grey levels of an image."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from uwsim.scenario.build.terrain import FloatGrid, grid_axes, resampled
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.spec.fields import AssetFile, Metres, Size
from uwsim.scenario.spec.terrain import MAX_NODES, TerrainModel

FORMATS = ("PNG", "TIFF", "BMP", "JPEG", "JPEG2000", "PPM", "GIF", "WEBP", "TGA")
"""Supported formats. Pillow supports more, but some of them start other programs, such as Ghostscript for EPS."""


class ImageTerrain(TerrainModel):
    """Terrain heights from the grey levels of an 8- or 16-bit image. The first row is the northern edge.

    The centres of the outermost pixels lie on the terrain's edge. file: the image. interpolation: method between its
    pixels. black_m, white_m: z at grey level 0 and at the highest one (255 or 65535).
    """

    source: Literal["image"]
    file: AssetFile = Field(examples=["terrains/mountains.png"])
    size_m: tuple[Size, Size] = Field(examples=[[200, 200]])
    black_m: Metres = Field(examples=[-20])
    white_m: Metres = Field(examples=[-5])
    interpolation: Literal["cubic", "linear"] = "cubic"

    def heights(self) -> NDArray[np.floating]:
        """Grey levels mapped to black_m..white_m and stretched over size_m, row 0 to the north; see TerrainModel."""
        share = _grey_share(self)
        h, w = share.shape
        x, y = grid_axes(self.size_m, self.spacing_m)
        heights = self.black_m + (self.white_m - self.black_m) * share

        def pixel_at(x: FloatGrid, y: FloatGrid) -> tuple[FloatGrid, FloatGrid]:
            return (0.5 - y / self.size_m[1]) * (h - 1), (x / self.size_m[0] + 0.5) * (w - 1)

        return resampled(heights, x, y, pixel_at, self.interpolation)


def _grey_share(spec: ImageTerrain) -> NDArray[np.float64]:
    """Return grey levels (h, w) scaled from 0 (black) to 1 (white). Raises ScenarioError."""
    from PIL import Image, UnidentifiedImageError  # here, since every scenario imports this module

    from uwsim.scenario.build.whole_tiff import require_whole_tiff

    try:
        require_whole_tiff(spec.file)
        with Image.open(spec.file, formats=FORMATS) as image:
            if image.width * image.height > MAX_NODES:
                raise ScenarioError(
                    f"terrain '{spec.file}': {image.width} x {image.height} pixels, must be at most {MAX_NODES}"
                )
            levels = np.asarray(image)
            mode = image.mode
    except (UnidentifiedImageError, OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        if isinstance(error, ScenarioError):
            raise
        raise ScenarioError(f"terrain '{spec.file}': not a readable image: {error}") from None
    if mode in ("RGB", "RGBA", "LA"):
        levels = _one_channel(levels, mode, spec)
    elif mode not in ("L", "I", "I;16", "I;16B"):
        raise ScenarioError(f"terrain '{spec.file}': image mode {mode}, expected 8 or 16 bit grey")
    if min(levels.shape) < 2:
        raise ScenarioError(
            f"terrain '{spec.file}': {levels.shape[1]} x {levels.shape[0]} pixels, expected 2 x 2 or more"
        )
    white = 255 if levels.dtype == np.uint8 else 65535
    if levels.min() < 0 or levels.max() > white:
        raise ScenarioError(f"terrain '{spec.file}': grey levels beyond 16 bit")
    return levels.astype(np.float64) / white


def _one_channel(levels: NDArray[np.uint8], mode: str, spec: ImageTerrain) -> NDArray[np.uint8]:
    """Return the grey levels of a greyscale image that was saved in colour, ignoring its alpha channel."""
    colours = levels[..., :1] if mode == "LA" else levels[..., :3]
    if (colours != colours[..., :1]).any():
        raise ScenarioError(
            f"terrain '{spec.file}': a colour image, expected grey levels (convert it to 8 or 16 bit grey)"
        )
    return colours[..., 0]
