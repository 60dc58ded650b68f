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


class Door:
    """Which pages of browsers may connect, and under which names of this machine.

    pages: those besides this machine's own, such as "https://station.example:8080"; host: where the server listens.
    Programs send no Origin: they may connect. A browser's page must be of this machine, of this server itself or one of
    `pages`; and the name by which it calls the server must be known, or be an address: else a page of somebody else
    whose name is made to point here would be taken for the server's own ("DNS rebinding"). Raises ValueError.
    """

    def __init__(self, pages: Iterable[str], host: str) -> None:
        self._pages = set()
        self._names = {"localhost", host.lower()}
        for page in pages:
            parts = urlsplit(page)
            if parts.scheme not in ("http", "https") or not parts.hostname or parts.path not in ("", "/"):
                raise ValueError(f"origin = '{page}': must be such as 'https://station.example:8080'")
            self._pages.add(page.rstrip("/").lower())
            self._names.add(parts.hostname)

    def refusal(self, request: Request, *, names_matter: bool) -> tuple[HTTPStatus, str] | None:
        """Return why a request is refused, or None. names_matter: whether the Host must be known without an Origin."""
        origins, hosts = request.headers.get_all("Origin"), request.headers.get_all("Host")
        if len(origins) > 1 or len(hosts) != 1:
            return HTTPStatus.BAD_REQUEST, "one Host and at most one Origin are expected\n"
        if (origins or names_matter) and not self._is_known(hosts[0]):
            return HTTPStatus.FORBIDDEN, f"the name '{hosts[0][:100]}' is not this server's (--page allows another)\n"
        if origins and not self._may_come_from(origins[0].lower(), hosts[0].lower()):
            return HTTPStatus.FORBIDDEN, f"pages of '{origins[0][:100]}' may not connect (--page allows one)\n"
        return None

    def _may_come_from(self, origin: str, host: str) -> bool:
        own = origin in (f"http://{host}", f"https://{host}")
        return own or origin in self._pages or LOOPBACK_PAGE.fullmatch(origin) is not None

    def _is_known(self, host: str) -> bool:
        try:
            name = urlsplit(f"//{host}").hostname or ""
            if name in self._names:
                return True
            ipaddress.ip_address(name)
        except ValueError:
            return False
        return True


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
