"""`uwsim --cite`: a BibTeX entry of CITATION.cff, with the commit and the build that are running."""

from __future__ import annotations

import subprocess
from pathlib import Path

CITATION = "CITATION.cff"


def bibtex() -> str:
    """Return the entry. Raises OSError or ValueError if CITATION.cff is missing or damaged."""
    from uwsim.base.texts.yaml_document import read_yaml
    from uwsim.scenario.fingerprint import build_fingerprint
    from uwsim.scenario.read.assets import assets_folder

    packaged = assets_folder() / CITATION
    path = packaged if packaged.exists() else assets_folder().parent / CITATION  # the latter in a clone
    cited = read_yaml(path).values
    commit = cited.get("commit") or _commit_of(path.parent)  # written where a wheel is built
    values = {
        "title": cited["title"],
        "author": " and ".join(f"{{{author['name']}}}" for author in cited["authors"]),  # no first and last names
        "year": str(cited["date-released"])[:4],
        "version": cited["version"],
        "url": cited.get("repository-code"),
        "note": ", ".join([*([f"commit {commit}"] if commit else []), f"build {build_fingerprint()}"]),
    }
    lines = [f"  {key} = {{{value}}},\n" for key, value in values.items() if value]
    return f"@software{{uwsim-{cited['version']},\n{''.join(lines)}}}"


def _commit_of(folder: Path) -> str:
    """Return the commit of a clone, with -dirty if its files differ from it; empty without Git."""
    if not (folder / ".git").exists():
        return ""
    command = ["git", "-C", str(folder), "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True, timeout=60).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return ""
