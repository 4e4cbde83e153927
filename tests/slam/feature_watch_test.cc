#include "slam/feature_watch.h"

#include <gtest/gtest.h>

#include <random>

#include "slam/simulated_sequence.h"
#include "surfit/frame/prepare_frame.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

const Rigid3d kPosed(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.02, 0, 0));
const Rigid3d kOther(Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY())),
                     Eigen::Vector3d(0.2, 0, 0.1));

// Features of two frames: the first `posed` have moved by kPosed, others by kOther, and `stray`
// more each in its own way.
struct Shared {
  FeaturePoints source, target;

  Shared(int posed, int other, int stray) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> place(-1, 1);
    const auto any = [&] { return Eigen::Vector3d(place(random), place(random), place(random)); };
    const int count = posed + other + stray;
    for (int i = 0; i < count; ++i) {
      for (std::uint64_t& bits : source.descriptors.emplace_back()) bits = random();
      source.points.push_back(any() + Eigen::Vector3d(0, 0, 2));
      const Eigen::Vector3d& point = source.points.back();
      const Eigen::Vector3d strayed = any() + Eigen::Vector3d(0, 0, 2);
      target.points.push_back(i < posed           ? kPosed * point
                              : i < posed + other ? kOther * point
                                                  : strayed);
    }
    target.descriptors = source.descriptors;
    source.sigmas_m = target.sigmas_m = std::vector<double>(count, 0.005);
  }
};

FeatureMotion Compare(const Shared& shared) {
  return CompareFeatures({shared.source, kPosed, {}}, {shared.target, Rigid3d(), {}});
}

TEST(CompareFeatures, CountsThoseThatMoveAsPosedAndByOneOtherMotion) {
  const FeatureMotion motion = Compare({40, 25, 10});
  EXPECT_GE(motion.as_posed, 40);
  EXPECT_LE(motion.as_posed, 42);
  EXPECT_EQ(motion.apart, 25);
  EXPECT_TRUE(motion.IsApart());
  EXPECT_FALSE(motion.IsRefuted());
  EXPECT_TRUE(Compare({20, 25, 10}).IsRefuted());
}

TEST(CompareFeatures, StrayFeaturesTellOfNoMotion) {
  EXPECT_FALSE(Compare({40, 0, 30}).IsApart());
  EXPECT_FALSE(Compare({0, 0, 30}).IsApart());
  EXPECT_FALSE(Compare({0, 0, 0}).IsApart());
}

// Half a second of a walk at 320 x 240 pixels.
class RoomFeatures : public ::testing::Test {
 protected:
  PosedFeatures Of(int frame, const Rigid3d& world_from_camera) const {
    const RgbdFrame& images = room_.frames[frame];
    return {FeaturesAtRest({PreprocessDepth(images.depth_m, {room_.camera, {}}, {}), images.color},
                           {}, ErrorModel()),
            world_from_camera,
            {}};
  }

  static constexpr int kLast = 15;
  const SimulatedSequence room_ = Simulate("room", 1, kLast + 1, Sensor::kIdeal,
                                           PinholeCamera{320, 240, 262.5, 262.5, 159.5, 119.5, {}});
};

TEST_F(RoomFeatures, ConfirmTrueMotionAndRefuteAnother) {
  const std::vector<Rigid3d>& truth = room_.world_from_camera;
  FeatureWatch watch;
  EXPECT_TRUE(watch.IsDue(0));
  EXPECT_FALSE(watch.Check(Of(0, truth[0]), 0).IsApart());
  EXPECT_FALSE(watch.IsDue(0.4));
  ASSERT_TRUE(watch.IsDue(0.5));
  // As it would be if the camera were held at something that goes where the camera goes.
  EXPECT_TRUE(watch.Check(Of(kLast, truth[0] * kOther), 0.5).IsRefuted());
  EXPECT_TRUE(watch.IsDue(0.51));
  const FeatureMotion motion = watch.Check(Of(kLast, truth[kLast]), 0.53);
  EXPECT_GE(motion.as_posed, 10);
  EXPECT_GT(motion.as_posed, 2 * motion.apart);
  EXPECT_FALSE(watch.IsDue(0.6));
}

}  // namespace
}  // namespace surfit::testing
