#include "registration/icp/cloud_covariance.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>

#include "registration/icp/icp_level.h"
#include "registration/icp/own_residuals.h"
#include "registration/icp/residual_rows.h"
#include "registration/icp/row_finder.h"
#include "surfit/core/lanes.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/registration/icp.h"

namespace surfit {
namespace {

constexpr std::size_t kLeastCells = 12;

using ErrorCell = std::array<std::int64_t, 3>;

ErrorCell ErrorCellOf(const Eigen::Vector3d& point, const CloudErrorScales& scales) {
  Eigen::Vector3d at = point;
  if (scales.camera != nullptr) at << scales.camera->Project(point), 0;
  at /= scales.cell;
  ErrorCell cell;
  for (int axis = 0; axis < 3; ++axis) {
    cell[axis] = static_cast<std::int64_t>(std::floor(at[axis]));
  }
  return cell;
}

// Sums over the points of a cell.
struct CellSums {
  Vector6d gradient = Vector6d::Zero();  // of 1/2 sum of w |r|^2, with fixed weights w
  Matrix6d hessian = Matrix6d::Zero();   // Gauss-Newton

  // Adds the rows (Jacobian, residual) of a correspondence.
  template <typename Rows>
  void Add(const Rows& rows, double information, const RobustKernel& kernel) {
    double s = 0;
    for (const auto& row : rows) s += row[6] * row[6];
    const double weight = information * EvaluateKernel(kernel, information * s).slope;
    for (const auto& row : rows) {
      const Vector6d slope = Vector6d::Map(&row[0]);
      gradient += weight * row[6] * slope;
      hessian += weight * slope * slope.transpose();
    }
  }
};

// Sums of all cells of size `scales.cell` with points, in the order of their indices.
std::vector<CellSums> SumsOfCells(const PairBuffer& pairs, ResidualType residual,
                                  const RobustKernel& kernel, const CloudErrorScales& scales) {
  std::map<ErrorCell, CellSums> cells;
  const auto add_all = [&](const auto& rows_of) {
    CellSums* sums = nullptr;
    ErrorCell last = {};
    for (int i = 0; i < pairs.size; ++i) {
      const ErrorCell cell = ErrorCellOf(pairs.p(i).cast<double>(), scales);
      // Most points are in the cell of the previous point.
      if (sums == nullptr || cell != last) sums = &cells[cell];
      last = cell;
      sums->Add(rows_of(i), pairs.information[i], kernel);
    }
    std::vector<CellSums> all;
    all.reserve(cells.size());
    for (const auto& [cell_index, sums_of_cell] : cells) all.push_back(sums_of_cell);
    return all;
  };
  if (const OwnResidual* const own = OwnResidualOf(residual)) {
    const int rows_of_pair = own->row_count();
    RawVector<float> rows(static_cast<std::size_t>(rows_of_pair) * kRowColumns * pairs.size);
    own->FillRows(pairs, 0, pairs.size, rows.data());
    return add_all([&](int i) {
      std::vector<std::array<double, kRowColumns>> row(rows_of_pair);
      for (int r = 0; r < rows_of_pair; ++r) {
        for (int k = 0; k < kRowColumns; ++k) {
          row[r][k] = rows[static_cast<std::size_t>(r * kRowColumns + k) * pairs.size + i];
        }
      }
      return row;
    });
  }
  return WithRowsOf(residual, [&](auto type) {
    using Rows = decltype(type);
    return add_all([&](int i) {
      PairValues<double> pair;
      for (int k = 0; k < 3; ++k) {
        pair.p[k] = pairs.p(i)[k];
        pair.q[k] = pairs.q(i)[k];
        pair.n[k] = pairs.n(i)[k];
        pair.m[k] = pairs.m(i)[k];
      }
      double evaluated[Rows::kRows][kRowColumns];
      Rows::Evaluate(pair, evaluated);
      std::array<std::array<double, kRowColumns>, Rows::kRows> rows;
      for (int r = 0; r < Rows::kRows; ++r) {
        std::copy(evaluated[r], evaluated[r] + kRowColumns, rows[r].begin());
      }
      return rows;
    });
  });
}

// Sum over the cells of h h^T with h = (I - H_c H^-1)^-1 g_c = H (H - H_c)^-1 g_c, where H_c is the
// Gauss-Newton Hessian of cell c and H the sum of all cells. This is the jackknife estimate CR3
// (Bell and McCaffrey 2002). It corrects for the influence of a cell on the minimum, which makes
// its own gradient small. Zero if there are too few cells.
Matrix6d SpreadOf(const std::vector<CellSums>& cells) {
  if (cells.size() < kLeastCells) return Matrix6d::Zero();
  Matrix6d hessian = Matrix6d::Zero();
  for (const CellSums& cell : cells) hessian += cell.hessian;
  Matrix6d sum = Matrix6d::Zero();
  for (const CellSums& cell : cells) {
    const Eigen::LDLT<Matrix6d> rest(hessian - cell.hessian);
    const Vector6d corrected = hessian * rest.solve(cell.gradient);
    sum += corrected * corrected.transpose();
  }
  return sum;
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
  if (!(system.weight_sum > 0) || !(scales.noise_m > 0) || !(scales.cell > 0)) return result;
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

  const Matrix6d spread =
      SpreadOf(SumsOfCells(association.Collect(target_from_source), residual, kernel, scales));
  if (spread.isZero(0)) return result;
  const Matrix6d inverse = motions * derivative.inverse() * motions.transpose();
  const Matrix6d covariance = inverse * spread * inverse.transpose();
  result.covariance = 0.5 * (covariance + covariance.transpose());
  result.step_to_minimum = inverse * system.right_side;
  return result;
}

namespace {

// Image blocks per image width. Blocks of the default levels have 16 px or more, which is more than
// the filter window and the window of the normals together.
constexpr int kBlocksPerWidth = 10;

CloudErrorScales ScalesOf(const PinholeCamera& camera, double noise_m) {
  return {noise_m, static_cast<double>(camera.width) / kBlocksPerWidth, &camera};
}

// Levels of CovarianceOfViews() and CovarianceByBlocks().
constexpr int kMaxColumns = 400, kMaxFastColumns = 200;

// Finest level with at most `max_columns` columns, or the coarsest common level.
std::size_t LevelOfCovariance(const FramePyramid& source, const FramePyramid& target,
                              int max_columns) {
  const std::size_t levels = std::min(source.levels.size(), target.levels.size());
  std::size_t level = 0;
  while (level + 1 < levels && target.levels[level].camera.width > max_columns) ++level;
  return level;
}

// Normal systems of the square blocks of the source image, row by row. Blocks without pairs are
// empty.
std::vector<NormalSystem> SystemsOfBlocks(const ProjectiveSearch& search, ResidualType residual,
                                          const RobustKernel& kernel) {
  const int width = search.source.vertex.width(), height = search.source.vertex.height();
  const int size = (width + kBlocksPerWidth - 1) / kBlocksPerWidth;
  if (size == 0) return {};
  const int columns = (width + size - 1) / size, rows = (height + size - 1) / size;
  std::vector<NormalSystem> systems(static_cast<std::size_t>(columns) * rows);
  ParallelFor(0, rows, 1, [&](int row, int) {
    PairBuffer pairs;
    pairs.SetCapacity(size * size + Lanes<float>::kCount);  // the last store writes all lanes
    const int begin = row * size, end = std::min(height, begin + size);
    for (int column = 0; column < columns; ++column) {
      const int left = column * size, right = std::min(width, left + size);
      pairs.size = WithInstructions([&](auto instructions) {
        const RowFinder<decltype(instructions)> finder(search);
        int count = 0;
        for (int v = begin; v < end; ++v) count += finder.Find(v, left, right, count, &pairs);
        return count;
      });
      systems[static_cast<std::size_t>(row) * columns + column] =
          Linearize(pairs, residual, kernel);
    }
  });
  return systems;
}

}  // namespace

std::optional<Matrix6d> CovarianceByBlocks(const FramePyramid& source, const FramePyramid& target,
                                           const Rigid3d& target_from_source,
                                           const IcpOptions& options) {
  const std::size_t level = LevelOfCovariance(source, target, kMaxFastColumns);
  const ResidualType residual = ResidualTypeFromName(options.residual);
  NormalSystem sum;
  std::vector<CellSums> blocks;
  for (const NormalSystem& system :
       SystemsOfBlocks({source.levels[level], target.levels[level], target_from_source,
                        options.gates, options.error_model, NormalsNeededBy(residual)},
                       residual, options.error_model.kernel)) {
    if (system.pair_count == 0) continue;
    sum += system;
    blocks.push_back({-system.right_side, system.hessian});
  }
  if (Observe(sum, options.observability).Degenerate()) return std::nullopt;
  const Matrix6d spread = SpreadOf(blocks);
  if (spread.isZero(0)) return std::nullopt;
  const Eigen::LDLT<Matrix6d> derivative(sum.hessian - sum.SpuriousInformation());
  if (!derivative.isPositive() || derivative.rcond() < 1e-12) return std::nullopt;
  const Matrix6d inverse = derivative.solve(Matrix6d::Identity());
  const Matrix6d covariance = inverse * spread * inverse.transpose();
  return Matrix6d(0.5 * (covariance + covariance.transpose()));
}

std::optional<Matrix6d> CovarianceOfViews(const FramePyramid& source, const FramePyramid& target,
                                          const IcpResult& icp, const IcpOptions& options) {
  Validate(options);
  if (!icp.Succeeded() || source.levels.empty() || target.levels.empty()) return std::nullopt;
  const ResidualType residual = ResidualTypeFromName(options.residual);
  const bool is_projective = options.association == "projective";
  if (is_projective && residual == ResidualType::kPointToPoint) return std::nullopt;
  const std::size_t level = LevelOfCovariance(source, target, kMaxColumns);
  const FrameLevel& from = source.levels[level];
  const FrameLevel& to = target.levels[level];
  std::unique_ptr<Association> association;
  if (is_projective) {
    association = std::make_unique<ProjectiveAssociation>(
        from, to, options.gates, options.error_model, NormalsNeededBy(residual));
  } else {
    association = std::make_unique<KdTreeAssociation>(
        SearchablePoints(PointSetOf(from, options.error_model)),
        SearchablePoints(PointSetOf(to, options.error_model)),
        KdTreeAssociationOptions{options.gates, NormalsNeededBy(residual)});
  }
  return CovarianceOfClouds(*association, icp.target_from_source, residual,
                            options.error_model.kernel, ScalesOf(to.camera, icp.rmse_m))
      .covariance;
}

}  // namespace surfit
