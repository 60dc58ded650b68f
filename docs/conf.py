"""The documentation's site: `tools/docs` builds it into build/site, warnings are errors."""

import re
from importlib.metadata import version as installed_version
from pathlib import Path
from typing import Any

project = "uwsim"
author = "the uwsim authors"
version = release = installed_version("uwsim")

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx_copybutton"]
exclude_patterns = ["_static", "paper"]
html_static_path, html_css_files = ["_static"], ["front.css"]
myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 3
nb_execution_mode = "cache"  # notebooks are executed when they, or what is beside them, have changed
nb_execution_cache_path = str(Path(__file__).parents[1] / "build" / "notebooks")
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 300  # [s] of a cell, on a busy machine
myst_links_external_new_tab = True

suppress_warnings = ["ref.python"]  # a type's name in a signature that two modules have, such as Vehicle
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_default_options = {"members": True, "undoc-members": False}
autodoc_preserve_defaults = True

html_theme = "furo"
html_title = f"uwsim {release}"
html_show_sphinx = False
copybutton_prompt_text = r"\$ |>>> "
copybutton_prompt_is_regexp = True
copybutton_exclude = ".linenos, .gp"


def _plain_docstring(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Our docstrings are plain English, no markup: stars and bars are what they are, code stands in backticks."""
    text = "\n".join(lines)
    text = re.sub(r"([*|\\])", r"\\\1", text)
    text = re.sub(r"(?<!`)`([^`\n]+)`(?!`)", r"``\1``", text)
    text = re.sub(r"\n\n(?=    \S)", "\n\n::\n\n", text, count=1)  # an example, indented
    lines[:] = text.split("\n")


def setup(app: Any) -> None:
    """Sphinx calls this."""
    app.connect("autodoc-process-docstring", _plain_docstring)
