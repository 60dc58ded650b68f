"""Who may connect: the browser's origin, the token, the number of clients, and where the server listens."""

from __future__ import annotations

import hmac
import ipaddress
import re
import ssl
import warnings
from collections.abc import Iterable
from http import HTTPStatus
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

from websockets.http11 import Request

LOOPBACK_PAGE = re.compile(r"https?://(localhost|127\.0\.0\.1|\[::1\])(:\d+)?", re.IGNORECASE)


def allowed_origins(pages: Iterable[str]) -> list[str | re.Pattern[str] | None]:
    """Return who may connect: programs (which send no Origin), pages of this machine, and `pages`. Raises ValueError.

    pages: such as "https://station.example:8080".
    """
    for page in pages:
        parts = urlsplit(page)
        if parts.scheme not in ("http", "https") or not parts.netloc or parts.path not in ("", "/"):
            raise ValueError(f"origin = '{page}': must be such as 'https://station.example:8080'")
    return [None, LOOPBACK_PAGE, *(page.rstrip("/") for page in pages)]


def check_token(token: str | None) -> None:
    """Raise ValueError for a token that is too short, or cannot be sent in a URL."""
    if token is not None and not re.fullmatch(r"[A-Za-z0-9_.~-]{8,256}", token):
        raise ValueError("token: must have 8 to 256 characters of A-Z a-z 0-9 _ . ~ -")


def has_token(request: Request, token: str) -> bool:
    """Return whether a client knows the token: `?token=...` in the URL, or `Authorization: Bearer ...`."""
    offered = parse_qs(urlsplit(request.path).query).get("token", [])
    bearer = request.headers.get_all("Authorization")
    offered += [value.removeprefix("Bearer ") for value in bearer if value.startswith("Bearer ")]
    return any(hmac.compare_digest(text.encode(), token.encode()) for text in offered)


def refusal(request: Request, *, clients: int, limit: int, token: str | None) -> tuple[HTTPStatus, str] | None:
    """Return why a client may not connect, or None."""
    if clients >= limit:
        return HTTPStatus.SERVICE_UNAVAILABLE, f"{limit} clients are connected, which is the most\n"
    if token is not None and not has_token(request, token):
        return HTTPStatus.UNAUTHORIZED, "the token is missing or wrong: connect to ws://HOST:PORT/?token=TOKEN\n"
    return None


def tls_context(certfile: Path | str | None, keyfile: Path | str | None) -> ssl.SSLContext | None:
    """Return the server's side of TLS; None without a certificate. Raises ValueError, OSError."""
    if certfile is None:
        if keyfile is not None:
            raise ValueError("keyfile: give the certfile, too")
        return None
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    try:
        context.load_cert_chain(certfile, keyfile)
    except ssl.SSLError as error:
        raise ValueError(f"certfile '{certfile}': no certificate with its key in PEM ({error.reason})") from None
    except FileNotFoundError:
        missing = next(p for p in (certfile, keyfile) if p is not None and not Path(p).exists())
        raise FileNotFoundError(f"'{missing}': no such file") from None
    return context


def warn_beyond_loopback(host: str, token: str | None, tls: bool) -> None:
    """Say in words what it means to listen on more than this machine's own address."""
    try:
        is_local = host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        is_local = False
    if is_local:
        return
    gaps = [] if token else ["anyone who reaches this machine can drive the vehicle (a token would prevent that)"]
    if not tls:
        gaps.append("everything is sent in plain text (a certificate would prevent that)")
    warnings.warn(f"listening on {host}, beyond this machine" + "".join(f"; {gap}" for gap in gaps), stacklevel=3)
