"""The imaging sonar `clipped`: a forward-looking one that drops faint echoes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.instruments.sonars.imaging import ForwardLooking, Place, SonarImage, look_ahead
from uwsim.scenario.spec.imaging_sonar import ImagingKind, figure


@dataclass(frozen=True, kw_only=True)
class Clipped(ForwardLooking):
    """A forward-looking sonar that drops faint echoes."""

    kind: ClassVar[str] = "clipped"

    margin_db: float = figure(10.0, 0, 60, "dB", "least level above the noise")


def ping(sim: Place, world_from_sonar: Floats, model: Clipped, name: str, *, with_labels: bool = False) -> SonarImage:
    """Return the core's picture, with the mean noise in place of faint echoes."""
    image = look_ahead(sim, world_from_sonar, model, name=name, with_labels=with_labels)
    noise_db = image.noise_db[:, None]
    loud = image.level_db >= noise_db + np.float32(model.margin_db)
    return replace(image, level_db=np.where(loud, image.level_db, noise_db))


CLIPPED = ImagingKind(Clipped, ping)
