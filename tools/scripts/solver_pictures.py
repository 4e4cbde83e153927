#!/usr/bin/env python3
"""Creates the pictures of docs/understand.md from two pages of surfit_compare_solvers:

    tools/scripts/solver_pictures.py KNOWN_PAIRS/comparison.html FRAMES/comparison.html
"""

import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "report"))

from report_page import By, open_browser  # noqa: E402


def take(browser, page, section, picture):
    browser.get(pathlib.Path(page).resolve().as_uri())
    if browser.execute_script("return document.documentElement.dataset.theme") == "light":
        browser.find_element(By.ID, "theme").click()
    element = browser.find_element(By.ID, section)
    browser.execute_script("arguments[0].scrollIntoView()", element)
    element.screenshot(str(picture))


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    browser = open_browser()
    browser.set_window_size(1500, 2400)
    try:
        take(browser, sys.argv[1], "times", ROOT / "docs" / "solvers_time.png")
        take(browser, sys.argv[2], "basins", ROOT / "docs" / "solvers_basin.png")
    finally:
        browser.quit()


if __name__ == "__main__":
    main()
