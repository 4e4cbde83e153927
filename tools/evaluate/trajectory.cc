// Compares an estimated trajectory with the ground truth: ATE and RPE.

#include <glog/logging.h>

#include <iomanip>
#include <iostream>
#include <optional>

#include "common/json.h"
#include "common/settings_text.h"
#include "common/tool_main.h"
#include "core/shared_options.h"
#include "evaluate/evaluations.h"
#include "surfit/core/error.h"
#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/io/trajectory_files.h"

namespace surfit::tools {
namespace {

// Distance of the poses of a relative pose error: N frames, or Ns for N seconds.
class DeltaText final : public OptionText {
 public:
  explicit DeltaText(RelativePoseErrorOptions* rpe) : rpe_(rpe) {}
  std::string Get() const override { return OptionToText(rpe_->delta) + (IsTime() ? "s" : ""); }
  void Set(const std::string& text) override {
    const bool is_time = !text.empty() && text.back() == 's';
    const auto numbers = WithContext("a number of frames, or seconds as in 0.5s", [&] {
      return NumbersFromText(is_time ? text.substr(0, text.size() - 1) : text, 1);
    });
    rpe_->delta = numbers.front();
    rpe_->delta_unit = is_time ? Unit::kSeconds : Unit::kFrames;
  }
  const std::type_info& type() const override { return typeid(DeltaText); }
  void* field() override { return rpe_; }

 private:
  using Unit = RelativePoseErrorOptions::Unit;
  bool IsTime() const { return rpe_->delta_unit == Unit::kSeconds; }

  RelativePoseErrorOptions* rpe_;
};

struct TrajectoryOptions {
  std::string groundtruth, estimate, frames;
  std::string time_offset_s;  // number, "estimate" or empty
  bool fit_mount = false;
  TrajectoryEvaluationOptions evaluation;

  void Visit(OptionVisitor& v) {
    v.Group("trajectory");
    v.Add(groundtruth, SharedOption("groundtruth", Required(), Everyday()));
    v.Add(estimate, SharedOption("estimate", Required(), Everyday()));
    v.Add(frames, "frames",
          "list of frames for the coverage, timestamps first (rgb.txt); empty: the poses of the "
          "ground "
          "truth",
          AsFlag("frame_list"));
    v.Add(
        time_offset_s, "time_offset_s",
        "time offset of the estimate for an additional ATE; estimate: the offset with the smallest "
        "ATE; empty: none",
        InUnit("s"), AsFlag());
    v.Add(fit_mount, SharedOption("fit_mount"));
    MatchOptions& match = evaluation.match;
    PairText max_gap(Option("max_gap_s", "", Between(0, 1)), &match.max_gap_s,
                     Option("max_difference_s", "", Between(0, 1)), &match.max_difference_s);
    v.AddText(max_gap,
              Option("max_gap_s",
                     "GAP,DIFFERENCE: interpolate between ground-truth poses at most GAP apart, "
                     "else take the nearest pose with a time difference of at most DIFFERENCE, s; "
                     "0,0.01: as evo; 0,0.02: as the TUM scripts",
                     AsFlag()));
    DeltaText delta(&evaluation.rpe);
    v.AddText(delta, Option("delta",
                            "distance between the two poses of a relative pose error: a number of "
                            "frames, or seconds as in 0.5s",
                            AsFlag()));
    v.Check([this] { GivenOffset(); });
  }

  // std::nullopt if the offset is not a number.
  std::optional<double> GivenOffset() const {
    std::optional<double> offset_s;
    if (time_offset_s == "estimate") return offset_s;
    try {
      OptionFromText(time_offset_s, &offset_s);
    } catch (const InputError&) {
      throw InputError(Concat("time_offset_s is '", time_offset_s,
                              "', must be a number of seconds or 'estimate'"));
    }
    return offset_s;
  }
};

std::string DescribeStamps(const Trajectory& trajectory) {
  if (trajectory.empty()) return "no poses";
  return Concat(trajectory.size(), " poses from ", std::fixed, std::setprecision(3),
                trajectory.front().stamp_s, " to ", trajectory.back().stamp_s, " s");
}

// Returns std::nullopt if no offset is requested.
std::optional<TimeOffset> FindTimeOffset(const Trajectory& ground_truth, const Trajectory& estimate,
                                         const TrajectoryOptions& options) {
  if (options.time_offset_s.empty()) return std::nullopt;
  const MatchOptions& match = options.evaluation.match;
  const std::optional<double> given = options.GivenOffset();
  auto offset = given ? EvaluateTimeOffset(ground_truth, estimate, *given, match)
                      : EstimateTimeOffset(ground_truth, estimate, match);
  if (offset) return offset;
  throw InputError(Concat("time_offset_s is '", options.time_offset_s,
                          "': fewer than 3 poses match with ",
                          given ? "this offset" : "any offset up to 0.1 s"));
}

Json ToJson(const TrajectoryEvaluation& e, const std::optional<TimeOffset>& offset,
            const std::optional<MountFit>& mount, TrajectoryOptions options) {
  Json json;
  SetStatistics("ate", "m", &e.ate->translation_m, &json);
  json["time_offset_s"] = offset ? Json(offset->offset_s) : Json();
  SetStatistics("ate_at_time_offset", "m", offset ? &offset->ate.translation_m : nullptr, &json);
  SetStatistics("ate_fit_mount", "m", mount ? &mount->ate.translation_m : nullptr, &json);
  json["mount_m"] = mount ? Json(mount->true_body_in_estimated_m) : Json();
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
  json["options"] = FlagsToJson(TableOf(&options));
  return json;
}

void PrintMount(const MountFit& mount) {
  std::cerr << "with a fitted mount of " << mount.true_body_in_estimated_m.norm() << " m: ATE RMSE "
            << mount.ate.translation_m.rmse << " m" << std::endl;
  const std::string warning = MountWarning(mount);
  if (!warning.empty()) LOG(WARNING) << warning;
}

void PrintSummary(const TrajectoryEvaluation& e, const std::optional<TimeOffset>& offset,
                  const TrajectoryOptions& options) {
  std::cerr << "ATE RMSE " << e.ate->translation_m.rmse << " m over " << e.matched << " of "
            << e.expected << (options.frames.empty() ? " ground-truth poses" : " frames");
  if (e.rpe) {
    std::cerr << ", RPE RMSE " << e.rpe->translation_m.rmse << " m and " << e.rpe->rotation_deg.rmse
              << " deg per step of ";
  } else {
    std::cerr << ", no RPE: no two poses have a distance of ";
  }
  const RelativePoseErrorOptions& rpe = options.evaluation.rpe;
  const bool frames = rpe.delta_unit == RelativePoseErrorOptions::Unit::kFrames;
  std::cerr << rpe.delta << (frames ? " frames" : " seconds") << std::endl;
  if (!offset) return;
  std::cerr << "with a time offset of " << offset->offset_s << " s: ATE RMSE "
            << offset->ate.translation_m.rmse << " m" << std::endl;
}

int RunTrajectory(const TrajectoryOptions& options) {
  const Trajectory ground_truth = ReadTumTrajectory(options.groundtruth);
  const Trajectory estimate = ReadTumTrajectory(options.estimate);
  const auto frames = options.frames.empty() ? Stamps(ground_truth) : ReadTumStamps(options.frames);
  const TrajectoryEvaluation evaluation =
      EvaluateTrajectory(ground_truth, estimate, frames, options.evaluation);
  if (!evaluation.ate) {
    throw InputError(Concat(
        evaluation.matched, " poses match within ", options.evaluation.match.max_difference_s,
        " s, must be at least 3: ", options.groundtruth, " has ", DescribeStamps(ground_truth),
        ", ", options.estimate, " has ", DescribeStamps(estimate)));
  }
  const std::optional<TimeOffset> offset = FindTimeOffset(ground_truth, estimate, options);
  std::optional<MountFit> mount;
  if (options.fit_mount) {
    mount = FitMount(MatchPoses(ground_truth, estimate, options.evaluation.match), false);
  }
  PrintJson(ToJson(evaluation, offset, mount, options));
  PrintSummary(evaluation, offset, options);
  if (mount) PrintMount(*mount);
  return kDone;
}

}  // namespace

Mode TrajectoryEvaluationMode() { return MakeMode("trajectory", RunTrajectory); }

}  // namespace surfit::tools
