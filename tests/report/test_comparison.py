"""The page of a solver comparison: complete, without network requests, with correct figures."""

import json
import math
import pathlib

import pytest
from report_page import frame_drawn, run_tool


@pytest.fixture(scope="module")
def output(tmp_path_factory):
    folder = tmp_path_factory.mktemp("comparison")
    done = run_tool("surfit_compare_solvers", "--synthetic_points=500", "--threads=1,2",
                    "--rotations_deg=1,5,170", "--translations_m=0.01,0.1,0.3", f"--output={folder}",
                    "--solver=closed_form_ldlt,ceres", "--residual=point_to_plane,point_to_point")
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture(scope="module")
def rows(output):
    return json.loads((output / "comparison.json").read_text())["rows"]


@pytest.fixture(scope="module", autouse=True)
def page(browser, output):
    browser.get_log("browser")  # clears messages of other pages
    browser.get(pathlib.Path(output / "comparison.html").resolve().as_uri())


def test_opens_from_disk_without_errors_or_network(browser):
    assert browser.execute_script("return document.documentElement.dataset.readyMs")
    assert browser.get_log("browser") == []
    urls = browser.execute_script("return performance.getEntriesByType('resource').map((e) => e.name)")
    assert [url for url in urls if not url.startswith("data:")] == []


def test_dot_positions_are_logarithmic(browser, rows):
    """Positions of the dots are linear in the logarithm of time, between powers of ten."""
    times = [[row[key] for key in ("linearize_ms", "solve_ms", "total_ms") if row[key]] for row in rows]
    lines = browser.execute_script(
        "return [...document.querySelectorAll('#times tbody .dots')].map((dots) =>"
        "[...dots.children].map((dot) => parseFloat(dot.style.left)))")
    assert [len(line) for line in lines] == [len(line) for line in times]
    logs = [math.log10(time) for line in times for time in line]
    low, high = math.floor(min(logs)), math.ceil(max(logs))
    assert [left for line in lines for left in line] == pytest.approx(
        [100 * (log - low) / (high - low) for log in logs], abs=0.01)


def test_ratios_equal_those_of_the_runs(browser, rows):
    """Mean values of the table cells equal the ratios over all runs. Each row with one thread has a table."""
    tables = browser.execute_script(
        "return [...document.querySelectorAll('.shares')].map((table) =>"
        "[...table.querySelectorAll('td')].map((cell) => Number(cell.textContent)))")
    once = [row for row in rows if row["threads"] == 1]
    assert sorted(sum(table) / len(table) for table in tables) == pytest.approx(
        sorted(100 * row["converged_ratio"] for row in once), abs=0.5)
    assert all(len(table) == 9 for table in tables)


def test_plots_the_loss_of_each_solver(browser, rows):
    browser.execute_script("document.getElementById('losses').scrollIntoView()")
    frame_drawn(browser)
    plotted = browser.execute_script(
        "return surfit.charts.map((c) => [c.options.plugins.title.text, c.data.datasets.map((d) => d.label)])")
    names = ["closed_form_ldlt", "ceres"]
    assert dict(plotted) == {"point_to_plane, known": names, "point_to_point, known": names}
    first = browser.execute_script("return surfit.charts[0].data.datasets[0].data")
    assert len(first) > 1 and first[0]["y"] > first[-1]["y"]
    assert browser.get_log("browser") == []
