// Looks for places that a camera returned to, and verifies each.

#include <cmath>
#include <iomanip>
#include <iostream>
#include <map>

#include "apps/evaluate/revisits.h"
#include "common/console.h"
#include "common/tool_main.h"
#include "surfit/core/error.h"

namespace surfit::tools {
namespace {

constexpr double kDegrees = 180 / M_PI;

struct Options {
  std::string run;
  FindLoopsRunOptions search;

  void Visit(OptionVisitor& v) {
    v.Group("sequence");
    v.Add(run, "run", "folder that surfit_slam wrote, for its trajectory.txt", Everyday());
    v.AddPart(search, "search", "how loops are found");
  }
  void TakeTrajectoryOfRun() {
    if (run.empty() == search.trajectory.empty()) {
      throw InputError("one of --run and --trajectory must be given, and not both");
    }
    if (!run.empty()) search.trajectory = run + "/trajectory.txt";
  }
};

void PrintReasons(const std::vector<FoundLoop>& loops) {
  std::map<FarReason, int> counts;
  for (const FoundLoop& loop : loops) ++counts[loop.attempt.verdict.reason];
  std::vector<std::vector<std::string>> rows = {{"verdict", "loops"}};
  for (const FarReason reason : FarReasons()) {
    rows.push_back({ToString(reason), std::to_string(counts[reason])});
  }
  rows.push_back({"proposed", std::to_string(loops.size())});
  std::cout << TextTable(rows, 1);
}

void PrintKeyframes(const FindLoopsRunResult& result) {
  std::cout << std::setprecision(3) << result.frames << " frames (" << result.left_out
            << " left out: no pose or no depth), " << result.keyframes.size() << " keyframes, "
            << static_cast<double>(result.view_bytes) / 1e6 << " MB of views (" << result.given_up
            << " given up)\nCPU time: " << result.view_ms << " ms to make a view, "
            << result.query_ms << " ms to propose its loops, " << result.verify_ms
            << " ms to verify one" << std::endl;
}

void PrintEvaluation(const LoopEvaluation& evaluation) {
  std::cout << std::setprecision(3) << "of " << evaluation.revisiting
            << " frames that return to a place, " << evaluation.linked << " are linked";
  if (evaluation.revisiting > 0) {
    std::cout << " (" << 100. * evaluation.linked / evaluation.revisiting << " %)";
  }
  std::cout
      << "\nwrong loops accepted: " << evaluation.wrong << " (of these, " << evaluation.disputed
      << " that the surfaces speak for more than for the truth); largest errors of accepted loops: "
      << 100 * evaluation.worst_m << " cm, " << evaluation.worst_rad * kDegrees << " deg"
      << std::endl;
}

int Run(const FindLoopsRunOptions& options) {
  ProgressLine line;
  const FindLoopsRunResult result = RunFindLoops(
      options, [&](int frames) { line.Show(Concat("frame ", frames), /*last=*/false); });
  PrintReasons(result.loops);
  PrintKeyframes(result);
  if (result.evaluation) PrintEvaluation(*result.evaluation);
  std::cout << "all loops: " << options.output << "/loops.csv, accepted ones: " << options.output
            << "/loops.g2o" << std::endl;
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  surfit::tools::Options options;
  return surfit::tools::ToolMain(
      argc, argv,
      "looks for places that the camera of an RGB-D sequence returned to: chooses keyframes along "
      "an estimated trajectory, finds those that look alike or are near, and verifies each pair "
      "densely. With ground truth it also tells which are right.",
      surfit::TableOf(&options), [&] { return surfit::tools::Run(options.search); },
      [&] { options.TakeTrajectoryOfRun(); });
}
