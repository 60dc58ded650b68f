"""The pages and images of the documentation, except generated ones."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
_WRITTEN = [path for path in DOCS.rglob("*.*") if "reference" not in path.relative_to(DOCS).parts]
PAGES = sorted(path for path in _WRITTEN if path.suffix == ".md")
PICTURES = sorted(path for path in _WRITTEN if path.suffix in (".png", ".jpg", ".webp"))


def page_named(name: str) -> Path:
    """Return the path of a page given its name, such as "link"."""
    (found,) = (path for path in PAGES if path.stem == name)
    return found
