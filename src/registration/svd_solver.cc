#include "cost_functions/robust_kernel.h"
#include "registration/decompositions.h"
#include "registration/pair_solver.h"
#include "registration/solver_factories.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

// Weighted points of a block, and their products.
struct PointSums {
  double weight = 0;
  Eigen::Vector3d p = Eigen::Vector3d::Zero(), q = Eigen::Vector3d::Zero();
  Eigen::Matrix3d qp = Eigen::Matrix3d::Zero();  // sum of w q p^T

  PointSums& operator+=(const PointSums& other) {
    weight += other.weight;
    p += other.p;
    q += other.q;
    qp += other.qp;
    return *this;
  }
};

// The rigid motion that minimises sum w |R p + t - q|^2 (Kabsch 1976, Umeyama 1991): with centroids
// p0, q0, R is the rotation nearest to sum w (q - q0) (p - p0)^T, and t = q0 - R p0. Weights are
// the kernel's at the present pose.
class SvdSolver final : public PairSolver<SvdSolver> {
 public:
  using PairSolver::PairSolver;

  bool ReachesMinimum() const override {
    return options().error_model.kernel.type == RobustKernelType::kNone;
  }

  template <typename S>
  Vector6d Solve(const Pairs<S>& pairs, const RobustKernel& kernel, const IntensityPairs&,
                 const StepResult&, SolveReport* report) const {
    constexpr int kGrain = 4096;
    const Stopwatch solving;
    // Products about the first pair: far from the origin, centring afterwards would lose digits.
    const Eigen::Vector3d origin = pairs.p(0).template cast<double>();
    const PointSums sums = ParallelSum(0, pairs.size, kGrain, PointSums(), [&](int begin, int end) {
      PointSums sum;
      for (int i = begin; i < end; ++i) {
        const Eigen::Vector3d p = pairs.p(i).template cast<double>() - origin;
        const Eigen::Vector3d q = pairs.q(i).template cast<double>() - origin;
        const double information = pairs.information[i];
        const double s = information * (p - q).squaredNorm();
        const double w = information * EvaluateKernel(kernel, s).slope;
        sum += {w, w * p, w * q, w * q * p.transpose()};
      }
      return sum;
    });
    report->linearize_ms = solving.Milliseconds();
    const Eigen::Vector3d p0 = sums.p / sums.weight, q0 = sums.q / sums.weight;
    const Eigen::Matrix3d rotation = NearestRotation(sums.qp - sums.weight * q0 * p0.transpose());
    const Rigid3d motion(rotation, origin + q0 - rotation * (origin + p0));
    Vector6d increment;
    increment << QuaternionLog<double>(motion.rotation), motion.translation;
    report->solve_ms = solving.Milliseconds();
    return increment;
  }
};

}  // namespace

std::unique_ptr<PoseSolver> MakeSvdSolver(const PoseSolverOptions& options) {
  if (options.name != "svd") return nullptr;
  if (options.residual != ResidualType::kPointToPoint) {
    throw InputError(Concat("residual is '", ToString(options.residual),
                            "', must be point_to_point with solver svd; all other solvers take ",
                            "every residual"));
  }
  if (options.error_model.UsesIntensities()) {
    throw InputError(Concat("photometric_weight is ", options.error_model.photometric_weight,
                            ", must be 0 with solver svd, which knows points only"));
  }
  return std::make_unique<SvdSolver>(options);
}

}  // namespace surfit
