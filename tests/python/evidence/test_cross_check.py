"""The cross-check for other simulators: uwsim passes its own cases, and a wrong quantity misses."""

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

FOLDER = Path(__file__).parents[3] / "docs/cross-check"
QUICK = [path for path in sorted((FOLDER / "cases").glob("*.yaml")) if "kirchhoff" not in path.stem]


@pytest.fixture(scope="module")
def adapter() -> ModuleType:
    spec = importlib.util.spec_from_file_location("run_uwsim", FOLDER / "run_uwsim.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_there_are_twelve_cases_with_a_law_and_a_source(adapter: ModuleType) -> None:
    cases = [adapter.load(path) for path in sorted(adapter.CASES.glob("*.yaml"))]
    assert len(cases) == 12 == len(adapter.ADAPTER)
    assert all(
        case["law"] and case["source"] and set(case["expect"]) >= {"value", "unit", "tolerance"} for case in cases
    )


@pytest.mark.parametrize("path", QUICK, ids=lambda path: path.stem)
def test_a_case_passes_within_its_tolerance(adapter: ModuleType, path: Path) -> None:
    case = adapter.load(path)
    got = adapter.ADAPTER[path.stem.partition("-")[2]](case)
    assert adapter.error(case, got) <= case["expect"]["tolerance"]
    assert adapter.error(case, 1.5 * got + 1) > case["expect"]["tolerance"]
