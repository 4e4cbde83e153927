// Looks for places that a camera returned to, and verifies each.

#include <gflags/gflags.h>

#include <chrono>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <map>

#include "common/progress_line.h"
#include "common/sequence_flags.h"
#include "common/text_table.h"
#include "common/tool_main.h"
#include "surfit/core/error.h"
#include "surfit/run/find_loops_run.h"

namespace {

const surfit::FindLoopsRunOptions kDefaults;
constexpr double kDegrees = 180 / M_PI;

}  // namespace

DEFINE_string(run, "", "folder that surfit_slam wrote: its trajectory.txt is taken");
DEFINE_string(trajectory, kDefaults.trajectory, "or the estimated trajectory itself: TUM format");
DEFINE_string(output, kDefaults.output, "folder for loops.csv and loops.g2o; made if missing");
DEFINE_double(keyframe_distance, kDefaults.keyframes.max_distance_m,
              "metres that the camera moves to the next keyframe, at most");
DEFINE_double(keyframe_angle_deg, kDefaults.keyframes.max_angle_rad* kDegrees,
              "degrees that it turns, at most");
DEFINE_double(keyframe_overlap, kDefaults.keyframes.min_overlap_share,
              "share of a keyframe's view that is still seen at the next, at least");
DEFINE_int32(loop_gap, kDefaults.loops.min_gap, "frames between two keyframes of a loop, at least");
DEFINE_int32(max_alike, kDefaults.loops.max_alike, "keyframes that look most alike and are tried");
DEFINE_int32(max_near, kDefaults.loops.max_near,
             "further keyframes that are tried because their poses are near");
DEFINE_double(max_view_megabytes, static_cast<double>(kDefaults.max_view_bytes) / 1e6,
              "memory for all keyframes' views; beyond, those of places that others show as well "
              "are given up");
DEFINE_int32(revisit_gap, kDefaults.revisit_gap,
             "a frame counts as returned if the true pose of one so many frames earlier is near");
DEFINE_double(revisit_distance, kDefaults.revisit_m, "metres that are near");
DEFINE_double(revisit_angle_deg, kDefaults.revisit_rad* kDegrees, "degrees that are near");
DEFINE_int32(threads, kDefaults.threads, "threads that compute at the same time");

namespace surfit::tools {
namespace {

std::string TrajectoryFile() {
  if (FLAGS_run.empty() == FLAGS_trajectory.empty()) {
    throw InputError("one of --run and --trajectory must be given, and not both");
  }
  return FLAGS_run.empty() ? FLAGS_trajectory : FLAGS_run + "/trajectory.txt";
}

FindLoopsRunOptions OptionsFromFlags() {
  FindLoopsRunOptions options;
  options.sequence = SequenceOptionsFromFlags();
  options.trajectory = TrajectoryFile();
  RequireFlag("output", FLAGS_output);
  options.output = FLAGS_output;
  options.keyframes.max_distance_m = FLAGS_keyframe_distance;
  options.keyframes.max_angle_rad = FLAGS_keyframe_angle_deg / kDegrees;
  options.keyframes.min_overlap_share = FLAGS_keyframe_overlap;
  options.loops.min_gap = FLAGS_loop_gap;
  options.loops.max_alike = FLAGS_max_alike;
  options.loops.max_near = FLAGS_max_near;
  options.max_view_bytes = static_cast<std::size_t>(1e6 * FLAGS_max_view_megabytes);
  options.revisit_gap = FLAGS_revisit_gap;
  options.revisit_m = FLAGS_revisit_distance;
  options.revisit_rad = FLAGS_revisit_angle_deg / kDegrees;
  options.threads = FLAGS_threads;
  return options;
}

void PrintReasons(const std::vector<FoundLoop>& loops) {
  std::map<LoopReason, int> counts;
  for (const FoundLoop& loop : loops) ++counts[loop.attempt.verdict.reason];
  std::vector<std::vector<std::string>> rows = {{"verdict", "loops"}};
  for (const LoopReason reason : LoopReasons()) {
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

int Run() {
  const FindLoopsRunOptions options = OptionsFromFlags();
  ProgressLine line;
  const auto start = std::chrono::steady_clock::now();
  const FindLoopsRunResult result = RunFindLoops(options, [&](int frames) {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    line.Show(Concat("frame ", frames), elapsed.count(), false);
  });
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
  return surfit::tools::ToolMain(
      argc, argv,
      "looks for places that the camera of an RGB-D sequence returned to: chooses keyframes along "
      "an estimated trajectory, finds those that look alike or are near, and verifies each pair "
      "densely. With ground truth it also tells which are right.",
      surfit::tools::Run);
}
