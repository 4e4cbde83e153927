#include "tracking/moving_corners.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "testing/matchers.h"

namespace surfit::testing {
namespace {

using Label = CornerMotion::Label;

constexpr double kNear_m = 1.4, kFar_m = 3.5;
const PinholeCamera kSmallCamera = {320, 240, 267, 267, 159.5, 119.5, {}};
// Motions of the camera: relative to the static scene, and relative to a person.
const Rigid3d kStaticMotion(Eigen::Quaterniond(Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitY())),
                            Eigen::Vector3d(0.02, 0.01, 0));
const Rigid3d kPersonMotion(Eigen::Quaterniond(Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitX())),
                            Eigen::Vector3d(-0.06, 0.02, 0));

// Corners of a background at 3.5 m and of a person at 1.4 m, with an error of 0.2 px. The person
// covers the right third of the image.
std::vector<TrackedCorner> CornersOf(int background, int person) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> u(0, 1);
  std::normal_distribution<double> error(0, 0.2);
  std::vector<TrackedCorner> corners;
  for (int i = 0; i < background + person; ++i) {
    const bool is_person = i >= background;
    const double column = is_person ? 213 + 100 * u(random) : 213 * u(random);
    const Eigen::Vector2d first(column, 240 * u(random));
    const double depth_m = (is_person ? kNear_m : kFar_m) + 0.3 * u(random);
    const Eigen::Vector3d point = kSmallCamera.Ray(first.x(), first.y()) * depth_m;
    const Rigid3d& motion = is_person ? kPersonMotion : kStaticMotion;
    const Eigen::Vector2d seen =
        kSmallCamera.Project(motion * point) + Eigen::Vector2d(error(random), error(random));
    corners.push_back({point, first, seen});
  }
  return corners;
}

// A textured shirt has more corners than the background. By their number, the person would be the
// static scene.
TEST(FindStaticMotion, IsMotionOfBackgroundBesideTexturedPerson) {
  constexpr int kBackground = 80, kPerson = 160;
  const CornerMotion motion =
      FindStaticMotion(CornersOf(kBackground, kPerson), kSmallCamera, Rigid3d());
  ASSERT_EQ(motion.labels.size(), kBackground + kPerson);
  EXPECT_TRUE(motion.is_certain);
  const Rigid3d difference = motion.now_from_before * kStaticMotion.Inverse();
  EXPECT_LT(RotationAngle(difference.rotation), 0.003);
  int wrong = 0;
  for (int i = 0; i < kBackground + kPerson; ++i) {
    wrong += motion.labels[i] == (i < kBackground ? Label::kMoving : Label::kStatic);
  }
  EXPECT_EQ(wrong, 0);
}

TEST(FindStaticMotion, FindsOneMotionOfStaticScene) {
  const CornerMotion motion = FindStaticMotion(CornersOf(120, 0), kSmallCamera, Rigid3d());
  EXPECT_FALSE(motion.is_certain);
  EXPECT_EQ(std::count(motion.labels.begin(), motion.labels.end(), Label::kMoving), 0);
}

TEST(FindStaticMotion, FindsNoMotionOfFewCorners) {
  EXPECT_TRUE(FindStaticMotion(CornersOf(5, 0), kSmallCamera, Rigid3d()).labels.empty());
  EXPECT_TRUE(FindStaticMotion({}, kSmallCamera, Rigid3d()).labels.empty());
}

}  // namespace
}  // namespace surfit::testing
