"""Keep the counts of words that uwsim's prose avoids below their ceilings: python -m tools.words [--update].

Ceilings are counts by word and area in words.json. They may only fall; --update lowers them to the current counts.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[1]
CEILINGS = Path(__file__).with_name("words.json")
AREAS = ("cpp", "python", "docs", "tests", "tools")
SUFFIXES = {".h", ".cpp", ".py", ".js", ".html", ".j2", ".md", ".ipynb", ""}
LEFT_OUT = re.compile(r"/vendor/|^tests/fuzz/found/|^tests/python/data/|^tools/words\.|test_words\.py$")
SLACK = 5
"""How far a count may lie below its ceiling before the ceiling must be lowered."""
WORDS = {
    **{word: rf"\b{word}\b" for word in ("says", "tells", "told", "hears", "anew", "nobody", "somebody", "whoever")},
    "what is no": r"\bwhat is no\b",
    "docstring What/Of/Who/Whether": r'(?:"""|///? )(?:What|Of|Who|Whoever|Whose|Whether)\b',
}
PATTERNS = {
    word: re.compile(pattern, 0 if word.startswith("docstring") else re.IGNORECASE) for word, pattern in WORDS.items()
}

Table = dict[str, dict[str, int]]


def main() -> int:
    """Return 1 if a count is above its ceiling, or so far below it that the ceiling must be lowered."""
    counts, ceilings = count(), json.loads(CEILINGS.read_text())
    if "--update" in sys.argv[1:]:
        ceilings = lowered(counts, ceilings)
        rows = (f" {json.dumps(word)}: {json.dumps(row)}" for word, row in ceilings.items())
        CEILINGS.write_text("{\n" + ",\n".join(rows) + "\n}\n")
    wrong = problems(counts, ceilings)
    print("\n".join(wrong), end="\n" if wrong else "")
    return 1 if wrong else 0


def count() -> Table:
    """Return how often each word occurs in each area."""
    table: Table = {word: dict.fromkeys(AREAS, 0) for word in WORDS}
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    for name in set(listed.stdout.splitlines()):
        area, path = area_of(name), ROOT / name
        if area and path.is_file():
            for word, found in count_in(path.read_text()).items():
                table[word][area] += found
    return table


def area_of(name: str) -> str | None:
    """Return the area in which a path counts, if any; the Markdown files at the root belong to the docs."""
    first, _, rest = name.partition("/")
    if Path(name).suffix not in SUFFIXES or LEFT_OUT.search(name):
        return None
    if not rest:
        return "docs" if name.endswith(".md") else None
    return first if first in AREAS else None


def count_in(text: str) -> Counter[str]:
    """Return how often each word occurs in a text."""
    return Counter({word: len(pattern.findall(text)) for word, pattern in PATTERNS.items()})


def lowered(counts: Table, ceilings: Table) -> Table:
    """Return the ceilings, each lowered to its count; a word without ceilings gets its counts as ceilings."""
    return {
        word: {area: min(number, ceilings.get(word, {}).get(area, number)) for area, number in row.items()}
        for word, row in counts.items()
    }


def problems(counts: Table, ceilings: Table) -> list[str]:
    """Return a line for each count that is above its ceiling or too far below it."""
    lines = []
    for word, row in counts.items():
        for area, number in row.items():
            ceiling = ceilings.get(word, {}).get(area, 0)
            if number > ceiling:
                lines.append(f"{area}: '{word}' {number} times, at most {ceiling} allowed: write it in plain words")
            elif number < ceiling - SLACK:
                lines.append(f"{area}: '{word}' only {number} times: lower the ceiling: python -m tools.words --update")
    return lines


if __name__ == "__main__":
    sys.exit(main())
