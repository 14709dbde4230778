"""One browser for each worker, and for each test a server that says what the test wants."""

import os
import pathlib
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import page_server
from page_driver import Page, start_browser


@pytest.fixture(scope="session")
def browser():
    """A Chromium without a window."""
    driver = start_browser()
    yield driver
    driver.quit()


@pytest.fixture
def server():
    """A server without a robot."""
    one = page_server.PageServer()
    yield one
    one.close()


@pytest.fixture
def page(browser, server):
    """A page that is not open yet, on a screen of 1280 x 800."""
    one = Page(browser, server)
    yield one
    one.leave()


@pytest.fixture
def module(page):
    """Run checks in the page: call it with the name of a module, and a body in which `m` is the module."""
    page.go("empty.html")
    return page.module


assert os.path.exists("/usr/bin/chromedriver"), "these tests need chromium-driver: apt-get install chromium-driver"
