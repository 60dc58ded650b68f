"""The description of a folder of figures: README.md, manifest.json, and the licence of the files it comes from."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

from uwsim.base.atomic_file import write_atomically
from uwsim.evidence.fingerprint import machine
from uwsim.evidence.reproduce.figure import PAPER, Figure
from uwsim.evidence.reproduce.number import Number, shown
from uwsim.evidence.reproduce.paper import plain
from uwsim.evidence.reproduce.their_world import TheirWorld, inputs

MANIFEST, README, LICENCE = "manifest.json", "README.md", "LICENSE"
BLOCK = 1 << 20


def write_deposit(
    folder: Path,
    checkout: Path,
    command: str,
    theirs: TheirWorld,
    numbers: Sequence[Number],
    drawn: Mapping[str, Mapping[int, Figure]],
) -> None:
    """Write README.md, figures.json, the project's licence, and manifest.json with the hashes of all others."""
    held = sum(each.held for each in numbers)
    write_atomically(folder / README, _readme(command, theirs, numbers, held).encode())
    values = {side: [asdict(figures[k]) for k in sorted(figures)] for side, figures in drawn.items()}
    write_atomically(folder / "figures.json", (json.dumps(plain(values), indent=1, allow_nan=False) + "\n").encode())
    if (checkout / LICENCE).is_file():
        shutil.copyfile(checkout / LICENCE, folder / "scenario" / LICENCE)
    (folder / ".uwsim.lock").unlink(missing_ok=True)
    files = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    manifest = {
        "paper": PAPER,
        "command": command,
        "versions": machine(),
        "seed": theirs.seed,
        "claims_held": held,
        "claims": len(numbers),
        "numbers": [asdict(each) for each in numbers],
        "left_out_or_assumed": list(map(str, theirs.notes)),
        "inputs": hashes(inputs(checkout), checkout),
        "outputs": hashes(files, folder),
    }
    text = json.dumps(plain(manifest), indent=1, allow_nan=False)
    write_atomically(folder / MANIFEST, (text + "\n").encode())


def hashes(paths: Sequence[Path], root: Path) -> dict[str, str]:
    """Return the SHA-256 of files by their paths from a folder. Raises OSError."""
    found = {}
    for path in paths:
        digest = hashlib.sha256()
        with path.open("rb") as file:
            while block := file.read(BLOCK):
                digest.update(block)
        found[path.relative_to(root).as_posix()] = digest.hexdigest()
    return found


def _readme(command: str, theirs: TheirWorld, numbers: Sequence[Number], held: int) -> str:
    rows = [
        f"| [{each.figure}](fig{each.figure:02d}.png) | {each.quantity} | {shown(each.theirs, each.unit)} "
        f"| {shown(each.ours, each.unit)} | {each.claim} | {'held' if each.held else '**not held**'} |"
        for each in numbers
    ]
    notes = [f"- {note}" for note in theirs.notes]
    versions = ", ".join(f"{name} {value}" for name, value in machine().items())
    return "\n".join([
        "# The paper's figures from its authors' own files, beside ours",
        "",
        f"“{PAPER}” by Chaudhary, Mishra, Kalyan and Chitre (OCEANS 2021). Left in each picture, and in the column",
        "`theirs`: uwsim with the terrain, station, gates, pipelines and vehicle of the authors' published project",
        "(https://github.com/org-arl/UWRoboticsSimulator, MIT licence, in `scenario/LICENSE`), in its colours. Right,",
        "and in the column `ours`: uwsim's packaged scenario `paper`.",
        "",
        f"{held} of {len(numbers)} claims held.",
        *(f"\n**Their bed is not whole: {part}.**" for part in theirs.missing_bed),
        "",
        "| figure | quantity | theirs | ours | claim | |", "|---|---|---|---|---|---|", *rows,
        "",
        "Fig. 8 has no world, so both sides are the same table. Fig. 12 is the map of the scenario's own survey, flown",
        "by each vehicle. The vehicle's hydrodynamics are drafted from its hull; its cameras, lamps and instruments",
        "are those of `paper`, in front of and below the hull.",
        "",
        "## Made by",
        "", "```sh", command, "```",
        "",
        f"Seed {theirs.seed}. {versions}. `manifest.json` has these, the SHA-256 of each input file and of each file",
        "here; `figures.json` the values behind each figure; `numbers.csv` the table above. Rates in Fig. 10 and the",
        "screens of Figs. 4 and 5 come from a live simulator and differ from run to run; all else is repeated exactly.",
        "",
        "## Left out or assumed in the conversion",
        "", *(notes or ["nothing"]),
        "",
    ])  # fmt: skip
