"""Access control for uwsim's servers: browser origins, tokens, client limits, encryption."""

from __future__ import annotations

import asyncio
import hmac
import ipaddress
import logging
import re
import ssl
import warnings
from collections.abc import Iterable
from http import HTTPStatus
from pathlib import Path
from typing import Any, Protocol
from urllib.parse import parse_qs, urlsplit

from websockets.http11 import Request

from uwsim.bridges.rare_log import RareLog

LOOPBACK_PAGE = re.compile(r"https?://(localhost|127\.0\.0\.1|\[::1\])(:\d+)?", re.IGNORECASE)
ORIGIN = re.compile(r"([A-Za-z][A-Za-z0-9+.-]*://[^/?#@\s]*)/?")
REFUSALS_LOGGED = 20
WRONG_S, WRONG_MAX_S = 1.0, 5.0

logger = logging.getLogger("uwsim.bridges.admission")

Refusal = tuple[HTTPStatus, str]


class Fields(Protocol):
    """The header fields of a request."""

    def get_all(self, name: str, /) -> list[Any] | None:
        """Return all values of a field, or None or [] if it is absent."""


class Door:
    """Decides which browser pages may connect, and under which host names.

    pages: additional origins, such as "https://station.example:8080". Desktop programs built from web pages have
    origins such as "app://station" or "file://" (also the origin of every page that a browser opens from a file). host:
    the address on which the server listens. Programs other than browsers send no Origin and may connect. A page in a
    browser must come from this machine, from this server or from one of `pages`, and the host name in the request must
    be a known name or an IP address. Otherwise a foreign page whose host name resolves to this machine would appear to
    be the server's own ("DNS rebinding"). Raises ValueError.
    """

    def __init__(self, pages: Iterable[str], host: str) -> None:
        self._pages = set()
        self._names = {"localhost", host.lower()}
        for page in pages:
            origin, parts = ORIGIN.fullmatch(page), urlsplit(page)
            is_web = parts.scheme in ("http", "https")
            if origin is None or (is_web and not parts.hostname):
                raise ValueError(f"origin = '{page}': must look like 'https://station.example:8080'")
            self._pages.add(origin[1].lower())
            if is_web and parts.hostname:
                self._names.add(parts.hostname)

    def refusal(self, fields: Fields, *, names_matter: bool) -> Refusal | None:
        """Return the reason to refuse a request, or None.

        names_matter: whether to check Host even without an Origin.
        """
        origins, hosts = fields.get_all("Origin") or [], fields.get_all("Host") or []
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
    """Raise ValueError if a token has the wrong length or cannot be sent in a URL."""
    if token is not None and not re.fullmatch(r"[A-Za-z0-9_.~-]{8,256}", token):
        raise ValueError("token: must have 8 to 256 characters of A-Z a-z 0-9 _ . ~ -")


def has_token(request: Request, token: str) -> bool:
    """Return whether a request carries the token: `?token=...` in the URL, or `Authorization: Bearer ...`."""
    return any(hmac.compare_digest(text.encode(), token.encode()) for text in offered_tokens(request))


def offered_tokens(request: Request) -> list[str]:
    """Return the tokens that a request carries."""
    offered = parse_qs(urlsplit(request.path).query).get("token", [])
    bearer = request.headers.get_all("Authorization")
    return offered + [value.removeprefix("Bearer ") for value in bearer if value.startswith("Bearer ")]


class Admission:
    """One server's rules: pages, token and whether it has places for clients. Raises ValueError."""

    def __init__(self, host: str, *, pages: Iterable[str] = (), token: str | None = None, places: int) -> None:
        check_token(token)
        self.door = Door(pages, host)
        self.token = token
        self._places = places
        self._logged: set[str] = set()
        self._rare = RareLog(logger)
        self._waiting = 0  # wrong tokens that are not yet answered

    async def delay_wrong_token(self, request: Request, address: str) -> None:
        """Log a wrong token, and wait: WRONG_S after the answer to the one before, so that guessing takes long."""
        if self.token is None or not offered_tokens(request) or has_token(request, self.token):
            return
        self._rare.warning(f"a wrong token came from {address}")
        self._waiting += 1
        try:
            await asyncio.sleep(min(WRONG_S * self._waiting, WRONG_MAX_S))
        finally:
            self._waiting -= 1

    def refusal(self, request: Request, *, is_client: bool) -> Refusal | None:
        """Return the reason to refuse a request, or None. Refusals are logged.

        is_client: False for a request for a page or file, for which the site checks the token.
        """
        reason = self.door.refusal(request.headers, names_matter=not is_socket(request))
        if reason is None and is_client:
            if not self._places:
                reason = HTTPStatus.SERVICE_UNAVAILABLE, "only pages are served here\n"
            elif self.token is not None and not has_token(request, self.token):
                reason = (
                    HTTPStatus.UNAUTHORIZED,
                    "the token is missing or wrong: connect to ws://HOST:PORT/?token=TOKEN\n",
                )
        if reason is not None:
            self._log(reason[1].rstrip())
        return reason

    def _log(self, why: str) -> None:
        """Log a refusal, since browsers do not show the reason, but only once, so that no page can fill the log."""
        if why not in self._logged and len(self._logged) < REFUSALS_LOGGED:
            self._logged.add(why)
            logger.warning("a client was refused: %s", why.encode("ascii", "backslashreplace").decode())


def is_socket(request: Request) -> bool:
    """Return whether a request opens a WebSocket."""
    return "websocket" in request.headers.get("Upgrade", "").lower()


def tls_context(certfile: Path | str | None, keyfile: Path | str | None) -> ssl.SSLContext | None:
    """Return a server's TLS context, or None without a certificate. Raises ValueError or OSError."""
    if certfile is None:
        if keyfile is not None:
            raise ValueError("keyfile: needs certfile, too")
        return None
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    try:
        context.load_cert_chain(certfile, keyfile)
    except ssl.SSLError as error:
        raise ValueError(f"certfile '{certfile}': contains no PEM certificate with its key ({error.reason})") from None
    except FileNotFoundError:
        missing = next(p for p in (certfile, keyfile) if p is not None and not Path(p).exists())
        raise FileNotFoundError(f"'{missing}': no such file") from None
    return context


def warn_beyond_loopback(host: str, token: str | None, tls: bool) -> None:
    """Warn about the risks of listening on an address other than loopback."""
    try:
        is_local = host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        is_local = False
    if is_local:
        return
    gaps = [] if token else ["anyone who reaches this machine can drive the vehicle (a token would prevent that)"]
    if not tls:
        gaps.append("everything is sent in plain text (a certificate would prevent that)")
    warnings.warn(f"listening on {host}, beyond this machine" + "".join(f"; {gap}" for gap in gaps), stacklevel=4)
