// Tests of the calibration covariance that allows for errors shared by neighbouring surfels.
#include "optimization/refinement/clustered_covariance.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <map>
#include <tuple>
#include <vector>

#include "optimization/refinement/reduced_factor.h"
#include "refinement/random_surfels.h"

namespace surfit::testing {
namespace {

constexpr int kPoses = 5, kSurfels = 400;
constexpr double kNoiseSigmas = 1;
// As in the tested file: the image has eight clusters side by side.
constexpr int kAcross = 8;

JointKernels Kernels() { return KernelsOf(ErrorModel()); }

ReducedSystem SystemOf(const BlockPattern& pattern, const SharedSurfels& shared,
                       const JointState& state) {
  return Reduce(shared, pattern, state, Kernels());
}

// Surfels with their observations, in this order.
SharedSurfels Chosen(const SharedSurfels& shared, const std::vector<std::size_t>& chosen) {
  SharedSurfels some;
  some.readouts = shared.readouts;
  for (const std::size_t s : chosen) {
    SharedSurfel surfel = shared.surfels[s];
    const auto copy = [](const auto& from, std::size_t* begin, std::size_t* end, auto* to) {
      const std::size_t new_begin = to->size();
      to->insert(to->end(), from.begin() + static_cast<std::ptrdiff_t>(*begin),
                 from.begin() + static_cast<std::ptrdiff_t>(*end));
      *begin = new_begin;
      *end = to->size();
    };
    copy(shared.observations, &surfel.begin, &surfel.end, &some.observations);
    copy(shared.textures, &surfel.textures_begin, &surfel.textures_end, &some.textures);
    some.surfels.push_back(surfel);
  }
  return some;
}

// Surfels without observations have no first keyframe, and do not occur in the refinement.
RandomProblem MakeProblem() {
  RandomProblem problem = MakeRandomProblem(kPoses, kSurfels, kNoiseSigmas);
  std::vector<std::size_t> observed;
  for (std::size_t s = 0; s < problem.shared.surfels.size(); ++s) {
    if (problem.shared.surfels[s].end > problem.shared.surfels[s].begin) observed.push_back(s);
  }
  problem.shared = Chosen(problem.shared, observed);
  return problem;
}

Eigen::MatrixXd RowsOf(const SharedSurfels& shared, const JointState& state) {
  const BlockPattern pattern(shared, kPoses);
  return CovarianceOf(SystemOf(pattern, shared, state), std::vector<bool>(kCalibrationSize, false))
      .calibration_rows;
}

TEST(CalibrationRows, AreRowsOfTheInverseHessian) {
  const RandomProblem problem = MakeProblem();
  const BlockPattern pattern(problem.shared, kPoses);
  const ReducedSystem system = SystemOf(pattern, problem.shared, problem.state);
  const Eigen::MatrixXd hessian = DenseHessian(system);
  // The first pose is fixed.
  const Eigen::Index size = hessian.rows() - kPoseTangentSize;
  const Eigen::MatrixXd inverse = hessian.bottomRightCorner(size, size).inverse();
  const Eigen::MatrixXd rows = RowsOf(problem.shared, problem.state);
  EXPECT_TRUE((rows.leftCols<kPoseTangentSize>().array() == 0).all());
  const Eigen::MatrixXd expected = inverse.bottomRows<kCalibrationSize>();
  const Eigen::MatrixXd found = rows.rightCols(size);
  for (Eigen::Index i = 0; i < kCalibrationSize; ++i) {
    EXPECT_LT((found.row(i) - expected.row(i)).norm(), 1e-6 * expected.row(i).norm()) << i;
  }
}

// The gradient of a cluster is the gradient of a system with its surfels only.
TEST(ClusteredCovariance, EqualsSumOverSystemsOfTheClusters) {
  const RandomProblem problem = MakeProblem();
  const SharedSurfels& shared = problem.shared;
  const float cell_px = static_cast<float>(problem.state.calibration.camera.width) / kAcross;
  std::map<std::tuple<int, int, int>, std::vector<std::size_t>> clusters;
  for (std::size_t s = 0; s < shared.surfels.size(); ++s) {
    const PlaneObservation& first = shared.observations[shared.surfels[s].begin];
    clusters[{first.keyframe, static_cast<int>(first.u / cell_px),
              static_cast<int>(first.v / cell_px)}]
        .push_back(s);
  }
  ASSERT_GT(clusters.size(), 20u);
  const Eigen::MatrixXd rows = RowsOf(shared, problem.state);
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(kCalibrationSize, kCalibrationSize);
  for (const auto& [cluster, surfels] : clusters) {
    const SharedSurfels some = Chosen(shared, surfels);
    const BlockPattern pattern(some, kPoses);
    const Eigen::VectorXd change = rows * SystemOf(pattern, some, problem.state).gradient;
    expected += change * change.transpose();
  }
  expected *= static_cast<double>(clusters.size()) / static_cast<double>(clusters.size() - 1);
  const Eigen::MatrixXd found = ClusteredCovariance(shared, problem.state, Kernels(), rows);
  for (Eigen::Index i = 0; i < kCalibrationSize; ++i) {
    for (Eigen::Index j = 0; j < kCalibrationSize; ++j) {
      const double scale = std::sqrt(expected(i, i) * expected(j, j));
      EXPECT_NEAR(found(i, j), expected(i, j), 1e-6 * scale) << i << " " << j;
    }
  }
}

// Copies of a surfel have the same errors, so they add no information. The covariance for
// independent errors decreases by the number of copies.
TEST(ClusteredCovariance, DoesNotDecreaseWithCopiesOfSurfels) {
  constexpr int kCopies = 4;
  const RandomProblem problem = MakeProblem();
  std::vector<std::size_t> copies;
  for (std::size_t s = 0; s < problem.shared.surfels.size(); ++s) {
    copies.insert(copies.end(), kCopies, s);
  }
  const SharedSurfels many = Chosen(problem.shared, copies);
  const Eigen::MatrixXd rows = RowsOf(problem.shared, problem.state);
  const Eigen::MatrixXd many_rows = RowsOf(many, problem.state);
  const Eigen::MatrixXd of_one =
      ClusteredCovariance(problem.shared, problem.state, Kernels(), rows);
  const Eigen::MatrixXd of_many = ClusteredCovariance(many, problem.state, Kernels(), many_rows);
  const auto independent = rows.rightCols<kCalibrationSize>();
  const auto independent_of_many = many_rows.rightCols<kCalibrationSize>();
  for (Eigen::Index i = 0; i < kCalibrationSize; ++i) {
    EXPECT_NEAR(independent_of_many(i, i), independent(i, i) / kCopies, 1e-6 * independent(i, i));
    EXPECT_NEAR(of_many(i, i), of_one(i, i), 1e-6 * of_one(i, i)) << i;
  }
}

// The eigenvalues of diagonal matrices are the ratios of the variances.
TEST(ClusterEffect, IsMeanRatioOfVariances) {
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(kCalibrationSize, kCalibrationSize);
  covariance(0, 0) = 4, covariance(1, 1) = 9;
  Eigen::MatrixXd clustered = covariance;
  clustered(0, 0) = 8, clustered(1, 1) = 54;
  clustered(2, 2) = 700;  // of a fixed parameter
  EXPECT_NEAR(ClusterEffect(covariance, clustered), (2 + 6) / 2., 1e-12);
}

// Correlated parameters, and units that differ by orders of magnitude.
TEST(ClusterEffect, OfScaledCovarianceIsTheScale) {
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(kCalibrationSize, kCalibrationSize);
  covariance.topLeftCorner<2, 2>() << 4, 1e-4, 1e-4, 9e-8;
  EXPECT_NEAR(ClusterEffect(covariance, 3 * covariance), 3, 1e-9);
}

TEST(ClusterEffect, IsAtLeastOne) {
  const Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(kCalibrationSize, kCalibrationSize);
  EXPECT_EQ(ClusterEffect(covariance, 0.5 * covariance), 1);
  EXPECT_EQ(ClusterEffect(0 * covariance, covariance), 1);  // all parameters are fixed
}

}  // namespace
}  // namespace surfit::testing
