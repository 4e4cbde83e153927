#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>

#include "registration/solver_factories.h"

namespace surfit {
namespace {

// The step with everything but the increment.
StepResult PrepareStep(const NormalSystem& system, double min_eigenvalue) {
  StepResult result;
  result.system = system;
  result.smallest_eigenvalue = system.ScaledEigenvalues()[0];
  result.singular = !(result.smallest_eigenvalue > min_eigenvalue);
  return result;
}

using SystemSolver = StepResult (*)(const NormalSystem&, double);

// Solves the 6 x 6 system that the association sums while it associates.
class NormalSystemSolver : public PoseSolver {
 public:
  NormalSystemSolver(SystemSolver solve, double min_eigenvalue)
      : solve_(solve), min_eigenvalue_(min_eigenvalue) {}
  StepResult Step(const ProjectiveAssociation& association,
                  const Rigid3d& target_from_source) const override {
    return solve_(association.Linearize(target_from_source), min_eigenvalue_);
  }

 private:
  SystemSolver solve_;
  double min_eigenvalue_;
};

// Solves the N x 6 system of all rows.
class QrSolver : public PoseSolver {
 public:
  explicit QrSolver(double min_eigenvalue) : min_eigenvalue_(min_eigenvalue) {}
  StepResult Step(const ProjectiveAssociation& association,
                  const Rigid3d& target_from_source) const override {
    return SolveQr(association.Collect(target_from_source), min_eigenvalue_);
  }

 private:
  double min_eigenvalue_;
};

}  // namespace

StepResult SolveLdlt(const NormalSystem& system, double min_eigenvalue) {
  StepResult result = PrepareStep(system, min_eigenvalue);
  if (!result.singular) result.increment = system.hessian.ldlt().solve(system.right_side);
  return result;
}

StepResult SolveLu(const NormalSystem& system, double min_eigenvalue) {
  StepResult result = PrepareStep(system, min_eigenvalue);
  if (!result.singular) result.increment = system.hessian.partialPivLu().solve(system.right_side);
  return result;
}

StepResult SolveQr(const Correspondences& c, double min_eigenvalue) {
  StepResult result = PrepareStep(BuildNormalSystem(c), min_eigenvalue);
  if (result.singular) return result;
  Eigen::Matrix<double, Eigen::Dynamic, 6> a(c.size(), 6);
  Eigen::VectorXd b(c.size());
  for (std::size_t i = 0; i < c.size(); ++i) {
    const Eigen::Vector3d p(c.px[i], c.py[i], c.pz[i]);
    const Eigen::Vector3d q(c.qx[i], c.qy[i], c.qz[i]);
    const Eigen::Vector3d n(c.nx[i], c.ny[i], c.nz[i]);
    const double root = std::sqrt(c.weight[i]);
    a.row(i) << root * p.cross(n).transpose(), root * n.transpose();
    b[i] = root * n.dot(q - p);
  }
  result.increment = a.householderQr().solve(b);
  return result;
}

std::unique_ptr<PoseSolver> MakeClosedFormSolver(const PoseSolverOptions& options) {
  const double min_eigenvalue = options.min_eigenvalue;
  if (options.name == "closed_form_ldlt") {
    return std::make_unique<NormalSystemSolver>(SolveLdlt, min_eigenvalue);
  }
  if (options.name == "closed_form_lu") {
    return std::make_unique<NormalSystemSolver>(SolveLu, min_eigenvalue);
  }
  if (options.name == "closed_form_qr") return std::make_unique<QrSolver>(min_eigenvalue);
  return nullptr;
}

}  // namespace surfit
