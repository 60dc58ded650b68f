"""Run the notebooks and keep their outputs and pictures in them: `python -m tools.notebooks [NAME...]`.

Without names, those whose code has changed since they were run. Each keeps a digest of the code that gave its outputs,
which tests compare. Pictures are stored with 64 colours, so that all notebooks together take about a megabyte.
"""

from __future__ import annotations

import base64
import hashlib
import io
import shutil
import sys
import tempfile
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from PIL import Image

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "notebooks"
COLOURS, TIMEOUT_S = 64, 600
PNG = "image/png"


def digest_of_code(notebook: nbformat.NotebookNode) -> str:
    """Return a digest of all code cells."""
    code = "\0".join(cell.source for cell in notebook.cells if cell.cell_type == "code")
    return hashlib.blake2b(code.encode(), digest_size=8).hexdigest()


def is_fresh(notebook: nbformat.NotebookNode) -> bool:
    """Return whether the outputs are those of the code that the notebook contains."""
    return notebook.metadata.get("uwsim", {}).get("ran") == digest_of_code(notebook)


def run(path: Path) -> None:
    """Run a notebook in a copy of the folder, and write it with its outputs."""
    notebook = nbformat.read(path, as_version=4)
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(path.parent, folder, dirs_exist_ok=True)
        NotebookClient(
            notebook, timeout=TIMEOUT_S, record_timing=False, resources={"metadata": {"path": folder}}
        ).execute()
    for cell in notebook.cells:
        for output in cell.get("outputs", []):
            if PNG in output.get("data", {}):
                output["data"][PNG] = _small(output["data"][PNG])
    notebook.metadata["uwsim"] = {"ran": digest_of_code(notebook)}
    notebook.metadata["language_info"] = {"name": "python"}  # otherwise it would change with Python's version
    nbformat.write(notebook, path)


def _small(picture: str) -> str:
    image = Image.open(io.BytesIO(base64.b64decode(picture))).convert("RGB").quantize(COLOURS)
    image.save(made := io.BytesIO(), "PNG", optimize=True)
    return base64.b64encode(made.getvalue()).decode()


def main() -> None:
    """Run the named notebooks, or those that are not fresh."""
    named = [FOLDER / f"{Path(name).stem}.ipynb" for name in sys.argv[1:]]
    for path in named or sorted(FOLDER.glob("*.ipynb")):
        if named or not is_fresh(nbformat.read(path, as_version=4)):
            run(path)
            print(f"{path.name}: {path.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
