"""Write the reference pages that are generated from the code: python -m tools.reference FOLDER."""

import sys
from pathlib import Path

from tools.reference.benchmarks import benchmarks_page
from tools.reference.channels import channels_page
from tools.reference.commands import commands_page
from tools.reference.doors import PAGE, security_page
from tools.reference.environments import environments_page
from tools.reference.imaging import imaging_page
from tools.reference.python_names import python_pages
from tools.reference.results import results_page
from tools.reference.scenario import scenario_page
from tools.reference.sensors import sensors_page
from tools.reference.sources import sources_page
from tools.reference.sweep import sweep_page

PAGES = {
    "scenario": scenario_page,
    "sweep": sweep_page,
    "sensors": sensors_page,
    "imaging-sonars": imaging_page,
    "channels": channels_page,
    "commands": commands_page,
    "environments": environments_page,
    "sources": sources_page,
    "benchmarks": benchmarks_page,
    "benchmark-results": results_page,
}


def main() -> None:
    """Write each page whose text has changed."""
    match sys.argv[1:]:
        case [given] if not given.startswith("-"):
            folder = Path(given)
        case _:
            sys.exit(__doc__)
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in {**{name: page() for name, page in PAGES.items()}, **python_pages()}.items():
        target = folder / f"{name}.md"
        target.parent.mkdir(exist_ok=True)
        if not target.exists() or target.read_text() != text:
            target.write_text(text)
    if folder.resolve() == PAGE.parent / "docs/reference":
        PAGE.write_text(security_page())


main()
