"""The sweep reference: every key that a sweep's YAML file may contain."""

from tools.reference.scenario import reachable, section

from uwsim.campaigns.sweeps.spec import SweepSpec

HEAD = """# Sweep files

This page lists every key of a sweep file, generated from the models that check such files;
[sweeps](../guides/sweeps.md) explains how to use them. Keys without a default are required.

"""


def sweep_page() -> str:
    """Return the page, with a section for each model."""
    return HEAD + "\n".join(section(model) for model in reachable(SweepSpec))
