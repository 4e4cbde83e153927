"""Runs SLAM on a folder and shows the map with the path: slam_folder.py FOLDER [PICTURE]"""

import sys

import matplotlib.pyplot as plt
import surfit

slam = surfit.Slam()
for frame in surfit.Sequence(sys.argv[1]):
    report = slam.process(frame)
    print(f"frame {report.index}: {report.state}, {slam.surfel_count} surfels")

surfels = slam.surfels()
x, _, z = surfels.position_in_world[::10].T
plt.scatter(x, z, s=0.1, c=surfels.color[::10] / 255)
plt.plot(slam.poses[:, 0, 3], slam.poses[:, 2, 3], color="red")
plt.gca().set(aspect="equal", xlabel="x, m", ylabel="z, m", title="From above")
if len(sys.argv) > 2:
    plt.savefig(sys.argv[2], dpi=150)
else:
    plt.show()
