#include <Eigen/Householder>
#include <cmath>

#include "cost_functions/robust_kernel.h"
#include "registration/icp/own_residuals.h"
#include "registration/icp/residual_rows.h"
#include "registration/solvers/decompositions.h"
#include "registration/solvers/pair_solver.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

// Solves the 6 x 6 normal equations, which are accumulated during the association.
class NormalSystemSolver final : public PoseSolver {
 public:
  using SystemSolver = Vector6d (*)(const Matrix6d&, const Vector6d&);

  NormalSystemSolver(const PoseSolverOptions& options, SystemSolver solve)
      : PoseSolver(options), solve_(solve) {}

  StepResult Step(const Association& association,
                  const Rigid3d& target_from_source) const override {
    const Stopwatch linearizing;
    StepResult result = Describe(association, target_from_source);
    if (prior() == nullptr) return Solved(linearizing.Milliseconds(), &result);
    const PriorRows rows = prior()->RowsAt(target_from_source);
    return SolvedWithPrior(linearizing.Milliseconds(), rows, &result);
  }
  StepResult Step(const PairBuffer& pairs) const override { return StepOver(pairs); }
  StepResult Step(const Correspondences& pairs) const override { return StepOver(pairs); }

 private:
  template <typename S>
  StepResult StepOver(const Pairs<S>& pairs) const {
    const Stopwatch linearizing;
    StepResult result;
    result.system = Linearize(pairs, options().residual, options().error_model.kernel);
    result.observability = Observe(result.system, options().observability);
    return Solved(linearizing.Milliseconds(), &result);
  }

  StepResult Solved(double linearize_ms, StepResult* result) const {
    const Stopwatch solving;
    result->increment = result->observability.Degenerate()
                            ? SolveObservable(result->system, result->observability)
                            : solve_(result->system.hessian, result->system.right_side);
    result->report.costs = {result->system.JointCost()};
    result->report.linearize_ms = linearize_ms;
    result->report.solve_ms = linearize_ms + solving.Milliseconds();
    return *result;
  }

  StepResult SolvedWithPrior(double linearize_ms, const PriorRows& rows, StepResult* result) const {
    const Stopwatch solving;
    if (result->observability.degenerate_count < 6) {
      const auto jacobian = rows.leftCols<6>();
      const Matrix6d hessian = result->system.hessian + jacobian.transpose() * jacobian;
      const Vector6d right_side = result->system.right_side - jacobian.transpose() * rows.col(6);
      result->increment = solve_(hessian, right_side);
    }
    result->report.costs = {result->system.JointCost() + result->prior_cost};
    result->report.linearize_ms = linearize_ms;
    result->report.solve_ms = linearize_ms + solving.Milliseconds();
    return *result;
  }

  SystemSolver solve_;
};

// Householder QR of the weighted Jacobian. It avoids the squared condition number of the normal
// equations.
class QrSolver final : public PairSolver<QrSolver> {
 public:
  using PairSolver::PairSolver;

  template <typename S>
  Vector6d Solve(const Pairs<S>& pairs, const RobustKernel& kernel,
                 const IntensityPairs& intensities, const Rigid3d* pose, const StepResult& before,
                 SolveReport* report) const {
    const Stopwatch solving;
    if (pose == nullptr && before.observability.Degenerate()) {
      return SolveObservable(before.system, before.observability);
    }
    const int prior_rows = pose != nullptr ? static_cast<int>(PriorRows::RowsAtCompileTime) : 0;
    AllRows rows = RowsOf(pairs, kernel, prior_rows + intensities.size);
    if (intensities.size > 0) SetIntensityRows(intensities, &rows);
    if (pose != nullptr) {
      rows.middleRows<PriorRows::RowsAtCompileTime>(rows.rows() - intensities.size - prior_rows) =
          prior()->RowsAt(*pose);
    }
    report->linearize_ms = solving.Milliseconds();
    Vector6d increment = SolveByQr(&rows);
    report->solve_ms = solving.Milliseconds();
    return increment;
  }

 private:
  using AllRows = Eigen::Matrix<double, Eigen::Dynamic, kRowColumns>;

  // Weighted Jacobian rows of the pairs, followed by `more` uninitialised rows.
  template <typename S>
  AllRows RowsOf(const Pairs<S>& pairs, const RobustKernel& kernel, int more) const {
    if (const OwnResidual* const own = OwnResidualOf(options().residual))
      return WeightedRows(*own, pairs, kernel, more);
    return WithRowsOf(options().residual,
                      [&](auto type) { return WeightedRows<decltype(type)>(pairs, kernel, more); });
  }

  template <typename S>
  static AllRows WeightedRows(const OwnResidual& own, const Pairs<S>& pairs,
                              const RobustKernel& kernel, int more) {
    const int row_count = own.row_count();
    RawVector<S> rows(static_cast<std::size_t>(row_count) * kRowColumns * pairs.size);
    own.FillRows(pairs, 0, pairs.size, rows.data());
    AllRows all(pairs.size * row_count + more, kRowColumns);
    for (int i = 0; i < pairs.size; ++i) {
      auto block = all.middleRows(i * row_count, row_count);
      for (int k = 0; k < row_count; ++k) {
        for (int c = 0; c < kRowColumns; ++c)
          block(k, c) = rows[static_cast<std::size_t>(kRowColumns * k + c) * pairs.size + i];
      }
      const double information = pairs.information[i];
      const double s = information * block.col(kRowColumns - 1).squaredNorm();
      block *= std::sqrt(information * EvaluateKernel(kernel, s).slope);
    }
    return all;
  }

  template <typename Rows, typename S>
  static AllRows WeightedRows(const Pairs<S>& pairs, const RobustKernel& kernel, int more) {
    constexpr int kRows = Rows::kRows;
    AllRows all(pairs.size * kRows + more, kRowColumns);
    for (int i = 0; i < pairs.size; ++i) {
      double rows[kRows][kRowColumns];
      const PairValues<double> pair{{pairs.px[i], pairs.py[i], pairs.pz[i]},
                                    {pairs.qx[i], pairs.qy[i], pairs.qz[i]},
                                    {pairs.nx[i], pairs.ny[i], pairs.nz[i]},
                                    {pairs.mx[i], pairs.my[i], pairs.mz[i]},
                                    pairs.information[i]};
      Rows::Evaluate(pair, rows);
      const Eigen::Map<const Eigen::Matrix<double, kRows, 7, Eigen::RowMajor>> block(rows[0]);
      const double s = pair.information * block.col(6).squaredNorm();
      const double slope = EvaluateKernel(kernel, s).slope;
      all.template middleRows<kRows>(i * kRows) = std::sqrt(pair.information * slope) * block;
    }
    return all;
  }

  // Least-squares solution by QR, column by column. Eigen's blocked class is not faster for six
  // columns, and its compilation takes seconds.
  static Vector6d SolveByQr(AllRows* rows) {
    const Eigen::Index count = rows->rows();
    Eigen::VectorXd right_side = -rows->col(6);
    Eigen::Matrix<double, 1, 6> workspace;
    for (int k = 0; k < 6; ++k) {
      double tau = 0, beta = 0;
      rows->col(k).tail(count - k).makeHouseholderInPlace(tau, beta);
      (*rows)(k, k) = beta;
      const auto essential = rows->col(k).tail(count - k - 1);
      rows->block(k, k + 1, count - k, 5 - k)
          .applyHouseholderOnTheLeft(essential, tau, workspace.data());
      right_side.tail(count - k).applyHouseholderOnTheLeft(essential, tau, workspace.data());
    }
    rows->topLeftCorner(6, 6).triangularView<Eigen::Upper>().solveInPlace(right_side.head(6));
    return right_side.head(6);
  }

  void SetIntensityRows(const IntensityPairs& pairs, AllRows* all) const {
    const PhotometricTerm& term = *photometric();
    for (int i = 0; i < pairs.size; ++i) {
      const IntensityValues<double> values = {{pairs.px[i], pairs.py[i], pairs.pz[i]},
                                              term.exposure().Residual(pairs, i),
                                              pairs.slope_u[i],
                                              pairs.slope_v[i]};
      double rows[IntensityRows::kRows][kRowColumns];
      IntensityRows::Evaluate(values, term.camera().fx, term.camera().fy, rows);
      const double s = term.information() * values.residual * values.residual;
      const double slope = EvaluateKernel(term.kernel(), s).slope;
      all->row(all->rows() - pairs.size + i) =
          std::sqrt(term.information() * slope) *
          Eigen::Map<const Eigen::Matrix<double, 1, kRowColumns>>(rows[0]);
    }
  }
};

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

// Rigid motion that minimises sum w |R p + t - q|^2 (Kabsch 1976, Umeyama 1991). With the centroids
// p0 and q0, R is the rotation nearest to sum w (q - q0) (p - p0)^T, and t = q0 - R p0. The weights
// are the kernel weights at the current pose.
class SvdSolver final : public PairSolver<SvdSolver> {
 public:
  using PairSolver::PairSolver;

  bool ReachesMinimum() const override {
    return options().error_model.kernel.type == RobustKernelType::kNone;
  }

  template <typename S>
  Vector6d Solve(const Pairs<S>& pairs, const RobustKernel& kernel, const IntensityPairs&,
                 const Rigid3d*, const StepResult&, SolveReport* report) const {
    constexpr int kGrain = 4096;
    const Stopwatch solving;
    // Coordinates are relative to the first pair. The difference avoids cancellation far from the
    // origin.
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

std::unique_ptr<PoseSolver> MakeClosedFormSolver(const PoseSolverOptions& options) {
  if (options.name == "closed_form_ldlt") {
    return std::make_unique<NormalSystemSolver>(options, SolveLdlt);
  }
  if (options.name == "closed_form_lu") {
    return std::make_unique<NormalSystemSolver>(options, SolveLu);
  }
  if (options.name == "closed_form_qr") return std::make_unique<QrSolver>(options);
  return nullptr;
}

std::unique_ptr<PoseSolver> MakeSvdSolver(const PoseSolverOptions& options) {
  if (options.name != "svd") return nullptr;
  if (options.residual != ResidualType::kPointToPoint) {
    throw InputError("residual is '", ToString(options.residual),
                     "', must be point_to_point with solver svd; all other solvers take ",
                     "every residual");
  }
  ThrowIf(options.error_model.UsesIntensities(), "photometric_weight is ",
          options.error_model.photometric_weight,
          ", must be 0 with solver svd, which has no photometric residuals");
  return std::make_unique<SvdSolver>(options);
}

}  // namespace surfit
