"""Shared by the tests of the whole: the package of others, installed once."""

from pathlib import Path

import pytest

from plugin_package import installed_plugin


@pytest.fixture(scope="session")
def plugins(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return installed_plugin(tmp_path_factory.mktemp("plugins"))
