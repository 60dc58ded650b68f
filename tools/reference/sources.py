"""The sources of the models: the citations in the core's comments, with the code that uses them."""

import re
from pathlib import Path

from tools.reference.markdown import plain

CORE = Path(__file__).resolve().parents[2] / "cpp" / "uwsim"
CITES = re.compile(r"\b(?:18|19|20)\d\d\b")
HEAD = """# Sources

Every model of the core whose comment cites a source, with equations and ranges of validity; the comments also state
which values are assumed and which sources were not consulted. The files in `assets` cite the sources of the values
of vehicles, thrusters, sensors and sonars.

"""


def sources_page() -> str:
    """Return the page, with a section for each folder and an entry for each comment."""
    parts = []
    for folder in sorted(path for path in CORE.iterdir() if path.is_dir()):
        entries = [entry for file in sorted(folder.rglob("*.*")) for entry in _entries(file)]
        if entries:
            parts.append(f"## {folder.name}\n\n" + "\n".join(entries))
    return HEAD + "\n".join(parts)


def _entries(file: Path) -> list[str]:
    """Return the comments that cite a source, with the file's name in front of the first."""
    if file.suffix not in (".h", ".cpp"):
        return []
    comments = re.findall(r"(?:^[ \t]*///(?!<).*\n)+", file.read_text(), flags=re.MULTILINE)
    texts = [re.sub(r"^[ \t]*///[ ]?", "", comment, flags=re.MULTILINE) for comment in comments]
    cited = [_markdown(text) for text in texts if CITES.search(text)]
    name = f"**`{file.relative_to(CORE.parents[1])}`**"
    return [f"{name}\n\n" + "\n\n".join(cited) + "\n"] if cited else []


def _markdown(text: str) -> str:
    """Return a comment as Markdown; indented lines are equations and kept unchanged."""
    blocks: list[str] = []
    for equation, lines in _runs(text.splitlines()):
        if equation:
            blocks.append("```text\n" + "\n".join(line.strip() for line in lines) + "\n```")
        elif words := plain(" ".join(lines)).replace("\\`", "`"):
            blocks.append(words)
    return "\n\n".join(blocks)


def _runs(lines: list[str]) -> list[tuple[bool, list[str]]]:
    runs: list[tuple[bool, list[str]]] = []
    for line in lines:
        equation = line.startswith("  ")
        if not runs or runs[-1][0] != equation:
            runs.append((equation, []))
        runs[-1][1].append(line)
    return runs
