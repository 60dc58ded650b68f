"""The sensor `bearing`: the direction from which a pinger's sound arrives, for those who do not process samples."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from uwsim.base.quaternions import matrix
from uwsim.instruments.acoustics.pinger_sound import Burst
from uwsim.scenario.spec.sensor_kind import DerivedKind, Figure


def measure(
    values: Mapping[str, Any], figures: Mapping[str, float], time_s: float, ping: Callable[..., Burst | None]
) -> dict[str, float]:
    """Return the direction, straight to the pinger, of the last burst since the sample before.

    It is that at the time of the sample. All are NaN without a burst in the band, and below the threshold.
    """
    place = np.asarray(values["position_m"], np.float64)
    burst = ping(place, figures["low_hz"], figures["high_hz"])
    if burst is None or burst.level_db < figures["threshold_db"]:
        return dict.fromkeys(FIELDS, math.nan)
    x, y, z = matrix(values["orientation_xyzw"]).T @ (burst.pinger.position_m - place)
    return {
        "azimuth_rad": math.atan2(y, x),
        "elevation_rad": math.atan2(z, math.hypot(x, y)),
        "level_db": burst.level_db,
        "frequency_hz": burst.pinger.frequency_hz,
    }


FIELDS = {"azimuth_rad": (1, "rad"), "elevation_rad": (1, "rad"), "level_db": (1, "dB"), "frequency_hz": (1, "Hz")}

BEARING = DerivedKind(
    name="bearing",
    meaning="direction of a pinger (azimuth from x to y, elevation up is positive), in the sample after each ping",
    source="ins",
    fields=FIELDS,
    measure=measure,
    listens=True,
    parameters={
        "low_hz": Figure(200.0, 0.0, 1e6, "Hz", "lowest frequency that it detects"),
        "high_hz": Figure(250e3, 0.0, 1e6, "Hz", "highest frequency that it detects"),
        "threshold_db": Figure(100.0, 0.0, 300.0, "dB re 1 uPa", "lowest level of a burst that it detects"),
    },
)
