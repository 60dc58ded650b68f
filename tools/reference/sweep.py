"""The reference of sweeps: every key that a sweep's YAML file may hold."""

from tools.reference.scenario import reachable, section

from uwsim.sweeps.spec import SweepSpec

HEAD = """# Sweep files

Every key that the file of `uwsim sweep` may hold, from the models that check it; [sweeps](../sweeps.md) says how they
are used. A key without a default must be given.

"""


def sweep_page() -> str:
    """Return the page, with a section for each model."""
    return HEAD + "\n".join(section(model) for model in reachable(SweepSpec))
