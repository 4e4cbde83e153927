#!/usr/bin/env python3
"""Shows a frame next to the map views of several runs from its pose:

    surfit_slam --sequence=DIR --output=before --hold_out=10 --nofinal_map
    surfit_slam --sequence=DIR --output=after --hold_out=10
    for run in before after; do surfit_evaluate --what=views --run=$run; done
    tools/scripts/compare_views.py --frame=99 --output=looks.jpg before after

The picture shows the frame on the left, followed by the view of each run (one of its view_pictures).
surfit_evaluate writes the 12 worst views. For more, set `pictures` of surfit.ViewEvaluationOptions in Python.
Without --frame, the top views in map_color.png of the runs are shown:

    tools/scripts/compare_views.py --output=maps.jpg before after

Requires the Debian package python3-opencv.
"""

import argparse
import csv
import sys

import cv2
import numpy as np

HEADER_PX = 28  # height of the caption of view_pictures
# Layout of map_color.png: height of the title, and size of the first of four cells without its
# caption.
TITLE_PX, CELL_WIDTH_PX, CELL_HEIGHT_PX = 76, 800, 600


def view_of(run, frame):
    """The frame and the map view, from a picture in view_pictures."""
    with open(f"{run}/views.csv", encoding="utf-8") as file:
        views = list(csv.DictReader(file))
    # Pictures are numbered from the worst to the best view.
    views.sort(key=lambda view: float(view["psnr_covered_db"]))
    for rank, view in enumerate(views):
        if int(view["frame"]) != frame:
            continue
        picture = cv2.imread(f"{run}/view_pictures/{rank:02d}.png")
        if picture is None:
            break
        width = picture.shape[1] // 3
        return picture[HEADER_PX:, :width], picture[HEADER_PX:, width:2 * width]
    sys.exit(f"error: {run} has no picture of frame {frame}")


def map_from_above(run):
    picture = cv2.imread(f"{run}/map_color.png")
    if picture is None:
        sys.exit(f"error: {run} has no map_color.png")
    return picture[TITLE_PX:TITLE_PX + CELL_HEIGHT_PX, :CELL_WIDTH_PX]


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frame", type=int)
    parser.add_argument("--output", required=True)
    parser.add_argument("--width", type=int, default=1500, help="width of the picture, px")
    parser.add_argument("runs", nargs="+")
    args = parser.parse_args()
    if args.frame is None:
        row = np.hstack([map_from_above(run) for run in args.runs])
    else:
        views = [view_of(run, args.frame) for run in args.runs]
        row = np.hstack([views[0][0]] + [view for _, view in views])
    height = round(row.shape[0] * args.width / row.shape[1])
    row = cv2.resize(row, (args.width, height), interpolation=cv2.INTER_AREA)
    if not cv2.imwrite(args.output, row, [cv2.IMWRITE_JPEG_QUALITY, 85]):
        sys.exit(f"error: cannot write {args.output}")


if __name__ == "__main__":
    main()
