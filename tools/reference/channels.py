"""The channel reference: what a served simulator says and hears."""

from tools.reference.markdown import code, table

from uwsim import Simulator
from uwsim.channels import channels

HEAD = """# Channels

The topics of `uwsim serve lake`, from the table that every bridge and recording uses; other vehicles and scenarios have
others. Rates are the sensors' own; 0 Hz: as it changes.

"""


def channels_page() -> str:
    """Return the page: one table of what is said, one of what is heard."""
    said, heard = [], []
    for channel in channels(Simulator("lake")):
        if channel.read is not None:
            said.append((code(channel.name), code(channel.type), f"{channel.rate_hz or 0:g}"))
        else:
            heard.append((code(channel.name), code(channel.type)))
    text = HEAD + "## Said\n\n" + table(("topic", "type", "rate [Hz]"), said)
    return text + "\n## Heard\n\n" + table(("topic", "type"), heard)
