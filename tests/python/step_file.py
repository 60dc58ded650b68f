"""STEP files, as CAD programs export them."""

import itertools
from collections.abc import Iterable


def step_box(size_mm: tuple[float, float, float]) -> str:
    """Return a box with a corner in the origin: a solid of planes and polygons (ISO 10303-21 and 10303-214)."""
    lines: list[str] = []

    def add(text: str) -> str:
        lines.append(text)
        return f"#{len(lines)}"

    def of(kind: str, numbers: Iterable[float]) -> str:
        return add(f"{kind}('',({','.join(f'{float(x):.6f}' for x in numbers)}))")

    def frame(at: Iterable[float], z: Iterable[float], x: Iterable[float]) -> str:
        return add(f"AXIS2_PLACEMENT_3D('',{of('CARTESIAN_POINT', at)},{of('DIRECTION', z)},{of('DIRECTION', x)})")

    faces = []
    for axis, side in itertools.product(range(3), (0, 1)):
        turns = [(0, 0), (1, 0), (1, 1), (0, 1)] if side else [(0, 0), (0, 1), (1, 1), (1, 0)]
        ring = [tuple(s * {0: side, 1: u, 2: v}[(k - axis) % 3] for k, s in enumerate(size_mm)) for u, v in turns]
        loop = add(f"POLY_LOOP('',({','.join(of('CARTESIAN_POINT', point) for point in ring)}))")
        normal = [(2 * side - 1) * (k == axis) for k in range(3)]
        plane = add(f"PLANE('',{frame(ring[0], normal, [k == (axis + 1) % 3 for k in range(3)])})")
        bound = add(f"FACE_OUTER_BOUND('',{loop},.T.)")
        faces.append(add(f"FACE_SURFACE('',({bound}),{plane},.T.)"))
    shell = add(f"CLOSED_SHELL('',({','.join(faces)}))")
    solid = add(f"FACETED_BREP('',{shell})")
    length = add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))")
    units = add(
        f"(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT(({length}))REPRESENTATION_CONTEXT('',''))"
    )
    shape = add(f"FACETED_BREP_SHAPE_REPRESENTATION('',({frame([0] * 3, [0, 0, 1], [1, 0, 0])},{solid}),{units})")
    use = add("APPLICATION_CONTEXT('automotive design')")
    field = add(f"PRODUCT_CONTEXT('',{use},'mechanical')")
    product = add(f"PRODUCT('box','box','',({field}))")
    form = add(f"PRODUCT_DEFINITION_FORMATION('','',{product})")
    context = add(f"PRODUCT_DEFINITION_CONTEXT('part definition',{use},'design')")
    definition = add(f"PRODUCT_DEFINITION('','',{form},{context})")
    defined = add(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")
    add(f"SHAPE_DEFINITION_REPRESENTATION({defined},{shape})")
    data = "\n".join(f"#{number} = {text};" for number, text in enumerate(lines, 1))
    return (
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
        f"FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\n{data}\nENDSEC;\nEND-ISO-10303-21;\n"
    )
