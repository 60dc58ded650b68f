"""The numbers that other simulators print, each asked of uwsim at the call: a table with verdicts, which stay."""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import Field, model_validator

from uwsim.base.atomic_file import write_atomically
from uwsim.base.own_files import require_own
from uwsim.evidence.reproduce.claim_asks import ASKS, asked
from uwsim.scenario.read.spec_file import read_spec
from uwsim.scenario.spec.fields import InRange, Model, broken

SOURCE, FOLDER = "simulators", "claims"
MARKS = "<!-- claims -->\n", "<!-- end of the claims -->"
TABLE, VALUES = "claims.md", "claims.json"


class Claim(Model):
    """A number that a simulator's publication or file prints, or that follows from what it prints.

    claim: what the number is. printed: the values as printed. derived: the formula from them, "" if it is printed
    itself. source: repository, file and lines. value, unit: the number. tolerance: relative. ask: the kind of question,
    see ASKS, and its parameters. timed: whether it depends on the machine. verdict: as it was found. remark: why.
    """

    name: str
    simulator: str
    claim: str
    printed: str
    derived: str = ""
    source: str
    value: float
    unit: str
    tolerance: Annotated[float, InRange(0, 1)]
    ask: dict[str, Any]
    timed: bool = False
    verdict: Literal["agrees", "differs"]
    remark: str = ""

    @model_validator(mode="after")
    def _can_be_asked(self) -> Claim:
        kind = self.ask.get("kind")
        if kind not in ASKS:
            raise broken(f"must be one of {', '.join(ASKS)}", at=("ask", "kind"), value=kind)
        wanted = inspect.signature(ASKS[kind]).parameters.keys()
        if {*self.ask} - {"kind"} != {*wanted}:
            raise broken(f"must have {', '.join(wanted)}", at=("ask",))
        return self


class Claims(Model):
    """The claims, and the simulators of which there is none, with the reason."""

    missing: dict[str, str] = Field(default_factory=dict)
    claims: list[Claim] = Field(min_length=1)


class Answer(NamedTuple):
    """A claim and uwsim's number."""

    claim: Claim
    ours: float

    @property
    def verdict(self) -> str:
        """Return `agrees` if the number is the claim's within its tolerance, otherwise `differs`."""
        off = abs(self.ours - self.claim.value)
        return "agrees" if off <= self.claim.tolerance * abs(self.claim.value) else "differs"

    @property
    def has_changed(self) -> bool:
        """True if the verdict is another than the one that was found before."""
        return self.verdict != self.claim.verdict


def load_claims(source: str | Path = SOURCE) -> Claims:
    """Return the claims, by packaged name or path. Raises ScenarioError."""
    return read_spec(Claims, source, FOLDER)


def answers(claims: Sequence[Claim]) -> Iterator[Answer]:
    """Ask each claim of uwsim, now."""
    for claim in claims:
        yield Answer(claim, asked(**claim.ask))


def reproduce_claims(
    out: Path, *, quick: bool = False, page: Path | None = None, progress: Callable[[str], object] = lambda text: None
) -> list[Answer]:
    """Ask all claims, and write claims.md and claims.json into a folder. Raises OSError or ValueError.

    quick: leave out those that measure time. page: a file with MARKS, between which the table is put; it needs all.
    """
    found = load_claims()
    text = None if page is None else page.read_text()
    if text is not None and not all(text.count(mark) == 1 for mark in MARKS):
        raise ValueError(f"--page {page}: must have the lines {' and '.join(mark.strip() for mark in MARKS)} once")
    for name in (TABLE, VALUES):
        require_own(out / name)
    made = []
    for answer in answers([claim for claim in found.claims if not (quick and claim.timed)]):
        made.append(answer)
        claim = answer.claim
        changed = f" (was: {claim.verdict})" if answer.has_changed else ""
        progress(
            f"{claim.simulator:14} {claim.name:26} {claim.value:>12.6g}  uwsim {answer.ours:>12.6g} {claim.unit:6} "
            f"{answer.verdict}{changed}"
        )
    out.mkdir(parents=True, exist_ok=True)
    table = claims_table(found, made)
    write_atomically(out / TABLE, f"# Claims of other simulators, asked of uwsim\n\n{table}".encode())
    values = [{**each.claim.model_dump(), "ours": each.ours, "verdict_now": each.verdict} for each in made]
    write_atomically(out / VALUES, (json.dumps(values, indent=1, allow_nan=False) + "\n").encode())
    if page is not None and text is not None:
        head, _, rest = text.partition(MARKS[0])
        _, _, tail = rest.partition(MARKS[1])
        write_atomically(page, f"{head}{MARKS[0]}{table}{MARKS[1]}{tail}".encode(), replaces_any=True)
    return made


def claims_table(claims: Claims, made: Sequence[Answer]) -> str:
    """Return the table as Markdown."""
    agree = sum(each.verdict == "agrees" for each in made)
    lines = [
        f"{agree} of {len(made)} agree. Nothing was found of: "
        + "; ".join(f"{name} ({why})" for name, why in claims.missing.items()) + ".",
        "",
        "| simulator | claim | printed | theirs | uwsim | within | verdict |",
        "|---|---|---|---|---|---|---|",
    ]  # fmt: skip
    for claim, ours in made:
        verdict = Answer(claim, ours).verdict
        shown = f"{ours:.2g}" if claim.timed else f"{ours:.5g}"
        lines.append(
            f"| {claim.simulator} | {claim.claim} | {claim.printed}{f'; {claim.derived}' if claim.derived else ''} "
            f"| {claim.value:.5g} {claim.unit} | {shown} {claim.unit} | {100.0 * claim.tolerance:g} % "
            f"| {verdict if verdict == 'agrees' else f'**{verdict}**'}{f': {claim.remark}' if claim.remark else ''} |"
        )
    lines += ["", "Sources:", ""]
    lines += [f"- {claim.simulator}, {claim.claim}: {claim.source}" for claim, _ in made]
    return "\n".join([*lines, ""])
