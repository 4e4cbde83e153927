"""Runs on ROS bags equal the run on a folder with the same frames: bags_test.py FOLDER_OF_PROGRAMS

If a program that writes bags is missing, the test exits with code 77 after the comparison of the
other bags."""

import json
import pathlib
import subprocess
import sys
import tempfile

PROGRAMS = pathlib.Path(sys.argv[1])
HERE = pathlib.Path(__file__).resolve().parent


def digest(sequence, output, *flags):
    subprocess.run([PROGRAMS / "surfit_slam", f"--sequence={sequence}", f"--output={output}",
                    "--nopictures", *flags], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    return (json.loads((output / "summary.json").read_text())["digest"],
            (output / "trajectory.txt").read_text())


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        subprocess.run([PROGRAMS / "surfit_simulate", f"--output={folder}/room", "--frames=8",
                        "--downsample=4"], check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)
        written = subprocess.run([sys.executable, HERE / "write_bags.py", folder / "room",
                                  folder / "bags"], check=True, stdout=subprocess.PIPE, text=True)
        print(written.stdout, end="")
        expected = digest(folder / "room", folder / "of_folder")
        bags = sorted((folder / "bags").iterdir())
        for bag in bags:
            found = digest(bag, folder / f"of_{bag.name}", "--depth_scale=5000")
            assert found == expected, f"{bag.name}: {found[0]} differs from the folder: {expected[0]}"
            print(f"{bag.name}: {found[0]}, equal to the folder")
    sys.exit(0 if len(bags) == 8 else 77)


if __name__ == "__main__":
    main()
