"""Write a wheel's software bill of materials: `python -m tools.sbom WHEEL`, where the wheel is installed.

WHEEL.cdx.json is CycloneDX 1.6: the wheel with its hash, the Python packages that a plain installation brings, the
Debian libraries in it, the headers compiled into it, and the JavaScript of the station's page, each with version and
licence.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
import sys
import time
import uuid
import zipfile
from importlib import metadata
from pathlib import Path
from typing import Any

from tools.licence_list import debian_licence, debian_version, headers, javascript, python_packages

KINDS = {"Python": "pypi", "library": "deb/debian", "compiled": "deb/debian", "page": "npm"}


def bill(wheel: Path) -> dict[str, Any]:
    """Return the bill of materials. The same wheel and SOURCE_DATE_EPOCH yield the same bytes."""
    digest = hashlib.sha256(wheel.read_bytes()).hexdigest()
    rows = [*(row for row in python_packages(everything=False) if row[0] == "Python"), *_bundled(wheel)]
    rows += [*headers(), *javascript()]
    own = {
        "type": "library",
        "bom-ref": "uwsim",
        "name": "uwsim",
        "version": metadata.version("uwsim"),
        "licenses": [{"license": {"id": "MIT"}}],
        "hashes": [{"alg": "SHA-256", "content": digest}],
    }
    made = time.gmtime(int(os.environ.get("SOURCE_DATE_EPOCH", time.time())))
    components = [_component(*row) for row in rows]
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "serialNumber": f"urn:uuid:{uuid.uuid5(uuid.NAMESPACE_URL, digest)}",
        "version": 1,
        "metadata": {"timestamp": time.strftime("%Y-%m-%dT%H:%M:%SZ", made), "component": own},
        "components": components,
        "dependencies": [{"ref": "uwsim", "dependsOn": [each["bom-ref"] for each in components]}],
    }


def _component(kind: str, name: str, version: str, licence: str) -> dict[str, Any]:
    source = "pypi" if name == "pybind11" else KINDS[kind]
    address = f"pkg:{source}/{name.replace('@', '%40')}@{version}"
    return {
        "type": "library",
        "bom-ref": address,
        "name": name,
        "version": version,
        "purl": address,
        "licenses": [{"license": {"name": licence or "UNKNOWN"}}],
    }


def _bundled(wheel: Path) -> list[tuple[str, str, str, str]]:
    """Return the Debian packages of the libraries in the wheel. auditwheel has added a hash to the libraries' names."""
    with zipfile.ZipFile(wheel) as archive:
        names = {Path(name).name for name in archive.namelist() if ".so" in name and "uwsim.libs/" in name}
    packages = set()
    for name in names:
        pattern = f"/usr/lib/*/{re.sub(r'-[0-9a-f]{8}[.]so', '.so', name)}*"
        found = subprocess.run(["dpkg-query", "--search", pattern], capture_output=True, text=True, check=True).stdout
        packages.add(found.split(":")[0])
    return [("library", each, debian_version(each), debian_licence(each)) for each in sorted(packages)]


if __name__ == "__main__":
    path = Path(sys.argv[1])
    path.with_name(f"{path.name}.cdx.json").write_text(json.dumps(bill(path), indent=1) + "\n")
