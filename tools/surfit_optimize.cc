// Optimises a pose graph of a .g2o file.

#include <algorithm>
#include <iomanip>
#include <iostream>
#include <limits>
#include <unordered_map>

#include "common/console.h"
#include "common/json.h"
#include "common/tool_main.h"
#include "core/shared_options.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/io/g2o.h"
#include "surfit/optimization/pose_graph.h"

namespace surfit::tools {
namespace {

struct Options {
  std::string graph, output, summary, edge_errors, covariances;
  G2oOptions reading;
  PoseGraphOptions optimization;

  void Visit(OptionVisitor& v) {
    v.Add(graph, "graph", "pose graph: .g2o of SE(3) or SE(2)", Required(), AsFlag());
    v.Add(output, SharedOption("output"));
    v.Add(summary, SharedOption("summary"));
    v.Add(edge_errors, "edge_errors",
          "CSV file for the squared error of each edge and prior; empty: none", AsFlag());
    v.Add(covariances, "covariances",
          "ids of poses for marginal covariances in --summary, separated by commas; or all",
          AsFlag());
    v.AddPart(reading, "reading", "reading");
    v.AddPart(optimization, "optimization", "optimisation");
  }
};

void PrintIterations(const PoseGraphSummary& summary) {
  std::vector<std::vector<std::string>> rows = {
      {"round", "iteration", "cost", "gradient", "radius", "step", "ms"}};
  int iteration = 0, round = 0;
  for (const PoseGraphIteration& i : summary.iterations) {
    if (i.round != round) iteration = 0;
    round = i.round;
    rows.push_back({std::to_string(round), std::to_string(iteration++), Number(i.cost, 10),
                    Number(i.gradient_norm, 4), Number(i.trust_region_radius, 4),
                    i.accepted ? Number(i.step_norm) : "rejected", Number(i.time_ms, 4)});
  }
  std::cout << TextTable(rows, 0);
}

std::string Status(const PoseGraphSummary& summary, const PoseGraphFit& fit) {
  const bool is_doubtful = fit.doubtful && summary.termination == PoseGraphTermination::kConverged;
  return is_doubtful ? "doubtful" : ToString(summary.termination);
}

std::size_t PriorCount(const PoseGraph& graph) {
  return graph.priors.size() + graph.positions.size();
}

void PrintOutcome(const PoseGraph& graph, const PoseGraphSummary& s, const PoseGraphFit& fit) {
  std::cout << Status(s, fit) << ": " << graph.poses.size() << " poses (" << s.held_count
            << " fixed) in SE(" << (graph.planar ? 2 : 3) << "), " << graph.edges.size()
            << " edges (" << s.loop_count << " loops, " << s.outlier_edges.size() << " outliers), "
            << PriorCount(graph) << " priors\n"
            << "cost " << Number(s.given_cost, 10) << " of the input, "
            << Number(s.initial_cost, 10) << " after initialisation in "
            << Number(s.initialize_ms, 4) << " ms, " << Number(s.final_cost, 10)
            << " after optimisation in " << Number(s.solve_ms, 4) << " ms with " << s.sparse_backend
            << std::endl;
  if (!s.Succeeded()) return;
  std::cout << "chi-square " << Number(fit.chi_square) << " for "
            << Number(fit.degrees_of_freedom, 10) << " degrees of freedom, per degree of freedom "
            << Number(fit.odometry_ratio) << " of odometry and " << Number(fit.loop_ratio)
            << " of accepted loops" << std::endl;
}

void PrintInput(const G2oFile& file) {
  for (const auto& [tag, count] : file.ignored_lines) {
    std::cerr << "warning: " << count << " lines " << tag << " ignored" << std::endl;
  }
  if (file.indefinite_count > 0) {
    std::cerr << "warning: " << file.indefinite_count
              << " indefinite information matrices changed, see --indefinite_information"
              << std::endl;
  }
  if (file.chained_count > 0) {
    std::cerr << "note: the file has no vertices, " << file.chained_count
              << " poses are chained along a spanning tree" << std::endl;
  }
}

void PrintUndetermined(const PoseGraph& graph, const std::vector<std::size_t>& poses,
                       const char* what) {
  if (poses.empty()) return;
  std::cerr << "warning: edges do not determine the initial " << what << " of " << poses.size()
            << " poses, which start from the given values: id " << graph.poses[poses[0]].id
            << (poses.size() > 1 ? ", ..." : "") << std::endl;
}

void PrintWarnings(const PoseGraph& graph, const PoseGraphSummary& s, const PoseGraphFit& fit) {
  if (s.component_sizes.size() > 1) {
    std::cerr << "warning: the graph has " << s.component_sizes.size()
              << " disconnected components, of";
    constexpr std::size_t kMost = 10;
    for (std::size_t i = 0; i < std::min(kMost, s.component_sizes.size()); ++i) {
      std::cerr << (i > 0 ? ", " : " ") << s.component_sizes[i];
    }
    std::cerr << (s.component_sizes.size() > kMost ? ", ..." : "")
              << " poses: their relative poses are not determined" << std::endl;
  }
  PrintUndetermined(graph, s.undetermined_rotations, "rotations");
  PrintUndetermined(graph, s.undetermined_positions, "positions");
  if (!s.Succeeded()) {
    std::cerr << "failed: the solver found no solution" << std::endl;
  } else if (s.termination == PoseGraphTermination::kMaxIterations) {
    std::cerr << "not converged: the number of iterations reached --max_graph_iterations"
              << std::endl;
  }
  if (s.Succeeded() && fit.doubtful) std::cerr << "doubtful: " << fit.reason << std::endl;
}

// Outlier loops as pairs of ids, in the order of the file.
Json OutlierIds(const PoseGraph& graph, const PoseGraphSummary& summary) {
  Json ids = Json::array();
  for (const std::size_t i : summary.outlier_edges) {
    ids.push_back({graph.poses[graph.edges[i].b].id, graph.poses[graph.edges[i].a].id});
  }
  return ids;
}

// Index of the pose of each id of --covariances.
std::vector<std::size_t> CovariancePoses(const Options& options, const PoseGraph& graph) {
  std::vector<std::size_t> poses;
  std::unordered_map<std::string, std::size_t> index_of;
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    index_of[std::to_string(graph.poses[i].id)] = i;
    if (options.covariances == "all") poses.push_back(i);
  }
  if (options.covariances.empty() || options.covariances == "all") return poses;
  std::string rest = options.covariances + ",";
  for (std::size_t end = rest.find(','); end != std::string::npos; end = rest.find(',')) {
    const std::string id = rest.substr(0, end);
    rest.erase(0, end + 1);
    const auto found = index_of.find(id);
    ThrowIf(found == index_of.end(), "--covariances has the id '", id, "', must be ids of ",
            options.graph, ", separated by commas");
    poses.push_back(found->second);
  }
  return poses;
}

// Covariance of each chosen pose as 36 numbers by rows. Null if the edges do not determine them.
Json CovariancesToJson(const PoseGraph& graph, const PoseGraphSummary& summary,
                       const std::vector<std::size_t>& poses) {
  const auto covariances = MarginalCovariances(graph, summary, poses);
  if (!covariances) {
    std::cerr << "warning: no covariances: the edges do not determine all poses" << std::endl;
    return nullptr;
  }
  Json json = Json::object();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    Json numbers = Json::array();
    for (int k = 0; k < 36; ++k) numbers.push_back((*covariances)[i](k / 6, k % 6));
    json[std::to_string(graph.poses[poses[i]].id)] = numbers;
  }
  return json;
}

void WriteEdgeErrors(const PoseGraph& graph, const PoseGraphSummary& s, const std::string& path) {
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << "kind,from,to,used,squared_error\n"
        << std::setprecision(std::numeric_limits<double>::max_digits10);
    for (std::size_t i = 0; i < graph.edges.size(); ++i) {
      const PoseGraphEdge& edge = graph.edges[i];
      const bool used = !std::binary_search(s.outlier_edges.begin(), s.outlier_edges.end(), i);
      out << (edge.loop ? "loop," : "odometry,") << graph.poses[edge.b].id << ','
          << graph.poses[edge.a].id << ',' << used << ',' << SquaredError(graph, edge) << '\n';
    }
    for (const PoseGraphPrior& prior : graph.priors) {
      out << "prior," << graph.poses[prior.pose].id << ",,1," << SquaredError(graph, prior) << '\n';
    }
    for (const PoseGraphPosition& position : graph.positions) {
      out << "position," << graph.poses[position.pose].id << ",,1," << SquaredError(graph, position)
          << '\n';
    }
  });
}

Json FitToJson(const PoseGraphFit& fit) {
  return {{"chi_square", fit.chi_square}, {"degrees_of_freedom", fit.degrees_of_freedom},
          {"p_value", fit.p_value},       {"odometry_ratio", fit.odometry_ratio},
          {"loop_ratio", fit.loop_ratio}, {"doubtful", fit.doubtful},
          {"reason", fit.reason}};
}

Json ToJson(const G2oFile& file, const PoseGraphSummary& s, const PoseGraphFit& fit,
            Options options) {
  Json json = {{"status", Status(s, fit)},
               {"termination", ToString(s.termination)},
               {"poses", file.graph.poses.size()},
               {"held_poses", s.held_count},
               {"edges", file.graph.edges.size()},
               {"loops", s.loop_count},
               {"planar", file.graph.planar},
               {"priors", PriorCount(file.graph)},
               {"component_sizes", s.component_sizes},
               {"undetermined_rotations", s.undetermined_rotations.size()},
               {"undetermined_positions", s.undetermined_positions.size()},
               {"indefinite_matrices", file.indefinite_count},
               {"chained_poses", file.chained_count},
               {"ignored_lines", file.ignored_lines},
               {"start", s.start},
               {"loop_robustness", s.loop_robustness},
               {"given_cost", s.given_cost},
               {"initial_cost", s.initial_cost},
               {"final_cost", s.final_cost},
               {"truncated_cost", s.truncated_cost},
               {"loop_error_limit", s.loop_error_limit},
               {"fit", FitToJson(fit)},
               {"rounds", s.round_count},
               {"initialize_ms", s.initialize_ms},
               {"solve_ms", s.solve_ms}};
  for (const PoseGraphIteration& i : s.iterations) {
    json["iterations"].push_back({{"round", i.round},
                                  {"cost", i.cost},
                                  {"step_norm", i.step_norm},
                                  {"gradient_norm", i.gradient_norm},
                                  {"trust_region_radius", i.trust_region_radius},
                                  {"accepted", i.accepted},
                                  {"ms", i.time_ms}});
  }
  json["wrong_loops"] = OutlierIds(file.graph, s);
  json["options"] = FlagsToJson(TableOf(&options));
  return json;
}

int Run(const Options& options) {
  G2oFile file = ReadG2o(options.graph, options.reading);
  PrintInput(file);
  const std::vector<std::size_t> covariance_poses = CovariancePoses(options, file.graph);
  const PoseGraphSummary summary = OptimizePoseGraph(options.optimization, &file.graph);
  const PoseGraphFit fit = summary.Succeeded() ? TestFit(file.graph, summary) : PoseGraphFit();
  PrintIterations(summary);
  PrintOutcome(file.graph, summary, fit);
  PrintWarnings(file.graph, summary, fit);
  if (!options.summary.empty()) {
    Json json = ToJson(file, summary, fit, options);
    if (!covariance_poses.empty() && summary.Succeeded()) {
      json["covariances"] = CovariancesToJson(file.graph, summary, covariance_poses);
    }
    WriteFileAtomically(options.summary, [&](std::ostream& out) { out << ToText(json); });
  }
  if (!summary.Succeeded()) return kAlgorithmFailed;
  if (!options.output.empty()) WriteG2o(file.graph, options.output);
  if (!options.edge_errors.empty()) WriteEdgeErrors(file.graph, summary, options.edge_errors);
  const bool is_converged = summary.termination == PoseGraphTermination::kConverged;
  return is_converged && !fit.doubtful ? kDone : kAlgorithmFailed;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "optimises the pose graph of a .g2o file, and prints the cost at each iteration. --output is "
      "the .g2o file of the optimised graph; empty: none. The exit code is 2 if the solver does "
      "not "
      "converge, or if the residuals contradict the information matrices (doubtful).",
      surfit::tools::Run);
}
