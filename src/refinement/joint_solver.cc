#include "refinement/joint_solver.h"

#include <algorithm>
#include <cmath>

#include "refinement/joint_state.h"
#include "refinement/reduced_factor.h"

namespace surfit {
namespace {

// Far below the rounds': some directions hardly matter to the cost.
constexpr double kLeastChange = 1e-6;
// A step counts if the cost falls by more than this share of what the model promised.
constexpr double kLeastGain = 1e-3;

// The damping of Levenberg-Marquardt as Nielsen's rule changes it (Madsen, Nielsen and Tingleff:
// Methods for non-linear least squares problems, 2004, 3.16); start and rule are Ceres'.
class Damping {
 public:
  double value() const { return value_; }
  // gain: how the cost fell, by what the model promised.
  void Accept(double gain) {
    const double excess = 2 * gain - 1;
    value_ *= std::max(1. / 3, 1 - excess * excess * excess);
    growth_ = 2;
  }
  void Reject() {
    value_ *= growth_;
    growth_ *= 2;
  }

 private:
  double value_ = 1e-4, growth_ = 2;
};

JointState Moved(JointState state, const Eigen::VectorXd& increments) {
  for (std::size_t k = 1; k < state.world_from_camera.size(); ++k) {
    const auto begin = static_cast<Eigen::Index>(kPoseTangentSize * k);
    Rigid3d& pose = state.world_from_camera[k];
    const Eigen::Vector3d turn = increments.segment<3>(begin);
    pose.rotation = (QuaternionExp<double>(turn) * pose.rotation).normalized();
    pose.translation += increments.segment<3>(begin + 3);
  }
  Eigen::Matrix<double, kCalibrationSize, 1> calibration;
  CalibrationToBlock(state.calibration, calibration.data());
  calibration += increments.tail<kCalibrationSize>();
  CalibrationFromBlock(calibration.data(), &state.calibration);
  return state;
}

// The cost of a state, and its quadratic model there.
class JointCost {
 public:
  JointCost(const SharedSurfels& shared, const JointPrior& prior, const JointKernels& kernels,
            std::size_t pose_count)
      : shared_(shared), prior_(prior), kernels_(kernels), pattern_(shared, pose_count) {}

  const BlockPattern& pattern() const { return pattern_; }
  double RhoAt(const JointState& state) const {
    return FitOf(shared_, state, kernels_).rho + prior_.Rho(state);
  }
  ReducedSystem ModelAt(const JointState& state) const {
    ReducedSystem system = Reduce(shared_, pattern_, state, kernels_);
    prior_.AddTo(state, &system);
    return system;
  }

 private:
  const SharedSurfels& shared_;
  const JointPrior& prior_;
  JointKernels kernels_;
  BlockPattern pattern_;
};

}  // namespace

std::vector<bool> HeldCalibration(const RefinementOptions& options) {
  std::vector<bool> held(kCalibrationSize, !options.free_depth_field);
  std::fill_n(held.begin(), kFieldBegin, !options.free_intrinsics);
  held[kFieldBegin] = !options.free_depth_offset;
  return held;
}

int MinimizeJointly(const SharedSurfels& shared, const JointPrior& prior,
                    const JointKernels& kernels, const RefinementOptions& options,
                    JointState* state) {
  const JointCost cost(shared, prior, kernels, state->world_from_camera.size());
  ReducedFactor factor(cost.pattern(), HeldCalibration(options));
  ReducedSystem model = cost.ModelAt(*state);
  if (!std::isfinite(model.rho)) return kNoSolution;
  Damping damping;
  int steps = 0;
  while (steps < options.max_iterations) {
    ++steps;
    if (!factor.Factorize(model, damping.value())) {
      damping.Reject();
      continue;
    }
    const ReducedStep step = factor.Solve(model.gradient);
    const JointState moved = Moved(*state, step.increments);
    const double change = model.rho - cost.RhoAt(moved), gain = change / step.rho_decrease;
    const bool accepted = gain > kLeastGain;  // not if one of them is no number
    if (accepted) *state = moved;
    if (std::abs(change) <= kLeastChange * model.rho || steps == options.max_iterations) break;
    if (accepted) {
      damping.Accept(gain);
      model = cost.ModelAt(*state);
    } else {
      damping.Reject();
    }
  }
  return steps;
}

}  // namespace surfit
