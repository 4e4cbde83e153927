#include "common/solver_flags.h"

#include <gflags/gflags.h>

namespace {

const surfit::IcpOptions kIcp;

}  // namespace

DEFINE_string(solver, kIcp.solver,
              "pose solver: closed_form_ldlt, closed_form_lu, closed_form_qr, svd (point_to_point "
              "only), ceres, ceres_per_point or tiny");
DEFINE_string(linear_solver, kIcp.linear_solver,
              "linear solver of ceres_per_point: dense_qr, dense_normal_cholesky or "
              "sparse_normal_cholesky");
DEFINE_string(residual, kIcp.residual,
              "residual: point_to_point, point_to_plane, symmetric_point_to_plane or "
              "plane_to_plane");
DEFINE_string(association, kIcp.association, "data association: projective or kd_tree");

namespace surfit::tools {

void SetSolverFromFlags(IcpOptions* options) {
  options->solver = FLAGS_solver;
  options->linear_solver = FLAGS_linear_solver;
  options->residual = FLAGS_residual;
  options->association = FLAGS_association;
}

}  // namespace surfit::tools
