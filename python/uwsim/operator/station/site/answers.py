"""Answers to HTTP requests for a page's own files and for generated content, with headers that confine the page."""

from __future__ import annotations

import hashlib
import re
from functools import cache, lru_cache
from http import HTTPStatus
from pathlib import Path
from typing import NamedTuple

from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from uwsim.operator.station.wire_js import messages_js

PAGE = Path(__file__).resolve().parents[1] / "page"
MADE = PAGE / "wire/messages.js"  # as it is called: no such file is carried
TYPES = {
    ".js": "text/javascript", ".css": "text/css", ".html": "text/html", ".svg": "image/svg+xml", ".png": "image/png",
    ".jpg": "image/jpeg", ".txt": "text/plain", ".json": "application/json", ".glb": "model/gltf-binary",
    ".tif": "image/tiff", ".csv": "text/csv", ".geojson": "application/geo+json",
    ".zip": "application/zip", ".webp": "image/webp",
}  # fmt: skip
POLICY, FRAMES, NO_PAGES = "Content-Security-Policy", "frame-ancestors ", "'none'"


class File(NamedTuple):
    """The content of a response. name: the file name for a download, or "" if the browser displays the content."""

    body: bytes
    type: str
    name: str = ""


def frame(response: Response, framed_by: str) -> Response:
    """Let the pages of these sources, as in Content-Security-Policy, show a response in a frame."""
    return with_policy(response, FRAMES + NO_PAGES, FRAMES + framed_by)


def with_policy(response: Response, old: str, new: str) -> Response:
    """Replace a part of a response's Content-Security-Policy."""
    policy = response.headers[POLICY].replace(old, new)
    del response.headers[POLICY]  # a mere assignment would add a second header
    response.headers[POLICY] = policy
    return response


def is_foreign(request: Request) -> bool:
    """Return whether another site's page embeds the content, such as in a picture, without saying its origin."""
    return request.headers.get("Sec-Fetch-Site", "") == "cross-site" and "Origin" not in request.headers


def page_file(request: Request, path: str) -> Response:
    """Return one of the pages' files."""
    if not path.isprintable():
        return not_found(request)
    try:
        found = (PAGE / (path.lstrip("/") or "index.html")).resolve()
        if found == MADE:
            file, tag = _made()
        elif found.is_relative_to(PAGE) and found.is_file():
            file, tag = _read(found, found.stat().st_mtime_ns)
        else:
            return not_found(request)
    except OSError:  # a name too long for a file
        return not_found(request)
    headers = {"Cache-Control": "no-cache", "ETag": tag}
    if tag in [offered.strip() for offered in request.headers.get("If-None-Match", "").split(",")]:
        return answer(request, HTTPStatus.NOT_MODIFIED, File(b"", file.type), headers)
    return answer(request, HTTPStatus.OK, file, headers)


@lru_cache(200)
def _read(path: Path, changed_ns: int) -> tuple[File, str]:
    return _tagged(path.read_bytes(), path)


@cache
def _made() -> tuple[File, str]:
    return _tagged(messages_js().encode(), MADE)


def _tagged(body: bytes, path: Path) -> tuple[File, str]:
    """Return a file and its ETag."""
    kind = TYPES.get(path.suffix, "application/octet-stream")
    kind += "; charset=utf-8" if kind.startswith("text/") else ""
    return File(body, kind), f'"{hashlib.sha256(body).hexdigest()[:20]}"'


def not_found(request: Request) -> Response:
    """Return the answer for an unknown path."""
    return answer(request, HTTPStatus.NOT_FOUND, File(b"there is no such page\n", "text/plain"))


def answer(request: Request, status: HTTPStatus, file: File, extra: dict[str, str] | None = None) -> Response:
    """Return a response with this content and further headers."""
    headers = Headers({"Content-Type": file.type, "Content-Length": str(len(file.body)), "Connection": "close"})
    if file.name:
        headers["Content-Disposition"] = f'attachment; filename="{re.sub(r"[^A-Za-z0-9_.-]", "_", file.name)}"'
    for name, value in {**_safe(request), **(extra or {})}.items():
        headers[name] = value
    return Response(status, status.phrase, headers, file.body)


def _safe(request: Request) -> dict[str, str]:
    """Return headers that forbid the page to use scripts, pictures, sockets or frames of other servers."""
    host = request.headers["Host"]  # a known name or an address, as checked by the door
    policy = (
        "default-src 'none'; script-src 'self'; style-src 'self'; font-src 'self'; img-src 'self' blob: data:; "
        f"media-src 'self' blob:; worker-src 'self'; connect-src 'self' blob: ws://{host} wss://{host}; "
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
