#include "places/loop_starts.h"

#include <algorithm>

#include "places/match_features.h"
#include "registration/consensus.h"

namespace surfit {
namespace {

constexpr int kMostPoses = 3;
constexpr int kConsensusTries = 500;

// Without descriptors.
FeaturePoints PointsOf(const PlaceView& view, const ErrorModel& error_model) {
  FeaturePoints features;
  for (const PlaceFeature& feature : view.features) {
    features.points.push_back(feature.point.cast<double>());
    features.sigmas_m.push_back(
        SigmaOfFeature(feature.point.z(), {view.camera, view.noise}, error_model));
  }
  return features;
}

}  // namespace

LoopStarts FindLoopStarts(const PlaceView& source, const PlaceView& target,
                          const VerifyLoopOptions& options) {
  const std::vector<FeatureMatch> matches = MatchFeatures(source.features, target.features);
  LoopStarts starts;
  starts.matches = static_cast<int>(matches.size());
  const ErrorModel& error_model = options.icp.error_model;
  for (const Consensus& consensus :
       FindConsensus(PointsOf(source, error_model), PointsOf(target, error_model), matches,
                     kMostPoses, kConsensusTries)) {
    const int agreeing = static_cast<int>(consensus.inliers.size());
    starts.agreeing_features = std::max(starts.agreeing_features, agreeing);
    if (agreeing < options.min_agreeing_features) continue;
    starts.target_from_source.push_back(consensus.target_from_source);
  }
  return starts;
}

}  // namespace surfit
