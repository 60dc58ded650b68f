"""Writes the cross-check's cases of free bodies as Stonefish scenarios (XML), from the same YAML.

    python docs/cross-check/to_stonefish.py stonefish/

Axes are those of Stonefish, north, east, down, so that signs of y and z are turned round. Tags as in its documentation,
docs/bodies.rst and docs/environment.rst. Stonefish computes drag and added mass from the geometry, so that the cases'
coefficients cannot be given; with the sphere's, compare how drag and added mass scale. None of these files has been run
by us in this form.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from xml.etree import ElementTree as Xml

from ruamel.yaml import YAML

CASES = Path(__file__).parent / "cases"
FREE_BODIES = ("terminal-speed", "heave-period", "sphere-added-mass", "bounce", "incline")
BED_M = 20.0


def scenario(case: dict, name: str) -> Xml.Element:
    """Return the scenario of a case."""
    body, water = case["body"], case["water"]
    root = Xml.Element("scenario")
    environment = Xml.SubElement(root, "environment")
    Xml.SubElement(environment, "ned", latitude="0.0", longitude="0.0")
    ocean = Xml.SubElement(environment, "ocean")
    Xml.SubElement(ocean, "water", density=f"{water['density_kg_m3']:.1f}", jerlov="0.2")
    Xml.SubElement(ocean, "waves", height="0.0")
    materials = Xml.SubElement(root, "materials")
    restitution = f"{body.get('restitution', 0.0):.3f}"
    for material, density in (("Body", body["density_kg_m3"]), ("Ground", 3000.0)):
        Xml.SubElement(materials, "material", name=material, density=f"{density:.1f}", restitution=restitution)
    table = Xml.SubElement(materials, "friction_table")
    friction = f"{body.get('friction', 0.0):.3f}"
    Xml.SubElement(table, "friction", material1="Body", material2="Ground", static=friction, dynamic=friction)
    Xml.SubElement(Xml.SubElement(root, "looks"), "look", name="Grey", gray="0.5", roughness="0.9")
    down_m, pitch_rad = 5.0, 0.0
    if "size_m" in body:
        half_m = body["size_m"][2] / 2
        if name == "heave-period":
            down_m = half_m * (2 * body["density_kg_m3"] / water["density_kg_m3"] - 1) - 0.05
        if name in ("bounce", "incline"):
            pitch_rad = -math.radians(case.get("incline_deg", 0.0))
            gap_m = case["start"]["height_of_the_lower_face_m"] if name == "bounce" else 0.0
            down_m = BED_M - (half_m + gap_m) / math.cos(pitch_rad)
            ground = Xml.SubElement(root, "static", name="Ground", type="plane")
            _finish(ground, "Ground", BED_M, pitch_rad)
    mode = "floating" if name == "heave-period" else "submerged"
    dynamic = Xml.SubElement(root, "dynamic", name="Body", type=body["shape"], physics=mode, buoyant="true")
    if body["shape"] == "sphere":
        Xml.SubElement(dynamic, "dimensions", radius=f"{body['radius_m']:g}")
    else:
        Xml.SubElement(dynamic, "dimensions", xyz=" ".join(f"{side:g}" for side in body["size_m"]))
    Xml.SubElement(dynamic, "origin", xyz="0.0 0.0 0.0", rpy="0.0 0.0 0.0")
    _finish(dynamic, "Body", down_m, pitch_rad)
    expect = case["expect"]
    root.insert(0, Xml.Comment(f" {case['law']}; expected {expect['quantity']}: {expect['value']:g} {expect['unit']} "))
    return root


def _finish(element: Xml.Element, material: str, down_m: float, pitch_rad: float) -> None:
    Xml.SubElement(element, "material", name=material)
    Xml.SubElement(element, "look", name="Grey")
    Xml.SubElement(element, "world_transform", xyz=f"0.0 0.0 {down_m:.6f}", rpy=f"0.0 {pitch_rad:.9f} 0.0")


def main(out: Path) -> None:
    """Write a file per case."""
    out.mkdir(parents=True, exist_ok=True)
    for path in sorted(CASES.glob("*.yaml")):
        name = path.stem.partition("-")[2]
        if name in FREE_BODIES:
            root = scenario(YAML(typ="safe", pure=True).load(path.read_text(encoding="utf-8")), name)
            Xml.indent(root)
            Xml.ElementTree(root).write(out / f"{path.stem}.scn", encoding="utf-8", xml_declaration=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
