"""The page of a recorded run of 1000 frames: its size, and the time to open it."""

import os
import pathlib

import pytest
from report_page import Page, expect_every_mode_drawn, run_tool

KITCHEN = pathlib.Path(os.environ.get("SURFIT_DATA_DIR", os.environ["SURFIT_DEFAULT_DATA_DIR"]),
                       "seven_scenes_kitchen")


@pytest.mark.skipif(not KITCHEN.is_dir(), reason=f"{KITCHEN} is missing")
def test_opens_fast_and_is_small(browser, tmp_path):
    done = run_tool("surfit_slam", f"--sequence={KITCHEN}", f"--output={tmp_path}", "--last=999",
                    "--nopictures", "--report")
    assert done.returncode == 0, done.stderr
    report = tmp_path / "report.html"
    page = Page(browser, report)
    print(f"{report.stat().st_size / 1e6:.1f} MB, opened in {page.seconds_to_open:.1f} s, "
          f"all points drawn after {page.seconds_to_complete:.1f} s")
    assert report.stat().st_size < 30e6
    assert page.seconds_to_open < 5
    assert page.console() == []
    expect_every_mode_drawn(page)
