#include <Eigen/QR>
#include <cmath>

#include "cost_functions/robust_kernel.h"
#include "registration/decompositions.h"
#include "registration/linearize.h"
#include "registration/pair_solver.h"
#include "registration/residual_rows.h"
#include "registration/solver_factories.h"

namespace surfit {
namespace {

// Solves the 6 x 6 system, which is summed while pairs are found.
class NormalSystemSolver final : public PoseSolver {
 public:
  using SystemSolver = Vector6d (*)(const Matrix6d&, const Vector6d&);

  NormalSystemSolver(const PoseSolverOptions& options, SystemSolver solve)
      : PoseSolver(options), solve_(solve) {}

  StepResult Step(const Association& association,
                  const Rigid3d& target_from_source) const override {
    const Stopwatch linearizing;
    StepResult result = Describe(association, target_from_source);
    return Solved(linearizing.Milliseconds(), &result);
  }
  StepResult Step(const PairBuffer& pairs) const override { return StepOver(pairs); }
  StepResult Step(const Correspondences& pairs) const override { return StepOver(pairs); }

 private:
  template <typename S>
  StepResult StepOver(const Pairs<S>& pairs) const {
    const Stopwatch linearizing;
    StepResult result;
    result.system = Linearize(pairs, options().residual,
                              KernelFor(pairs, options().residual, options().error_model));
    result.observability = Observe(result.system, options().held);
    return Solved(linearizing.Milliseconds(), &result);
  }

  StepResult Solved(double linearize_ms, StepResult* result) const {
    const Stopwatch solving;
    result->increment = result->observability.Degenerate()
                            ? SolveHeld(result->system, result->observability)
                            : solve_(result->system.hessian, result->system.right_side);
    result->report.costs = {result->system.JointCost()};
    result->report.linearize_ms = linearize_ms;
    result->report.solve_ms = linearize_ms + solving.Milliseconds();
    return *result;
  }

  SystemSolver solve_;
};

// Householder QR of the matrix of all rows, each times the root of its weight: the condition number
// is not squared.
class QrSolver final : public PairSolver<QrSolver> {
 public:
  using PairSolver::PairSolver;

  template <typename S>
  Vector6d Solve(const Pairs<S>& pairs, const RobustKernel& kernel,
                 const IntensityPairs& intensities, const StepResult& before,
                 SolveReport* report) const {
    const Stopwatch solving;
    if (before.observability.Degenerate()) {
      return SolveHeld(before.system, before.observability);
    }
    AllRows rows = WithRowsOf(options().residual, [&](auto type) {
      return WeightedRows<decltype(type)>(pairs, kernel, intensities.size);
    });
    if (intensities.size > 0) SetIntensityRows(intensities, &rows);
    report->linearize_ms = solving.Milliseconds();
    const Vector6d increment = rows.template leftCols<6>().householderQr().solve(-rows.col(6));
    report->solve_ms = solving.Milliseconds();
    return increment;
  }

 private:
  using AllRows = Eigen::Matrix<double, Eigen::Dynamic, kRowColumns>;

  // Those of the pairs, and room for more at the end.
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

}  // namespace surfit
