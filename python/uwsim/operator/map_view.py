"""MapViewer: a page that shows a map's occupied voxels in 3D."""

from __future__ import annotations

import json
import logging
from http import HTTPStatus
from typing import Any
from urllib.parse import unquote, urlsplit

import cbor2
import numpy as np
from websockets.http11 import Request, Response

from uwsim.bridges.doors.conversation import Rates, Share
from uwsim.bridges.doors.listener import Entrance, Listener
from uwsim.channels.families.map_changes import Part, in_blocks
from uwsim.channels.ros import build
from uwsim.channels.ros.messages import to_plain
from uwsim.channels.ros.own_types import MAP_CHANGES
from uwsim.mapping import OccupancyChanges, OccupancyMap
from uwsim.mapping.info import occupied_cubes
from uwsim.mapping.voxel_keys import voxel_keys
from uwsim.operator.framed import LOCAL_PAGES, Framed
from uwsim.operator.station.site.answers import TYPES, File, answer, frame, is_foreign, not_found, page_file

VOXELS_MAX = 4_000_000
"""Maximum number of voxels on the page; a larger map is shown in cubes of 8, 64, ... voxels."""
BLOCK_BITS = 4  # a block of a MapChanges message has 16 cubes along an edge
COLOURED = 0.01, 0.99  # the quantiles of the height between which colours change


class MapViewer(Framed):
    """The page of a map; see `uwsim.view`. The map is copied: its later changes are not shown.

    name: the page's title. port: 0 chooses a free one. voxels_max: how many cubes the page gets at most. Raises
    ValueError if no voxel is occupied, OSError if it cannot listen.
    """

    def __init__(
        self, occupancy: OccupancyMap, name: str = "map", *, port: int = 0, voxels_max: int = VOXELS_MAX
    ) -> None:
        self._files = _files(occupancy, name, voxels_max)
        self._listener: Listener[Any] = Listener(
            Entrance(port=port), logging.getLogger("uwsim.map"), places=0, rates=Rates(1, 1), share=Share(0.1),
            open_session=_no_session, site=self._answer,
        )  # fmt: skip
        self._listener.start()
        self.url = self._listener.url.replace("ws", "http", 1) + "/"

    def close(self) -> None:
        """Close the page's server."""
        self._listener.stop()

    def __repr__(self) -> str:
        return f"<MapViewer at {self.url}>"

    async def _answer(self, request: Request) -> Response:
        path = unquote(urlsplit(request.path).path)
        if path == "/":
            return frame(page_file(request, "/map.html"), LOCAL_PAGES)
        if path not in self._files:
            return page_file(request, path)
        return not_found(request) if is_foreign(request) else answer(request, HTTPStatus.OK, self._files[path])


def _no_session(*_: object) -> Any:
    raise RuntimeError("a map's page has no sockets")  # its server has no places for them


def _files(occupancy: OccupancyMap, name: str, voxels_max: int) -> dict[str, File]:
    """Return what the page loads: the map's description, and its occupied cubes as a MapChanges message."""
    centres, edge_m = occupied_cubes(occupancy, name, voxels_max)
    keys = voxel_keys(centres - occupancy.origin_world_m, edge_m).astype(np.int16)
    keys = keys[np.lexsort((keys >> BLOCK_BITS).T)]
    blocks, counts, packed = in_blocks(OccupancyChanges(keys, np.ones(len(keys), np.bool_)))
    part = Part(0, True, edge_m, blocks.ravel(), counts, packed)
    message = build.message(MAP_CHANGES, header=build.header(0, "map"), **part._asdict())
    described = {
        "name": name,
        "voxel_m": occupancy.resolution_m,
        "cube_m": edge_m,
        "occupied": occupancy.count().occupied,
        "low_m": (keys.min(axis=0) * edge_m).tolist(),
        "high_m": ((keys.max(axis=0) + 1.0) * edge_m).tolist(),
        "coloured_m": np.quantile((keys[:, 2] + 0.5) * edge_m, COLOURED).tolist(),
    }
    return {
        "/map/map.json": File(json.dumps(described).encode(), TYPES[".json"]),
        "/map/voxels.cbor": File(cbor2.dumps(to_plain(message, form="cbor")), "application/cbor"),
    }
