"""Find where a program writes, renames or removes files, by walking its syntax."""

import ast
from collections.abc import Iterator
from pathlib import Path

WRITES = {"write_text", "write_bytes", "unlink", "rmtree", "touch", "copyfile", "copytree", "copy2"}
OF_MODULES = {("os", "link"), ("os", "remove"), ("os", "truncate"), ("shutil", "move"), ("shutil", "copy")}
LAW = {"require_own", "is_own", "remove_own", "remove_own_file"}
"""The functions of uwsim.base.own_files by which a writer regards files of others."""
LAWFUL = {
    "its own temporary files": """base/atomic_file.py:remove_unfinished base/atomic_file.py:GrowingFile.close
        base/atomic_file.py:GrowingFile.discard base/own_files.py:mark base/folder_lock.py:alone_in""",
    "in a temporary folder": """campaigns/workers/dask_workers.py:scratch_folder evidence/cli/vehicle.py:_print_draft
        evidence/reproduce/beside.py:_make evidence/reproduce/beside.py:_survey_map
        evidence/reproduce/deposit.py:write_deposit exchange/robots/written.py:require_simulable
        exchange/robots/written.py:_estimates exchange/unity/scenario.py:_Files.drafted
        evidence/validate/motion/closed_forms.py:_write_obj examples/m07_wall_scan.py:main
        examples/m08_station_keeping.py:main examples/m10_digital_twin.py:main
        operator/station/sessions/saves.py:save
        recording/foreign_bag.py:map_from_bag recording/real_flights/deep_water.py:_bare
        scenario/read/contained.py:run_contained scenario/read/contained.py:main""",
    "in a folder that is new or empty": """campaigns/datasets/sequences/euroc.py:Rows.__init__
        campaigns/datasets/sequences/euroc.py:Files.add campaigns/datasets/sequences/euroc.py:write_yaml
        campaigns/datasets/sequences/instruments.py:Imaged.close campaigns/datasets/sequences/make.py:_describe
        campaigns/datasets/sequences/tum.py:Tum.__init__ evidence/reproduce/beside.py:reproduce_beside
        league/new.py:new_team operator/station/editor/meshes.py:Meshes._keep""",
    "ours by its content": """bridges/ros_packages/write.py:write_sealed
        operator/station/editor/editor.py:Editor.save operator/station/flights/flights.py:Flights.make_room
        scenario/read/disk_cache.py:_make_room""",
    "just created, with mode x": "recording/mcap_sink.py:McapSink.__init__",
}
"""The functions that need no law, by the reason."""
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)


def lawless_writers(sources: Path) -> Iterator[str]:
    """Yield the functions, as module:name, that write, rename or remove a file, and use none of LAW."""
    for path in sorted(sources.rglob("*.py")):
        tree = ast.parse(path.read_text())
        for name, function in (("", tree), *_functions(tree, "")):
            inside = list(_own_nodes(function))
            used = {node.id for node in inside if isinstance(node, ast.Name)}
            if not used & LAW and any(_writes(node) for node in inside if isinstance(node, ast.Call)):
                yield f"{path.relative_to(sources)}:{name}"


def _functions(tree: ast.AST, within: str) -> Iterator[tuple[str, ast.AST]]:
    for node in ast.iter_child_nodes(tree):
        is_named = isinstance(node, FUNCTIONS)
        name = f"{within}.{node.name}".lstrip(".") if is_named else within  # type: ignore[attr-defined]
        if is_named:
            yield name, node
        yield from _functions(node, name)


def _own_nodes(function: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes of a function, without those of the functions in it."""
    for node in ast.iter_child_nodes(function):
        if not isinstance(node, FUNCTIONS):
            yield node
            yield from _own_nodes(node)


def _writes(call: ast.Call) -> bool:
    name = getattr(call.func, "attr", getattr(call.func, "id", ""))
    by = getattr(getattr(call.func, "value", None), "id", "")
    if name in ("open", "fdopen"):
        given = [*call.args, *(each.value for each in call.keywords)]
        modes = [str(each.value) for each in given if isinstance(each, ast.Constant)]
        return any(set(mode) & set("wa+") and set(mode) <= set("rwabt+") for mode in modes) and by != "wave"
    if name in ("rename", "replace"):  # of a path: the text's takes two arguments, and the dataclass's keywords
        return isinstance(call.func, ast.Attribute) and len(call.args) == 1 and not call.keywords and by != "self"
    return name in WRITES or (by, name) in OF_MODULES
