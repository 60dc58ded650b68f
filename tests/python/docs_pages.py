"""The documentation's pages, in whichever folder of docs/ they are; those that the program writes are left out."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(path for path in DOCS.rglob("*.md") if "reference" not in path.relative_to(DOCS).parts)


def page_named(name: str) -> Path:
    """Return the page of a name, such as "link"."""
    (found,) = (path for path in PAGES if path.stem == name)
    return found
