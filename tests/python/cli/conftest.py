"""Maps of the pool that the tests of `uwsim map` read."""

from pathlib import Path

import pytest

from pool_maps import write_pool_maps


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the files of write_pool_maps."""
    return write_pool_maps(tmp_path_factory.mktemp("maps"))
