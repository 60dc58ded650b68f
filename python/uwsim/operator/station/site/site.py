"""The station's HTTP content: page files, scenario previews, the scene, maps and snapshots."""

from __future__ import annotations

import asyncio
import json
import re
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from http import HTTPStatus
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from websockets.http11 import Request, Response

from uwsim.operator.station.sessions.running import Running
from uwsim.operator.station.site.answers import (
    NO_PAGES,
    TYPES,
    File,
    answer,
    frame,
    is_foreign,
    not_found,
    page_file,
    with_policy,
)
from uwsim.operator.station.site.files import map_file
from uwsim.operator.station.site.token_page import token_page
from uwsim.operator.station.station import Station

WAITING_MAX = 40  # maximum number of requests waiting for generated content
Route = tuple[str, Callable[..., tuple[bytes, str]]]
"""A pattern of paths, and what makes the content and the name of a download, "" for none."""
DATA = re.compile(r"/(scene|map|snapshot|preview|exercise|notes|edit)/")
PREVIEW = re.compile(r"/preview/(.{1,1000})\.(png|jpg)")
EDITED = re.compile(r"/edit/([0-9a-f]{1,64})/(.{1,200})")


class Site:
    """Answers the server's HTTP requests. Slow content is generated on separate threads.

    may_load: returns whether a request may load more than the page's own files, for example because it carries the
    token. framed_by: the sources that may show the page in a frame, as in Content-Security-Policy; by default none.
    """

    def __init__(
        self, station: Station, may_load: Callable[[Request], bool] = lambda request: True, framed_by: str = NO_PAGES
    ) -> None:
        self._sessions = station.sessions
        self._framed_by = framed_by
        self._may_load = may_load
        self._waiting = 0
        self._pool = ThreadPoolExecutor(2, thread_name_prefix="uwsim-site")

    async def __call__(self, request: Request) -> Response:
        """Return the response to a GET request."""
        return frame(await self._response(request), self._framed_by)

    async def _response(self, request: Request) -> Response:
        path = unquote(urlsplit(request.path).path)
        if not DATA.match(path):
            is_page = path.endswith(("/", ".html"))
            return _asking(request) if is_page and not self._may_load(request) else page_file(request, path)
        if is_foreign(request):
            return answer(request, HTTPStatus.FORBIDDEN, File(b"not for pictures of other pages\n", "text/plain"))
        if self._waiting >= WAITING_MAX:
            return answer(request, HTTPStatus.SERVICE_UNAVAILABLE, File(b"too much is being made\n", "text/plain"))
        if not self._may_load(request):
            return answer(request, HTTPStatus.UNAUTHORIZED, File(b"the token is missing or wrong\n", "text/plain"))
        self._waiting += 1
        try:
            file = await asyncio.get_running_loop().run_in_executor(self._pool, self._made, path)
        except LookupError:
            return not_found(request)
        except (ValueError, RuntimeError, OSError) as error:
            return answer(request, HTTPStatus.NOT_FOUND, File(f"{error}\n".encode(), "text/plain; charset=utf-8"))
        finally:
            self._waiting -= 1
        return answer(request, HTTPStatus.OK, file, {"Cache-Control": "no-store"})

    def _made(self, path: str) -> File:
        """Generate the content for a path.

        Raises LookupError for an unknown path, ValueError if the content is not available now.
        """
        asked = PREVIEW.fullmatch(path)
        if asked is not None:
            return File(self._sessions.preview(asked[1], asked[2]), TYPES[f".{asked[2]}"])
        edited = EDITED.fullmatch(path)
        if edited is not None:  # for those who may edit alone
            self._sessions.editor.require(edited[1])
            return _routed(OF_EDITOR, self._sessions.editor, edited[2])
        return _routed(ROUTES, self._sessions.present(), path)


def _routed(routes: list[Route], of: Any, path: str) -> File:
    """Return what a route makes of something for a path. Raises LookupError if none has it."""
    for pattern, make in routes:
        match = re.fullmatch(pattern, path)
        if match is not None:
            body, name = make(of, *match.groups())
            return File(body, TYPES.get(Path(path).suffix, "application/octet-stream"), name)
    raise LookupError(path)


OF_EDITOR: list[Route] = [
    (r"terrain\.f32", lambda editor: (editor.draft.plan.heights(), "")),
    (r"(\d{1,9})/(\d{1,5})\.glb", lambda editor, plan, number: (editor.solid(int(plan), int(number)), "")),
    (r"mesh/([^?]{1,100})\.png", lambda editor, name: (editor.meshes.still(name), "")),
]
ROUTES: list[Route] = [
    (r"/scene/scene\.json", lambda running: (_scene(running), "")),
    (r"/scene/object/(\d{1,5})\.glb", lambda running, number: (_object(running, int(number)), "")),
    (r"/scene/terrain\.f32", lambda running: (running.scene.heights(), "")),
    (r"/scene/chart\.f32", lambda running: (running.scene.chart(), "")),
    (r"/scene/mesh/(\d{1,5})\.glb", lambda running, number: (running.scene.mesh(int(number)), "")),
    (r"/scene/vehicle/([^/]+)\.glb", lambda running, name: (running.scene.hull(name), "")),
    (r"/exercise/(sheet\.html|score\.json)", lambda running, name: (running.flown.sheet(name), name)),
    (r"/map/([^/]+)\.(bt|ply|pcd|tif)", map_file),
    (r"/snapshot/(.+)\.png", lambda running, view: (running.snapshots.png(view), f"{view.replace('/', '-')}.png")),
    (r"/notes/notes\.(csv|geojson)", lambda running, suffix: (running.inspection.file(suffix), f"notes.{suffix}")),
    (r"/notes/(.+\.png)", lambda running, name: (running.inspection.picture(name), "")),
]


def _scene(running: Running) -> bytes:
    objects = [] if running.objects is None else running.objects.described()
    return json.dumps({**running.scene.described(), "objects": objects}).encode()


def _object(running: Running, number: int) -> bytes:
    if running.objects is None:
        raise ValueError("where loose bodies are, is not shown")
    return running.objects.surface(number)


def _asking(request: Request) -> Response:
    """Return the page that asks for the token."""
    try:
        file = File(token_page(request.path, request.headers["Host"]), "text/html; charset=utf-8")
    except ValueError:  # too many values in the query
        return not_found(request)
    response = answer(request, HTTPStatus.UNAUTHORIZED, file, {"Cache-Control": "no-store"})
    return with_policy(response, "form-action 'none'", "form-action 'self'")
