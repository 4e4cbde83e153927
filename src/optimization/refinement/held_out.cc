#include "optimization/refinement/held_out.h"

#include <cmath>
#include <cstddef>
#include <vector>

#include "optimization/refinement/reduced_factor.h"

namespace surfit {
namespace {

constexpr int kFolds = 5;

struct KeyframeRange {
  int begin = 0, end = 0;

  bool Contains(int keyframe) const { return keyframe >= begin && keyframe < end; }
};

// Some keyframes with the surfels that at least two of them observe. Textures are left out.
struct Part {
  SharedSurfels shared;
  JointState state;
};

// Part with the keyframes of a range, or with all others.
Part PartOf(const SharedSurfels& all, const JointState& state, const KeyframeRange& range,
            bool inside) {
  constexpr int kOutside = -1;
  Part part;
  part.state.calibration = state.calibration;
  std::vector<int> keyframe_in_part(state.world_from_camera.size(), kOutside);
  for (std::size_t k = 0; k < keyframe_in_part.size(); ++k) {
    if (range.Contains(static_cast<int>(k)) != inside) continue;
    keyframe_in_part[k] = static_cast<int>(part.state.world_from_camera.size());
    part.state.world_from_camera.push_back(state.world_from_camera[k]);
    part.shared.readouts.push_back(all.readouts[k]);
  }
  std::vector<PlaneObservation>& observations = part.shared.observations;
  for (SharedSurfel surfel : all.surfels) {
    const std::size_t first = observations.size();
    for (std::size_t i = surfel.begin; i < surfel.end; ++i) {
      PlaneObservation seen = all.observations[i];
      seen.keyframe = keyframe_in_part[seen.keyframe];
      if (seen.keyframe != kOutside) observations.push_back(seen);
    }
    if (observations.size() - first < 2) {
      observations.resize(first);
      continue;
    }
    surfel.begin = first;
    surfel.end = observations.size();
    surfel.textures_begin = surfel.textures_end = 0;
    part.shared.surfels.push_back(surfel);
  }
  return part;
}

// Cost of a part as a function of the calibration.
struct CalibrationCost {
  CalibrationModel model;
  double variance = 0;  // 0: no redundant observations

  double At(const CalibrationRow& change) const {
    return model.gradient.dot(change) + change.dot(model.information * change) / 2;
  }
};

CalibrationCost CostOf(const Part& part, const RefinementOptions& options) {
  const auto& [shared, state] = part;
  const JointKernels kernels = KernelsOf(options.error_model);
  CalibrationCost cost;
  cost.variance = VarianceOf(FitOf(shared, state, kernels), shared, state, options);
  if (!(cost.variance > 0)) return cost;
  const BlockPattern pattern(shared, state.world_from_camera.size());
  cost.model = MarginalOf(Reduce(shared, pattern, state, kernels), FixedCalibration(options));
  return cost;
}

// Change of the calibration to the minimum of a model. Fixed and unobservable parameters do not
// change.
CalibrationRow StepToMinimum(const CalibrationModel& model) {
  const CalibrationRow scale = model.information.diagonal().unaryExpr(
      [](double diagonal) { return diagonal > 0 ? 1 / std::sqrt(diagonal) : 0; });
  const ReducedSystem::CalibrationMatrix scaled =
      scale.asDiagonal() * model.information * scale.asDiagonal();
  const CalibrationRow right = scale.cwiseProduct(model.gradient);
  return -scale.cwiseProduct(scaled.completeOrthogonalDecomposition().solve(right));
}

CalibrationRow BlockOf(const DepthCalibration& calibration) {
  CalibrationRow block;
  CalibrationToBlock(calibration, block.data());
  return block;
}

// Cost of the prior at the state.
CalibrationModel ModelOf(const JointPrior& prior, const JointState& state,
                         const std::vector<bool>& fixed) {
  const BlockPattern pattern({}, state.world_from_camera.size());
  ReducedSystem system(pattern);
  prior.AddTo(state, &system);
  CalibrationModel model = {system.calibration, system.gradient.tail<kCalibrationSize>()};
  for (int i = 0; i < kCalibrationSize; ++i) {
    if (fixed[i]) model.Fix(i);
  }
  return model;
}

// Decrease of the squared residuals of a part from one change of the calibration to another, in
// units of their variance.
double GainOf(const CalibrationCost& tested, const CalibrationRow& from, const CalibrationRow& to) {
  return 2 * (tested.At(from) - tested.At(to)) / tested.variance;
}

}  // namespace

HalfGains GainsOf(const SharedSurfels& shared, const JointState& found,
                  const DepthCalibration& given, const JointPrior& prior,
                  const RefinementOptions& options) {
  const int count = static_cast<int>(found.world_from_camera.size());
  const KeyframeRange first_half = {0, count / 2};
  const std::array<CalibrationCost, 2> costs = {
      CostOf(PartOf(shared, found, first_half, true), options),
      CostOf(PartOf(shared, found, first_half, false), options)};
  const CalibrationModel of_prior = ModelOf(prior, found, FixedCalibration(options));
  const CalibrationRow to_given = BlockOf(given) - BlockOf(found.calibration);
  HalfGains gains;
  for (int h = 0; h < 2; ++h) {
    const CalibrationCost &tested = costs[h], &other = costs[1 - h];
    if (!(tested.variance > 0)) continue;
    gains.own[h] = GainOf(tested, to_given, CalibrationRow::Zero());
    if (other.variance > 0) {
      gains.held_out[h] = GainOf(tested, to_given, StepToMinimum(other.model + of_prior));
    }
  }
  return gains;
}

double HeldOutGain(const RefinementOptions& options, const DepthCalibration& given,
                   const DepthCalibration& start, const DepthCalibration& found_calibration,
                   const std::vector<RefinementKeyframe>& keyframes) {
  JointState found;
  found.calibration = found_calibration;
  for (const RefinementKeyframe& keyframe : keyframes) {
    found.world_from_camera.push_back(keyframe.world_from_camera);
  }
  const SharedSurfels shared = MakeSharedSurfels(keyframes, found.calibration, options);
  JointPrior prior(given, options.prior.Over({}));
  prior.SetWeight(
      VarianceOf(FitOf(shared, found, KernelsOf(options.error_model)), shared, found, options));
  const CalibrationModel of_prior = ModelOf(prior, found, FixedCalibration(options));
  const CalibrationRow to_start = BlockOf(start) - BlockOf(found.calibration);
  const int count = static_cast<int>(keyframes.size());
  double gain = 0;
  for (int f = 0; f < kFolds; ++f) {
    const KeyframeRange fold = {f * count / kFolds, (f + 1) * count / kFolds};
    const CalibrationCost tested = CostOf(PartOf(shared, found, fold, true), options);
    const CalibrationCost others = CostOf(PartOf(shared, found, fold, false), options);
    if (!(tested.variance > 0) || !(others.variance > 0)) continue;
    gain += GainOf(tested, to_start, StepToMinimum(others.model + of_prior));
  }
  return gain;
}

}  // namespace surfit
