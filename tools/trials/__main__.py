"""Let another project's program fly our vehicles; see tools/trial."""

from __future__ import annotations

import argparse
import importlib
import sys

TRIALS = {
    "ardusub": "a compiled ArduSub, in lockstep through its modes, twice",
    "imc": "a DUNE, with its own autopilot, navigation and maneuvers on our LAUV",
    "moos": "missions of an installed MOOS-IvP, on our REMUS 100s",
}


def main() -> int:
    """Fly; print a line for each check as it ends; return 1 if one failed."""
    names = argparse.ArgumentParser(prog="tools/trial", description=__doc__)
    names.add_argument("trial", choices=TRIALS, help="; ".join(f"{name}: {what}" for name, what in TRIALS.items()))
    name = names.parse_args(sys.argv[1:2]).trial
    trial = importlib.import_module(f"tools.trials.{name}")
    parser = argparse.ArgumentParser(prog=f"tools/trial {name}", description=trial.__doc__)
    trial.options(parser)
    failed = []
    for check, passed, text in trial.fly(parser.parse_args(sys.argv[2:])):
        print(f"{'ok  ' if passed else 'MISS'} {check}: {text}", flush=True)
        failed.extend([] if passed else [check])
    print(f"failed: {', '.join(failed)}" if failed else "all passed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
