#include <gtest/gtest.h>

#include <cmath>

#include "surfit/evaluation/trajectory_evaluation.h"

namespace surfit::testing {
namespace {

// A hand-held camera: it moves and rotates about all axes.
Rigid3d PoseOf(double t) {
  const Eigen::Vector3d position(0.3 * std::sin(3 * t), 0.2 * std::sin(5 * t), 0.4 * std::cos(t));
  const Eigen::Vector3d axis(std::sin(2 * t), std::cos(3 * t), std::sin(t + 1));
  return {Eigen::Quaterniond(Eigen::AngleAxisd(0.6 * std::sin(1.7 * t), axis.normalized())),
          position};
}

// The true body is at `mount_m` in the camera. The true world is `scale` times as large, and has
// another origin.
std::vector<MatchedPose> Poses(const Eigen::Vector3d& mount_m, double scale, bool rotates = true) {
  const Rigid3d true_from_estimated(
      Eigen::Quaterniond(Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, 3).normalized())),
      {5, -2, 1});
  std::vector<MatchedPose> poses;
  for (int i = 0; i < 200; ++i) {
    MatchedPose pose;
    pose.stamp_s = i / 30.;
    pose.estimate = PoseOf(pose.stamp_s);
    if (!rotates) pose.estimate.rotation.setIdentity();
    const Eigen::Vector3d body =
        scale * pose.estimate.translation + pose.estimate.rotation * mount_m;
    pose.ground_truth.translation = true_from_estimated * body;
    poses.push_back(pose);
  }
  return poses;
}

TEST(FitMount, FindsTheMount) {
  const Eigen::Vector3d mount_m(0.027, -0.01, 0.004);
  const auto poses = Poses(mount_m, 1);
  const auto fit = FitMount(poses, false);
  ASSERT_TRUE(fit);
  EXPECT_TRUE(fit->is_unique);
  EXPECT_LT((fit->true_body_in_estimated_m - mount_m).norm(), 1e-9);
  EXPECT_LT(fit->ate.translation_m.max, 1e-9);
  EXPECT_EQ(fit->scale, 1);
  EXPECT_GT(ComputeAbsoluteTrajectoryError(poses)->translation_m.rmse, 1e-3);
}

TEST(FitMount, FindsMountAndScale) {
  const Eigen::Vector3d mount_m(-0.03, 0.02, 0.01);
  const auto poses = Poses(mount_m, 1.01);
  const auto fit = FitMount(poses, true);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->scale, 1.01, 1e-9);
  EXPECT_LT((fit->true_body_in_estimated_m - mount_m).norm(), 1e-9);
  EXPECT_GT(FitMount(poses, false)->ate.translation_m.rmse, 1e-3);
}

TEST(FitMount, NeverRaisesTheError) {
  auto poses = Poses({0.01, 0, 0}, 1);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double wave = 0.005 * std::sin(0.37 * static_cast<double>(i * i % 101));
    poses[i].ground_truth.translation += Eigen::Vector3d(wave, -wave, 2 * wave);
  }
  const double plain_m = ComputeAbsoluteTrajectoryError(poses)->translation_m.rmse;
  const double mount_m = FitMount(poses, false)->ate.translation_m.rmse;
  EXPECT_LT(mount_m, plain_m);
  EXPECT_LE(FitMount(poses, true)->ate.translation_m.rmse, mount_m);
}

TEST(FitMount, IsNotUniqueWithoutRotation) {
  const auto fit = FitMount(Poses({0.02, 0, 0}, 1, /*rotates=*/false), false);
  ASSERT_TRUE(fit);
  EXPECT_FALSE(fit->is_unique);
  EXPECT_LT(fit->ate.translation_m.max, 1e-9);
  EXPECT_NE(MountWarning(*fit), "");
}

TEST(FitMount, NeedsThreePoses) {
  const auto poses = Poses({0, 0, 0}, 1);
  EXPECT_FALSE(FitMount({poses.begin(), poses.begin() + 2}, false));
}

TEST(MountWarning, BeginsAboveFiveCentimetres) {
  EXPECT_EQ(MountWarning(*FitMount(Poses({0.049, 0, 0}, 1), false)), "");
  EXPECT_NE(MountWarning(*FitMount(Poses({0.051, 0, 0}, 1), false)), "");
}

}  // namespace
}  // namespace surfit::testing
