"""The sweep reference: every key that a sweep's YAML file may contain."""

from tools.reference.scenario import reachable, section

from uwsim.campaigns.sweeps.spec import SweepSpec

HEAD = """# Sweep files

Every key of the file of `uwsim sweep`, from the models that check it; [sweeps](../guides/sweeps.md) explains how they
are used. A key without a default must be given.

"""


def sweep_page() -> str:
    """Return the page, with a section for each model."""
    return HEAD + "\n".join(section(model) for model in reachable(SweepSpec))
