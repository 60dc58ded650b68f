"""The page that a station with a token shows to a browser that has not sent it."""

from __future__ import annotations

import html
from urllib.parse import parse_qsl, urlsplit

PAGE = """<!doctype html>
<html lang="en">
  <head>
    <meta charset="utf-8" />
    <meta name="viewport" content="width=device-width, initial-scale=1" />
    <meta name="color-scheme" content="dark light" />
    <title>uwsim station: token</title>
    <link rel="icon" href="icon.svg" type="image/svg+xml" />
    <link rel="stylesheet" href="style/base.css" />
    <link rel="stylesheet" href="style/token.css" />
  </head>
  <body>
    <main class="token">
      <h1>This station asks for a token</h1>
      <p role="status">{reason}</p>
      <form method="get">
        {others}
        <label for="token">Token</label>
        <input id="token" name="token" type="password" minlength="8" maxlength="256" required autofocus
          autocomplete="current-password" />
        <button type="submit" class="primary">Open the station</button>
      </form>
      <p>
        The person who started the station chose the token, with <code>--token-file</code>, <code>UWSIM_TOKEN</code> or
        <code>--token</code>. It can also be part of the address: <code>{address}?token=TOKEN</code>.
      </p>
    </main>
  </body>
</html>
"""
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
