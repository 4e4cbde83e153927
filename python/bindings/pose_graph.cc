#include <algorithm>
#include <filesystem>

#include "bindings/arrays.h"
#include "bindings/bind.h"
#include "bindings/options_class.h"
#include "surfit/core/error.h"
#include "surfit/io/g2o.h"

namespace surfit::python {
namespace {

std::size_t IndexOf(const PoseGraph& graph, std::int64_t id) {
  const auto pose = std::find_if(graph.poses.begin(), graph.poses.end(),
                                 [&](const PoseGraphPose& p) { return p.id == id; });
  ThrowIf(pose == graph.poses.end(), "no pose has id ", id);
  return static_cast<std::size_t>(pose - graph.poses.begin());
}

void AddEdge(PoseGraph* graph, std::int64_t a, std::int64_t b, const Rigid3d& a_from_b,
             const py::object& information, bool loop) {
  PoseGraphEdge edge = {IndexOf(*graph, a), IndexOf(*graph, b), a_from_b};
  if (!information.is_none()) {
    const auto rows =
        py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(information);
    if (!rows) throw py::error_already_set();
    if (rows.ndim() != 2 || rows.shape(0) != 6 || rows.shape(1) != 6)
      throw InputError("information has shape ", ShapeOf(rows), ", must be (6, 6)");
    for (int i = 0; i < 36; ++i) edge.information(i / 6, i % 6) = rows.data()[i];
  }
  edge.loop = loop;
  graph->edges.push_back(edge);
}

PoseGraph ReadGraph(const std::filesystem::path& path, const std::string& odometry,
                    const std::string& indefinite_information) {
  G2oOptions options;
  options.odometry = odometry;
  options.indefinite_information = indefinite_information;
  return ReadG2o(path.string(), options).graph;
}

// Returns N x 6 x 6, or None.
py::object CovariancesOf(const PoseGraph& graph, const PoseGraphSummary& summary,
                         const std::vector<std::int64_t>& ids) {
  std::vector<std::size_t> poses;
  for (const std::int64_t id : ids) poses.push_back(IndexOf(graph, id));
  const auto covariances = MarginalCovariances(graph, summary, poses);
  if (!covariances) return py::none();
  py::array_t<double> result(
      {static_cast<py::ssize_t>(ids.size()), py::ssize_t{6}, py::ssize_t{6}});
  double* next = result.mutable_data();
  for (const auto& covariance : *covariances) {
    for (int i = 0; i < 36; ++i) *next++ = covariance(i / 6, i % 6);
  }
  return result;
}

py::array_t<double> PosesOf(const PoseGraph& graph) {
  py::array_t<double> poses(
      {static_cast<py::ssize_t>(graph.poses.size()), py::ssize_t{4}, py::ssize_t{4}});
  for (std::size_t i = 0; i < graph.poses.size(); ++i)
    WriteMatrix(graph.poses[i].world_from_pose, poses.mutable_data() + 16 * i);
  return poses;
}

std::vector<std::int64_t> IdsOf(const PoseGraph& graph) {
  std::vector<std::int64_t> ids;
  for (const PoseGraphPose& pose : graph.poses) ids.push_back(pose.id);
  return ids;
}

void BindGraphSummary(py::module_& module) {
  using Summary = PoseGraphSummary;
  BindReport<Summary>(module, "PoseGraphSummary", "Result of an optimisation.")
      .def_property_readonly("succeeded", &Summary::Succeeded, "True if the poses were optimised")
      .def_property_readonly(
          "termination", [](const Summary& s) { return ToString(s.termination); },
          "converged, max_iterations; or failed")
      .def_readonly(FIELD(Summary, sparse_backend), "solver of sparse systems")
      .def_readonly(FIELD(Summary, given_cost), "cost of the input, all edges")
      .def_readonly(FIELD(Summary, initial_cost), "cost after initialisation, all edges")
      .def_readonly(FIELD(Summary, final_cost), "final cost, without outlier edges")
      .def_readonly(FIELD(Summary, truncated_cost),
                    "final cost with squared errors of loops of at most loop_error_limit")
      .def_readonly(FIELD(Summary, loop_error_limit), "largest squared error of an inlier loop")
      .def_readonly(FIELD(Summary, start), "initial poses of the result")
      .def_readonly(FIELD(Summary, loop_robustness), "kernel of the result")
      .def_readonly(FIELD(Summary, component_sizes), "number of poses of each component")
      .def_readonly(FIELD(Summary, undetermined_rotations),
                    "indices of poses without a chordal rotation")
      .def_readonly(FIELD(Summary, undetermined_positions),
                    "indices of poses without a chordal position")
      .def_readonly(FIELD(Summary, round_count), "number of solves")
      .def_readonly(FIELD(Summary, held_count), "number of fixed poses")
      .def_readonly(FIELD(Summary, loop_count), "number of loop edges")
      .def_readonly(FIELD(Summary, outlier_edges), "rejected loops: indices of edges, ascending")
      .def_readonly(FIELD(Summary, initialize_ms), "wall time of the initialisation, ms")
      .def_readonly(FIELD(Summary, solve_ms), "wall time of the solver, ms");
}

void BindGraphFit(py::module_& module) {
  using Fit = PoseGraphFit;
  BindReport<Fit>(module, "PoseGraphFit", "Residuals compared with their information matrices.")
      .def_readonly(FIELD(Fit, chi_square), "sum of the squared errors without outliers")
      .def_readonly(FIELD(Fit, degrees_of_freedom), "rank of the measurements minus unknowns")
      .def_readonly(FIELD(Fit, p_value), "probability of a larger chi_square")
      .def_readonly(FIELD(Fit, odometry_ratio), "chi-square per degree of freedom of odometry")
      .def_readonly(FIELD(Fit, loop_ratio), "chi-square per degree of freedom of accepted loops")
      .def_readonly(FIELD(Fit, doubtful), "True if the result is implausible")
      .def_readonly(FIELD(Fit, reason), "reason for the doubt");
}

}  // namespace

void BindPoseGraph(py::module_& module) {
  BindGraphSummary(module);
  BindGraphFit(module);
  py::class_<PoseGraph>(module, "PoseGraph", "Poses and relative pose measurements.")
      .def(py::init<>(), "Empty pose graph.")
      .def_static(
          "read", &ReadGraph, py::arg("path"), py::arg("odometry") = G2oOptions().odometry,
          py::arg("indefinite_information") = G2oOptions().indefinite_information,
          "Reads a .g2o file of SE(3) or SE(2). odometry: consecutive, spanning_tree or none; all "
          "other edges are loops. indefinite_information: refuse, project or blocks.")
      .def(
          "write",
          [](const PoseGraph& graph, const std::filesystem::path& path) {
            WriteG2o(graph, path.string());
          },
          py::arg("path"), "Writes a .g2o file.")
      .def(
          "add_pose",
          [](PoseGraph& graph, std::int64_t id, const Rigid3d& world_from_pose, bool fixed) {
            graph.poses.push_back({id, world_from_pose, fixed});
          },
          py::arg("id"), py::arg("world_from_pose"), py::arg("fixed") = false,
          "Adds a pose, 4 x 4. A fixed pose is not optimised.")
      .def(
          "add_edge",
          [](PoseGraph& graph, std::int64_t a, std::int64_t b, const Rigid3d& a_from_b,
             const py::object& information,
             bool loop) { AddEdge(&graph, a, b, a_from_b, information, loop); },
          py::arg("a"), py::arg("b"), py::arg("a_from_b"), py::arg("information") = py::none(),
          py::arg("loop") = false,
          "Adds a relative pose measurement, 4 x 4, between the poses of two ids. information: 6 x "
          "6, for the left perturbation (rotation, translation), as in IcpResult; the identity if "
          "None. A loop may be rejected as outlier.")
      .def_property_readonly("ids", &IdsOf, "ids of the poses")
      .def_property_readonly("poses", &PosesOf, "N x 4 x 4, world from pose, metres")
      .def_property_readonly(
          "edge_count", [](const PoseGraph& graph) { return graph.edges.size(); },
          "number of measurements")
      .def_property_readonly("cost", &Cost, "half the sum of the squared errors of all edges")
      .def(
          "optimize",
          [](PoseGraph& graph, const PoseGraphOptions& options) {
            const py::gil_scoped_release release;
            return OptimizePoseGraph(options, &graph);
          },
          py::arg("options") = PoseGraphOptions(), "Optimises the poses.")
      .def("fit", &TestFit, py::arg("summary"),
           "Compares the residuals of the optimised graph with their information matrices.")
      .def("covariances", &CovariancesOf, py::arg("summary"), py::arg("ids"),
           "Marginal covariances of the optimised poses of these ids, N x 6 x 6, for (rotation, "
           "translation) in the world frame. None if the edges do not determine all poses.")
      .def("__repr__", [](const PoseGraph& graph) {
        return Concat("<surfit.PoseGraph of ", graph.poses.size(), " poses and ",
                      graph.edges.size(), " edges>");
      });
}

}  // namespace surfit::python
