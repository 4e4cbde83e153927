// Optimises a pose graph of a .g2o file.

#include <iostream>

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
  std::string graph, output, summary;
  PoseGraphOptions optimization;

  void Visit(OptionVisitor& v) {
    v.Add(graph, "graph", "pose graph: .g2o with VERTEX_SE3:QUAT and EDGE_SE3:QUAT", Required(),
          AsFlag());
    v.Add(output, SharedOption("output"));
    v.Add(summary, SharedOption("summary"));
    v.AddPart(optimization, "optimization", "optimisation");
  }
};

void PrintIterations(const PoseGraphSummary& summary) {
  std::vector<std::vector<std::string>> rows = {{"round", "iteration", "cost", "step", "ms"}};
  int iteration = 0, round = 0;
  for (const PoseGraphIteration& i : summary.iterations) {
    if (i.round != round) iteration = 0;
    round = i.round;
    rows.push_back({std::to_string(round), std::to_string(iteration++), Number(i.cost, 10),
                    i.accepted ? Number(i.step_norm) : "rejected", Number(i.time_ms, 4)});
  }
  std::cout << TextTable(rows, 0);
}

void PrintOutcome(const PoseGraph& graph, const PoseGraphSummary& s) {
  std::cout << ToString(s.termination) << ": " << graph.poses.size() << " poses (" << s.held_count
            << " fixed), " << graph.edges.size() << " edges (" << s.loop_count << " loops, "
            << s.outlier_edges.size() << " outliers)\n"
            << "cost " << Number(s.given_cost, 10) << " of the input, "
            << Number(s.initial_cost, 10) << " after initialisation in "
            << Number(s.initialize_ms, 4) << " ms, " << Number(s.final_cost, 10)
            << " after optimisation in " << Number(s.solve_ms, 4) << " ms with " << s.sparse_backend
            << std::endl;
}

void PrintIgnored(const G2oFile& file) {
  for (const auto& [tag, count] : file.ignored_lines) {
    std::cerr << "warning: " << count << " lines " << tag << " ignored" << std::endl;
  }
}

// Outlier loops as pairs of ids, in the order of the file.
Json OutlierIds(const PoseGraph& graph, const PoseGraphSummary& summary) {
  Json ids = Json::array();
  for (const std::size_t i : summary.outlier_edges) {
    ids.push_back({graph.poses[graph.edges[i].b].id, graph.poses[graph.edges[i].a].id});
  }
  return ids;
}

Json ToJson(const G2oFile& file, const PoseGraphSummary& s, Options options) {
  Json json = {{"termination", ToString(s.termination)},
               {"poses", file.graph.poses.size()},
               {"held_poses", s.held_count},
               {"edges", file.graph.edges.size()},
               {"loops", s.loop_count},
               {"ignored_lines", file.ignored_lines},
               {"given_cost", s.given_cost},
               {"initial_cost", s.initial_cost},
               {"final_cost", s.final_cost},
               {"rounds", s.round_count},
               {"initialize_ms", s.initialize_ms},
               {"solve_ms", s.solve_ms}};
  for (const PoseGraphIteration& i : s.iterations) {
    json["iterations"].push_back({{"round", i.round},
                                  {"cost", i.cost},
                                  {"step_norm", i.step_norm},
                                  {"accepted", i.accepted},
                                  {"ms", i.time_ms}});
  }
  json["wrong_loops"] = OutlierIds(file.graph, s);
  json["options"] = FlagsToJson(TableOf(&options));
  return json;
}

int Run(const Options& options) {
  G2oFile file = ReadG2o(options.graph);
  PrintIgnored(file);
  const PoseGraphSummary summary = OptimizePoseGraph(options.optimization, &file.graph);
  PrintIterations(summary);
  PrintOutcome(file.graph, summary);
  if (!options.summary.empty()) {
    WriteFileAtomically(options.summary,
                        [&](std::ostream& out) { out << ToText(ToJson(file, summary, options)); });
  }
  if (!summary.Succeeded()) {
    std::cerr << "failed: the solver found no solution" << std::endl;
    return kAlgorithmFailed;
  }
  if (!options.output.empty()) WriteG2o(file.graph, options.output);
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "optimises the pose graph of a .g2o file, and prints the cost at each iteration. --output is "
      "the .g2o file of the optimised graph; empty: none.",
      surfit::tools::Run);
}
