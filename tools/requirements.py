"""Print the requirements of pyproject.toml, one per line: `python tools/requirements.py build|run|dev|jazzy`.

build: requirements for building. run: also those for running, with the extra `standard`. dev: also all extras and the
group `dev`. jazzy: only the group of that name, which has an environment of its own.
"""

import re
import sys
import tomllib
from pathlib import Path


def requirements(mode: str) -> list[str]:
    """Return the lines, with uwsim's own extras resolved."""
    config = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())
    groups = config["dependency-groups"]
    if mode == "jazzy":
        return list(groups[mode])
    wanted = dict.fromkeys(config["build-system"]["requires"])
    if mode != "build":
        wanted |= dict.fromkeys(config["project"]["dependencies"])
    lines = {"build": [], "run": ["uwsim[standard]"], "dev": groups["dev"]}[mode]
    while lines:
        line, *lines = lines
        if own := re.fullmatch(r"uwsim\[(.*)\]", line):
            extras = [config["project"]["optional-dependencies"][name] for name in own[1].split(",")]
            lines = [each for extra in extras for each in extra] + lines
        else:
            wanted[line] = None
    return list(wanted)


if __name__ == "__main__":
    print(*requirements(sys.argv[1]), sep="\n")
