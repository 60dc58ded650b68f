"""Helper for browser tests of a station: Debian's headless Chromium with software WebGL."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import patch

from playwright.sync_api import Browser, BrowserContext, ConsoleMessage, Error, Frame, Page, sync_playwright

from uwsim.base.axes import AXES
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.rosbridge import server
from uwsim.exercises import Exercise
from uwsim.operator.station import Site, Station
from uwsim.operator.station.flights.flights import Bounds
from uwsim.operator.station.views import views
from waiting import until

CHROMIUM = Path("/usr/bin/chromium-headless-shell")  # from tools/apt-packages-dev.txt, in place of Playwright's build
SOFTWARE_GL = "--enable-unsafe-swiftshader"
AXE = Path(__file__).parents[2] / "build/js/node_modules/axe-core/axe.min.js"
PICTURES_HZ = 2.5  # less than the station renders, since each picture takes processor time there and in the page
SLOWLY = """{
  const paint = globalThis.requestAnimationFrame.bind(globalThis);
  let due = [];
  globalThis.requestAnimationFrame = (act) => {
    const draw = (time) => due.splice(0).forEach((each) => each(time));
    if (due.push(act) === 1) setTimeout(() => paint(draw), 80);
    return due.length;
  };
}"""
"""Ten frames a second instead of sixty, which take half of a page's processor time."""
WAIT_S = 180.0  # timeout for every wait; generous because the machine may be busy


@contextmanager
def chromium() -> Iterator[Browser]:
    assert CHROMIUM.exists(), "run tools/setup --dev"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=[SOFTWARE_GL])
        yield browser
        browser.close()


class Desk:
    """A station on its own port and the browser pages that view it. complaints: errors from the pages' consoles."""

    def __init__(self, browser: Browser, station: Station, server: RosbridgeServer) -> None:
        self.browser = browser
        self.station = station
        self.url = server.url.replace("ws", "http", 1)
        self.complaints: list[str] = []
        self.contexts: list[BrowserContext] = []

    def open(self, path: str = "/", requests: list[str] | None = None, **options: object) -> Page:
        """Open a page in a new browser context, which shares nothing with other pages, as for a separate user.

        requests: gets the addresses of all requests.
        """
        context = self.browser.new_context(**{"viewport": {"width": 1280, "height": 800}, **options})  # type: ignore[arg-type]
        self.contexts.append(context)
        context.add_init_script(SLOWLY)
        context.set_default_timeout(1000 * WAIT_S)
        page = context.new_page()
        page.on("console", lambda message: message.type == "error" and self.complain(message))
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        if requests is not None:
            page.on("request", lambda request: requests.append(request.url))
            page.on("websocket", lambda socket: requests.append(socket.url))
        page.goto(self.url + path)
        return page

    def complain(self, message: ConsoleMessage) -> None:
        self.complaints.append(f"{message.text} {message.location['url']}")

    def fly(self, is_patient: bool = True, **options: object) -> Page:
        """Open the page of a running simulator; the page takes control if there is no pilot yet.

        is_patient: the page does not take a silence of the server, which may last seconds on a busy machine, for a lost
        network, in which it releases all keys.
        """
        page = self.open(**options)
        self.settle(page, is_patient)
        return page

    def settle(self, page: Page, is_patient: bool = True) -> None:
        """Return when a page shows the running simulator, which has a pilot."""
        page.wait_for_selector("#station:not([hidden])")
        if is_patient:
            page.evaluate(
                "() => void setInterval(() => { station.station.bridge.receivedMs = performance.now(); }, 100)"
            )
        when(page, "station.telemetry.message && station.station.state.pilot")

    def give(self, giver: Page, taker: Page) -> None:
        """Hand the controls over from one page to another."""
        giver.evaluate("id => station.station.handOver(id)", taker.evaluate("station.station.id"))
        when(taker, "station.station.isPilot")

    def regain(self, page: Page) -> None:
        """Return when a page has the controls, which the last pilot's page has lost."""
        again = "station.station.isPilot || station.station.takeControl().then(() => false, () => false)"
        when(page, f"await ({again})")

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
def _serving(browser: Browser, station: Station) -> Iterator[Desk]:
    with (
        patch.object(server, "PONG_S", 10 * WAIT_S),  # a browser may stand still for longer than the usual limit
        patch.multiple(views, RATE_HZ=PICTURES_HZ, RATE_MAX_HZ=PICTURES_HZ, SMALL_PERIOD_S=1.0, UNAWAITED_PERIOD_S=2.0),
        RosbridgeServer(None, guests=[station], site=Site(station)) as serving,
        station.serving(serving.show),
    ):
        here = Desk(browser, station, serving)
        yield here
        for context in here.contexts:
            context.close()


@contextmanager
def desk(
    browser: Browser, folder: Path, scenario: str = "", keep_flights: Bounds | None = None, **choice: object
) -> Iterator[Desk]:
    """Serve a station, with `scenario` running (vehicle docked), or with the start screen if `scenario` is empty.

    keep_flights: of `Station`. choice: further arguments of `Station.start`.
    """
    with _serving(browser, Station(offered=scenario or "pool", folder=folder, keep_flights=keep_flights)) as here:
        if scenario:
            here.station.start({"scenario": scenario, "seed": 7, **choice})
        yield here


@contextmanager
def exercise_desk(browser: Browser, folder: Path, exercise: Exercise, **options: object) -> Iterator[Desk]:
    """Serve a station at which an exercise is flown. options: further arguments of `Station`."""
    station = Station(is_fixed=True, truth=False, folder=folder, **options)  # type: ignore[arg-type]
    with _serving(browser, station) as here:
        station.run_exercise(exercise)
        yield here


def shows(page: Page, selector: str, text: str, limit_s: float = WAIT_S) -> None:
    """Wait until an element of a page contains a text: it may follow from a later message than one just received."""
    when(page, f"document.querySelector({json.dumps(selector)})?.innerText.includes({json.dumps(text)})", limit_s)


WAIT = """async () => {
  for (const end = Date.now() + %d; Date.now() < end; await new Promise((done) => setTimeout(done, 20)))
    if (%s) return true;
  return false;
}"""


def when(page: Page | Frame, expression: str, limit_s: float = WAIT_S) -> None:
    """Wait until a JavaScript expression is true in a page. (Playwright's own wait needs eval, which pages forbid.)"""
    is_true = None
    while is_true is None:
        try:
            is_true = page.evaluate(WAIT % (1000 * limit_s, expression))
        except Error as error:  # while the page is loaded again
            if "context was destroyed" not in error.message:
                raise
    assert is_true, f"{expression} did not happen in {limit_s:g} s"


JUDGE = """async (part) => {
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
  const found = await axe.run(part, options);
  const wrong = listed(found.violations);
  let open = listed(found.incomplete).filter(isOpen).map(({ target }) => target[0]);
  while (open.length > 0) {
    const element = document.querySelector(open[0]);
    element?.scrollIntoView({ block: 'center', inline: 'center' });
    let left = new Map(open.map((each) => [each])); // all that may be seen now are computed at once
    if (element && isOnTop(element)) {
      const again = await axe.run({ include: open }, { ...options, runOnly: ['color-contrast'] });
      left = new Map(listed(again.incomplete).filter(isOpen).map((each) => [each.target[0], each]));
      wrong.push(...listed(again.violations), ...(left.has(open[0]) ? [left.get(open[0])] : []));
    }
    open = open.slice(1).filter((each) => left.has(each) && document.querySelector(each));
  }
  return wrong.map(({ id, html, any }) => [id, html.slice(0, 120), any[0]?.data?.messageKey ?? '']);
}"""


def judge(page: Page, what: str, part: str = "html") -> None:
    """Run axe to find accessibility problems for users with a screen reader, a keyboard or low vision.

    part: selector of what is judged. A contrast that axe leaves open, also where the text has been scrolled into view,
    counts as wrong, too, unless another element covers the text. Signs and single letters are computed like words.
    """
    if not page.evaluate("Boolean(globalThis.axe)"):
        page.evaluate(AXE.read_text())
    wrong = page.evaluate(JUDGE, part)
    assert not wrong, f"{what}: {wrong}"
