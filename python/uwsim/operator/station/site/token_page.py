"""The page that a station with a token shows to a browser that has not sent it."""

from __future__ import annotations

import html
from pathlib import Path
from urllib.parse import parse_qsl, urlsplit

PAGE = Path(__file__).with_suffix(".html").read_text(encoding="utf-8")
MISSING, WRONG = "The address of this page has no token.", "The token is wrong."
OTHERS_MAX = 10


def token_page(url: str, host: str) -> bytes:
    """Return the page for a request's path and query. The query's other values are kept."""
    parts = urlsplit(url)
    values = parse_qsl(parts.query, max_num_fields=OTHERS_MAX)
    others = "\n        ".join(
        f'<input type="hidden" name="{html.escape(name)}" value="{html.escape(value)}" />'
        for name, value in values
        if name != "token"
    )
    reason = WRONG if any(name == "token" for name, _ in values) else MISSING
    address = html.escape(f"{host}{parts.path}")
    return PAGE.format(reason=reason, others=others, address=address).encode()
