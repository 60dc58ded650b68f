"""The split of a dataset's frames into training and validation sets."""

from __future__ import annotations

import numpy as np

SPLITS = ("train", "val")
STRETCHES = 4
"""The number of stretches for validation, spread along a track."""


def split_of_frames(count: int, val_share: float, seed: int, *, in_sequence: bool) -> list[str]:
    """Return the split of each frame.

    round(val_share * count) frames are used for validation: random frames if the poses are random, or whole stretches
    of a sequence, since neighbouring frames look alike.
    """
    held_back = round(val_share * count)
    splits = np.full(count, SPLITS[0], dtype="<U5")
    if in_sequence:
        stretches = max(1, min(STRETCHES, held_back))
        lengths = [len(part) for part in np.array_split(np.empty(held_back), stretches)]
        for part, length in zip(np.array_split(np.arange(count), stretches), lengths, strict=True):
            first = (len(part) - length) // 2
            splits[part[first : first + length]] = SPLITS[1]
    else:
        splits[np.random.default_rng([seed, count]).permutation(count)[:held_back]] = SPLITS[1]
    return [str(split) for split in splits]
