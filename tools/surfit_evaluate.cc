// Compares an estimated trajectory with the ground truth: ATE and RPE.

#include <gflags/gflags.h>

#include <iomanip>
#include <iostream>

#include "common/json.h"
#include "common/tool_main.h"
#include "surfit/core/error.h"
#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/io/tum_trajectory.h"

namespace {

const surfit::TrajectoryEvaluationOptions kDefaults;

const char* UnitName(surfit::RelativePoseErrorOptions::Unit unit) {
  return unit == surfit::RelativePoseErrorOptions::Unit::kFrames ? "frames" : "seconds";
}

}  // namespace

DEFINE_string(groundtruth, "", "the true trajectory: TUM format, or ICL-NUIM's .gt.freiburg");
DEFINE_string(estimate, "", "the estimated trajectory, same format");
DEFINE_string(frames, "",
              "list of the frames that should have a pose, stamps first (rgb.txt): coverage is the "
              "share of them that has one; if empty, of the ground truth's poses");
DEFINE_double(max_difference_s, kDefaults.match.max_difference_s,
              "stamps further apart never match (evo: 0.01, TUM scripts: 0.02)");
DEFINE_double(delta, kDefaults.rpe.delta, "step of the relative pose error");
DEFINE_string(delta_unit, UnitName(kDefaults.rpe.delta_unit), "unit of --delta: frames or seconds");

namespace surfit::tools {
namespace {

TrajectoryEvaluationOptions OptionsFromFlags() {
  TrajectoryEvaluationOptions options;
  options.match.max_difference_s = FLAGS_max_difference_s;
  options.rpe.delta = FLAGS_delta;
  using Unit = RelativePoseErrorOptions::Unit;
  for (const Unit unit : {Unit::kFrames, Unit::kSeconds}) {
    if (FLAGS_delta_unit == UnitName(unit)) {
      options.rpe.delta_unit = unit;
      return options;
    }
  }
  throw InputError(
      Concat("--delta_unit is '", FLAGS_delta_unit, "', must be 'frames' or 'seconds'"));
}

std::string DescribeStamps(const Trajectory& trajectory) {
  if (trajectory.empty()) return "no poses";
  return Concat(trajectory.size(), " poses from ", std::fixed, std::setprecision(3),
                trajectory.front().stamp_s, " to ", trajectory.back().stamp_s, " s");
}

Json ToJson(const TrajectoryEvaluation& e, const TrajectoryEvaluationOptions& options) {
  Json json;
  SetStatistics("ate", "m", &e.ate->translation_m, &json);
  json["ate_coverage"] = e.coverage;
  json["ate_rotation_unique"] = e.ate->alignment.status == AlignmentStatus::kAligned;
  SetStatistics("rpe_translation", "m", e.rpe ? &e.rpe->translation_m : nullptr, &json);
  SetStatistics("rpe_rotation", "deg", e.rpe ? &e.rpe->rotation_deg : nullptr, &json);
  json["rpe_pairs"] = e.rpe ? e.rpe->translation_m.count : 0;
  json["poses_expected"] = e.expected;
  json["poses_matched"] = e.matched;
  const Rigid3d& a = e.ate->alignment.target_from_source;
  json["groundtruth_from_estimate"] = {{"translation_m", a.translation},
                                       {"quaternion_xyzw", a.rotation.coeffs()}};
  json["options"] = {
      {"groundtruth", FLAGS_groundtruth}, {"estimate", FLAGS_estimate},
      {"frames", FLAGS_frames},           {"max_difference_s", options.match.max_difference_s},
      {"delta", options.rpe.delta},       {"delta_unit", UnitName(options.rpe.delta_unit)}};
  return json;
}

void PrintSummary(const TrajectoryEvaluation& e) {
  std::cerr << "ATE RMSE " << e.ate->translation_m.rmse << " m over " << e.matched << " of "
            << e.expected << (FLAGS_frames.empty() ? " true poses" : " frames");
  if (e.rpe) {
    std::cerr << ", RPE RMSE " << e.rpe->translation_m.rmse << " m and " << e.rpe->rotation_deg.rmse
              << " deg a step of ";
  } else {
    std::cerr << ", no RPE: no two poses are apart by ";
  }
  std::cerr << FLAGS_delta << " " << FLAGS_delta_unit << std::endl;
}

int Run() {
  const TrajectoryEvaluationOptions options = OptionsFromFlags();
  RequireFlag("groundtruth", FLAGS_groundtruth);
  RequireFlag("estimate", FLAGS_estimate);
  const Trajectory ground_truth = ReadTumTrajectory(FLAGS_groundtruth);
  const Trajectory estimate = ReadTumTrajectory(FLAGS_estimate);
  const auto frames = FLAGS_frames.empty() ? Stamps(ground_truth) : ReadTumStamps(FLAGS_frames);
  const TrajectoryEvaluation evaluation =
      EvaluateTrajectory(ground_truth, estimate, frames, options);
  if (!evaluation.ate) {
    throw InputError(
        Concat(evaluation.matched, " poses match within ", options.match.max_difference_s,
               " s, must be at least 3: ", FLAGS_groundtruth, " has ", DescribeStamps(ground_truth),
               ", ", FLAGS_estimate, " has ", DescribeStamps(estimate)));
  }
  PrintJson(ToJson(evaluation, options));
  PrintSummary(evaluation);
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "compares a trajectory with the ground truth. Prints JSON on stdout (absolute trajectory "
      "error after rigid alignment without scale, relative pose error, coverage) and a summary "
      "on stderr.",
      surfit::tools::Run);
}
