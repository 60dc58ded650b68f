"""The station's HTTP content: page files, scenario previews, the scene, maps and snapshots."""

from __future__ import annotations

import asyncio
import hashlib
import json
import re
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from http import HTTPStatus
from pathlib import Path
from typing import NamedTuple
from urllib.parse import parse_qs, unquote, urlsplit

from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from uwsim.operator.station.downloads import cloud, depth_tiff, map_file, sheet_file
from uwsim.operator.station.hub import Station
from uwsim.operator.station.replay_files import ghost_json, hull_glb, track_json
from uwsim.operator.station.running import Running
from uwsim.operator.station.token_page import token_page

PAGE = Path(__file__).resolve().with_name("page")
TYPES = {
    ".js": "text/javascript", ".css": "text/css", ".html": "text/html", ".svg": "image/svg+xml", ".png": "image/png",
    ".txt": "text/plain", ".json": "application/json", ".glb": "model/gltf-binary", ".tif": "image/tiff",
    ".csv": "text/csv", ".geojson": "application/geo+json",
}  # fmt: skip
OTHER_BRIDGE = re.compile(r"wss?://[A-Za-z0-9.\-]{1,253}(:\d{1,5})?|wss?://\[[0-9A-Fa-f:]{2,39}\](:\d{1,5})?")
WAITING_MAX = 40  # maximum number of requests waiting for generated content
DATA = re.compile(r"/(scene|map|snapshot|preview|exercise|notes|flight|edit)/")
PREVIEW = re.compile(r"/preview/(.{1,1000})\.png")


class File(NamedTuple):
    """The content of a response. name: the file name for a download, or "" if the browser displays the content."""

    body: bytes
    type: str
    name: str = ""


POLICY, FRAMES, NO_PAGES = "Content-Security-Policy", "frame-ancestors ", "'none'"


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
        response = await self._response(request)
        policy = response.headers[POLICY].replace(FRAMES + NO_PAGES, FRAMES + self._framed_by)
        del response.headers[POLICY]  # a mere assignment would add a second header
        response.headers[POLICY] = policy
        return response

    async def _response(self, request: Request) -> Response:
        path = unquote(urlsplit(request.path).path)
        if not DATA.match(path):
            is_page = path.endswith(("/", ".html"))
            return _asking(request) if is_page and not self._may_load(request) else _page_file(request, path)
        if request.headers.get("Sec-Fetch-Site", "") == "cross-site" and "Origin" not in request.headers:
            return _answer(request, HTTPStatus.FORBIDDEN, File(b"not for pictures of other pages\n", "text/plain"))
        if self._waiting >= WAITING_MAX:
            return _answer(request, HTTPStatus.SERVICE_UNAVAILABLE, File(b"too much is being made\n", "text/plain"))
        if not self._may_load(request):
            return _answer(request, HTTPStatus.UNAUTHORIZED, File(b"the token is missing or wrong\n", "text/plain"))
        self._waiting += 1
        try:
            file = await asyncio.get_running_loop().run_in_executor(self._pool, self._made, path)
        except LookupError:
            return _not_found(request)
        except (ValueError, RuntimeError, OSError) as error:
            return _answer(request, HTTPStatus.NOT_FOUND, File(f"{error}\n".encode(), "text/plain; charset=utf-8"))
        finally:
            self._waiting -= 1
        return _answer(request, HTTPStatus.OK, file, {"Cache-Control": "no-store"})

    def _made(self, path: str) -> File:
        """Generate the content for a path.

        Raises LookupError for an unknown path, ValueError if the content is not available now.
        """
        asked = PREVIEW.fullmatch(path)
        if asked is not None:
            return File(self._sessions.preview(asked[1]), TYPES[".png"])
        if path == "/edit/terrain.f32":
            return File(self._sessions.editor.draft.plan.heights(), "application/octet-stream")
        running = self._sessions.present()
        for pattern, make in ROUTES:
            match = re.fullmatch(pattern, path)
            if match is not None:
                body, name = make(running, *match.groups())
                suffix = Path(path).suffix
                return File(body, TYPES.get(suffix, "application/octet-stream"), name)
        raise LookupError(path)


def _named(running: Running, vehicle: str, suffix: str) -> str:
    """Return the name of a map's file, which names its world."""
    return f"{running.live.simulator.scenario.name}-{vehicle}.{suffix}"


ROUTES: list[tuple[str, Callable[..., tuple[bytes, str]]]] = [
    (r"/scene/scene\.json", lambda running: (json.dumps(running.scene.described()).encode(), "")),
    (r"/scene/terrain\.f32", lambda running: (running.scene.heights(), "")),
    (r"/scene/mesh/(\d{1,5})\.glb", lambda running, number: (running.scene.mesh(int(number)), "")),
    (r"/scene/vehicle/([^/]+)\.glb", lambda running, name: (running.scene.hull(name), "")),
    (r"/exercise/(sheet\.html|score\.json)", lambda running, name: (sheet_file(running, name), name)),
    (r"/flight/track\.json", lambda running: (track_json(running), "")),
    (r"/flight/ghost/([^/]+)\.json", lambda running, name: (ghost_json(running, name), "")),
    (r"/flight/hull/([^/]+)\.glb", lambda running, name: (hull_glb(running, name), "")),
    (r"/map/([^/]+)\.bt", lambda running, name: (map_file(running, name), _named(running, name, "bt"))),
    (
        r"/map/([^/]+)\.(ply|pcd)",
        lambda running, name, suffix: (cloud(running, name, suffix), _named(running, name, suffix)),
    ),
    (r"/map/([^/]+)\.tif", lambda running, name: (depth_tiff(running, name), _named(running, name, "tif"))),
    (r"/snapshot/(.+)\.png", lambda running, view: (running.snapshots.png(view), f"{view.replace('/', '-')}.png")),
    (r"/notes/notes\.(csv|geojson)", lambda running, suffix: (running.inspection.file(suffix), f"notes.{suffix}")),
    (r"/notes/(.+\.png)", lambda running, name: (running.inspection.picture(name), "")),
]


def _asking(request: Request) -> Response:
    """Return the page that asks for the token."""
    try:
        file = File(token_page(request.path, request.headers["Host"]), "text/html; charset=utf-8")
    except ValueError:  # too many values in the query
        return _not_found(request)
    response = _answer(request, HTTPStatus.UNAUTHORIZED, file, {"Cache-Control": "no-store"})
    policy = response.headers[POLICY].replace("form-action 'none'", "form-action 'self'")
    del response.headers[POLICY]
    response.headers[POLICY] = policy
    return response


def _page_file(request: Request, path: str) -> Response:
    if not path.isprintable():
        return _not_found(request)
    try:
        found = (PAGE / (path.lstrip("/") or "index.html")).resolve()
        if not found.is_relative_to(PAGE) or not found.is_file():
            return _not_found(request)
    except OSError:  # a name too long for a file
        return _not_found(request)
    file, tag = _read(found, found.stat().st_mtime_ns)
    headers = {"Cache-Control": "no-cache", "ETag": tag}
    if tag in [offered.strip() for offered in request.headers.get("If-None-Match", "").split(",")]:
        return _answer(request, HTTPStatus.NOT_MODIFIED, File(b"", file.type), headers)
    return _answer(request, HTTPStatus.OK, file, headers)


@lru_cache(200)
def _read(path: Path, changed_ns: int) -> tuple[File, str]:
    """Return a file and its ETag."""
    body = path.read_bytes()
    kind = TYPES.get(path.suffix, "application/octet-stream")
    kind += "; charset=utf-8" if kind.startswith("text/") else ""
    return File(body, kind), f'"{hashlib.sha256(body).hexdigest()[:20]}"'


def _not_found(request: Request) -> Response:
    return _answer(request, HTTPStatus.NOT_FOUND, File(b"there is no such page\n", "text/plain"))


def _answer(request: Request, status: HTTPStatus, file: File, extra: dict[str, str] | None = None) -> Response:
    headers = Headers({"Content-Type": file.type, "Content-Length": str(len(file.body)), "Connection": "close"})
    if file.name:
        headers["Content-Disposition"] = f'attachment; filename="{re.sub(r"[^A-Za-z0-9_.-]", "_", file.name)}"'
    for name, value in {**_safe(request), **(extra or {})}.items():
        headers[name] = value
    return Response(status, status.phrase, headers, file.body)


def _safe(request: Request) -> dict[str, str]:
    """Return headers that forbid the page to use scripts, pictures, sockets or frames of other servers."""
    host = request.headers["Host"]  # a known name or an address, as checked by the door
    sockets = [f"ws://{host}", f"wss://{host}"]
    other = parse_qs(urlsplit(request.path).query).get("rosbridge", [""])[0].rstrip("/")
    if OTHER_BRIDGE.fullmatch(other):
        sockets += [other, other.replace("ws", "http", 1)]
    policy = (
        "default-src 'none'; script-src 'self'; style-src 'self'; font-src 'self'; img-src 'self' blob: data:; "
        f"media-src 'self' blob:; worker-src 'self'; connect-src 'self' blob: {' '.join(sockets)}; "
        f"base-uri 'none'; form-action 'none'; {FRAMES}{NO_PAGES}"
    )
    origin = request.headers.get("Origin")  # the origin of an admitted page, which may read what it loads
    return {
        POLICY: policy,
        "X-Content-Type-Options": "nosniff",
        "Referrer-Policy": "no-referrer",
        "Cross-Origin-Opener-Policy": "same-origin",
        "Cross-Origin-Resource-Policy": "cross-origin" if origin else "same-origin",
        "Vary": "Origin",
        **({"Access-Control-Allow-Origin": origin} if origin else {}),
    }
