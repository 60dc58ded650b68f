"""A reel gives the encoder the same pictures as a list of them, one at a time."""

import io

import numpy as np
import pytest
from PIL import Image

from uwsim.figures.reel import PictureStore


def picture(k: int) -> Image.Image:
    rgb = np.zeros((24, 40, 3), np.uint8)
    rgb[:, : 4 * k + 1] = (10 * k, 200, 90)
    return Image.fromarray(rgb)


@pytest.mark.parametrize("kind", ["webp", "gif"])
def test_the_animation_is_that_of_the_pictures(kind: str) -> None:
    pictures, store, plain = [picture(k) for k in range(6)], PictureStore(), io.BytesIO()
    for each in pictures:
        store.add(each)
    durations = [40] * 5 + [400]
    pictures[0].save(plain, kind, save_all=True, append_images=pictures[1:], duration=durations, loop=0)
    film = store.reel().encoded(kind, durations)
    assert film == plain.getvalue()
    assert Image.open(io.BytesIO(film)).n_frames == len(store) == 6
