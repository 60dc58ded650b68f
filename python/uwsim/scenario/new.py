"""Creates scenario files for editing, from the commented template or a packaged scenario."""

from __future__ import annotations

import re
from pathlib import Path

from uwsim.base.atomic_file import write_atomically
from uwsim.base.own_files import mark
from uwsim.scenario.read.assets import YAML_SUFFIXES, assets_folder, find_yaml
from uwsim.scenario.schema import schema_file
from uwsim.scenario.spec.fields import NAME


def new_scenario(name: str, out: Path | None = None, like: str | None = None, overwrite: bool = False) -> Path:
    """Write NAME.yaml into the working folder, or to `out`, and return its path.

    like: a packaged scenario to use as a starting point, instead of the template. The first line of the file refers to
    the schema, so that editors can complete and check keys. Raises ValueError for a bad name, FileExistsError, and
    ScenarioError for an unknown `like`.
    """
    if not NAME.fullmatch(name):
        raise ValueError(f"name '{name}': must be a letter followed by at most 39 letters, digits, '-' or '_'")
    path = Path(f"{name}.yaml") if out is None else out
    if path.suffix not in YAML_SUFFIXES:
        raise ValueError(f"--out {path}: must end in {' or '.join(YAML_SUFFIXES)}")
    source = assets_folder() / "templates" / "scenario.yaml" if like is None else find_yaml(like, "scenarios")
    text = source.read_text(encoding="utf-8")
    if like is None:
        text = text.replace("@NAME@", name).replace("@FILE@", str(path))
    else:
        text = re.sub(r"^name:.*$", f"name: {name}", text, count=1, flags=re.MULTILINE)
    content = f"# yaml-language-server: $schema={schema_file('scenario').as_uri()}\n{text}".encode()
    if overwrite:
        write_atomically(path, content, replaces_any=True)
    else:
        with path.open("xb") as file:
            file.write(content)
        mark(path)
    return path
