#!/usr/bin/env python3
"""The page of solvers has a row for a tiny graph, the wrong loop closures of it, and reports absent peers.

    solver_page_test.py SCRIPT TOOLS
"""

import math
import pathlib
import subprocess
import sys
import tempfile


def circle(path):
    """A circle of 24 poses in SE(2) that is walked twice, with small errors and loops between both rounds."""
    lines, step = [], 2 * math.pi / 24
    for i in range(48):
        lines.append(f"VERTEX_SE2 {i} {5 * math.sin(i * step)} {5 - 5 * math.cos(i * step)} {i * step}")
    chord, half = 10 * math.sin(step / 2), step / 2
    for i in range(47):
        error = 0.01 * math.sin(7 * i)
        lines.append(f"EDGE_SE2 {i} {i + 1} {chord * math.cos(half) + error} {chord * math.sin(half)} {step} "
                     "100 0 0 100 0 1000")
    for i in range(0, 24):
        lines.append(f"EDGE_SE2 {i} {i + 24} {0.01 * math.cos(5 * i)} 0 0 100 0 0 100 0 1000")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def main():
    script, tools = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        circle(folder / "circle.g2o")
        page = folder / "page.md"
        subprocess.run([sys.executable, script, f"--graphs={folder}", f"--tools={tools}", f"--output={page}",
                        "--gtsam=false", "--open3d=/none", "--ceres=/none", "--pcl=/none"], check=True)
        text = page.read_text(encoding="utf-8")
    assert "Peers: none. Absent: Ceres, GTSAM, Open3D, PCL." in text, text
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in text.splitlines() if line.startswith("| circle")]
    assert len(rows) == 3, rows
    assert rows[0][:3] == ["circle", "48", "71"], rows
    chordal, given = (float(cell.split(",")[0]) for cell in rows[0][3:])
    assert 0 < chordal < 1 and abs(chordal - given) < 1e-6, rows
    for row in rows[1:]:
        errors = [float(cell.split()[0]) for cell in row[2].split(",")]
        assert len(errors) == 3 and max(errors) < 0.05, rows


if __name__ == "__main__":
    main()
