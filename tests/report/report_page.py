"""Reports in headless Chromium with WebGL on the CPU."""

import io
import os
import pathlib
import re
import subprocess
import time

import pytest

webdriver = pytest.importorskip("selenium.webdriver", reason="Selenium (python3-selenium) is missing")
pil_image = pytest.importorskip("PIL.Image", reason="Pillow (python3-pil) is missing")

from selenium.webdriver.chrome.service import Service  # noqa: E402
from selenium.webdriver.common.by import By  # noqa: E402
from selenium.webdriver.support.ui import Select, WebDriverWait  # noqa: E402

DRIVER = pathlib.Path("/usr/bin/chromedriver")
MODES = ["color", "normal", "confidence", "last_seen", "first_seen"]


def run_tool(name, *flags):
    return subprocess.run([os.path.join(os.environ["SURFIT_TOOLS_DIR"], name), *flags],
                          capture_output=True, text=True, check=False)


def open_browser():
    if not DRIVER.exists():
        pytest.skip("Chromium's driver (chromium-driver) is missing")
    options = webdriver.ChromeOptions()
    for flag in ["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--use-angle=swiftshader",
                 "--enable-unsafe-swiftshader", "--window-size=1400,1000"]:
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(options=options, service=Service(str(DRIVER)))


@pytest.fixture(scope="session")
def browser():
    driver = open_browser()
    yield driver
    driver.quit()


def numbers(text):
    """The numbers in a text, as strings."""
    return re.findall(r"-?\d+(?:\.\d+)?", text)


def frame_drawn(browser):
    """Waits until the page has drawn the requested frame."""
    browser.execute_async_script("const done = arguments[0];"
                                 "requestAnimationFrame(() => requestAnimationFrame(() => done()))")


class Page:
    """A report opened from disk; seconds_to_open includes the first picture, of a part of the points,
    and seconds_to_complete the one of all of them."""

    def __init__(self, browser, path):
        self.browser = browser
        begin = time.monotonic()
        browser.get(pathlib.Path(path).resolve().as_uri())
        frame_drawn(browser)
        self.seconds_to_open = time.monotonic() - begin
        self.wait_for_all_points()
        self.seconds_to_complete = time.monotonic() - begin

    def wait_until(self, condition, *arguments):
        """Waits until a JavaScript condition with these `arguments` is true. Returns its value."""
        return WebDriverWait(self.browser, 60, poll_frequency=0.02).until(
            lambda _: self.script(f"return {condition}", *arguments), condition)

    def wait_for_all_points(self):
        self.wait_until("surfit.mapView.isComplete")
        frame_drawn(self.browser)

    def scroll_to(self, element_id):
        """Shows an element, and waits for its plots and pictures: they are made once they are seen, in
        an order that the browser chooses."""
        self.script("document.getElementById(arguments[0]).scrollIntoView()", element_id)
        self.wait_until("[...document.querySelectorAll(`#${arguments[0]} :is(.chart, .pictures)`)]"
                        ".every((box) => box.firstChild)", element_id)
        frame_drawn(self.browser)

    def console(self):
        return self.browser.get_log("browser")

    def script(self, text, *arguments):
        return self.browser.execute_script(text, *arguments)

    def map_picture(self):
        """Picture of the 3D view, an RGB image of Pillow."""
        frame_drawn(self.browser)
        self.wait_for_all_points()
        png = self.browser.find_element(By.ID, "map-canvas").screenshot_as_png
        return pil_image.open(io.BytesIO(png)).convert("RGB")

    def choose_mode(self, mode):
        Select(self.browser.find_element(By.ID, "color-mode")).select_by_value(mode)

    def click(self, name):
        element = self.browser.find_element(By.ID, name)
        self.script(f"document.getElementById('{element.get_attribute('id')}').click()")


def simulate_room(folder, frames):
    """Simulates a sequence of a room. Returns its path."""
    room = str(folder / "room")
    made = run_tool("surfit_simulate", f"--output={room}", f"--frames={frames}", "--downsample=4")
    assert made.returncode == 0, made.stderr
    return room


def run_slam(room, output, *flags):
    done = run_tool("surfit_slam", f"--sequence={room}", f"--output={output}", "--nopictures", *flags)
    assert done.returncode == 0, done.stderr


def drawn_ratio(picture):
    """Ratio of pixels that differ from the background, which is the colour of the first corner."""
    background = picture.getpixel((0, 0))
    pixels = list(picture.getdata())
    return sum(pixel != background for pixel in pixels) / len(pixels)


def differing_ratio(a, b):
    pairs = list(zip(a.getdata(), b.getdata()))
    return sum(p != q for p, q in pairs) / len(pairs)


def expect_every_mode_drawn(page):
    """Expects that each colour mode shows the map, and that all modes differ."""
    page.click("show-estimate")  # only the map
    page.click("show-truth")
    page.click("show-cameras")
    pictures = {}
    for mode in MODES:
        page.choose_mode(mode)
        pictures[mode] = page.map_picture()
        assert drawn_ratio(pictures[mode]) > 0.1, mode
    for i, mode in enumerate(MODES):
        for other in MODES[i + 1:]:
            assert differing_ratio(pictures[mode], pictures[other]) > 0.05, (mode, other)
