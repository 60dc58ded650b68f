"""A station's token: the page that asks for it, the ways to give it, and wrong ones."""

import logging
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from uwsim.bridges import RosbridgeServer
from uwsim.bridges.doors import admission
from uwsim.bridges.doors.admission import has_token
from uwsim.cli.access import Access
from uwsim.operator.station import Site, Station

pytest.importorskip("playwright", reason="needs playwright")
from browser import when
from listening_sockets import status, upgrade

TOKEN = "correct-horse"
UWSIM = [sys.executable, "-c", "from uwsim.cli import main; main()"]


def test_a_page_without_the_token_asks_for_it_and_opens_with_it(browser) -> None:
    station = Station()
    site = Site(station, lambda request: has_token(request, TOKEN))
    with (
        RosbridgeServer(None, guests=[station], site=site, token=TOKEN) as server,
        station.serving(server.show),
    ):
        page = browser.new_context(viewport={"width": 1280, "height": 800}).new_page()
        url = server.url.replace("ws", "http", 1)
        page.goto(f"{url}/?theme=dark#later")
        assert page.inner_text("h1") == "This station asks for a token"
        assert "no token" in page.inner_text("[role=status]")
        if "UWSIM_PICTURES" in os.environ:
            page.screenshot(path=Path(os.environ["UWSIM_PICTURES"]) / "token.png")
        page.fill("#token", "wrong-horse")
        page.click("button")
        when(page, "document.querySelector('[role=status]')?.innerText.includes('wrong')")
        page.fill("#token", TOKEN)
        page.click("button")
        page.wait_for_selector("#start:not([hidden])")
        assert "theme=dark" in page.url


def test_a_wrong_token_is_delayed_and_logged(caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(admission, "WRONG_S", 0.5)
    with RosbridgeServer(None, token=TOKEN) as server, caplog.at_level(logging.WARNING):
        begun_s = time.monotonic()
        assert upgrade(server.port, "/?token=wrong-horse") == 401
        assert time.monotonic() - begun_s > 0.5
        assert upgrade(server.port, f"/?token={TOKEN}") == 101
    assert "a wrong token came from 127.0.0.1" in caplog.text and "wrong-horse" not in caplog.text


def test_a_token_comes_from_the_option_the_file_or_the_environment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "token"
    file.write_text(f"{TOKEN}\n")
    assert Access(token_file=file).settings("127.0.0.1")["token"] == TOKEN
    monkeypatch.setenv("UWSIM_TOKEN", "from-outside")
    assert Access().settings("127.0.0.1")["token"] == "from-outside"
    assert Access(token_file=file).settings("127.0.0.1")["token"] == TOKEN
    assert Access(token="by-option").settings("127.0.0.1")["token"] == "by-option"
    with pytest.raises(ValueError, match="--token: cannot be given with --token-file"):
        Access(token="by-option", token_file=file).settings("127.0.0.1")
    monkeypatch.setenv("UWSIM_TOKEN", "")
    with pytest.raises(ValueError, match="UWSIM_TOKEN is empty"):
        Access().settings("127.0.0.1")
    monkeypatch.delenv("UWSIM_TOKEN")
    assert Access().settings("127.0.0.1")["token"] is None
    file.write_text("\n")
    with pytest.raises(ValueError, match="is empty"):
        Access(token_file=file).settings("127.0.0.1")


def test_a_token_from_a_file_is_visible_to_nobody(tmp_path: Path) -> None:
    """Neither in the options of the process nor in what it prints."""
    file = tmp_path / "token"
    file.write_text(TOKEN)
    command = [*UWSIM, "serve", "pool", "--port", "0", "--station", "--token-file", str(file)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            greeting = process.stdout.readline()
            assert "the station's page at" in greeting and TOKEN not in greeting
            assert TOKEN not in Path(f"/proc/{process.pid}/cmdline").read_text()
            port = int(greeting.split(" at ws://127.0.0.1:")[1].split(",")[0])
            assert (status(port), status(port, path=f"/?token={TOKEN}")) == (401, 200)
        finally:
            process.terminate()
