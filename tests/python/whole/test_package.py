"""The package's own papers agree with each other, and a plain installation is light."""

import re
import subprocess
import sys
import textwrap
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from ruamel.yaml import YAML
from tools.measured import PAGES, WITH_SPEED, all_values, filled

from command_line import uwsim
from uwsim.base.extras import EXTRA_OF, MissingExtraError
from uwsim.cli.program import bibtex
from uwsim.scenario.fingerprint import build_fingerprint

ROOT = Path(__file__).parents[3]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def test_every_paper_states_the_same_version_and_authors() -> None:
    citation = YAML(typ="safe").load(ROOT / "CITATION.cff")
    released = re.findall(r"^## \[(\d.*?)\]", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)  # newest first
    assert {str(citation["version"]), *released[:1]} == {PROJECT["version"]}
    names = [PROJECT["authors"], citation["authors"]]
    assert [[each["name"] for each in authors] for authors in names] == [["The uwsim authors"]] * 2
    minors = [int(each.rsplit(".")[-1]) for each in PROJECT["classifiers"] if "Python :: 3." in each]
    wheels = (ROOT / ".github/workflows/wheels.yml").read_text()
    assert wheels.count(" ".join(f"3.{minor}" for minor in minors)) == 2  # interpreters that are installed, and used


def test_the_changelog_is_short_until_a_release() -> None:
    head, *sections = re.split(r"^## ", (ROOT / "CHANGELOG.md").read_text(), flags=re.MULTILINE)
    assert "Keep a Changelog" in head and sections[0].startswith("[Unreleased]\n")
    assert len(sections[0].splitlines()) <= 160, "state what exists, in one line of its theme"


def test_one_figure_of_speed_is_stated_everywhere() -> None:
    values = all_values()
    for page in PAGES:
        text = page.read_text()
        assert filled(text, values) == text, f"{page}: run `python -m tools.measured write`"
        stated = re.findall(r"(\w+)(<!--[\w.]+-->)? times\s+real\s+time", text)
        assert stated == [(str(values["survey"]["times"]), "<!--survey.times-->")] * (page in WITH_SPEED), page
    assert filled(
        "`old`<!--survey.machine--> 1.0<!--survey.seconds-->", {"survey": {"machine": "a b", "seconds": 2}}
    ) == ("`a b`<!--survey.machine--> 2<!--survey.seconds-->")


def test_the_citation_names_version_commit_and_build(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    commit = subprocess.run(["git", "rev-parse", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=False).stdout
    shown = uwsim("--cite").stdout
    assert f"version = {{{PROJECT['version']}}}" in shown and f"build {build_fingerprint()}" in shown
    assert commit.strip() in shown
    (tmp_path / "assets").mkdir()  # as in a wheel of the hosted workflow
    wheel = (ROOT / "CITATION.cff").read_text() + 'repository-code: "https://example.org/a_b"\ncommit: abc123\n'
    (tmp_path / "assets/CITATION.cff").write_text(wheel)
    monkeypatch.setattr("uwsim.scenario.read.assets.assets_folder", lambda: tmp_path / "assets")
    entry = bibtex()
    assert "url = {https://example.org/a_b}" in entry and "commit abc123, build" in entry and "year = {20" in entry


def test_the_package_runs_as_the_command() -> None:
    ran = subprocess.run([sys.executable, "-m", "uwsim", "--version"], capture_output=True, text=True, check=True)
    assert ran.stdout == f"uwsim {PROJECT['version']}\n"


def test_every_action_of_the_workflows_is_pinned_by_commit() -> None:
    used = [line for path in (ROOT / ".github/workflows").glob("*.yml") for line in path.read_text().splitlines()]
    actions = [line for line in used if "uses:" in line]
    assert actions
    assert [line for line in actions if not re.search(r"@[0-9a-f]{40} # v\d", line)] == []


def modules_imported() -> dict[str, Path]:
    """Return every module outside the standard library that uwsim's sources import, with one file that does."""
    importing = re.compile(
        r"^ *(?:from (\w+)[\w.]* import |import (\w+)(?:\.\w+)*(?: as \w+)?(?:  #.*)?$)", re.MULTILINE
    )
    found: dict[str, Path] = {}
    for path in (ROOT / "python/uwsim").rglob("*.py"):
        found |= {first or second: path for first, second in importing.findall(path.read_text())}
    return {name: path for name, path in found.items() if name not in {*sys.stdlib_module_names, "uwsim"}}


def packages(lines: list[str]) -> set[str]:
    """Return the names of the packages that requirements name, with those of uwsim's own extras."""
    wanted = [Requirement(line) for line in lines]
    inner = [
        PROJECT["optional-dependencies"][extra] for each in wanted for extra in each.extras if each.name == "uwsim"
    ]
    return {each.name for each in wanted} | {name for lines in inner for name in packages(lines)}


PACKAGE_OF = {
    "brping": "bluerobotics-ping",
    "GSFU": "gsfu",
    "PIL": "pillow",
    "zenoh": "eclipse-zenoh",
    "foxglove": "foxglove-sdk",
}
OF_OTHERS = {
    "ruamel",
    "affine",
    "annotated_types",
    "typing_extensions",
    "mpl_toolkits",
    "IPython",
    "imageio_ffmpeg",  # where the system has no ffmpeg
    "dask",
    "filterpy",
    "gsw",
    "cv2",
    "playwright",  # takes screens if it is there; kept ones otherwise
    "mujoco",
    "pvlib",
    "pydantic_core",
    "lz4",  # as is zstandard, a dependency of mcap
    "zstandard",
    "markupsafe",
    "torch",
    "rospy",
    "rosgraph",
    "genpy",
    "roslib",
}
"""Modules that other requirements bring, peers to compare with, and ROS 1, which PyPI does not have."""


def test_a_plain_installation_is_light_and_the_extra_of_everything_else_is_known() -> None:
    hard = packages(PROJECT["dependencies"])
    assert len(hard) <= 9
    assert {"numpy", "pydantic", "ruamel.yaml"} <= hard
    reasons = (ROOT / "docs/guides/install.md").read_text()
    assert [name for name in hard if f"`{name}`" not in reasons] == []
    unknown = {name: path for name, path in modules_imported().items() if name not in {*hard, *EXTRA_OF, *OF_OTHERS}}
    assert not unknown, "add them to dependencies, or to an extra and EXTRA_OF"
    for module, extra in EXTRA_OF.items():
        brought = {name.lower() for name in packages(PROJECT["optional-dependencies"][extra])}
        assert {PACKAGE_OF.get(module, module).replace("_", "-"), module} & brought, module
    assert set(PROJECT["optional-dependencies"]) - {"all", "rl"} <= {
        extra for name in ("all", "standard") for line in PROJECT["optional-dependencies"][name]
        for extra in Requirement(line).extras
    }  # fmt: skip


BARE = """
    import sys
    from importlib.machinery import PathFinder

    import uwsim

    slow = {"importlib.metadata", "inspect", "numpy", "pydantic", "scipy", "typer", "trimesh", "uwsim._core"}
    assert not slow & sys.modules.keys(), f"import uwsim imports {slow & sys.modules.keys()}"
    assert uwsim.__version__[0].isdigit()

    class Bare:
        @staticmethod
        def find_spec(name, path=None, target=None):
            missing = name.partition(".")[0] in uwsim.base.extras.EXTRA_OF
            return None if missing else PathFinder.find_spec(name, path, target)

    sys.meta_path[sys.meta_path.index(PathFinder)] = Bare
    try:
        import uwsim.figures.style
    except uwsim.base.extras.MissingExtraError as error:
        print(error)
    import uwsim.cli.map, uwsim.mapping.info
    from uwsim.cli import main
    sys.argv = ["uwsim", "survey", "pool", "--time-limit", "4", "--out", sys.argv[1]]
    main()
"""


def test_without_any_extra_a_survey_ends_with_a_map(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("UWSIM_CACHE", str(tmp_path / "cache"))
    command = [sys.executable, "-c", textwrap.dedent(BARE), str(tmp_path / "out")]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    assert "no report.html, which needs figures: pip install 'uwsim[figures]'" in ran.stderr
    assert "Traceback" not in ran.stderr
    need = "uwsim.figures.style needs 'matplotlib', which is not installed: pip install 'uwsim[figures]'"
    assert need in ran.stdout
    assert (tmp_path / "out/map.bt").read_bytes().startswith(b"# Octomap OcTree binary file")
    assert (tmp_path / "out/summary.json").is_file() and not (tmp_path / "out/report.html").exists()


START = """
    import sys

    from uwsim.simulator.simulator import Simulator

    Simulator("lake").step()
    own = [name for name in sys.modules if name.partition(".")[0] == "uwsim"]
    unused = {"scipy", "PIL", "typer", "mcap", "rosbags", "uwsim.flight", "uwsim.channels"}
    assert not unused & sys.modules.keys(), f"a first step imports {unused & sys.modules.keys()}"
    assert len(own) <= 300, f"a first step imports {len(own)} of our modules"
"""


def test_a_first_step_imports_no_more_than_it_needs() -> None:
    command = [sys.executable, "-c", textwrap.dedent(START)]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    assert not ran.returncode, ran.stderr


def test_an_import_of_another_program_that_fails_is_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(EXTRA_OF, "no_such_module", "figures")
    with pytest.raises(ModuleNotFoundError) as caught:
        import no_such_module  # type: ignore[import-not-found] # noqa: F401
    assert not isinstance(caught.value, MissingExtraError)
