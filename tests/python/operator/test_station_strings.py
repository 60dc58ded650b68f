"""All that a person reads on the station's page stands in its files of strings, one for each language."""

import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "python/uwsim/operator/station/page"
NODE = Path(sys.prefix) / "bin/node"


def test_no_text_stands_outside_of_the_files():
    done = subprocess.run([NODE, ROOT / "tests/js/texts.mjs"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, f"put into strings/*.json:\n{done.stdout}{done.stderr}"


class Texts(HTMLParser):
    """Collects what a person reads of a document; noscript and title stay as they are."""

    def __init__(self):
        super().__init__()
        self.open, self.found, self.keys = [], [], []

    def handle_starttag(self, tag, attrs):
        self.open.append(tag)
        for name, value in attrs:
            if name in ("aria-label", "title", "placeholder", "alt") and value:
                self.found.append(value)
            if name in ("data-text", "data-label", "data-tip"):
                self.keys.append(value)

    def handle_endtag(self, tag):
        while self.open and self.open.pop() != tag:
            pass

    def handle_data(self, data):
        if any(letter.isalpha() for letter in data) and not {"noscript", "title"} & set(self.open):
            self.found.append(data.strip())


@pytest.mark.parametrize("path", sorted(PAGE.glob("*.html")), ids=lambda path: path.name)
def test_the_documents_have_no_words_of_their_own(path):
    texts = Texts()
    texts.feed(path.read_text())
    assert set(texts.found) <= {"uwsim"}
    assert bool(texts.keys) == (path.name == "index.html")
