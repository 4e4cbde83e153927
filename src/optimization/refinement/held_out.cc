#include "optimization/refinement/held_out.h"

#include <Eigen/QR>
#include <cmath>
#include <cstddef>
#include <vector>

#include "optimization/refinement/reduced_factor.h"

namespace surfit {
namespace {

struct KeyframeRange {
  int begin = 0, end = 0;
};

// Keyframes of a range with the surfels that at least two of them observe. Textures are left out.
struct Half {
  SharedSurfels shared;
  JointState state;
};

Half HalfOf(const SharedSurfels& all, const JointState& state, const KeyframeRange& range) {
  Half half;
  half.state.calibration = state.calibration;
  for (int k = range.begin; k < range.end; ++k) {
    half.state.world_from_camera.push_back(state.world_from_camera[k]);
    half.shared.readouts.push_back(all.readouts[k]);
  }
  std::vector<PlaneObservation>& observations = half.shared.observations;
  for (SharedSurfel surfel : all.surfels) {
    const std::size_t first = observations.size();
    for (std::size_t i = surfel.begin; i < surfel.end; ++i) {
      PlaneObservation seen = all.observations[i];
      if (seen.keyframe < range.begin || seen.keyframe >= range.end) continue;
      seen.keyframe -= range.begin;
      observations.push_back(seen);
    }
    if (observations.size() - first < 2) {
      observations.resize(first);
      continue;
    }
    surfel.begin = first;
    surfel.end = observations.size();
    surfel.textures_begin = surfel.textures_end = 0;
    half.shared.surfels.push_back(surfel);
  }
  return half;
}

// Cost of a half as a function of the calibration.
struct CalibrationCost {
  CalibrationModel model;
  double variance = 0;  // 0: no redundant observations

  double At(const CalibrationRow& change) const {
    return model.gradient.dot(change) + change.dot(model.information * change) / 2;
  }
};

CalibrationCost CostOf(const Half& half, const RefinementOptions& options) {
  const auto& [shared, state] = half;
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

}  // namespace

HalfGains GainsOf(const SharedSurfels& shared, const JointState& found,
                  const DepthCalibration& given, const JointPrior& prior,
                  const RefinementOptions& options) {
  const int count = static_cast<int>(found.world_from_camera.size());
  const KeyframeRange halves[] = {{0, count / 2}, {count / 2, count}};
  std::array<CalibrationCost, 2> costs;
  for (int h = 0; h < 2; ++h) {
    costs[h] = CostOf(HalfOf(shared, found, halves[h]), options);
  }
  const CalibrationModel of_prior = ModelOf(prior, found, FixedCalibration(options));
  const CalibrationRow to_given = BlockOf(given) - BlockOf(found.calibration);
  HalfGains gains;
  for (int h = 0; h < 2; ++h) {
    const CalibrationCost &tested = costs[h], &other = costs[1 - h];
    if (!(tested.variance > 0)) continue;
    const auto gain_of = [&](const CalibrationRow& change) {
      return 2 * (tested.At(to_given) - tested.At(change)) / tested.variance;
    };
    gains.own[h] = gain_of(CalibrationRow::Zero());
    if (other.variance > 0) gains.held_out[h] = gain_of(StepToMinimum(other.model + of_prior));
  }
  return gains;
}

}  // namespace surfit
