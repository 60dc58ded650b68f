"""The page in German, in each state that it has: no fault of access, no word cut, nothing wider than the screen.

What shows a state is judged in each theme, and the whole page in one. `test_exercise_by_keys` has the states of an
exercise, `test_hud_page` the bar and the pictures.
"""

from browser import desk, judge, shows, until, when
from uwsim.operator.station.flights.flights import Bounds

WIDTHS = (1280, 1920)
THEMES = ["dark", "light", "night"]
CUT = """() => [...document.querySelectorAll('button, .lamp, #lease, .caption, .panel h2, .exercise-files a')]
  .filter((each) => each.checkVisibility() && each.scrollWidth > each.clientWidth + 1 && each.clientWidth > 0)
  .map(({ id, textContent }) => id || textContent)"""


def look(page, state: str, text: str, part: str = "body") -> None:
    """Judge a state, which shows a German text in a part, in each theme, and the page in the last, at each width."""
    shows(page, part, text, 15.0)
    assert "undefined" not in page.inner_text("body")
    THEMES.append(THEMES.pop(0))  # the last one is another one for each state
    for theme in THEMES:
        page.evaluate(f"document.documentElement.dataset.theme = '{theme}', dispatchEvent(new Event('theme'))")
        if theme != THEMES[-1] and part != "body":
            judge(page, f"{state} in German, {theme}", part)
    for width in WIDTHS:
        page.set_viewport_size({"width": width, "height": width * 9 // 16})
        page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done())))")
        assert page.evaluate(CUT) == [] and page.evaluate("document.documentElement.scrollWidth") <= width, (
            state,
            width,
        )
    page.set_viewport_size({"width": 1280, "height": 720})
    judge(page, f"{state} in German, {THEMES[-1]}")


def test_each_state_in_german_and_the_menu_changes_the_language(browser, tmp_path):
    with desk(browser, tmp_path, keep_flights=Bounds(3)) as here:
        page = here.open(locale="de-DE", viewport={"width": 1280, "height": 720})
        look(page, "start", "Startwert", "#start")
        page.select_option("#field-scenario", "pool")
        page.click("button[type=submit]")
        here.settle(page)
        when(page, "station.station.isPilot && station.views.largeView.picture.drawn > 0")
        assert page.evaluate("document.documentElement.lang") == "de"
        look(page, "docked", "Lösen", "#dock")
        here.station.present().live.rov.undock()
        page.click("#hold-depth")
        until(lambda: here.rov.holds and here.rov.holds.has_control, "a hold")
        look(page, "aided", "Sie steuern", "#lease")
        page.keyboard.press("x")
        look(page, "all stop", "bewegt das Fahrzeug", "#stopped")
        page.click("#end-stop")
        page.click("#pause")
        when(page, "station.station.state.paused")
        look(page, "paused", "Pause", ".topbar")
        page.click("#pause")
        page.keyboard.press("Escape")
        page.wait_for_selector("#menu-dialog[open]")
        look(page, "menu", "Fortsetzen", "#menu-dialog")
        page.click("text=Beenden, zum Startbild")
        page.wait_for_selector("#flights li button:not(:disabled)")
        look(page, "flights", "Wiedergeben", "#flights")
        page.click("#flights li button")
        page.wait_for_selector("#timeline:not([hidden])")
        when(page, "station.telemetry.message")
        look(page, "replay", "Steuer übernehmen", "#timeline")
        page.evaluate("station.station.bridge.close()")
        look(page, "lost link", "neuer Versuch", "#banner")
        assert not here.complaints
        page.evaluate("localStorage.setItem('uwsim.language', 'en')")
        page.reload()
        page.wait_for_selector("html[lang=en] #station:not([hidden])")
        french = here.open(locale="fr-FR")  # without a table
        when(french, "document.documentElement.lang === 'en'")
