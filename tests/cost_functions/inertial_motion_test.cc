#include "cost_functions/inertial_motion.h"

#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "cost_functions/pose_manifold.h"
#include "testing/random_pose.h"

namespace surfit::testing {
namespace {

using AutodiffInertialMotion =
    ceres::AutoDiffCostFunction<InertialMotion, kInertialResiduals, kPoseSize, kMotionSize,
                                kPoseSize, kMotionSize, 3>;
constexpr std::array<int, 5> kSizes = {kPoseSize, kMotionSize, kPoseSize, kMotionSize, 3};

PreintegratedImu RandomMotion(std::mt19937_64* rng) {
  std::vector<ImuSample> samples;
  for (int i = 0; i < 30; ++i)
    samples.push_back({0.01 * i, RandomVector(2, rng), RandomVector(12, rng)});
  const ImuBias bias = {RandomVector(0.02, rng), RandomVector(0.2, rng)};
  return *PreintegrateImu(samples, 0.013, 0.249, bias, {});
}

struct Blocks {
  std::array<std::vector<double>, 5> values;

  std::array<const double*, 5> pointers() const {
    std::array<const double*, 5> all;
    for (int k = 0; k < 5; ++k) all[k] = values[k].data();
    return all;
  }
};

std::vector<double> PoseBlockOf(const Rigid3d& pose) {
  std::vector<double> block(kPoseSize);
  PoseToBlock(pose, block.data());
  return block;
}

// States that agree with the motion, except for errors of the given size.
Blocks StatesNear(const PreintegratedImu& motion, const Rigid3d& body_from_imu, double size,
                  std::mt19937_64* rng) {
  const Eigen::Vector3d gravity = kGravity_m_per_s2 * RandomVector(1, rng).normalized();
  const ImuState i = {RandomPose(1.5, 3, rng), RandomVector(1, rng)};
  const ImuState j = PredictImu(i, motion, gravity);
  const Rigid3d imu_from_body = body_from_imu.Inverse();
  Blocks blocks;
  blocks.values[0] = PoseBlockOf(i.world_from_imu * imu_from_body);
  blocks.values[2] = PoseBlockOf(j.world_from_imu * RandomPose(size, size, rng) * imu_from_body);
  const auto motion_block = [&](const ImuState& state, double error) {
    Eigen::Matrix<double, kMotionSize, 1> block;
    block << state.velocity_m_per_s + RandomVector(error, rng),
        motion.bias.gyro_rad_per_s + RandomVector(error, rng),
        motion.bias.accel_m_per_s2 + RandomVector(error, rng);
    return std::vector<double>(block.data(), block.data() + kMotionSize);
  };
  blocks.values[1] = motion_block(i, size);
  blocks.values[3] = size == 0 ? motion_block(j, 0) : motion_block(j, size);
  blocks.values[4] = {gravity.x(), gravity.y(), gravity.z()};
  return blocks;
}

using Derivative = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct Evaluated {
  Eigen::Matrix<double, kInertialResiduals, 1> residuals;
  std::array<Derivative, 5> jacobians;  // poses: along the manifold
};

Evaluated Evaluate(const ceres::CostFunction& cost, const Blocks& blocks) {
  Evaluated e;
  std::array<double*, 5> jacobians;
  for (int k = 0; k < 5; ++k) {
    e.jacobians[k].resize(kInertialResiduals, kSizes[k]);
    jacobians[k] = e.jacobians[k].data();
  }
  cost.Evaluate(blocks.pointers().data(), e.residuals.data(), jacobians.data());
  for (const int k : {0, 2}) {
    Derivative plus(kPoseSize, kPoseTangentSize);
    ProductPoseManifold().PlusJacobian(blocks.values[k].data(), plus.data());
    e.jacobians[k] = e.jacobians[k] * plus;
  }
  return e;
}

TEST(InertialMotion, IsZeroForPredictedState) {
  std::mt19937_64 rng(1);
  for (int trial = 0; trial < 20; ++trial) {
    const PreintegratedImu motion = RandomMotion(&rng);
    const Rigid3d body_from_imu = RandomPose(1, 0.1, &rng);
    const Blocks blocks = StatesNear(motion, body_from_imu, 0, &rng);
    const auto all = blocks.pointers();
    Eigen::Matrix<double, kInertialResiduals, 1> residuals;
    InertialMotion(motion, body_from_imu)(all[0], all[1], all[2], all[3], all[4], residuals.data());
    // The whitening multiplies rounding errors of 1e-15 by up to 1e6.
    EXPECT_LT(residuals.norm(), 1e-8);
  }
}

// The cost is the squared Mahalanobis distance of the error in PreintegratedImu::covariance.
TEST(InertialMotion, CostIsMahalanobisDistanceOfError) {
  std::mt19937_64 rng(2);
  for (int trial = 0; trial < 20; ++trial) {
    const PreintegratedImu motion = RandomMotion(&rng);
    Blocks blocks = StatesNear(motion, {}, 0, &rng);
    Eigen::Matrix<double, 15, 1> error;
    error << RandomVector(0.01, &rng), RandomVector(0.02, &rng), RandomVector(0.03, &rng),
        RandomVector(1e-4, &rng), RandomVector(1e-3, &rng);
    const Rigid3d i = PoseFromBlock(blocks.values[0].data());
    Rigid3d j = PoseFromBlock(blocks.values[2].data());
    j.rotation = j.rotation * QuaternionExp<double>(Eigen::Vector3d(error.head<3>()));
    j.translation += i.rotation * error.segment<3>(3);
    blocks.values[2] = PoseBlockOf(j);
    const Eigen::Vector3d speed = i.rotation * error.segment<3>(6);
    for (int k = 0; k < 3; ++k) blocks.values[3][k] += speed[k];
    for (int k = 0; k < 6; ++k) blocks.values[3][3 + k] += error[9 + k];
    const auto all = blocks.pointers();
    Eigen::Matrix<double, kInertialResiduals, 1> residuals;
    const InertialMotion cost(motion);
    cost(all[0], all[1], all[2], all[3], all[4], residuals.data());
    const double expected = error.dot(motion.covariance.ldlt().solve(error));
    EXPECT_NEAR(residuals.squaredNorm(), expected, 1e-6 * expected);
  }
}

TEST(AnalyticInertialMotion, AgreesWithAutodiff) {
  std::mt19937_64 rng(3);
  for (const double size : {0., 1e-8, 1e-3, 0.1, 0.8}) {
    for (int trial = 0; trial < 20; ++trial) {
      const PreintegratedImu motion = RandomMotion(&rng);
      const Rigid3d body_from_imu = RandomPose(1, 0.1, &rng);
      const Blocks blocks = StatesNear(motion, body_from_imu, size, &rng);
      const Evaluated expected =
          Evaluate(AutodiffInertialMotion(new InertialMotion(motion, body_from_imu)), blocks);
      const Evaluated found = Evaluate(AnalyticInertialMotion(motion, body_from_imu), blocks);
      // Residuals are in standard deviations; rounding errors reach 1e-11 of them.
      EXPECT_LE((found.residuals - expected.residuals).norm(),
                1e-8 * expected.residuals.norm() + 1e-10);
      for (int k = 0; k < 5; ++k) {
        EXPECT_LT((found.jacobians[k] - expected.jacobians[k]).norm(),
                  1e-8 * expected.jacobians[k].norm())
            << "block " << k << ", size " << size;
      }
    }
  }
}

}  // namespace
}  // namespace surfit::testing
