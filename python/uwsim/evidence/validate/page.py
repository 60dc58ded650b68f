"""Writes the results of a validation as a page, with a table for each suite and the curves."""

from __future__ import annotations

from pathlib import Path

from uwsim.base.atomic_file import write_atomically
from uwsim.evidence.validate.check import Check

PAGE = "index.md"
HEAD = """# Validation

This page is the output of `uwsim validate --out FOLDER`. It lists every comparison with a closed form, a published
value or a limit. The error is relative to the expected value, or to the scale that the check defines; for a limit it is
the ratio of the computed value to the limit.

"""


def write_page(folder: Path, found: dict[str, list[Check]]) -> None:
    """Write index.md into the folder with the curves. found: checks by suite."""
    parts = [_section(suite, checks) for suite, checks in found.items()]
    curves = [f"![{path.stem.replace('_', ' ')}]({path.name})" for path in sorted(folder.glob("*.png"))]
    ending = ["## Curves\n\n" + "\n\n".join(curves) + "\n"] if curves else []
    write_atomically(folder / PAGE, (HEAD + "\n".join([*parts, *ending])).encode())


def _section(suite: str, checks: list[Check]) -> str:
    misses = sum(not check.passed for check in checks)
    verdict = f"{misses} missed" if misses else "all within tolerance"
    lines = [f"## {suite}", "", f"{len(checks)} checks, {verdict}.", ""]
    lines += ["| check | quantity | expected | computed | error | tolerance | |", "|---|---|---:|---:|---:|---:|---|"]
    lines += [_row(check) for check in checks]
    return "\n".join(lines) + "\n"


def _row(check: Check) -> str:
    unit = f" {check.unit}" if check.unit else ""
    cells = [check.group, check.name, f"{check.expected:.7g}{unit}", f"{check.got:.7g}{unit}"]
    cells += [f"{check.error:.1e}", f"{check.tolerance:.0e}", "ok" if check.passed else "**MISS**"]
    return "| " + " | ".join(_plain(cell) for cell in cells) + " |"


def _plain(cell: str) -> str:
    return cell.replace("|", "\\|").replace("_", "\\_").replace("<", "&lt;")
