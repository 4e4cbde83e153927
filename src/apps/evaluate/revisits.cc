#include "apps/evaluate/revisits.h"

#include <memory>
#include <optional>
#include <vector>

#include "run/posed_views.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/evaluation/trajectory_evaluation.h"

namespace surfit {
namespace {

struct TruePosedFrame {
  int index;
  Rigid3d true_pose, estimated_pose;  // world_from_camera
};

struct RelativePoses {
  int source, target;        // frame indices
  Rigid3d truth, estimated;  // target_from_source
};

std::vector<TruePosedFrame> ReadFrames(const RevisitOptions& options, int* without_pose) {
  const std::unique_ptr<FrameSource> source = OpenSequence(options.sequence);
  const SequenceInfo& info = source->info();
  if (info.ground_truth.empty()) {
    throw InputError(Concat(options.sequence.path, ": the sequence has no ground truth"));
  }
  const Trajectory estimate = ReadEstimate(options.estimate, info);
  std::vector<TruePosedFrame> frames;
  while (const std::optional<ReadResult> result = source->Next()) {
    const auto truth = InterpolatePose(info.ground_truth, result->stamp_s);
    const auto estimated = InterpolatePose(estimate, result->stamp_s);
    if (result->frame && truth && estimated) {
      frames.push_back({result->index, *truth, *estimated});
    } else {
      ++*without_pose;
    }
  }
  return frames;
}

std::vector<RelativePoses> FindRevisits(const std::vector<TruePosedFrame>& frames,
                                        const RevisitOptions& options) {
  std::vector<RelativePoses> revisits;
  for (const TruePosedFrame& target : frames) {
    for (const TruePosedFrame& source : frames) {
      if (source.index - target.index < options.min_gap) continue;
      const Rigid3d truth = target.true_pose.Inverse() * source.true_pose;
      if (truth.translation.norm() > options.max_distance_m) continue;
      if (RotationAngle(truth.rotation) > options.max_angle_rad) continue;
      revisits.push_back({source.index, target.index, truth,
                          target.estimated_pose.Inverse() * source.estimated_pose});
    }
  }
  return revisits;
}

struct PairErrors {
  double surface_m, icp_translation_m, icp_rotation_deg;
};

struct Errors {
  std::vector<double> surface_m, icp_translation_m, icp_rotation_deg;

  void Add(const PairErrors& errors) {
    surface_m.push_back(errors.surface_m);
    icp_translation_m.push_back(errors.icp_translation_m);
    icp_rotation_deg.push_back(errors.icp_rotation_deg);
  }
  SurfaceAgreement Summary() const {
    return {Summarize(surface_m), Summarize(icp_translation_m), Summarize(icp_rotation_deg)};
  }
};

IcpOptions ThoroughIcp() {
  IcpOptions options;
  options.max_iterations = 50;
  options.min_relative_rmse_change = 1e-5;
  return options;
}

// Measures the surface distance at the given relative pose, and the correction of this pose by ICP.
// Returns std::nullopt if the views do not overlap or ICP fails.
std::optional<PairErrors> Measure(const FramePyramid& source, const FramePyramid& target,
                                  const Rigid3d& target_from_source) {
  const auto surface_m =
      MedianSurfaceDistance(source.levels.front(), target.levels.front(), target_from_source);
  const IcpResult icp = Register(source, target, target_from_source, ThoroughIcp());
  if (!surface_m || !icp.Succeeded()) return std::nullopt;
  const PoseError moved = ErrorOf(icp.target_from_source, target_from_source);
  return PairErrors{*surface_m, moved.translation_m, moved.rotation_deg};
}

}  // namespace

RevisitReport CompareAtRevisits(const RevisitOptions& options,
                                const std::function<void(int, int)>& progress) {
  Validate(options);
  RevisitReport report;
  const std::vector<RelativePoses> revisits =
      FindRevisits(ReadFrames(options, &report.without_pose), options);
  report.pairs = static_cast<int>(revisits.size());
  Errors of_truth, of_estimate;
  int done = 0;
  for (const RelativePoses& pair : revisits) {
    const auto view = [&](int index) {
      return ReadPosedView(options.sequence, index, options.preprocess).view.pyramid;
    };
    const FramePyramid source = view(pair.source), target = view(pair.target);
    const std::optional<PairErrors> truth = Measure(source, target, pair.truth);
    const std::optional<PairErrors> estimated = Measure(source, target, pair.estimated);
    if (truth && estimated) {
      of_truth.Add(*truth);
      of_estimate.Add(*estimated);
    } else {
      ++report.unregistered;
    }
    progress(++done, report.pairs);
  }
  if (report.unregistered == report.pairs) return report;
  report.ground_truth = of_truth.Summary();
  report.estimate = of_estimate.Summary();
  return report;
}

}  // namespace surfit
