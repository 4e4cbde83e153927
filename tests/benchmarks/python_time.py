"""Compares the time of SLAM from Python with the time of surfit_slam, in alternating runs:

    python_time.py SEQUENCE [TURNS]

PYTHONPATH is the folder of the module, and SURFIT_TOOLS_DIR the folder of the programs. Both read
ahead. The time is from the begin of the first frame to the end of the last frame. The exit code is 1
if the digests differ.
"""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time

import surfit


def of_program(sequence):
    with tempfile.TemporaryDirectory() as output:
        subprocess.run([os.path.join(os.environ["SURFIT_TOOLS_DIR"], "surfit_slam"), "--nopictures",
                        f"--sequence={sequence}", f"--output={output}"], check=True,
                       stdout=subprocess.DEVNULL)
        with open(os.path.join(output, "summary.json"), encoding="utf-8") as file:
            summary = json.load(file)
    return summary["frame_ms"]["mean"] * summary["frames_total"] / 1000, summary["digest"]


def of_python(sequence):
    slam = surfit.Slam()
    begin = time.monotonic()
    for frame in surfit.Sequence(sequence):
        slam.process(frame)
    return time.monotonic() - begin, slam.digest


def main():
    sequence = sys.argv[1]
    turns = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    pairs = [(of_program(sequence), of_python(sequence)) for _ in range(turns)]
    for program, python in pairs:
        print(f"surfit_slam {program[0]:.2f} s, Python {python[0]:.2f} s: {python[0] / program[0]:.3f}")
    ratio = statistics.median(python[0] / program[0] for program, python in pairs)
    print(f"median ratio {ratio:.3f}")
    same = len({digest for pair in pairs for _, digest in pair}) == 1
    print("digests are equal" if same else "digests differ")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
