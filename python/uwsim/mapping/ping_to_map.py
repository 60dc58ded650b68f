"""The processing chain from a ping to a map: depth string, decoded ranges, LaserScan, point cloud, world, OctoMap."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.sealed import Sealed
from uwsim.mapping import ranging
from uwsim.mapping.map_filler import MapFiller

if TYPE_CHECKING:
    from uwsim.mapping.files.georeference import Georeference
    from uwsim.mapping.files.swath import Swath

Box = tuple[NDArray[np.float64], NDArray[np.float64]]
"""A box, as its low and high corners, (3,) each."""
Wire = Callable[[NDArray[np.float32]], NDArray[np.float32]]
"""A function that returns the ranges (beams,) that arrive for the ranges sent."""


class PingToMap(Sealed):
    """Processes pings and inserts them into a map: the only chain, so that one ping makes one map wherever it is made.

    filler: inserts into the map; None if the caller inserts the echoes. hull: a box around the vehicle's hull, body
    frame; echoes from inside it are discarded. wire: transmits the ranges from the sonar to the map; by default, as a
    depth string. decodes: whether it returns what `decode_depth_string` returned, which has been checked.
    outlier_filter: whether ranging.reject_outliers is part of the chain. max_uncertainty_m: the limit for
    ranging.reject_uncertain; None omits that step.
    """

    model: _core.MultibeamModel
    hull: Box
    filler: MapFiller | None
    max_uncertainty_m: float | None
    _fixed_when = "the chain is made"

    def __init__(
        self,
        model: int | _core.MultibeamModel,
        hull: Box,
        filler: MapFiller | None = None,
        *,
        wire: Wire | None = None,
        decodes: bool = False,
        outlier_filter: bool = False,
        max_uncertainty_m: float | None = None,
    ) -> None:
        self.model = model if isinstance(model, _core.MultibeamModel) else ranging.MODELS[model]
        self.hull = hull
        self.filler = filler
        self._carried = wire or depth_string(self.model)
        self._scan_of = ranging.scan_of_decoded if decodes or wire is None else ranging.to_laser_scan
        self._outlier_filter = outlier_filter
        self.max_uncertainty_m = max_uncertainty_m

    def insert(
        self,
        ranges_m: NDArray[np.float32],
        world_from_body: NDArray[np.float64],
        world_from_sonar: NDArray[np.float64],
        stamp_s: float,
        deviation_m: NDArray[np.float32] | None = None,
    ) -> NDArray[np.float32]:
        """Insert a ping with ranges (beams,), taken at these poses (4, 4); return its echoes in the world, (n, 3).

        deviation_m: (beams,), standard deviations of the echoes' positions, if known; see ranging.place_deviation_m.
        """
        assert self.filler is not None
        echoes_world_m = self.echoes(ranges_m, world_from_body, world_from_sonar, stamp_s, deviation_m)
        self.filler.insert(echoes_world_m, world_from_sonar[:3, 3].copy())
        return echoes_world_m

    def echoes(
        self,
        ranges_m: NDArray[np.float32],
        world_from_body: NDArray[np.float64],
        world_from_sonar: NDArray[np.float64],
        stamp_s: float,
        deviation_m: NDArray[np.float32] | None = None,
    ) -> NDArray[np.float32]:
        """Return the echoes that `insert` inserts, in the world, (n, 3)."""
        scan = self.scan(ranges_m, stamp_s, deviation_m)
        return ranging.to_world(scan, *self.hull, world_from_body, world_from_sonar)

    def echoes_of(self, ping: Any) -> NDArray[np.float32]:
        """Return the echoes (n, 3) in the world of a ping that Sonar.ping() took, at the vehicle's true pose."""
        body, sonar, stamp_s = ping.world_from_body, ping.world_from_sonar, 1e-9 * ping.time_ns
        return self.echoes(ping.ranges_m, body, sonar, stamp_s, ranging.place_deviation_m(ping))

    def scan(
        self, ranges_m: NDArray[np.float32], stamp_s: float, deviation_m: NDArray[np.float32] | None = None
    ) -> ranging.LaserScan:
        """Return a ping's scan as it arrives, after both filters."""
        arrived_m = self._carried(self._certain(ranges_m, deviation_m))
        return self._agreeing(self._scan_of(arrived_m, self.model, stamp_s))

    def kept_m(
        self, ranges_m: NDArray[np.float32], deviation_m: NDArray[np.float32] | None = None
    ) -> NDArray[np.float32]:
        """Return the ranges (beams,) as given, with inf for echoes that the filters reject.

        For those who send ranges on, such as a topic: a map made from them contains the same echoes.
        """
        if not self._outlier_filter and (deviation_m is None or self.max_uncertainty_m is None):
            return ranges_m
        return np.where(np.isfinite(self.scan(ranges_m, 0.0, deviation_m).ranges), ranges_m, np.float32(np.inf))

    def _certain(self, ranges_m: NDArray[np.float32], deviation_m: NDArray[np.float32] | None) -> NDArray[np.float32]:
        if deviation_m is None or self.max_uncertainty_m is None:
            return ranges_m
        return ranging.reject_uncertain(ranges_m, deviation_m, self.max_uncertainty_m)

    def _agreeing(self, scan: ranging.LaserScan) -> ranging.LaserScan:
        return ranging.reject_outliers(scan) if self._outlier_filter else scan


def depth_string(model: _core.MultibeamModel, transmit: Callable[[str], str] | None = None) -> Wire:
    """Return the published wire, which encodes ranges as a depth string and decodes it again.

    transmit: simulates the channel; receives each depth string and returns the string that arrives.
    """

    def carried(ranges_m: NDArray[np.float32]) -> NDArray[np.float32]:
        text = ranging.encode_depth_string(ranges_m, model)
        return ranging.decode_depth_string(text if transmit is None else transmit(text), model)

    return carried


def received_echoes(echoes_sonar_m: NDArray[np.float64], map_from_sonar: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return echoes (n, 3) that arrived with the pose of their sonar (4, 4), in the map's frame.

    Their sender's chain has filtered them. The pose is applied in float64: the chain's float32 would move most of them
    by a last digit.
    """
    return (echoes_sonar_m @ map_from_sonar[:3, :3].T + map_from_sonar[:3, 3]).astype(np.float32)


def traced_beams(
    swath: Swath, profile: _core.SoundSpeedProfile, place: Georeference
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return where each beam of a swath from a survey file ends (n, 3) and the sonar (3,), in the world of place.

    Rays are traced from the transducer for half of the travel times through the profile, at the file's attitude. Beams
    that the file flags, or that do not arrive, are nan.
    """
    position = place.world_m(swath.latitude_deg, swath.longitude_deg, -swath.reference_depth_m)
    yaw = math.pi / 2 - swath.heading_rad + place.north_rad(position)
    level = np.array([[math.cos(yaw), math.sin(yaw), 0], [math.sin(yaw), -math.cos(yaw), 0], [0, 0, -1]])
    sonar = position + swath.transducer_m @ level
    seen = swath.is_detected & np.isfinite(swath.axes).all(axis=1)
    ends = np.full((len(seen), 3), np.nan)
    ends[seen] = _core.soundings(swath.axes[seen] @ level, swath.travel_time_s[seen], sonar, profile)
    ends[~np.isfinite(ends).all(axis=1)] = np.nan
    return ends, sonar
