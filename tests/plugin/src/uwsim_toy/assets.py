"""The package's assets: `modems/blue_light.yaml`."""

from pathlib import Path


def folder() -> Path:
    """Return the folder, which has folders of the same names as uwsim's."""
    return Path(__file__).parent
