"""The reader of XML."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree
from xml.parsers import expat

DEPTH_MAX = 100


def xml_root(content: bytes, name: str) -> ElementTree.Element:
    """Return the root of an XML document. A document type is refused: entities and defaults may expand without bound.

    Prefixes such as gz: are parts of names, and need not be declared. name: of the document, for messages. Raises
    ValueError for what is not XML, or is too deep.
    """
    builder, parser, depth = ElementTree.TreeBuilder(), expat.ParserCreate(), 0

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > DEPTH_MAX:
            raise ValueError(f"{name}: has elements {depth} deep: must be at most {DEPTH_MAX}")
        builder.start(tag, attributes)

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(tag)

    def refuse(*_: Any) -> None:
        raise ValueError(f"{name}: has a DOCTYPE: must have none")

    parser.StartElementHandler, parser.EndElementHandler, parser.StartDoctypeDeclHandler = start, end, refuse
    parser.CharacterDataHandler = builder.data
    parser.buffer_text = True
    try:
        parser.Parse(content, True)
    except expat.ExpatError as error:
        raise ValueError(f"{name}: must be XML: {error}") from None
    return builder.close()
