#include "optimization/refinement/joint_solver.h"

#include <algorithm>
#include <cmath>

#include "core/named_values.h"
#include "optimization/refinement/joint_state.h"
#include "optimization/refinement/reduced_factor.h"
#include "registration/solvers/pair_solver.h"

namespace surfit {
namespace {

// Minimum ratio of actual and predicted cost decrease of an accepted step.
constexpr double kMinGain = 1e-3;

// Damping of Levenberg-Marquardt by Nielsen's rule (Madsen, Nielsen and Tingleff: Methods for
// non-linear least squares problems, 2004, 3.16), with the initial value of Ceres.
class Damping {
 public:
  double value() const { return value_; }
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

class JointCost {
 public:
  JointCost(const JointProblem& problem, std::size_t pose_count)
      : problem_(problem), pattern_(problem.shared, pose_count) {}

  const BlockPattern& pattern() const { return pattern_; }
  double RhoAt(const JointState& state) const {
    return FitOf(problem_.shared, state, problem_.kernels).rho + problem_.prior.Rho(state);
  }
  ReducedSystem ModelAt(const JointState& state) const {
    ReducedSystem system = Reduce(problem_.shared, pattern_, state, problem_.kernels);
    problem_.prior.AddTo(state, &system);
    return system;
  }

 private:
  const JointProblem& problem_;
  BlockPattern pattern_;
};

constexpr NamedValue<decltype(&MinimizeJointly)> kSolvers[] = {{"reduced", &MinimizeReduced},
                                                               {"ceres", &MinimizeWithCeres}};

}  // namespace

std::vector<std::string> RefinementSolverNames() { return NamesOf(kSolvers); }

std::vector<bool> FixedCalibration(const RefinementOptions& options) {
  std::vector<bool> held(kCalibrationSize, !options.estimate_depth_field);
  std::fill_n(held.begin(), kFieldBegin, !options.estimate_intrinsics);
  held[kFieldBegin] = !options.estimate_depth_offset;
  held[kReadout] = !options.estimate_readout;
  return held;
}

JointReport MinimizeJointly(const JointProblem& problem, const RefinementOptions& options,
                            JointState* state) {
  return ValueOf("solver", options.solver, kSolvers)(problem, options, state);
}

JointReport MinimizeReduced(const JointProblem& problem, const RefinementOptions& options,
                            JointState* state) {
  const Stopwatch solving;
  const JointCost cost(problem, state->world_from_camera.size());
  ReducedFactor factor(cost.pattern(), FixedCalibration(options));
  JointReport report;
  const Stopwatch linearizing;
  ReducedSystem model = cost.ModelAt(*state);
  report.linearize_ms = linearizing.Milliseconds();
  if (!std::isfinite(model.rho)) {
    report.iterations = kNoSolution;
    return report;
  }
  report.costs.push_back(model.rho / 2);
  Damping damping;
  while (report.iterations < options.max_iterations) {
    ++report.iterations;
    if (!factor.Factorize(model, damping.value())) {
      damping.Reject();
      continue;
    }
    const ReducedStep step = factor.Solve(model.gradient);
    const JointState moved = Moved(*state, step.increments);
    const double rho = cost.RhoAt(moved);
    const double change = model.rho - rho, gain = change / step.rho_decrease;
    const bool accepted = gain > kMinGain;  // false if a value is NaN
    if (accepted) {
      *state = moved;
      report.costs.push_back(rho / 2);
    }
    const bool ends = std::abs(change) <= options.min_relative_step_change * model.rho;
    if (ends || report.iterations == options.max_iterations) break;
    if (accepted) {
      damping.Accept(gain);
      model = cost.ModelAt(*state);
    } else {
      damping.Reject();
    }
  }
  report.solve_ms = solving.Milliseconds();
  return report;
}

}  // namespace surfit
