# %% [markdown]
# # From a folder of images to a map
#
# Notebook cells for VS Code, Spyder and Jupytext. As a script, `tour.py FOLDER PICTURES` writes
# each picture into a folder.

# %%
import pathlib
import sys

import matplotlib.pyplot as plt
import numpy as np
import surfit

folder, pictures = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])


def show(name):
    """Writes the picture; in a notebook, use plt.show()."""
    plt.savefig(pictures / f"{name}.png", dpi=80, bbox_inches="tight")
    plt.close()


# %% [markdown]
# ## Recorded images
# Depth is in metres; 0 is missing. Poses are 4 x 4 arrays, world_from_camera.

# %%
sequence = surfit.Sequence(folder)
first = next(sequence)
_, (left, right) = plt.subplots(1, 2, figsize=(10, 4))
left.imshow(first.color)
shown = right.imshow(np.where(first.depth_m > 0, first.depth_m, np.nan))
plt.colorbar(shown, label="depth, m")
show("frame")

# %% [markdown]
# ## SLAM, frame by frame
# Each report contains the state of a frame, the result of its registration, and times.

# %%
slam = surfit.Slam(surfit.SlamOptions(), sequence.camera)
reports = [slam.process(first)] + [slam.process(frame) for frame in sequence]
tracked = sum(report.state == "tracked" for report in reports)
print(f"{tracked} of {len(reports)} frames tracked, {slam.surfel_count} surfels")
indices = [report.index for report in reports]
plt.stackplot(indices, [report.times.track_ms for report in reports],
              [report.times.fuse_ms for report in reports], labels=["tracking", "fusion"])
plt.gca().set(xlabel="frame", ylabel="time, ms")
plt.legend()
show("time")

# %% [markdown]
# ## Map from above, with the path of the camera

# %%
surfels = slam.surfels()
x, _, z = surfels.position_in_world[::5].T
plt.scatter(x, z, s=1, c=surfels.color[::5] / 255)
plt.plot(slam.poses[:, 0, 3], slam.poses[:, 2, 3], color="red")
plt.gca().set(aspect="equal", xlabel="x, m", ylabel="z, m")
show("map")

# %% [markdown]
# ## Error, if ground truth is available

# %%
truth = folder / "groundtruth.txt"
if truth.exists():
    error = surfit.evaluate(truth, slam.trajectory).ate.translation_m
    print(f"absolute trajectory error {1000 * error.rmse:.1f} mm")

# %% [markdown]
# ## Mesh of the map

# %%
slam.write_map(pictures / "map.ply")
mesh = surfit.make_mesh(surfit.read_point_cloud(pictures / "map.ply"),
                        surfit.MeshOptions(cell_m=0.05))
print(f"{len(mesh.vertices)} vertices, {len(mesh.triangles)} triangles")
axes = plt.figure().add_subplot(projection="3d")
axes.plot_trisurf(*mesh.vertices[:, [0, 2, 1]].T, triangles=mesh.triangles, linewidth=0)
axes.invert_zaxis()  # y points down
show("mesh")
