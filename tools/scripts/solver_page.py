#!/usr/bin/env python3
"""Creates docs/solvers.md: Surfit and its peers on public pose graphs and cloud pairs.

    tools/scripts/solver_page.py --graphs=DIR [--pairs=DIR] [--tools=DIR] [--output=FILE] [PEERS]

DIR of --graphs contains .g2o files. DIR of --pairs contains pairs.csv with the columns name, source, target, truth,
center and max_m. `truth` is a file with the 4 x 4 matrix target_from_source. `center` is the centroid of the source,
"x y z" in m, and `max_m` the largest correct position error of the centroid. Peers that are not installed are
reported as absent:

    --ceres   folder with the programs pose_graph_2d and pose_graph_3d of examples/slam of Ceres
    --gtsam   command of a Python with the module gtsam (Debian 13: python3-gtsam)
    --open3d  command of a Python with the module open3d (Debian 12: python3-open3d)
    --pcl     folder with the program pcl_icp (Debian 12: pcl-tools); requires --open3d, which thins the clouds

Requires numpy.
"""

import argparse
import csv
import datetime
import json
import pathlib
import resource
import shlex
import shutil
import subprocess
import sys
import tempfile
import time

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
LIMIT_S = 120  # processor seconds of a program
WRONG_SHARES, WRONG_DRAWS, WRONG_MAX_EDGES = (0.2, 0.5), 3, 2600
MAX_DEGREES = 2  # of a correct registration
PEER_POINTS = 30000  # maximum number of points of a cloud at the finest voxel size of Open3D

HEAD = """# Solvers and their peers

`tools/scripts/solver_page.py` created this page on {date} from commit {commit}. {machine}.
Peers: {found}. Absent: {absent}. Times are processor seconds of one run. Other
programs on the machine increase them.

## Pose graphs

Cells are the final cost in the metric of `surfit_optimize` ([error](understand.md#loop-closure-and-pose-graph)) and
the time. "Chordal" and "given" are values of `--start`. Ceres is the example program of Ceres, which starts from the
given poses. GTSAM is Levenberg-Marquardt from chordal poses, in SE(2) from LAGO or the given poses. Peers minimise
costs of their own. The last column is the cost of the result of "Surfit, chordal" in the metric of GTSAM, relative to
the result of GTSAM. "No result" is an error or the limit of {limit} s. Times of Surfit include the start of the
process, the chi-square test and the output files. Times of GTSAM include the input file only.

"""
WRONG = """
## Wrong loop closures

Cells are the ATE in m to the optimum without wrong loop closures, of {draws} draws with GNC. Wrong loop closures are a
ratio of the loop closures of the graph. They connect random poses, with a random rotation and a translation of 5 % of
the size of the graph. GTSAM is its GNC optimiser with trusted odometry and the threshold of 99.9 %.

"""
PAIRS = """
## Pairs of clouds

A registration is right up to {degrees} degrees, and up to the given error of the centroid of the source. Surfit is
`surfit_register` with default options on all points. "Refused" is exit code 2. Peers use at most {points:,} points
of a cloud, in voxels of size v. Open3D is point to plane at 8 v, 4 v, 2 v and v from the identity, and from 4 v after
RANSAC over FPFH features at 2 v. PCL is `pcl_icp` from the identity at v with a gate of 24 v.

"""


class Graph:
    """Lines of a .g2o file by id. Files without vertices get chained poses."""

    def __init__(self, path, tools, folder):
        out = folder / "prepared.g2o"  # has positive semidefinite information matrices
        surfit_graph(tools, path, out, "--start=given", "--max_graph_iterations=1")
        self.edges = [line.split() for line in out.read_text().splitlines() if line.startswith("EDGE")]
        lines = [line.split() for line in path.read_text().splitlines()]
        self.planar = self.edges[0][0] == "EDGE_SE2"
        self.vertices = {int(w[1]): w[2:] for w in lines if w and w[0].startswith("VERTEX")} or self.chain()
        rank = {id_: i for i, id_ in enumerate(sorted(self.vertices))}
        self.loops = [e for e in self.edges if abs(rank[int(e[1])] - rank[int(e[2])]) != 1]

    def chain(self):
        poses = {int(self.edges[0][1]): [0, 0, 0]}
        for _, a, b, dx, dy, turn, *_ in self.edges:
            if int(a) in poses and int(b) not in poses:
                x, y, angle = poses[int(a)]
                c, s = np.cos(angle), np.sin(angle)
                poses[int(b)] = [x + c * float(dx) - s * float(dy), y + s * float(dx) + c * float(dy),
                                 angle + float(turn)]
        return poses

    def write(self, path, vertices=None, more=()):
        tag = "VERTEX_SE2" if self.planar else "VERTEX_SE3:QUAT"
        rows = [[tag, id_, *pose] for id_, pose in (vertices or self.vertices).items()] + self.edges + list(more)
        path.write_text("".join(" ".join(map(str, row)) + "\n" for row in rows))

    def wrong_loops(self, ratio, seed):
        """Random edges between poses more than 10 apart, with the information of a random loop."""
        random, ids, added = np.random.default_rng(seed), sorted(self.vertices), []
        size = 3 if self.planar else 7
        spread = 0.05 * np.sqrt(positions(self.vertices).var(0).sum())
        while len(added) < ratio * len(self.loops):
            a, b = sorted(random.integers(0, len(ids), 2))
            if b - a <= 10:
                continue
            loop = self.loops[random.integers(len(self.loops))]
            turn = [random.uniform(-np.pi, np.pi)]
            if not self.planar:
                turn = random.normal(size=4)
                turn /= np.linalg.norm(turn)
            move = random.normal(0, spread, 2 if self.planar else 3)
            added.append([loop[0], ids[a], ids[b], *move, *turn, *loop[3 + size:]])
        return added


def read_poses(path):
    """Numbers by id, of vertices of a .g2o file or of rows with id and pose."""
    rows = (line.replace("VERTEX_SE2", "").replace("VERTEX_SE3:QUAT", "").split()
            for line in path.read_text().splitlines())
    return {int(w[0]): w[1:] for w in rows if w and w[0].isdigit()}


def positions(vertices):
    """The first two or three numbers of the poses, by id."""
    return np.array([list(map(float, vertices[id_][:3 if len(vertices[id_]) == 7 else 2])) for id_ in sorted(vertices)])


def rmse_after_alignment(a, b):
    p, q = a - a.mean(0), b - b.mean(0)
    u, _, vt = np.linalg.svd(q.T @ p)
    u[:, -1] *= np.sign(np.linalg.det(u @ vt))
    return float(np.sqrt(((p @ (u @ vt).T - q) ** 2).sum(1).mean()))


def run(command, folder):
    """Exit code, standard output and processor seconds. Exit codes: negative after LIMIT_S, None without a program."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    try:
        done = subprocess.run([str(word) for word in command], cwd=folder, capture_output=True, text=True,
                              preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (LIMIT_S, LIMIT_S)))
    except FileNotFoundError:
        return None, "", 0
    if done.returncode not in (0, 2):
        print(*command, f"exit code {done.returncode}", done.stderr[-500:], file=sys.stderr)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done.returncode, done.stdout, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def surfit_graph(tools, path, out, *flags):
    """Summary and processor seconds; (None, 0) without a result. Writes the optimised graph to `out`."""
    summary = out.with_suffix(".json")
    code, _, seconds = run([tools / "surfit_optimize", f"--graph={path}", f"--output={out}", f"--summary={summary}",
                            "--indefinite_information=blocks", *flags], out.parent)
    return (json.loads(summary.read_text()), seconds) if code in (0, 2) else (None, 0)


def gtsam_peer(path, out, rival):
    """Optimises a graph from chordal poses. Writes rows of id and pose. `rival`: "gnc", or a result to evaluate."""
    import gtsam
    begin = time.process_time()
    planar = "VERTEX_SE2" in pathlib.Path(path).read_text()
    graph, given = gtsam.readG2o(path, not planar)
    measured = gtsam.NonlinearFactorGraph(graph)
    first, size = min(given.keys()), graph.size()
    noise = gtsam.noiseModel.Isotropic.Sigma(3 if planar else 6, 1e-6)
    graph.add(gtsam.PriorFactorPose2(first, given.atPose2(first), noise) if planar else
              gtsam.PriorFactorPose3(first, given.atPose3(first), noise))
    try:
        initial = gtsam.lago.initialize(graph) if planar else gtsam.InitializePose3.initialize(graph)
    except (IndexError, ValueError):  # LAGO fails on some graphs
        initial = given
    optimizer = gtsam.LevenbergMarquardtOptimizer(graph, initial)
    if rival == "gnc":
        rank = {key: i for i, key in enumerate(sorted(given.keys()))}
        ends = [[rank[key] for key in graph.at(i).keys()] for i in range(size)]
        params = gtsam.GncLMParams()
        params.setKnownInliers([*(i for i in range(size) if abs(ends[i][0] - ends[i][1]) == 1), size])
        optimizer = gtsam.GncLMOptimizer(graph, initial, params)
        optimizer.setInlierCostThresholdsAtProbability(0.999)
    found = optimizer.optimize()
    seconds = time.process_time() - begin
    with open(out, "w", encoding="utf-8") as file:
        for key in given.keys():
            pose = found.atPose2(key) if planar else found.atPose3(key)
            numbers = [pose.x(), pose.y(), *([pose.theta()] if planar else [pose.z()])]
            if not planar:
                q = pose.rotation().toQuaternion()
                numbers += [q.x(), q.y(), q.z(), q.w()]
            print(key, *numbers, file=file)
    ratio = None if rival == "gnc" else measured.error(gtsam.readG2o(rival, not planar)[1]) / measured.error(found)
    print(json.dumps([seconds, ratio]))


def open3d_peer(source, target, method):
    """Registers two clouds by point to plane, with "global" from RANSAC over FPFH. "thin": thins them for PCL.

    Writes pose.txt with target_from_source, or source.pcd and target.pcd.
    """
    import open3d
    begin = time.process_time()
    reg, search = open3d.pipelines.registration, open3d.geometry.KDTreeSearchParamHybrid
    clouds = [open3d.io.read_point_cloud(path).remove_non_finite_points() for path in (source, target)]
    clouds = [cloud.remove_duplicated_points() for cloud in clouds]
    finest = max(float(np.median(cloud.compute_nearest_neighbor_distance())) for cloud in clouds)
    while max(len(cloud.voxel_down_sample(finest).points) for cloud in clouds) > PEER_POINTS:
        finest *= 1.2
    pose, scales = np.eye(4), (8, 4, 2, 1)

    def thinned(voxel):
        thin = [cloud.voxel_down_sample(voxel) for cloud in clouds]
        for cloud in thin:
            cloud.estimate_normals(search(2 * voxel, 30))
        return thin

    if method == "thin":
        for name, cloud in zip(("source.pcd", "target.pcd"), clouds):
            open3d.io.write_point_cloud(name, open3d.geometry.PointCloud(cloud.voxel_down_sample(finest).points))
        return print(json.dumps(24 * finest))
    if method == "global":
        scales, voxel = (4, 2, 1), 2 * finest
        thin = thinned(voxel)
        features = [reg.compute_fpfh_feature(cloud, search(5 * voxel, 100)) for cloud in thin]
        checks = [reg.CorrespondenceCheckerBasedOnEdgeLength(0.9),
                  reg.CorrespondenceCheckerBasedOnDistance(1.5 * voxel)]
        pose = reg.registration_ransac_based_on_feature_matching(
            *thin, *features, True, 1.5 * voxel, reg.TransformationEstimationPointToPoint(False), 3, checks,
            reg.RANSACConvergenceCriteria(100000, 0.999)).transformation
    for scale in scales:
        pose = reg.registration_icp(
            *thinned(scale * finest), 3 * scale * finest, pose, reg.TransformationEstimationPointToPlane(),
            reg.ICPConvergenceCriteria(max_iteration=100)).transformation
    np.savetxt("pose.txt", pose)
    return print(json.dumps(time.process_time() - begin))


class Page:
    """Rows of the tables. Peers that are not installed have no column."""

    def __init__(self, options, folder):
        self.tools, self.folder = options.tools.resolve(), folder
        script = pathlib.Path(__file__).resolve()
        self.found = {}
        for name in ("gtsam", "open3d"):
            command = shlex.split(getattr(options, name))
            if run([*command, "-c", f"import numpy, {name}"], folder)[0] == 0:
                self.found[name] = [*command, script, f"--peer={name}"]
        for name, program in (("ceres", "pose_graph_3d"), ("pcl", "pcl_icp")):
            path = shutil.which(program, path=getattr(options, name))
            if path and (name != "pcl" or "open3d" in self.found):
                self.found[name] = pathlib.Path(path).resolve().parent

    def python_peer(self, name, *arguments):
        """Number or list that a Python peer reports; None: no result."""
        code, text, _ = run([*self.found[name], *arguments], self.folder)
        return json.loads(text.splitlines()[-1]) if code == 0 else None

    def peer_poses(self, name, graph, path, rival):
        """Poses by id, processor seconds and ratio of costs in the metric of GTSAM; None: no result."""
        out = self.folder / "poses_optimized.txt"
        if name == "gtsam":
            reported = self.python_peer(name, path, out, rival)
        else:
            program = self.found[name] / ("pose_graph_2d" if graph.planar else "pose_graph_3d")
            code, _, seconds = run([program, f"--input={path}"], self.folder)
            reported = [seconds, None] if code == 0 else None
        return reported and (read_poses(out), *reported)

    def graph_row(self, name, graph):
        path, best, out = (self.folder / f"{word}.g2o" for word in ("graph", "chordal", "out"))
        graph.write(path)
        cells = [name, len(graph.vertices), len(graph.edges)]
        for start, out in (("chordal", best), ("given", out)):
            summary, seconds = surfit_graph(self.tools, path, out, f"--start={start}")
            if summary is None:
                cells.append("no result")
                continue
            at_limit = " (limit)" * (summary["termination"] == "max_iterations")
            cells.append(f"{summary['final_cost']:.7g}, {seconds:.2f} s{at_limit}")
        ratio = None
        for peer in self.graph_peers():
            result = self.peer_poses(peer, graph, path, best)
            cells.append("no result")
            if result:
                poses, seconds, ratio = result
                graph.write(self.folder / "peer.g2o", poses)
                summary, _ = surfit_graph(self.tools, self.folder / "peer.g2o", out, "--start=given",
                                          "--max_graph_iterations=1")
                cells[-1] = f"{summary['given_cost']:.7g}, {seconds:.2f} s"
        return cells + [f"{ratio:.6f}" if ratio else ""] * ("gtsam" in self.found)

    def graph_peers(self):
        return [name for name in ("ceres", "gtsam") if name in self.found]

    def wrong_loop_row(self, name, graph, ratio):
        path, out = self.folder / "graph.g2o", self.folder / "out.g2o"
        graph.write(path)
        surfit_graph(self.tools, path, out)
        best, found, by_gtsam = positions(read_poses(out)), [], []
        for draw in range(WRONG_DRAWS):
            graph.write(path, more=graph.wrong_loops(ratio, draw))
            summary, _ = surfit_graph(self.tools, path, out, "--loop_robustness=gnc")
            error = rmse_after_alignment(positions(read_poses(out)), best)
            found.append(f"{error:.1g}" + " (doubtful)" * (summary["status"] == "doubtful"))
            if "gtsam" in self.found and by_gtsam[-1:] != ["no result"]:
                result = self.peer_poses("gtsam", graph, path, "gnc")
                by_gtsam.append(f"{rmse_after_alignment(positions(result[0]), best):.1g}" if result else "no result")
        return [name, f"{100 * ratio:.0f} %", ", ".join(found), *([", ".join(by_gtsam)] if by_gtsam else [])]

    def pair_row(self, pair):
        out = self.folder / "pair"
        code, _, seconds = run([self.tools / "surfit_register", f"--source={pair['source']}",
                                f"--target={pair['target']}", f"--output={out}"], self.folder)
        cells = [pair["name"], "no result"]
        if code in (0, 2):
            cells[1] = verdict(pair, np.loadtxt(out / "transform.txt"), seconds, code == 2)
        if "open3d" in self.found:
            for method in ("identity", "global"):
                seconds = self.python_peer("open3d", pair["source"], pair["target"], method)
                cells.append("no result" if seconds is None else
                             verdict(pair, np.loadtxt(self.folder / "pose.txt"), seconds))
        if "pcl" in self.found:
            cells.append(self.pcl_cell(pair))
        return cells

    def pcl_cell(self, pair):
        gate_m = self.python_peer("open3d", pair["source"], pair["target"], "thin")
        code, text, seconds = run([self.found["pcl"] / "pcl_icp", "-d", gate_m, "-i", 100, "target.pcd", "source.pcd"],
                                  self.folder)
        rows = [line.split() for line in text.splitlines() if len(line.split()) == 4 and "saving" not in line]
        return verdict(pair, np.array(rows[-4:], float), seconds) if code == 0 else "no result"


def verdict(pair, pose, seconds, refused=False):
    truth = pair["truth"]
    turn = truth[:3, :3].T @ pose[:3, :3]
    degrees = np.degrees(np.arctan2(np.linalg.norm(turn - turn.T) / 8 ** 0.5, (np.trace(turn) - 1) / 2))
    metres = np.linalg.norm((pose - truth) @ [*map(float, pair["center"].split()), 1])
    right = degrees <= MAX_DEGREES and metres <= float(pair["max_m"])
    word = "refused" if refused else "right" if right else "wrong"
    return f"{word}: {degrees:.2f}°, {1000 * metres:.0f} mm, {seconds:.1f} s"


def read_pairs(folder):
    with open(folder / "pairs.csv", encoding="utf-8") as file:
        for pair in csv.DictReader(file):
            paths = {key: (folder / pair[key]).resolve() for key in ("source", "target")}
            yield {**pair, **paths, "truth": np.loadtxt(folder / pair["truth"])}


def table(head, rows):
    """Table of rows, which are also printed on stderr when they are ready."""
    text = "".join("| " + " | ".join(line) + " |\n" for line in (head, ["---"] * len(head)))
    for row in rows:
        print(*row, sep="  ", file=sys.stderr, flush=True)
        text += "| " + " | ".join(map(str, row)) + " |\n"
    return text


def machine():
    info = pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    names = [line.split(":")[1].strip() for line in info if line.startswith("model name")]
    return f"{len(names)} processors, {names[0]}" if names else "Unknown processor"


def write_page(options, folder):
    page = Page(options, folder)
    paths = [path for path in sorted(options.graphs.glob("*.g2o")) if path.stat().st_size > 0]
    graphs = {path.stem: Graph(path.resolve(), page.tools, folder) for path in paths}
    names = {"ceres": "Ceres", "gtsam": "GTSAM", "open3d": "Open3D", "pcl": "PCL"}
    commit = run(["git", "-C", ROOT, "rev-parse", "--short", "HEAD"], folder)[1].strip() or "unknown"
    text = HEAD.format(date=datetime.date.today(), commit=commit, machine=machine(),
                       limit=LIMIT_S, found=", ".join(names[name] for name in names if name in page.found) or "none",
                       absent=", ".join(names[name] for name in names if name not in page.found) or "none")
    peers = [names[name] for name in page.graph_peers()]
    text += table(["graph", "poses", "edges", "Surfit, chordal", "Surfit, given", *peers,
                   *(["metric of GTSAM"] if "gtsam" in page.found else [])],
                  (page.graph_row(name, graph) for name, graph in graphs.items()))
    small = [(name, graph, ratio) for name, graph in graphs.items() for ratio in WRONG_SHARES
             if len(graph.loops) > 10 and len(graph.edges) <= WRONG_MAX_EDGES]
    if small:
        text += WRONG.format(draws=WRONG_DRAWS) + table(
            ["graph", "wrong", "Surfit", *(["GTSAM"] if "gtsam" in page.found else [])],
            (page.wrong_loop_row(*row) for row in small))
    if options.pairs:
        columns = [["Open3D, identity", "Open3D, FPFH"], ["PCL"]]
        columns = [c for name, group in zip(("open3d", "pcl"), columns) if name in page.found for c in group]
        text += PAIRS.format(degrees=MAX_DEGREES, points=PEER_POINTS) + table(
            ["pair", "Surfit", *columns], (page.pair_row(pair) for pair in read_pairs(options.pairs)))
    options.output.write_text(text, encoding="utf-8")


def main():
    if sys.argv[1:2] == ["--peer=gtsam"]:
        return gtsam_peer(*sys.argv[2:])
    if sys.argv[1:2] == ["--peer=open3d"]:
        return open3d_peer(*sys.argv[2:])
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--graphs", type=pathlib.Path, required=True)
    parser.add_argument("--pairs", type=pathlib.Path)
    parser.add_argument("--tools", type=pathlib.Path, default=ROOT / "build/release/tools")
    parser.add_argument("--output", type=pathlib.Path, default=ROOT / "docs/solvers.md")
    parser.add_argument("--gtsam", default=sys.executable)
    parser.add_argument("--open3d", default=sys.executable)
    parser.add_argument("--ceres", default=None)
    parser.add_argument("--pcl", default=None)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        write_page(options, pathlib.Path(folder))


if __name__ == "__main__":
    main()
