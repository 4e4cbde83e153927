#include <memory>
#include <random>

#include "apps/solvers/pose_problem.h"
#include "registration/solvers/pair_solver.h"
#include "surfit/core/parallel.h"
#include "surfit/registration/pose_solver.h"

namespace surfit {
namespace {

constexpr int kMaxSteps = 50;
constexpr double kSmallestStep = 1e-6;  // rad, m; above single-precision rounding
constexpr double kTruthRotation_rad = 0.3, kTruthTranslation_m = 0.5;

Eigen::Vector3d RandomVector(double size, std::mt19937_64* rng) {
  std::uniform_real_distribution<double> coordinate(-size, size);
  Eigen::Vector3d vector;
  for (int i = 0; i < 3; ++i) vector[i] = coordinate(*rng);
  return vector;
}

// Random correspondences. The source points are in a cube with sides of 2 m, centred 3 m in front
// of the camera. The target points have noise, which is also the standard deviation of the error
// model. Exact points have floor_sigma_m.
PairBuffer MakePairs(const CompareOptions& options, const Rigid3d& target_from_source) {
  std::mt19937_64 rng(options.seed);
  std::normal_distribution<double> noise(0, 1);
  const double sigma_m =
      options.noise_m > 0 ? options.noise_m : options.icp.error_model.floor_sigma_m;
  PairBuffer pairs;
  for (int i = 0; i < options.synthetic_points; ++i) {
    const Eigen::Vector3d p = Eigen::Vector3d(0, 0, 3) + RandomVector(1, &rng);
    const Eigen::Vector3d m = RandomVector(1, &rng).normalized();
    Eigen::Vector3d q = target_from_source * p;
    for (int k = 0; k < 3; ++k) q[k] += options.noise_m * noise(rng);
    const Eigen::Vector3d n = target_from_source.rotation * m;
    pairs.Add(p.cast<float>(), q.cast<float>(), n.cast<float>(), m.cast<float>(),
              static_cast<float>(1 / (sigma_m * sigma_m)));
  }
  pairs.SetCapacity(pairs.size);
  return pairs;
}

void MoveSource(const PairBuffer& pairs, const Rigid3d& motion, PairBuffer* moved) {
  const Eigen::Matrix3f r = motion.rotation.toRotationMatrix().cast<float>();
  const Eigen::Vector3f t = motion.translation.cast<float>();
  const auto turn = [&](const float* a, const float* b, const float* c, int row, float offset,
                        float* to, int begin, int end) {
    const float r0 = r(row, 0), r1 = r(row, 1), r2 = r(row, 2);
    for (int i = begin; i < end; ++i) to[i] = r0 * a[i] + r1 * b[i] + r2 * c[i] + offset;
  };
  ParallelFor(0, pairs.size, 4096, [&](int begin, int end) {
    float* const p[] = {moved->px.data(), moved->py.data(), moved->pz.data()};
    float* const m[] = {moved->mx.data(), moved->my.data(), moved->mz.data()};
    for (int k = 0; k < 3; ++k) {
      turn(pairs.px.data(), pairs.py.data(), pairs.pz.data(), k, t[k], p[k], begin, end);
      turn(pairs.mx.data(), pairs.my.data(), pairs.mz.data(), k, 0, m[k], begin, end);
    }
  });
}

PoseSolverOptions SolverOptionsOf(const SolverCombination& combination, const IcpOptions& icp) {
  PoseSolverOptions options;
  options.name = combination.solver;
  if (!combination.linear_solver.empty()) options.linear_solver = combination.linear_solver;
  options.residual = ResidualTypeFromName(combination.residual);
  options.error_model = icp.error_model;
  options.error_model.kernel.type = RobustKernelType::kNone;
  options.observability = icp.observability;
  return options;
}

// A step with constant covariances of the residuals. The covariances of planes rotate with the
// source points between steps, so that steps repeat.
bool EndsAfterOneStep(const PoseSolver& solver, ResidualType residual) {
  return solver.ReachesMinimum() && residual != ResidualType::kPlaneToPlane;
}

SolveOutcome Solve(const PairBuffer& pairs, const PoseSolverOptions& options,
                   const Rigid3d& start) {
  const std::unique_ptr<PoseSolver> solver = MakePoseSolver(options);
  SolveOutcome outcome;
  outcome.points = pairs.size;
  outcome.target_from_source = start;
  PairBuffer moved = pairs;
  std::vector<SolveReport> reports;
  const Stopwatch total;
  for (int i = 0; i < kMaxSteps && !outcome.succeeded; ++i) {
    MoveSource(pairs, outcome.target_from_source, &moved);
    const StepResult step = solver->Step(moved);
    outcome.target_from_source = LeftIncrement<double>(step.increment, outcome.target_from_source);
    outcome.succeeded =
        EndsAfterOneStep(*solver, options.residual) || step.increment.norm() < kSmallestStep;
    reports.push_back(step.report);
  }
  outcome.total_ms = total.Milliseconds();
  SetTimes(reports, &outcome);

  MoveSource(pairs, outcome.target_from_source, &moved);
  const NormalSystem at_end = Linearize(moved, options.residual, options.error_model.kernel);
  outcome.final_cost = at_end.cost;
  for (const SolveReport& report : reports) {
    outcome.iterations += static_cast<int>(report.costs.size());
    // Without a robust kernel, the cost is half of the weighted sum of squared residuals.
    for (const double cost : report.costs) outcome.losses.push_back(2 * cost / at_end.weight_sum);
  }
  outcome.losses.push_back(at_end.AverageLoss());
  return outcome;
}

}  // namespace

PoseProblems KnownPairsProblems(const CompareOptions& options) {
  return {1, [&options](int) {
            const Rigid3d truth =
                Perturbed(Rigid3d(), kTruthRotation_rad, kTruthTranslation_m, options.seed);
            const auto pairs = std::make_shared<const PairBuffer>(MakePairs(options, truth));
            PoseProblem problem;
            problem.truth = problem.center = truth;
            problem.solve = [&options, pairs](const SolverCombination& combination,
                                              const Rigid3d& start) {
              return Solve(*pairs, SolverOptionsOf(combination, options.icp), start);
            };
            return problem;
          }};
}

}  // namespace surfit
