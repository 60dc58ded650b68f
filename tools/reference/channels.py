"""The channel reference: the topics that a served simulator publishes and receives."""

from tools.reference.markdown import code, table

from uwsim import Simulator
from uwsim.channels import channels
from uwsim.channels.ros.own_types import OWN_TYPES

HEAD = """# Channels

The topics of `uwsim serve lake`, from the table that all bridges and recordings use; they depend on the scenario and
its vehicles. Rates are those of the sensors; a topic with a rate of 0 Hz is published when its value changes.

"""


def channels_page() -> str:
    """Return the page: one table of published topics, one of received ones, and the messages of our own."""
    published, received = [], []
    for channel in channels(Simulator("lake")):
        if channel.direction == "out":
            published.append((code(channel.name), code(channel.type), f"{channel.rate_hz or 0:g}"))
        else:
            received.append((code(channel.name), code(channel.type)))
    text = HEAD + "## Published\n\n" + table(("topic", "type", "rate [Hz]"), published)
    text += "\n## Received\n\n" + table(("topic", "type"), received)
    own = (f"\n### {name.replace('/msg/', '/')}\n\n```text\n{fields}```\n" for name, fields in OWN_TYPES.items())
    return text + "\n## Messages of uwsim's own\n" + "".join(own)
