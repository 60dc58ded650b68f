"""The paper is named wherever it is meant, and the first page and the manuscript state what exists."""

import re
import tomllib
from importlib.metadata import entry_points
from pathlib import Path

import pytest

from docs_pages import DOCS, PAGES, ROOT
from uwsim.base.texts.yaml_document import read_yaml
from uwsim.evidence.cli.reproduce import reproduce
from uwsim.scenario.read.assets import assets_folder

MENTION = re.compile(r"\bthe paper\b|\bthe published simulator\b", re.IGNORECASE)
LINKED = re.compile(r"\[the (paper|published simulator)\]\([\w./]*#the-paper\)", re.IGNORECASE)


def one_line(text: str) -> str:
    return " ".join(re.sub(r"[{}]", "", text).split())


def reference() -> dict:
    return read_yaml(ROOT / "CITATION.cff").values["references"][0]


def features() -> str:
    text = (ROOT / "README.md").read_text()
    return text[text.index("## Features") : text.index("## Where to go next")]


@pytest.mark.parametrize("page", [ROOT / "README.md", *PAGES], ids=lambda page: page.stem)
def test_a_page_links_the_paper_where_it_first_names_it(page: Path) -> None:
    text = page.read_text()
    if (found := MENTION.search(text)) and page.name != "glossary.md" and page.parent.name != "paper":
        assert LINKED.match(text, found.start() - 1), text[found.start() - 40 : found.end() + 40]


def test_title_authors_year_and_address_are_the_same_everywhere() -> None:
    cited = reference()
    authors = [(author["given-names"], author["family-names"]) for author in cited["authors"]]
    for text in ((DOCS / "inside/glossary.md").read_text(), reproduce.__doc__ or ""):
        for value in (cited["title"], cited["year"], cited["repository-code"], *(" ".join(each) for each in authors)):
            assert str(value) in one_line(text)
    (entry,) = (
        one_line(each) for each in (DOCS / "paper/paper.bib").read_text().split("\n@") if "chaudhary2021" in each
    )
    assert cited["title"] in entry and str(cited["year"]) in entry and cited["repository-code"] in entry
    assert " and ".join(f"{family}, {given}" for given, family in authors) in entry


def test_the_first_page_names_what_exists() -> None:
    text, names = features(), features().lower()
    lines = re.findall(r"^- \*\*\[(.+?)\]\((.+?)\)\*\*", text, flags=re.MULTILINE)
    assert len(lines) == text.count("\n- ") == 7
    assert all((ROOT / target).is_file() for target in re.findall(r"\]\((?!https)([^)#]+)", text))
    plain = re.sub(r"[^a-z0-9]", "", names)
    kinds = ("uwsim.bridges", "uwsim.scenario_sources", "uwsim.kinds.imaging_sonar")
    for name in (entry.name for group in kinds for entry in entry_points(group=group)):
        assert name.replace("_", "") in plain, name
    vehicles = {path.stem.split("_")[0] for path in (assets_folder() / "vehicles").glob("*.yaml")}
    assert not {name for name in vehicles if f"`{name}`" not in text}
    assert f"{len(list((assets_folder() / 'scenarios').glob('*.yaml')))} packaged [scenarios]" in one_line(text)


def test_the_page_on_installation_lists_every_extra() -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    rows = re.findall(r"^\| (`[^|]+`) \|", (DOCS / "guides/install.md").read_text(), flags=re.MULTILINE)
    assert {name for name in extras if extras[name]} <= set(re.findall(r"`([\w-]+)`", " ".join(rows)))


def test_the_manuscript_lacks_only_its_authors() -> None:
    text = (DOCS / "paper/paper.md").read_text()
    entries = set(re.findall(r"^@\w+\{(\w+),", (DOCS / "paper/paper.bib").read_text(), flags=re.MULTILINE))
    assert set(re.findall(r"@(\w+)", text)) == entries
    assert text.count("To be completed") <= 1
    if "To be completed" in text:
        pytest.skip("the manuscript lacks its authors and affiliation, which a person must fill in")
