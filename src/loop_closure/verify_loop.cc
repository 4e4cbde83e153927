#include <algorithm>
#include <iterator>
#include <utility>

#include "registration/global/feature_points.h"
#include "registration/global/register_from.h"
#include "surfit/core/options.h"
#include "surfit/loop_closure/find_loops.h"

namespace surfit {
namespace {

constexpr double kMinOverlapWithoutColor = 0.5;

class ExpandedView {
 public:
  // The view must not be empty.
  ExpandedView(const PlaceView& view, const PreprocessOptions& preprocess)
      : has_color_(!view.intensity.empty()) {
    constexpr int kCoarserLevels = 2;
    std::vector<FrameLevel> levels = PyramidOf(view, preprocess).levels;
    if (levels.size() == 1) levels.push_back(levels.front());
    const int last = std::min<int>(static_cast<int>(levels.size()), 1 + kCoarserLevels);
    finest_.levels.push_back(std::move(levels.front()));
    std::move(levels.begin() + 1, levels.begin() + last, std::back_inserter(coarser_.levels));
    const FrameLevel& level = coarser_.levels.front();
    Image<float> value(level.camera.width, level.camera.height);
    for (std::size_t i = 0; i < level.intensity.size(); ++i) {
      value[i] = level.intensity[i] >= 0 ? level.intensity[i] : 0;
    }
    brightness_ = BrightnessOf(std::move(value));
  }

  GlobalView ForRegistration() const {
    return {coarser_, finest_, {coarser_.levels.front(), brightness_}, has_color_};
  }

 private:
  FramePyramid finest_;   // finest level only
  FramePyramid coarser_;  // coarser levels, or the finest level if it is the only one
  BrightnessLevel brightness_;
  bool has_color_;
};

FeaturePoints PointsOf(const PlaceView& view, const ErrorModel& error_model) {
  FeaturePoints features;
  for (const PlaceFeature& feature : view.features) {
    features.points.emplace_back(feature.point.cast<double>());
    features.sigmas_m.push_back(SigmaOfFeature(feature.point.z(), kFeaturePlaceSigmaPx,
                                               {view.camera, view.noise}, error_model));
    features.descriptors.push_back(feature.descriptor);
  }
  return features;
}

// Initial poses with enough inlier features, by descending number of inliers.
std::vector<Rigid3d> StartsFromFeatures(const PlaceView& source, const PlaceView& target,
                                        const VerifyLoopOptions& options,
                                        GlobalRegistrationResult* verdict) {
  constexpr int kMaxPoses = 3, kConsensusTries = 500;
  constexpr int kMinAgreeing = 12;  // inlier features of an initial pose
  const FeaturePoints from = PointsOf(source, options.icp.error_model);
  const FeaturePoints to = PointsOf(target, options.icp.error_model);
  const std::vector<FeatureMatch> matches = MatchFeatures(from, to);
  verdict->matches = static_cast<int>(matches.size());
  std::vector<Rigid3d> starts;
  for (const Consensus& consensus : FindConsensus(from, to, matches, kMaxPoses, kConsensusTries)) {
    const int agreeing = static_cast<int>(consensus.inliers.size());
    verdict->agreeing_features = std::max(verdict->agreeing_features, agreeing);
    if (agreeing >= kMinAgreeing) starts.push_back(consensus.target_from_source);
  }
  return starts;
}

}  // namespace

GlobalRegistrationResult VerifyLoop(const PlaceView& source, const PlaceView& target,
                                    const VerifyLoopOptions& options,
                                    const std::optional<Rigid3d>& target_from_source_prior) {
  Validate(options);
  GlobalRegistrationResult verdict;
  if (source.empty() || target.empty()) return verdict;
  std::vector<Rigid3d> starts = StartsFromFeatures(source, target, options, &verdict);
  if (target_from_source_prior) starts.push_back(*target_from_source_prior);
  if (starts.empty()) {
    verdict.reason = GlobalRegistrationReason::kNoStart;
    return verdict;
  }
  IcpOptions coarse_icp = options.icp;
  coarse_icp.gates.max_distance_m *= options.icp.gate_growth;
  coarse_icp.error_model.floor_sigma_m *= 2;
  const ExpandedView from(source, options.preprocess), to(target, options.preprocess);
  FitCriteria fit = options.fit;
  // The surfaces alone decide. They must overlap more, because many places have similar shapes.
  if (source.intensity.empty() && target.intensity.empty()) {
    fit.needs_color = false;
    fit.min_overlap_ratio = std::max(fit.min_overlap_ratio, kMinOverlapWithoutColor);
  }
  return RegisterFrom(starts, from.ForRegistration(), to.ForRegistration(),
                      {coarse_icp, options.icp, fit}, verdict);
}

}  // namespace surfit
