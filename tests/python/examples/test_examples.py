"""Every example runs and prints output."""

import importlib
import pkgutil

import pytest

import uwsim.examples


@pytest.mark.parametrize("name", [module.name for module in pkgutil.iter_modules(uwsim.examples.__path__)])
def test_the_example_runs(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    importlib.import_module(f"uwsim.examples.{name}").main()
    assert capsys.readouterr().out.strip()
