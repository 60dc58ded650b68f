"""Keep lines, long files, imports, test seconds and some words within budget.toml: python -m tools.budget [--update].

The number of all lines only falls: who adds a feature names, in the same push, what leaves for it. --update lowers each
number to what stands. --history: hold each commit since SINCE against its own numbers.

Rooms are the folders of cpp/uwsim, python/uwsim and of the tests beside them, and the other folders. Seconds are
processor time of the last whole run of the Python tests (tests/python/processor_seconds.py).
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path

from tools.module_graph import ROOT, imports, modules, ring_of

NUMBERS = Path(__file__).with_name("budget.toml")
SINCE = "997d79cb01069790a486064676c64c439ae704af"
"""The commit from which on each one is held: a clone without it (shallow, or an archive) cannot check this."""
SECONDS = ROOT / "build/test_seconds.json"
LONG_LINES = 300
LOOP_S = 0.012  # of a fixed loop, in seconds of the machine for which budget.toml is written
SLACK = {"lines": 300, "long": 0, "arrows": 0, "seconds": 10, "words": 5}
"""How far a count may lie below its number before the number must be lowered."""
STEP = {"lines": 50, "seconds": 5}
"""Numbers are lowered to multiples of these, so that a small mend need not raise one."""
COUNTED = {
    *(".py", ".cpp", ".h", ".js", ".mjs", ".css", ".html", ".j2", ".md", ".sh", ".cmake", ".yaml", ".yml", ".toml", "")
}
LEFT_OUT = re.compile(
    r"/vendor/|_core\.pyi$|^docs/(reference|benchmarks)/|^tests/(fuzz/found|python/data)/|^(LICENSE|\.git)"
)
PROSE = {".h", ".cpp", ".py", ".js", ".html", ".j2", ".md", ""}
WORDS = {
    **{word: rf"\b{word}\b" for word in ("says", "tells", "told", "hears", "anew", "nobody", "somebody", "whoever")},
    "what is no": r"\bwhat is no\b",
    "docstring What/Of/Who/Whether": r'(?:"""|///? )(?:What|Of|Who|Whoever|Whose|Whether)\b',
}
PATTERNS = {
    word: re.compile(pattern, 0 if word.startswith("docstring") else re.IGNORECASE) for word, pattern in WORDS.items()
}

Table = Mapping[str, Mapping[str, float]]


def main() -> int:
    """Print the price of the change; return 1 if a count is above its number, or too far below it."""
    if "--history" in sys.argv[1:]:
        try:
            wrong = list(broken_commits(ROOT, SINCE))
        except subprocess.CalledProcessError:
            print(f"budget: {SINCE[:8]} is not in this clone: what each commit held is not checked")
            return 0
        print("\n".join(wrong), end="\n" if wrong else "")
        return 1 if wrong else 0
    counts, numbers = count(), tomllib.loads(NUMBERS.read_text())
    if "--update" in sys.argv[1:]:
        numbers = lowered(counts, numbers)
        NUMBERS.write_text(written(numbers))
    print(price())
    wrong = problems(counts, numbers)
    print("\n".join(wrong), end="\n" if wrong else "")
    return 1 if wrong else 0


def count() -> dict[str, dict[str, float]]:
    """Return what the tree holds, as budget.toml has it; seconds only where a whole run of the tests has left them."""
    lines: Counter[str] = Counter()
    long: Counter[str] = Counter()
    words: Counter[str] = Counter(dict.fromkeys(WORDS, 0))
    for name in _git("ls-files", "--cached", "--others", "--exclude-standard").splitlines():
        if (room := room_of(name)) is None or not (path := ROOT / name).is_file():
            continue
        text = path.read_text()
        number = text.count("\n")
        lines[room] += number
        lines["all"] += number
        long[room] += number > LONG_LINES
        if path.suffix in PROSE and path.name not in ("budget.py", "test_budget.py"):
            words += Counter({word: len(pattern.findall(text)) for word, pattern in PATTERNS.items()})
    for module, path in modules().items():
        if ring := ring_of(module):
            lines[f"ring {ring}"] += path.read_text().count("\n")
    return {
        "lines": dict(lines),
        "long": {room: number for room, number in long.items() if number},
        "arrows": dict(Counter(start for start, _ in arrows())),
        "words": {word: words[word] for word in WORDS},
    } | _seconds()


def _seconds() -> dict[str, dict[str, float]]:
    """Return the seconds that the last whole run of the tests has left, as if the machine were that of the numbers."""
    if not SECONDS.is_file():
        return {}
    measured = json.loads(SECONDS.read_text())
    scale = LOOP_S / measured["loop_s"]
    rooms = {room: round(scale * seconds_s) for room, seconds_s in measured["rooms"].items()}
    return {"seconds": {**rooms, "all": sum(rooms.values())}}


def room_of(name: str) -> str | None:
    """Return the room in which a path counts, None for files that nobody here writes by hand."""
    path = Path(name)
    if path.suffix not in COUNTED or LEFT_OUT.search(name):
        return None
    first, *rest = path.parts
    if not rest:
        return "docs" if path.suffix == ".md" else "root"
    inside = rest[: min(len(rest) - 1, 2 if rest[0] in ("uwsim", "python", "cpp") else 1)]
    return "/".join([first, *inside]) if first in ("cpp", "python", "tests") else first


def arrows() -> set[tuple[str, str]]:
    """Return which room of python/uwsim imports which other, not for type checkers alone."""
    pairs = ((each.module, each.imported) for each in imports() if each.when != "types")
    rooms = (tuple(name.split(".")[1] for name in pair if "." in name) for pair in pairs)
    return {(room[0], room[1]) for room in rooms if len(room) == 2 and room[0] != room[1]}


def problems(counts: Table, numbers: Table) -> list[str]:
    """Return a line for each count that is above its number or too far below it."""
    found: list[str] = []
    for table in (name for name in numbers if name in counts):
        row, numbers_of = counts[table], numbers[table]
        for name in sorted(row.keys() | numbers_of.keys()):
            number, most = row.get(name, 0), numbers_of.get(name, 0)
            if number > most:
                found.append(f"budget: {table} of {name!r}: {number:g}, at most {most:g}: remove some")
            elif number < most - SLACK[table]:
                found.append(
                    f"budget: {table} of {name!r}: only {number:g} of {most:g}: python -m tools.budget --update"
                )
    return found


def broken_commits(root: Path, since: str) -> Iterator[str]:
    """Yield a line for each commit after one that holds more lines than its numbers, or raises that of all lines."""
    git = partial(_git, root=root)
    commits = git("rev-list", "--reverse", "--no-merges", f"{since}..HEAD").split()
    held = lines_of(since, root)
    least = tomllib.loads(git("show", f"{since}:tools/budget.toml"))["lines"]["all"]
    for commit in commits:
        for row in git("diff-tree", "--no-commit-id", "-r", "--numstat", "--no-renames", commit).splitlines():
            added, removed, name = row.split("\t")
            if (room := room_of(name)) and added != "-":
                held[room] += int(added) - int(removed)
                held["all"] += int(added) - int(removed)
        numbers = tomllib.loads(git("show", f"{commit}:tools/budget.toml"))["lines"]
        over = [f"{room!r} {held[room]} of {most}" for room, most in numbers.items() if held[room] > most]
        if numbers["all"] > least:
            over.append(f"the number of all lines is raised from {least} to {numbers['all']}")
        least = min(least, numbers["all"])
        if over:
            yield f"budget: {git('log', '-1', '--format=%h %s', commit).strip()}: {', '.join(over)}"


def lines_of(commit: str, root: Path) -> Counter[str]:
    """Return the lines of a commit, by room and of all."""
    held: Counter[str] = Counter()
    empty = _git("hash-object", "-t", "tree", "/dev/null", root=root).strip()
    for row in _git("diff-tree", "-r", "--numstat", "--no-renames", empty, commit, root=root).splitlines():
        added, _, name = row.split("\t")
        if (room := room_of(name)) and added != "-":
            held[room] += int(added)
            held["all"] += int(added)
    return held


def lowered(counts: Table, numbers: Table) -> dict[str, dict[str, float]]:
    """Return the numbers, each lowered to its count; a room that is gone loses its line."""
    kept = {}
    for table, row in numbers.items():
        now = counts.get(table, row)
        step = STEP.get(table, 1)
        kept[table] = {name: min(most, -(-now[name] // step) * step) for name, most in row.items() if name in now}
    return kept


def written(numbers: Table) -> str:
    """Return the text of budget.toml."""
    head = "# The most of each that the tree may hold; python -m tools.budget explains and checks it.\n"
    tables = ("\n".join(f"{json.dumps(name)} = {most:g}" for name, most in row.items()) for row in numbers.values())
    return head + "".join(f"\n[{table}]\n{rows}\n" for table, rows in zip(numbers, tables, strict=True))


def price() -> str:
    """Return how many lines a change adds and removes by room: what is not committed, else the last commit."""
    base = "HEAD" if _git("status", "--porcelain", "--untracked-files=no") else "HEAD~1"
    added: Counter[str] = Counter()
    removed: Counter[str] = Counter()
    new = _git("ls-files", "--others", "--exclude-standard").splitlines()
    changes = [line.split("\t") for line in _git("diff", "--numstat", "--no-renames", base).splitlines()]
    for plus, minus, name in [*changes, *([str(_lines(name)), "0", name] for name in new)]:
        if (room := room_of(name)) and plus != "-":
            added[room] += int(plus)
            removed[room] += int(minus)
    rooms = ", ".join(f"{room} +{added[room]} -{removed[room]}" for room in sorted(added))
    return f"budget: the change: +{added.total()} -{removed.total()} lines: {rooms}"


def _lines(name: str) -> int:
    return (ROOT / name).read_bytes().count(b"\n")


def _git(*arguments: str, root: Path = ROOT) -> str:
    return subprocess.run(["git", *arguments], cwd=root, capture_output=True, text=True, check=True).stdout


if __name__ == "__main__":
    sys.exit(main())
