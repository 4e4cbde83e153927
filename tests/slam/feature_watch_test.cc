#include "tracking/feature_watch.h"

#include <gtest/gtest.h>

#include <random>

#include "slam/simulated_sequence.h"
#include "surfit/frame/rectify_frame.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

const Rigid3d kPosed(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.02, 0, 0));
const Rigid3d kOther(Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY())),
                     Eigen::Vector3d(0.2, 0, 0.1));

// Corresponding points of two frames. The first `posed` points move by kPosed, the next `other`
// points by kOther, and `stray` points have random motions. All except the posed points are farther
// away by `farther_m`.
struct Shared {
  FeaturePoints source, target;

  Shared(int posed, int other, int stray, double farther_m = -0.3) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> place(-1, 1);
    const auto any = [&] { return Eigen::Vector3d(place(random), place(random), place(random)); };
    const int count = posed + other + stray;
    for (int i = 0; i < count; ++i) {
      const double z = i < posed ? 2 : 2 + farther_m;
      source.points.push_back(any() + Eigen::Vector3d(0, 0, z));
      const Eigen::Vector3d& point = source.points.back();
      const Eigen::Vector3d strayed = any() + Eigen::Vector3d(0, 0, z);
      target.points.push_back(i < posed           ? kPosed * point
                              : i < posed + other ? kOther * point
                                                  : strayed);
    }
    source.sigmas_m = target.sigmas_m = std::vector<double>(count, 0.005);
  }
};

FeatureMotion Compare(const Shared& shared) {
  return CompareMotions(shared.source, {kPosed, {}}, shared.target, {Rigid3d(), {}});
}

TEST(CompareMotions, CountsPointsOfPoseAndOfOtherMotion) {
  const FeatureMotion motion = Compare({40, 25, 10});
  EXPECT_GE(motion.consistent_count, 40);
  EXPECT_LE(motion.consistent_count, 42);
  EXPECT_EQ(motion.apart, 25);
  EXPECT_TRUE(motion.HasTwoMotions());
  EXPECT_FALSE(motion.IsRejected());
  EXPECT_TRUE(Compare({20, 25, 10}).IsRejected());
}

TEST(CompareMotions, FindsNoMotionOfStaticPoints) {
  const Rigid3d world_from_source(QuaternionExp<double>({0.3, -0.2, 0.1}), {1, 2, 3});
  const Rigid3d world_from_target(QuaternionExp<double>({0.1, 0.2, -0.3}), {1.5, 1.8, 2.7});
  Shared shared(40, 0, 0);
  for (int i = 0; i < shared.source.size(); ++i) {
    shared.target.points[i] =
        world_from_target.Inverse() * (world_from_source * shared.source.points[i]);
  }
  const FeatureMotion motion = CompareMotions(shared.source, {world_from_source, {}}, shared.target,
                                              {world_from_target, {}});
  EXPECT_EQ(motion.consistent_count, 40);
  EXPECT_EQ(motion.apart, 0);
}

TEST(CompareMotions, PointsBehindCountTwice) {
  EXPECT_TRUE(Compare({40, 25, 10, 1.5}).IsRejected());
  EXPECT_FALSE(Compare({40, 25, 10, -0.5}).IsRejected());
  EXPECT_FALSE(Compare({60, 25, 10, 1.5}).IsRejected());
}

TEST(CompareMotions, IgnoresPointsWithRandomMotions) {
  EXPECT_FALSE(Compare({40, 0, 30}).HasTwoMotions());
  EXPECT_FALSE(Compare({0, 0, 30}).HasTwoMotions());
  EXPECT_FALSE(Compare({0, 0, 0}).HasTwoMotions());
}

// Half a second of a walk at 320 x 240 pixels.
class RoomCorners : public ::testing::Test {
 protected:
  ColoredView Of(int frame) const {
    const RgbdFrame& images = room_.frames[frame];
    return {PreprocessDepth(images.depth_m, {room_.camera, {}}, {}), images.color};
  }

  static constexpr int kLast = 15;
  const SimulatedSequence room_ = Simulate("room", 1, kLast + 1, Sensor::kIdeal,
                                           PinholeCamera{320, 240, 262.5, 262.5, 159.5, 119.5, {}});
};

TEST_F(RoomCorners, ConfirmTrueMotionAndRejectOtherMotion) {
  const std::vector<Rigid3d>& truth = room_.world_from_camera;
  FeatureWatch watch{ErrorModel()};
  EXPECT_TRUE(watch.IsDue(0));
  EXPECT_FALSE(watch.Check(Of(0), {}, {truth[0], {}}, 0).HasTwoMotions());
  EXPECT_FALSE(watch.IsDue(0.4));
  for (int i = 1; i <= kLast; ++i) watch.Follow(Of(i), truth[i], i / 30.);
  ASSERT_TRUE(watch.IsDue(0.5));
  // Simulates registration to an object that moves with the camera.
  EXPECT_TRUE(watch.Check(Of(kLast), {}, {truth[0] * kOther, {}}, 0.5).IsRejected());
  EXPECT_TRUE(watch.IsDue(0.51));
  watch.Follow(Of(kLast), truth[kLast], 0.53);
  const FeatureMotion motion = watch.Check(Of(kLast), {}, {truth[kLast], {}}, 0.53);
  EXPECT_GE(motion.consistent_count, 20);
  EXPECT_GT(motion.consistent_count, 2 * motion.apart);
  EXPECT_FALSE(watch.IsDue(0.6));
}

TEST_F(RoomCorners, AreRemovedWithoutColor) {
  const std::vector<Rigid3d>& truth = room_.world_from_camera;
  FeatureWatch watch{ErrorModel()};
  watch.Check(Of(0), {}, {truth[0], {}}, 0);
  ColoredView without = Of(1);
  without.color = {};
  watch.Follow(without, truth[1], 1 / 30.);
  watch.Follow(Of(2), truth[2], 2 / 30.);
  EXPECT_EQ(watch.Check(Of(2), {}, {truth[2], {}}, 0.5).consistent_count, 0);
}

}  // namespace
}  // namespace surfit::testing
