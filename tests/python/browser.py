"""Helper for browser tests of a station: Debian's headless Chromium with software WebGL."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import patch

from playwright.sync_api import Browser, Page, sync_playwright

from uwsim.base.axes import AXES
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.rosbridge import server
from uwsim.exercises import Exercise
from uwsim.operator.station import Site, Station
from uwsim.operator.station.flights.flights import Bounds
from waiting import until

CHROMIUM = Path("/usr/bin/chromium-headless-shell")  # from tools/apt-packages-dev.txt, in place of Playwright's build
SOFTWARE_GL = "--enable-unsafe-swiftshader"
AXE = Path(__file__).parents[2] / "build/js/node_modules/axe-core/axe.min.js"
WAIT_S = 180.0  # timeout for every wait; generous because the machine may be busy


@contextmanager
def chromium() -> Iterator[Browser]:
    assert CHROMIUM.exists(), "run tools/setup --dev"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=[SOFTWARE_GL])
        with patch.object(server, "PONG_S", 10 * WAIT_S):  # a browser may stand still for longer than the usual limit
            yield browser
        browser.close()


class Desk:
    """A station on its own port and the browser pages that view it. complaints: errors from the pages' consoles."""

    def __init__(self, browser: Browser, station: Station, server: RosbridgeServer) -> None:
        self.browser = browser
        self.station = station
        self.url = server.url.replace("ws", "http", 1)
        self.complaints: list[str] = []
        self.requests: list[str] = []

    def open(self, path: str = "/", **options: object) -> Page:
        """Open a page in a new browser context, which shares nothing with other pages, as for a separate user."""
        context = self.browser.new_context(**{"viewport": {"width": 1280, "height": 800}, **options})  # type: ignore[arg-type]
        context.set_default_timeout(1000 * WAIT_S)
        page = context.new_page()
        page.on("console", lambda message: message.type == "error" and self.complaints.append(message.text))
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on("request", lambda request: self.requests.append(request.url))
        page.on("websocket", lambda socket: self.requests.append(socket.url))
        page.goto(self.url + path)
        return page

    def fly(self, is_patient: bool = True, **options: object) -> Page:
        """Open the page of a running simulator; the page takes control if there is no pilot yet.

        is_patient: the page does not take a silence of the server, which may last seconds on a busy machine, for a lost
        network, in which it releases all keys.
        """
        page = self.open(**options)
        page.wait_for_selector("#station:not([hidden])")
        if is_patient:
            page.evaluate(
                "() => void setInterval(() => { station.station.bridge.receivedMs = performance.now(); }, 100)"
            )
        when(page, "station.telemetry.message")
        when(page, "station.station.state.pilot")
        return page

    def leave(self, *pages: Page) -> None:
        """Give the controls up and close pages, so that the next one takes control."""
        for page in pages:
            page.evaluate("station.station.handOver('').catch(() => null)")
            page.context.close()
        until(lambda: not self.station.lease.pilot, "no pilot")

    @property
    def rov(self):
        return self.station.present().live.simulator.rov

    def effort(self, axis: str) -> float:
        """Return the vehicle's last commanded effort along an axis."""
        return float(self.rov.effort[AXES.index(axis)])


@contextmanager
def desk(
    browser: Browser, folder: Path, scenario: str = "", keep_flights: Bounds | None = None, **choice: object
) -> Iterator[Desk]:
    """Serve a station, with `scenario` running (vehicle docked), or with the start screen if `scenario` is empty.

    keep_flights: of `Station`. choice: further arguments of `Station.start`.
    """
    station = Station(offered=scenario or "pool", folder=folder, keep_flights=keep_flights)
    with RosbridgeServer(None, guests=[station], site=Site(station)) as serving, station.serving(serving.show):
        if scenario:
            station.start({"scenario": scenario, "seed": 7, **choice})
        here = Desk(browser, station, serving)
        yield here
        for context in list(browser.contexts):
            context.close()


@contextmanager
def exercise_desk(browser: Browser, folder: Path, exercise: Exercise, **options: object) -> Iterator[Desk]:
    """Serve a station at which an exercise is flown. options: further arguments of `Station`."""
    station = Station(is_fixed=True, truth=False, folder=folder, **options)  # type: ignore[arg-type]
    with RosbridgeServer(None, guests=[station], site=Site(station)) as serving, station.serving(serving.show):
        station.run_exercise(exercise)
        yield Desk(browser, station, serving)
        for context in list(browser.contexts):
            context.close()


def shows(page: Page, selector: str, text: str) -> None:
    """Wait until an element of a page contains a text: it may follow from a later message than one just received."""
    until(lambda: text in page.inner_text(selector), f"{text!r} in {selector}")


def when(page: Page, expression: str) -> None:
    """Wait until a JavaScript expression is true in a page. (Playwright's own wait needs eval, which pages forbid.)"""
    until(lambda: page.evaluate(f"Boolean({expression})"), expression)


JUDGE = """async () => {
  const options = {
    runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa'],
    checks: { 'color-contrast': { options: { ignoreUnicode: false, ignoreLength: true } } },
  };
  const listed = (results) => results.flatMap(({ id, nodes }) => nodes.map((node) => ({ id, ...node })));
  const isOpen = ({ id, any }) => id === 'color-contrast' && !any.some(({ data }) => data?.messageKey === 'emptyValue');
  const isOnTop = (element) => {
    const { left, top, right, bottom } = element.getBoundingClientRect();
    element.style.pointerEvents = 'auto';
    const hit = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
    element.style.pointerEvents = '';
    return Boolean(hit) && (element.contains(hit) || hit.contains(element));
  };
  const found = await axe.run(options);
  const wrong = listed(found.violations);
  for (const { target } of listed(found.incomplete).filter(isOpen)) {
    const element = document.querySelector(target[0]);
    element?.scrollIntoView({ block: 'center', inline: 'center' });
    const again = element && isOnTop(element) ? await axe.run(element, options) : { violations: [], incomplete: [] };
    wrong.push(...listed(again.violations), ...listed(again.incomplete).filter(isOpen));
  }
  return wrong.map(({ id, html, any }) => [id, html.slice(0, 120), any[0]?.data?.messageKey ?? '']);
}"""


def judge(page: Page, what: str) -> None:
    """Run axe to find accessibility problems for users with a screen reader, a keyboard or low vision.

    A contrast that axe leaves open, also where the text has been scrolled into view, counts as wrong, too, unless
    another element covers the text. Signs and single letters are computed like words.
    """
    if not page.evaluate("Boolean(globalThis.axe)"):
        page.evaluate(AXE.read_text())
    wrong = page.evaluate(JUDGE)
    assert not wrong, f"{what}: {wrong}"
