"""All that a person reads on the station's page stands in its files of strings, one for each language."""

import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

from browser import desk, judge, shows, when

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


def test_a_german_browser_gets_german_and_the_menu_changes_it(browser, tmp_path):
    with desk(browser, tmp_path, "pool") as here:
        page = here.fly(locale="de-DE", viewport={"width": 1440, "height": 900})
        when(page, "station.station.isPilot && station.views.largeView.picture.drawn > 0")
        assert page.evaluate("document.documentElement.lang") == "de"
        shows(page, "#dock", "Lösen")
        shows(page, "#lease", "Sie steuern")
        assert "undefined" not in page.inner_text("body")
        judge(page, "the German page")
        page.keyboard.press("Escape")
        page.wait_for_selector("#menu-dialog[open]")
        judge(page, "the German menu")
        page.click("#menu-dialog >> text=English")
        page.wait_for_selector("html[lang=en] #station:not([hidden])")
        shows(page, "#dock", "Release")
        assert not here.station.present().live.paused
        french = here.open(locale="fr-FR")  # without a table
        when(french, "document.documentElement.lang === 'en'")
        assert not here.complaints
