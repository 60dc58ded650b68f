"""Writes the results of a validation as a page: a table for each suite, and the curves."""

from __future__ import annotations

from pathlib import Path

from uwsim.evidence.validate.check import Check

PAGE = "index.md"
HEAD = """# Validation

What `uwsim validate --out FOLDER` found: every closed form, published figure and limit, what was expected and what the
simulator gave. The error is relative to the expected value, or to the scale that the check names; for a limit it is the
share of it that is used.

"""


def write_page(folder: Path, found: dict[str, list[Check]]) -> None:
    """Write index.md into the folder that contains the curves. found: checks by suite."""
    parts = [_section(suite, checks) for suite, checks in found.items()]
    curves = [f"![{path.stem.replace('_', ' ')}]({path.name})" for path in sorted(folder.glob("*.png"))]
    ending = ["## Curves\n\n" + "\n\n".join(curves) + "\n"] if curves else []
    (folder / PAGE).write_text(HEAD + "\n".join([*parts, *ending]))


def _section(suite: str, checks: list[Check]) -> str:
    misses = sum(not check.passed for check in checks)
    verdict = f"{misses} missed" if misses else "all within tolerance"
    lines = [f"## {suite}", "", f"{len(checks)} checks, {verdict}.", ""]
    lines += ["| what | figure | expected | got | error | tolerance | |", "|---|---|---:|---:|---:|---:|---|"]
    lines += [_row(check) for check in checks]
    return "\n".join(lines) + "\n"


def _row(check: Check) -> str:
    unit = f" {check.unit}" if check.unit else ""
    cells = [check.group, check.name, f"{check.expected:.7g}{unit}", f"{check.got:.7g}{unit}"]
    cells += [f"{check.error:.1e}", f"{check.tolerance:.0e}", "ok" if check.passed else "**MISS**"]
    return "| " + " | ".join(_plain(cell) for cell in cells) + " |"


def _plain(cell: str) -> str:
    return cell.replace("|", "\\|").replace("_", "\\_").replace("<", "&lt;")
