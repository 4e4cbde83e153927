#include "surfit/places/limit_keyframes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace surfit {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// Along a line at these places, each with a view of 1000 features that no other has.
std::vector<Keyframe> KeyframesAt(const std::vector<double>& x_m) {
  std::vector<Keyframe> keyframes;
  for (const double x : x_m) {
    Keyframe keyframe;
    keyframe.frame_index = static_cast<int>(keyframes.size());
    keyframe.world_from_camera.translation.x() = x;
    keyframe.view.depth = Image<std::uint16_t>(10, 10, 1);
    keyframe.view.features.resize(1);
    keyframe.view.features[0].descriptor = {keyframes.size() * 0x123456789abcdef, 0, 0, 0};
    keyframes.push_back(keyframe);
  }
  return keyframes;
}

PlaceIndex IndexOf(const std::vector<Keyframe>& keyframes) {
  PlaceIndex index;
  for (int i = 0; i < static_cast<int>(keyframes.size()); ++i) index.Add(i, keyframes[i].view);
  return index;
}

TEST(LimitKeyframes, LeavesAllWhatIsWithinTheLimit) {
  std::vector<Keyframe> keyframes = KeyframesAt({0, 1, 2});
  PlaceIndex index = IndexOf(keyframes);
  const std::size_t bytes = 3 * keyframes[0].view.Bytes();
  EXPECT_THAT(LimitKeyframes(bytes, &keyframes, &index), IsEmpty());
  EXPECT_EQ(index.keyframe_count(), 3);
}

TEST(LimitKeyframes, GivesUpTheOlderViewOfThePairThatIsMostAlike) {
  std::vector<Keyframe> keyframes = KeyframesAt({0, 1, 2.5, 2.6, 1.2});
  PlaceIndex index = IndexOf(keyframes);
  const std::size_t bytes = 3 * keyframes[0].view.Bytes();
  // 2.5 and 2.6 m are 0.1 m apart, then 1 and 1.2 m are nearest.
  EXPECT_THAT(LimitKeyframes(bytes, &keyframes, &index), ElementsAre(2, 1));
  EXPECT_TRUE(keyframes[2].view.empty());
  EXPECT_TRUE(keyframes[1].view.empty());
  EXPECT_FALSE(keyframes[3].view.empty());
  EXPECT_EQ(keyframes[2].world_from_camera.translation.x(), 2.5);
  EXPECT_EQ(index.keyframe_count(), 3);
}

TEST(LimitKeyframes, CountsATurnAsWay) {
  std::vector<Keyframe> keyframes = KeyframesAt({0, 0.1, 5, 5.2});
  keyframes[1].world_from_camera.rotation = QuaternionExp<double>({0, 0.5, 0});
  PlaceIndex index = IndexOf(keyframes);
  const std::size_t bytes = 3 * keyframes[0].view.Bytes();
  EXPECT_THAT(LimitKeyframes(bytes, &keyframes, &index), ElementsAre(2));
}

TEST(LimitKeyframes, GivesUpAllWhereNothingIsAllowed) {
  std::vector<Keyframe> keyframes = KeyframesAt({0, 1});
  PlaceIndex index = IndexOf(keyframes);
  EXPECT_THAT(LimitKeyframes(0, &keyframes, &index), ElementsAre(0, 1));
}

}  // namespace
}  // namespace surfit
