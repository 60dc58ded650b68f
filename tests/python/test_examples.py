"""Every example runs and says something."""

import importlib
import pkgutil

import pytest

import uwsim.examples


@pytest.mark.parametrize("name", [module.name for module in pkgutil.iter_modules(uwsim.examples.__path__)])
def test_it_runs(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    importlib.import_module(f"uwsim.examples.{name}").main()
    assert capsys.readouterr().out.strip()
