#include "optimization/refinement/clustered_covariance.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <map>
#include <tuple>
#include <vector>

#include "cost_functions/robust_kernel.h"
#include "optimization/refinement/reduced_system.h"

namespace surfit {
namespace {

constexpr int kClustersAcross = 8;  // per image width

// Keyframe, column and row of a cluster.
using Cluster = std::tuple<int, int, int>;

// Sums over the rows of a surfel: the change of the calibration, and the normal equations of the
// parameters of the surfel.
class SurfelSums {
 public:
  SurfelSums(const Eigen::MatrixXd& influence, bool has_texture) : influence_(influence) {
    if (!has_texture) information_.diagonal().tail<2>().setOnes();
  }

  void Add(const JointRow& row, int keyframe, const Eigen::Vector3d& by_surfel, double weight) {
    const CalibrationRow change =
        influence_.middleCols<kPoseTangentSize>(kPoseTangentSize * keyframe) * row.by_pose +
        influence_.rightCols<kCalibrationSize>() * row.by_calibration;
    change_ += weight * row.residual * change;
    by_surfel_ += weight * change * by_surfel.transpose();
    information_ += weight * by_surfel * by_surfel.transpose();
    gradient_ += weight * row.residual * by_surfel;
  }

  // The change with the parameters of the surfel eliminated, as in ReducedSystem.
  CalibrationRow Reduced() const {
    const Eigen::LLT<Eigen::Matrix3d> llt(information_);
    if (llt.info() != Eigen::Success) return change_;
    return change_ - by_surfel_ * llt.solve(gradient_);
  }

 private:
  const Eigen::MatrixXd& influence_;
  CalibrationRow change_ = CalibrationRow::Zero();
  Eigen::Matrix<double, kCalibrationSize, kTexturedUnknowns> by_surfel_ =
      Eigen::Matrix<double, kCalibrationSize, kTexturedUnknowns>::Zero();
  Eigen::Matrix3d information_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient_ = Eigen::Vector3d::Zero();
};

// Change of the calibration by the gradient of one surfel.
CalibrationRow ChangeBy(const SharedSurfels& shared, const SharedSurfel& surfel,
                        const PlacedPoses& placed, const JointKernels& kernels,
                        const Eigen::MatrixXd& influence) {
  const SurfelResiduals sight(shared, surfel, placed);
  const SurfelParameters best = sight.Best(kernels);
  SurfelSums sums(influence, !sight.textures().empty());
  for (std::size_t i = 0; i < sight.planes().size(); ++i) {
    const int keyframe = shared.observations[surfel.begin + i].keyframe;
    const JointRow row =
        sight.planes()[i].Row(best.displacement, surfel.normal_in_world, placed.rotations[keyframe],
                              placed.state.calibration);
    sums.Add(row, keyframe, {row.by_displacement, 0, 0},
             EvaluateKernel(kernels.plane, row.residual * row.residual).slope);
  }
  for (std::size_t i = 0; i < sight.textures().size(); ++i) {
    const int keyframe = shared.textures[surfel.textures_begin + i].keyframe;
    const std::array<JointRow, 2> rows =
        sight.textures()[i].Rows(best, surfel.normal_in_world, placed.rotations[keyframe]);
    const double squared =
        rows[0].residual * rows[0].residual + rows[1].residual * rows[1].residual;
    const double weight = EvaluateKernel(kernels.texture, squared).slope;
    for (int j = 0; j < 2; ++j) {
      Eigen::Vector3d by_surfel(rows[j].by_displacement, 0, 0);
      by_surfel[1 + j] = -1;
      sums.Add(rows[j], keyframe, by_surfel, weight);
    }
  }
  return sums.Reduced();
}

}  // namespace

Eigen::MatrixXd ClusteredCovariance(const SharedSurfels& shared, const JointState& state,
                                    const JointKernels& kernels, const Eigen::MatrixXd& influence) {
  const PlacedPoses placed(state);
  const float cell_px = static_cast<float>(state.calibration.camera.width) / kClustersAcross;
  std::map<Cluster, CalibrationRow> changes;
  for (const SharedSurfel& surfel : shared.surfels) {
    const PlaneObservation& first = shared.observations[surfel.begin];
    const Cluster cluster = {first.keyframe, static_cast<int>(first.u / cell_px),
                             static_cast<int>(first.v / cell_px)};
    const auto [at, is_new] = changes.try_emplace(cluster, CalibrationRow::Zero());
    at->second += ChangeBy(shared, surfel, placed, kernels, influence);
  }
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(kCalibrationSize, kCalibrationSize);
  if (changes.size() < 2) return covariance;
  for (const auto& [cluster, change] : changes) covariance += change * change.transpose();
  const auto count = static_cast<double>(changes.size());
  return count / (count - 1) * covariance;
}

double ClusterEffect(const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& clustered) {
  std::vector<Eigen::Index> estimated;
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    if (covariance(i, i) > 0) estimated.push_back(i);
  }
  if (estimated.empty()) return 1;
  // Scaled to a unit diagonal, because px and 1/m differ by orders of magnitude.
  const Eigen::VectorXd inverse_sigma = covariance.diagonal()(estimated).cwiseSqrt().cwiseInverse();
  const auto scaled = [&](const Eigen::MatrixXd& matrix) -> Eigen::MatrixXd {
    return inverse_sigma.asDiagonal() * matrix(estimated, estimated).eval() *
           inverse_sigma.asDiagonal();
  };
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(scaled(covariance));
  const double mean = ldlt.solve(scaled(clustered)).trace() / static_cast<double>(estimated.size());
  return std::max(1., mean);
}

}  // namespace surfit
