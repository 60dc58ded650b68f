"""Pictures of the views at full size, with the instruments' values in their metadata."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.channels.families.telemetry import plain_panel
from uwsim.channels.guest import Values
from uwsim.channels.table import Table
from uwsim.instruments.cameras.image_file import encode_png
from uwsim.instruments.gauges import GAUGES
from uwsim.live import LiveSimulator
from uwsim.operator.station.views.arrivals import Arrivals
from uwsim.operator.station.views.views import Views
from uwsim.simulator.failures.events import comment_of

OF_THE_TRUTH = ("true_position", "is_truth")
"""Fields of /telemetry that are not stored in pictures."""


@dataclass
class Snapshots:
    """The views of a running simulator, from which pictures are taken. arrivals: those received over a link, if any."""

    live: LiveSimulator
    table: Table
    views: Views
    arrivals: Arrivals | None

    def png(self, view: str) -> bytes:
        """Return a lossless picture of a camera's view. Raises ValueError.

        For a view received over a link, this is the last picture that arrived, with the last panel.
        """
        rgb, panel = self.picture(view)
        return encode_png(rgb, text=self.described(view, panel, comment_of(self.live.simulator.events)))

    def picture(self, view: object) -> tuple[NDArray[np.uint8], Values]:
        """Return a picture of a camera's view, (H, W, 3), and the panel at the same time. Raises ValueError."""
        shown = self.views.view(view)
        if self.arrivals is not None and shown.name in self.arrivals:
            return self.arrivals.snapshot(shown.name)
        source = next((each for each in self.table.sources if each.name == shown.vehicle), self.table.sources[0])
        frame, panel = self.views.capture(shown, lambda sim: plain_panel(sim, source))
        return frame.rgb, panel

    def panel(self, vehicle: str) -> Values:
        """Return a vehicle's current panel or, over a link, the last to arrive. Raises ValueError if there is none."""
        if self.arrivals is not None:
            return self.arrivals.panel(vehicle)
        source = next(each for each in self.table.sources if each.name == vehicle)
        return self.live.read(lambda sim: plain_panel(sim, source)).result()

    def described(self, view: str, panel: Values, comment: str, *, note: str = "") -> dict[str, str]:
        """Return the text chunks of a picture: PNG's standard keywords, and "uwsim" with all values as JSON."""
        scenario = self.live.simulator.scenario.name
        values = instruments(panel)
        line = " ".join(f"{key}={value}" for key, value in values.items() if value is not None)
        hidden = OF_THE_TRUTH if values["position_m"] is not None else (*OF_THE_TRUTH, "orientation")
        rest = {key: _json(value) for key, value in panel.items() if key not in hidden}
        every = {"scenario": scenario, "view": view, "comment": comment, "note": note, **values, "panel": rest}
        texts = {"Title": f"{scenario}: {view}", "Description": line, "Comment": note or comment, "Software": "uwsim"}
        return {**{key: text for key, text in texts.items() if text}, "uwsim": json.dumps(every)}


def instruments(panel: Values) -> Values:
    """Return the values shown in pictures, in SI units and degrees, or None for values that are not measured.

    position_m (east, north and up, in odom) and heading_deg (clockwise from north) are the vehicle's own estimates.
    """
    header = panel["header"]["stamp"]
    position = np.asarray(panel["position"], np.float64)
    is_known = bool(np.isfinite(position).all())  # without an estimate, the orientation is not measured either
    x, y, z, w = np.asarray(panel["orientation"], np.float64).tolist()
    yaw_rad = math.atan2(2.0 * (x * y + w * z), 1.0 - 2.0 * (y * y + z * z))
    return {
        "time_s": round(header["sec"] + 1e-9 * header["nanosec"], 3),
        **{gauge.column: _known(panel[gauge.name], 2) for gauge in GAUGES if gauge.shown_in == "big"},
        "heading_deg": round((90.0 - math.degrees(yaw_rad)) % 360.0, 1) % 360.0 if is_known else None,
        "position_m": [round(value, 2) for value in position.tolist()] if is_known else None,
    }


def _known(value: Any, digits: int) -> float | None:
    return round(float(value), digits) if value is not None and math.isfinite(value) else None


def _json(value: Any) -> Any:
    """Return a panel's value in JSON types, with null for unknown values."""
    if isinstance(value, dict):
        return {key: _json(item) for key, item in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [_json(item) for item in value]
    if isinstance(value, np.generic):
        return _json(value.item())
    return None if isinstance(value, float) and not math.isfinite(value) else value
