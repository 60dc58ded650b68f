"""PNG files: Pillow, another reader, finds the same pixels and text."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from uwsim.instruments.cameras.image_file import encode_png


@pytest.mark.parametrize("optimize", [False, True])
@pytest.mark.parametrize("shape", [(1, 1), (5, 1), (1, 6), (7, 9), (1, 1, 3), (7, 9, 3)])
@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_another_reader_finds_the_same_pixels_and_text(
    shape: tuple[int, ...], kind: type[np.generic], optimize: bool
) -> None:
    if len(shape) == 3 and kind is np.uint16:
        pytest.skip("Pillow reads 16 bits in grey only")
    pixels = np.random.default_rng(3).integers(0, np.iinfo(kind).max, shape, kind, endpoint=True)
    text = {"Title": "größe", "Comment": "a\nb"}
    for laid_out in (pixels, pixels[::-1, ::-1], np.asfortranarray(pixels), np.zeros_like(pixels)):
        file = encode_png(laid_out, optimize=optimize, text=text)
        assert file == encode_png(laid_out.copy(), optimize=optimize, text=text)
        with Image.open(io.BytesIO(file)) as picture:
            picture.load()
            np.testing.assert_array_equal(np.array(picture), laid_out)
            assert picture.text == text
