"""Architecture rules that neither compilers nor import-linter check: which file may include or import which.

Each rule is a function from a file's path and text to error messages, so that tests can show that it rejects bad code.
"""

import ast
import re
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path, PurePosixPath

import pytest

ROOT = Path(__file__).parents[3]

# C++: the folders of cpp/uwsim from which a folder's files may include headers, besides itself.
MAY_INCLUDE: dict[str, set[str]] = {
    "core": set(),
    "world": {"core"},
    "vehicle": {"core"},
    "acoustics": {"core"},
    "estimation": {"core"},  # a filter cannot see the truth
    "mapping": {"core"},  # neither can a map
    "control": {"core", "vehicle"},  # a controller has a model of its vehicle, but no access to the vehicle
    "rays": {"core", "world"},
    "dynamics": {"core", "world", "vehicle"},  # bodies collide through Bullet, not through rays
    "sensors": {"core", "world", "acoustics", "rays"},
    "sonar": {"core", "world", "acoustics", "rays"},
    "camera": {"core", "world", "rays"},
    "sim": {"core", "world", "vehicle", "acoustics", "rays", "dynamics", "sensors", "sonar"},
    "autopilots": {"core", "sim", "vehicle", "sensors"},  # a simulation that another program drives
}

# C++: a library's include pattern, and the files that may include it.
LIBRARIES: dict[str, tuple[str, str]] = {
    "Eigen": (r"Eigen/", r"cpp/.*"),
    "Eigen's FFT": (r"unsupported/Eigen/FFT", r"cpp/uwsim/camera/plane_transform\.cpp"),
    "Embree": (r"embree\d*/", r"cpp/uwsim/rays/embree\.h"),
    "Bullet": (
        r"bt\w+\.h|Bullet\w*/|LinearMath/",
        r"cpp/uwsim/dynamics/(bullet_contacts\.h|"
        r"(bullet_(contacts|engine|ground|memory)|convex_contact|polytope|solid_triangles)\.cpp)",
    ),
    "OctoMap": (r"octomap/|octomath/", r"cpp/uwsim/mapping/octomap_engine\.cpp"),
    "dynamicEDT3D": (r"dynamicEDT3D/", r"cpp/uwsim/mapping/distance_field\.cpp"),
    "PCL": (r"pcl/", r"cpp/uwsim/mapping/(clouds\.cpp|scan_clouds\.cpp|pcl_clouds\.h)"),
    "instructions of x86": (
        r"immintrin\.h",
        r"cpp/uwsim/(core/(float|double)_lanes\.h|mapping/bricks/kernels/scan_kernels_\w+\.cpp)",
    ),
    "pybind11": (r"pybind11/", r"cpp/bindings/.*"),
}
STANDARD_HEADER = re.compile(r"[a-z_0-9]+")
SYSTEM_HEADER = re.compile(r"((sys|arpa|netinet)/)?\w+\.h")

# Python: modules that the command line may import before it knows the command, to keep `uwsim --help` fast.
EAGER_IN_CLI = sys.stdlib_module_names | {"typer", "rich"}


def includes(text: str) -> list[str]:
    """Return every include as written, with its quotes or brackets."""
    return re.findall(r'^\s*#\s*include\s*(<[^>]+>|"[^"]+")', text, flags=re.MULTILINE)


def folder_of(path: PurePosixPath) -> str:
    """Return the layer of a C++ file: a folder of cpp/uwsim, or `bindings`."""
    return path.parts[2] if path.parts[:2] == ("cpp", "uwsim") else path.parts[1]


def include_edges(path: PurePosixPath, text: str) -> Iterator[str]:
    """Our headers are included by their path from cpp/, along the allowed edges; the bindings may include any."""
    folder = folder_of(path)
    if folder != "bindings" and folder not in MAY_INCLUDE:
        yield f"{path}: folder {folder!r} has no line in MAY_INCLUDE"
        return
    for include in (name.strip('"') for name in includes(text) if name.startswith('"')):
        parts = PurePosixPath(include).parts
        if folder == "bindings" and parts[0] == "bindings":
            continue
        if parts[0] != "uwsim" or len(parts) < 3:
            yield f'{path}: "{include}": write our headers as "uwsim/<folder>/<file>.h"'
        elif folder != "bindings" and parts[1] not in MAY_INCLUDE[folder] | {folder}:
            yield f"{path}: {folder} must not include {include}"


def library_includes(path: PurePosixPath, text: str) -> Iterator[str]:
    """A library is included only by its designated files; headers include only Eigen (and, in bindings, pybind11)."""
    for include in (name.strip("<>") for name in includes(text) if name.startswith("<")):
        owner = next((owner for pattern, owner in LIBRARIES.values() if re.match(pattern, include)), None)
        system_ok = path.suffix == ".cpp" and SYSTEM_HEADER.fullmatch(include)
        if owner and not re.fullmatch(owner, str(path)):
            yield f"{path}: <{include}> belongs in {owner}"
        elif not (owner or system_ok or STANDARD_HEADER.fullmatch(include)):
            yield f"{path}: <{include}> is of no library in LIBRARIES, or a system header in a header"


def pragma_once(path: PurePosixPath, text: str) -> Iterator[str]:
    if path.suffix == ".h" and not re.search(r"^#pragma once$", text, flags=re.MULTILINE):
        yield f"{path}: no #pragma once"


def documented_instructions(path: PurePosixPath, text: str) -> Iterator[str]:
    """GCC's own names of instructions keep clang, and so tools/fuzz, from compiling the kernels."""
    for name in re.findall(r"__builtin_ia32_(?!pause\b)\w+", text):
        yield f"{path}: {name}: use the intrinsic of <immintrin.h>"


def only_core_from_uwsim(path: PurePosixPath, text: str) -> Iterator[str]:
    """Inside the package, only `_core` and submodules are imported from `uwsim`; import-linter cannot follow others."""
    if not re.search(r"\buwsim\s+import\b|\bimport\b.*\buwsim\b(?!\.)", text):
        return
    submodules = {entry.stem for entry in (ROOT / "python/uwsim").iterdir()}
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and node.module == "uwsim" and node.level == 0:
            for alias in node.names:
                if alias.name not in submodules | {"_core"}:
                    yield f"{path}:{node.lineno}: import {alias.name} from the module that defines it"
        elif isinstance(node, ast.Import) and any(alias.name == "uwsim" for alias in node.names):
            yield f"{path}:{node.lineno}: `import uwsim` hides what is used; import the module"


def top_level_imports(text: str) -> Iterator[tuple[int, str]]:
    """Yield the line and module of each import outside functions."""
    for node in ast.parse(text).body:
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.lineno, node.module or ""


@cache
def imported_at_once(file: Path) -> frozenset[str]:
    """Return the modules that a file imports outside functions."""
    return frozenset(module for _, module in top_level_imports(file.read_text()))


def loads_fast(module: str, importing: frozenset[str] = frozenset()) -> bool:
    """Return True if a module is in EAGER_IN_CLI, or if it and the packages around it import only such modules."""
    if module.split(".")[0] in EAGER_IN_CLI or module in importing:
        return True
    path = ROOT / "python" / f"{module.replace('.', '/')}.py"
    if not module.startswith("uwsim.") or not path.is_file():
        return False
    packages = [folder / "__init__.py" for folder in path.parents if folder.is_relative_to(ROOT / "python/uwsim/")]
    files = [path, *(init for init in packages if init.parent.name != "uwsim")]  # which is imported in any case
    found = frozenset().union(*map(imported_at_once, files))
    return all(loads_fast(each, importing | {module}) for each in found)


def eager_imports(path: PurePosixPath, text: str) -> Iterator[str]:
    """Except for a few fast modules, the command line imports modules inside its commands."""
    for line, module in top_level_imports(text):
        if not loads_fast(module):
            yield f"{path}:{line}: import {module} inside the command that needs it"


Rule = Callable[[PurePosixPath, str], Iterator[str]]
RULES: list[tuple[Rule, str]] = [
    (include_edges, r"cpp/(uwsim|bindings)/.*\.(h|cpp)"),
    (library_includes, r"cpp/(uwsim|bindings)/.*\.(h|cpp)"),
    (documented_instructions, r"cpp/.*\.(h|cpp)"),
    (pragma_once, r"(cpp|tests/cpp)/.*\.h"),
    (only_core_from_uwsim, r"python/uwsim/(?!examples/).*\.py"),
    (
        eager_imports,
        r"python/uwsim/(\w+/)?cli/(?!draw_|map_convert|pose_option|run_live)\w+\.py",
    ),  # everything except the imports inside commands
]


@cache
def our_files() -> list[PurePosixPath]:
    found = (path for top in ("cpp", "python", "tests", "tools", "assets") for path in (ROOT / top).rglob("*"))
    return sorted(PurePosixPath(path.relative_to(ROOT).as_posix()) for path in found if path.is_file())


@pytest.mark.parametrize(("rule", "applies_to"), RULES, ids=[rule.__name__ for rule, _ in RULES])
def test_the_sources_keep_the_rule(rule: Rule, applies_to: str) -> None:
    paths = [path for path in our_files() if re.fullmatch(applies_to, str(path))]
    assert paths, f"nothing matches {applies_to}: the rule checks no file"
    assert [complaint for path in paths for complaint in rule(path, (ROOT / path).read_text())] == []


@pytest.mark.parametrize(
    ("rule", "path", "bad", "good"),
    [
        (include_edges, "cpp/uwsim/vehicle/a.h", '#include "uwsim/dynamics/b.h"', '#include "uwsim/core/pose.h"'),
        (include_edges, "cpp/uwsim/mapping/a.cpp", '  #  include "uwsim/world/b.h"', '#include "uwsim/mapping/a.h"'),
        (include_edges, "cpp/uwsim/sim/a.cpp", '#include "uwsim/mapping/b.h"', '#include "uwsim/sonar/b.h"'),
        (include_edges, "cpp/uwsim/core/a.cpp", '#include "a.h"', '#include "uwsim/core/a.h"'),
        (include_edges, "cpp/bindings/a.cpp", '#include "../uwsim/core/pose.h"', '#include "bindings/binders.h"'),
        (include_edges, "cpp/uwsim/dynamics/a.cpp", '#include "uwsim/rays/b.h"', '#include "uwsim/world/b.h"'),
        (include_edges, "cpp/uwsim/sim/a.cpp", '#include "cpp/bindings/bind.h"', ""),
        (library_includes, "cpp/uwsim/rays/ray_scene.h", "#include <embree3/rtcore.h>", "#include <Eigen/Core>"),
        (library_includes, "cpp/uwsim/sonar/a.cpp", "#include <embree3/rtcore.h>", "#include <unistd.h>"),
        (library_includes, "cpp/uwsim/sim/a.cpp", "#include <btBulletDynamicsCommon.h>", "#include <vector>"),
        (library_includes, "cpp/uwsim/mapping/clouds.cpp", "#include <octomap/OcTree.h>", "#include <pcl/a.h>"),
        (library_includes, "cpp/uwsim/core/a.cpp", "#include <pybind11/numpy.h>", "#include <cmath>"),
        (library_includes, "cpp/uwsim/core/a.cpp", "#include <boost/any.hpp>", "#include <sys/stat.h>"),
        (library_includes, "cpp/uwsim/core/a.h", "#include <unistd.h>", "#include <string_view>"),
        (documented_instructions, "cpp/uwsim/core/a.h", "__builtin_ia32_sqrtps(x)", "_mm_sqrt_ps(x)"),
        (pragma_once, "cpp/uwsim/core/a.h", "// #pragma once", "#pragma once\n"),
        (only_core_from_uwsim, "python/uwsim/a.py", "from uwsim import Simulator", "from uwsim import _core, scenario"),
        (only_core_from_uwsim, "python/uwsim/a.py", "def f():\n    import uwsim", "import uwsim.mapping.ranging"),
        (eager_imports, "python/uwsim/cli/program.py", "from uwsim import survey", "def f():\n    import uwsim.survey"),
        (eager_imports, "python/uwsim/cli/program.py", "import numpy as np", "import typer\nfrom pathlib import Path"),
        (eager_imports, "python/uwsim/cli/sonar.py", "import uwsim.cli.draw_sonar", "import uwsim.cli.options"),
    ],
)
def test_the_rule_can_fail(rule: Rule, path: str, bad: str, good: str) -> None:
    assert list(rule(PurePosixPath(path), bad))
    assert list(rule(PurePosixPath(path), good)) == []


def test_native_tests_lie_in_folders_of_the_sources() -> None:
    """Each folder of cpp/uwsim has its tests in the folder of the same name; only shared tests lie above."""
    folders = {path.name for path in (ROOT / "tests/cpp").iterdir() if path.is_dir()}
    assert folders == set(MAY_INCLUDE) == {path.name for path in (ROOT / "cpp/uwsim").iterdir() if path.is_dir()}
    assert [path.name for path in (ROOT / "tests/cpp").glob("test_*")] == []


def test_the_dispatcher_tests_every_flag_that_its_files_are_compiled_with() -> None:
    """An untested flag may cause an illegal instruction on another machine."""
    cmake = (ROOT / "cpp/uwsim/CMakeLists.txt").read_text()
    sets = dict(re.findall(r"^set\((avx\w+) ([^)]*)\)", cmake, flags=re.MULTILINE))
    dispatcher = (ROOT / "cpp/uwsim/core/instruction_set.cpp").read_text()
    tested: set[str] = set()
    for name in ("avx2", "avx512"):
        flags = set(re.findall(r"-m([a-z0-9]+)\b(?![-=])", sets[name]))
        body = re.search(rf"bool has_{name}\(\) {{(.*?)}}", dispatcher, flags=re.DOTALL)
        assert body, f"has_{name} is not in instruction_set.cpp"
        tested |= set(re.findall(r'__builtin_cpu_supports\("(\w+)"\)', body.group(1)))
        assert flags and flags <= tested, f"{name}: flags that are compiled with but not tested: {flags - tested}"
    elsewhere = [path for path in (ROOT / "cpp").rglob("*.*") if "__builtin_cpu_supports" in path.read_text()]
    assert elsewhere == [ROOT / "cpp/uwsim/core/instruction_set.cpp"]


def test_no_folder_of_sources_has_more_than_30_files() -> None:
    folders = [path for path in (ROOT / "python/uwsim").rglob("*") if path.is_dir()]
    full = {path.name: count for path in folders if (count := len([*path.glob("*.py")])) > 30}
    assert full == {"base": 31}, "the list may only become shorter"
