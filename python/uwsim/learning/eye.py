"""Pictures as part of observations."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.spaces import Box, Dict, Space
from numpy.typing import NDArray

from uwsim.base.named import did_you_mean
from uwsim.batch import Batch
from uwsim.learning.options import EpisodeOptions

EFFECTS = ("attenuation", "backscatter", "sunlight", "lamps", "distortion", "exposure", "noise")


class Eye:
    """The pictures of a camera on the first vehicle of each member, with the light and the noise of that member."""

    def __init__(self, batch: Batch, options: EpisodeOptions) -> None:
        """Raise ValueError for a camera that the vehicle does not have."""
        self._batch = batch
        self._name = str(options.camera)
        known = list(batch.aboard(0).rov.cameras)
        if self._name not in known:
            rule = f"must be one of {', '.join(known)}{did_you_mean(self._name, known)}"
            raise ValueError(f"camera = {options.camera!r}: {rule}")
        self.height, self.width = options.camera_size

    @property
    def space(self) -> Box:
        """The Gymnasium space of one picture."""
        return Box(0, 255, (self.height, self.width, 3), np.uint8)

    def pictures(self) -> NDArray[np.uint8]:
        """Return the pictures (n, height, width, 3) of all members."""
        return self._batch.capture(self._name, EFFECTS, size=(self.height, self.width))


def look(space: Space[Any], eye: Eye | None) -> Space[Any]:
    """Return the observation space, with the eye's pictures if there is an eye."""
    if eye is None:
        return space
    parts = dict(space.spaces) if isinstance(space, Dict) else {"state": space}
    return Dict({**parts, "camera": eye.space})
