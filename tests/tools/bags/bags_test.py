"""Frames in ROS bags give the run of the same frames in a folder: bags_test.py FOLDER_OF_PROGRAMS

Exits with 77 where a program that writes bags is missing, but only after what the others have
written is compared."""

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
            assert found == expected, f"{bag.name}: {found[0]} is not the folder's {expected[0]}"
            print(f"{bag.name}: {found[0]}, as the folder's")
    sys.exit(0 if len(bags) == 8 else 77)


if __name__ == "__main__":
    main()
