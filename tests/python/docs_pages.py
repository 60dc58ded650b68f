"""The pages and images of the documentation, except generated ones."""

import re
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


def blocks(page: Path, language: str) -> list[str]:
    """Return a page's blocks of code in a language."""
    return re.findall(rf"^```{language}\n(.*?)^```$", page.read_text(), flags=re.DOTALL | re.MULTILINE)
