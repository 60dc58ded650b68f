"""The channel reference: the topics that a served simulator publishes and receives."""

from tools.reference.markdown import code, table

from uwsim import Simulator
from uwsim.channels import channels

HEAD = """# Channels

The topics of `uwsim serve lake`, from the table that all bridges and recordings use; they depend on the scenario and
its vehicles. Rates are those of the sensors; a topic with a rate of 0 Hz is published when its value changes.

"""


def channels_page() -> str:
    """Return the page: one table of published topics, one of received ones."""
    published, received = [], []
    for channel in channels(Simulator("lake")):
        if channel.direction == "out":
            published.append((code(channel.name), code(channel.type), f"{channel.rate_hz or 0:g}"))
        else:
            received.append((code(channel.name), code(channel.type)))
    text = HEAD + "## Published\n\n" + table(("topic", "type", "rate [Hz]"), published)
    return text + "\n## Received\n\n" + table(("topic", "type"), received)
