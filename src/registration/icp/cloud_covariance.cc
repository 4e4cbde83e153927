#include "registration/icp/cloud_covariance.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "registration/icp/icp_level.h"
#include "registration/icp/own_residuals.h"
#include "registration/icp/residual_rows.h"

namespace surfit {
namespace {

constexpr std::size_t kLeastCells = 12;

struct PairGradient {
  std::array<std::int64_t, 3> cell;
  Vector6d gradient;
};

// Gradients of 1/2 sum of w |r|^2 with fixed weights, per pair.
std::vector<PairGradient> GradientsOf(const PairBuffer& pairs, ResidualType residual,
                                      const RobustKernel& kernel, double cell_m) {
  std::vector<PairGradient> gradients(pairs.size);
  const auto add = [&](int i, const auto& rows) {
    double s = 0;
    Vector6d sum = Vector6d::Zero();
    for (const auto& row : rows) {
      s += row[6] * row[6];
      for (int k = 0; k < 6; ++k) sum[k] += row[k] * row[6];
    }
    const double information = pairs.information[i];
    gradients[i].gradient = information * EvaluateKernel(kernel, information * s).slope * sum;
    for (int axis = 0; axis < 3; ++axis) {
      gradients[i].cell[axis] = static_cast<std::int64_t>(std::floor(pairs.p(i)[axis] / cell_m));
    }
  };
  if (const OwnResidual* const own = OwnResidualOf(residual)) {
    const int rows_of_pair = own->row_count();
    RawVector<float> rows(static_cast<std::size_t>(rows_of_pair) * kRowColumns * pairs.size);
    own->FillRows(pairs, 0, pairs.size, rows.data());
    for (int i = 0; i < pairs.size; ++i) {
      std::vector<std::array<double, kRowColumns>> row(rows_of_pair);
      for (int r = 0; r < rows_of_pair; ++r) {
        for (int k = 0; k < kRowColumns; ++k) {
          row[r][k] = rows[static_cast<std::size_t>(r * kRowColumns + k) * pairs.size + i];
        }
      }
      add(i, row);
    }
    return gradients;
  }
  WithRowsOf(residual, [&](auto type) {
    using Rows = decltype(type);
    for (int i = 0; i < pairs.size; ++i) {
      PairValues<double> pair;
      for (int k = 0; k < 3; ++k) {
        pair.p[k] = pairs.p(i)[k];
        pair.q[k] = pairs.q(i)[k];
        pair.n[k] = pairs.n(i)[k];
        pair.m[k] = pairs.m(i)[k];
      }
      double rows[Rows::kRows][kRowColumns];
      Rows::Evaluate(pair, rows);
      add(i, rows);
    }
    return 0;
  });
  return gradients;
}

// Sum over the cells of g g^T, with the correction C / (C - 6) for C cells and 6 estimated
// parameters. Zero if there are too few cells.
Matrix6d SpreadOf(std::vector<PairGradient>* gradients) {
  std::stable_sort(gradients->begin(), gradients->end(),
                   [](const PairGradient& a, const PairGradient& b) { return a.cell < b.cell; });
  Matrix6d sum = Matrix6d::Zero();
  std::size_t cells = 0;
  for (std::size_t i = 0; i < gradients->size(); ++cells) {
    Vector6d of_cell = Vector6d::Zero();
    const std::size_t first = i;
    for (; i < gradients->size() && (*gradients)[i].cell == (*gradients)[first].cell; ++i) {
      of_cell += (*gradients)[i].gradient;
    }
    sum += of_cell * of_cell.transpose();
  }
  if (cells < kLeastCells) return Matrix6d::Zero();
  return sum * (static_cast<double>(cells) / static_cast<double>(cells - 6));
}

// Steps of numerical derivatives, in standard deviations of the residuals. The robust kernel is
// nearly quadratic within kLocalSigmas. kNoiseSigmas is the size of the noise.
constexpr double kNoiseSigmas = 1, kLocalSigmas = 0.3;

// Derivative of the gradient by central differences, in the coordinates of `motions`: its columns
// move the points by about 1 m. The result is symmetrised, because correspondences have noise.
Matrix6d DerivativeOf(const Matrix6d& motions, double step_m,
                      const std::function<Vector6d(const Vector6d&)>& gradient_at) {
  Matrix6d changes;
  for (int k = 0; k < 6; ++k) {
    const Vector6d step = step_m * motions.col(k);
    changes.col(k) = (gradient_at(step) - gradient_at(-step)) / (2 * step_m);
  }
  const Matrix6d derivative = motions.transpose() * changes;
  return 0.5 * (derivative + derivative.transpose());
}

std::vector<Vector6d> DegenerateDirections(const Matrix6d& motions, const Matrix6d& derivative) {
  // The noise of normals and correspondences changes the eigenvalues by about this ratio.
  constexpr double kSmallest = 3e-4;
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(derivative);
  std::vector<Vector6d> directions;
  for (int i = 0; i < 6 && !(eigen.eigenvalues()[i] > kSmallest * eigen.eigenvalues()[5]); ++i) {
    directions.emplace_back(motions * eigen.eigenvectors().col(i));
  }
  return directions;
}

}  // namespace

double CloudCovariance::StepSigmas() const {
  if (!covariance) return 0;
  return std::sqrt(std::max(0., step_to_minimum.dot(covariance->llt().solve(step_to_minimum))));
}

CloudCovariance CovarianceOfClouds(const Association& association,
                                   const Rigid3d& target_from_source, ResidualType residual,
                                   const RobustKernel& kernel, const CloudErrorScales& scales) {
  CloudCovariance result;
  const NormalSystem system = Linearize(association, target_from_source, residual, kernel);
  if (!(system.weight_sum > 0) || !(scales.noise_m > 0) || !(scales.cell_m > 0)) return result;
  const Eigen::Vector3d center = system.point_sum / system.weight_sum;
  const double radius2 =
      system.point_product_sum.trace() / system.weight_sum - center.squaredNorm();
  if (!(radius2 > 0)) return result;
  // Columns: motions of the points by about 1 m, rotations about the centre.
  Matrix6d motions = Matrix6d::Identity();
  motions.topLeftCorner<3, 3>() /= std::sqrt(radius2);
  motions.bottomLeftCorner<3, 3>() = CrossMatrix<double>(center) / std::sqrt(radius2);
  const auto derivative_over = [&](double step_m) {
    return DerivativeOf(motions, step_m, [&](const Vector6d& increment) {
      return Vector6d(-Linearize(association, LeftIncrement<double>(increment, target_from_source),
                                 residual, kernel)
                           .right_side);
    });
  };
  Matrix6d derivative;
  for (const double sigmas : {kNoiseSigmas, kLocalSigmas}) {
    derivative = derivative_over(sigmas * scales.noise_m);
    result.degenerate_directions = DegenerateDirections(motions, derivative);
    if (!result.degenerate_directions.empty()) return result;
  }

  std::vector<PairGradient> gradients =
      GradientsOf(association.Collect(target_from_source), residual, kernel, scales.cell_m);
  const Matrix6d spread = SpreadOf(&gradients);
  if (spread.isZero(0)) return result;
  const Matrix6d inverse = motions * derivative.inverse() * motions.transpose();
  const Matrix6d covariance = inverse * spread * inverse.transpose();
  result.covariance = 0.5 * (covariance + covariance.transpose());
  result.step_to_minimum = inverse * system.right_side;
  return result;
}

}  // namespace surfit
