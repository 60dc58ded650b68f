"""HTML pages in the common style, with embedded pictures."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

HERE = Path(__file__).parent


def filled_page(template: Path, **values: Any) -> str:
    """Return a page rendered from a template, which extends base_page.html.j2 and may use the macros in `parts`.

    values: those of the template; warnings and tiles, pairs of a value and its name, come first in each page.
    """
    environment = Environment(
        loader=FileSystemLoader([template.parent, HERE]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    parts = environment.get_template("page_parts.html.j2").module
    style = Markup((HERE / "report_style.css").read_text(encoding="utf-8"))
    common = {"style": style, "parts": parts, "warnings": (), "tiles": ()}
    return environment.get_template(template.name).render({**common, **values})


def data_uri(path: Path) -> str:
    """Return a PNG as a data URI."""
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode("ascii")
