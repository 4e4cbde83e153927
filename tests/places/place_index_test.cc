#include "surfit/loop_closure/place_index.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "places/simulated_places.h"
#include "surfit/core/options.h"
#include "testing/matchers.h"

namespace surfit::testing {

namespace {

bool Any(int /*keyframe*/) { return true; }

PlaceView RandomView(std::uint64_t seed, int features = 100) {
  std::mt19937_64 generator(seed);
  PlaceView view;
  view.features.resize(features);
  for (PlaceFeature& feature : view.features) {
    for (std::uint64_t& word : feature.descriptor) word = generator();
  }
  return view;
}

// A subset of the features of the view, each with some random bit flips.
PlaceView Changed(const PlaceView& view, int features, int bits) {
  std::mt19937_64 generator(1);
  PlaceView changed;
  changed.features.assign(view.features.begin(), view.features.begin() + features);
  for (PlaceFeature& feature : changed.features) {
    for (int i = 0; i < bits; ++i) {
      const std::uint64_t bit = generator() % 256;
      feature.descriptor[bit / 64] ^= std::uint64_t{1} << (bit % 64);
    }
  }
  return changed;
}

PlaceIndex IndexOfTen() {
  PlaceIndex index;
  for (int i = 0; i < 10; ++i) index.Add(i, RandomView(i));
  return index;
}

TEST(PlaceIndex, FindsOnlyIdenticalView) {
  const auto candidates = IndexOfTen().Query(RandomView(3), 5, Any);
  ASSERT_EQ(candidates.size(), 1);
  EXPECT_EQ(candidates[0].keyframe, 3);
  EXPECT_NEAR(candidates[0].similarity, 1, 1e-12);
}

// With 14 of 256 bits and 8 tables, a feature with 10 flipped bits is found with probability 1 - (1
// - (1 - 14/256)^10)^8 = 0.999.
TEST(PlaceIndex, FindsSimilarFeatures) {
  const auto candidates = IndexOfTen().Query(Changed(RandomView(3), 50, 10), 5, Any);
  ASSERT_EQ(candidates.size(), 1);
  EXPECT_EQ(candidates[0].keyframe, 3);
  EXPECT_GT(candidates[0].similarity, 0.95);
}

TEST(PlaceIndex, SortsBySimilarityAndLimitsCount) {
  PlaceIndex index;
  const PlaceView view = RandomView(1);
  index.Add(7, Changed(view, 30, 0));
  index.Add(2, Changed(view, 80, 0));
  index.Add(9, Changed(view, 80, 0));
  const auto candidates = index.Query(view, 2, Any);
  ASSERT_EQ(candidates.size(), 2);
  EXPECT_EQ(candidates[0].keyframe, 2);
  EXPECT_EQ(candidates[1].keyframe, 9);
  EXPECT_EQ(index.Query(view, 1, [](int keyframe) { return keyframe == 7; })[0].keyframe, 7);
}

// Ten keyframes share 60 features, and each has 40 unique features. A feature of k of 10 keyframes
// has the weight log(11 / k). So the score of another keyframe is 60 log(11 / 10) / (60 log(11 /
// 10) + 40 log(11)).
TEST(PlaceIndex, WeightsFeaturesByRarity) {
  const auto view = [](int keyframe) {
    PlaceView both = RandomView(keyframe, 40);
    const PlaceView shared = RandomView(1000, 60);
    both.features.insert(both.features.end(), shared.features.begin(), shared.features.end());
    return both;
  };
  PlaceIndexOptions options;
  options.min_similarity = 0;
  PlaceIndex index(options);
  for (int i = 0; i < 10; ++i) index.Add(i, view(i));
  const auto candidates = index.Query(view(3), 10, Any);
  ASSERT_EQ(candidates.size(), 10);
  EXPECT_EQ(candidates[0].keyframe, 3);
  EXPECT_NEAR(candidates[0].similarity, 1, 1e-12);
  const double common = 60 * std::log(1.1), own = 40 * std::log(11.);
  EXPECT_NEAR(candidates[1].similarity, common / (common + own), 1e-12);
}

TEST(PlaceIndex, DoesNotFindRemovedKeyframes) {
  PlaceIndex index = IndexOfTen();
  const std::size_t bytes = index.Bytes();
  index.Remove(3);
  EXPECT_EQ(index.keyframe_count(), 9);
  EXPECT_LT(index.Bytes(), bytes);
  EXPECT_TRUE(index.Query(RandomView(3), 5, Any).empty());
  EXPECT_EQ(index.Query(RandomView(8), 5, Any).size(), 1);
  index.Add(3, RandomView(3));
  EXPECT_EQ(index.Query(RandomView(3), 5, Any).size(), 1);
}

// Removes and adds keyframes at random. Indices in the tables change when unused entries are
// removed.
TEST(PlaceIndex, AgreesWithANewIndexAfterChanges) {
  std::mt19937_64 rng(5);
  PlaceIndexOptions options;
  options.min_similarity = 0;
  PlaceIndex changed(options);
  std::set<int> keyframes;
  // Keyframes share half of their features with the next one.
  const auto view = [](int keyframe) {
    PlaceView both = RandomView(keyframe, 20);
    const PlaceView shared = RandomView(keyframe + 1, 20);
    both.features.insert(both.features.end(), shared.features.begin(), shared.features.end());
    return both;
  };
  for (int i = 0; i < 300; ++i) {
    const int keyframe = static_cast<int>(rng() % 30);
    if (keyframes.count(keyframe) > 0) {
      changed.Remove(keyframe);
      keyframes.erase(keyframe);
    } else {
      changed.Add(keyframe, view(keyframe));
      keyframes.insert(keyframe);
    }
    if (i % 10 != 0) continue;
    PlaceIndex fresh(options);
    for (const int k : keyframes) fresh.Add(k, view(k));
    EXPECT_EQ(changed.Bytes(), fresh.Bytes());
    EXPECT_EQ(changed.keyframe_count(), fresh.keyframe_count());
    const auto found = changed.Query(view(keyframe), 30, Any);
    const auto expected = fresh.Query(view(keyframe), 30, Any);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t k = 0; k < found.size(); ++k) {
      EXPECT_EQ(found[k].keyframe, expected[k].keyframe);
      EXPECT_EQ(found[k].similarity, expected[k].similarity);
    }
  }
}

TEST(PlaceIndex, RejectsAKeyframeTwice) {
  PlaceIndex index = IndexOfTen();
  ExpectInputError([&] { index.Add(3, RandomView(3)); }, Names("keyframe 3"));
}

TEST(PlaceIndex, HasNoCandidatesWithoutFeatures) {
  EXPECT_TRUE(IndexOfTen().Query(PlaceView(), 5, Any).empty());
  EXPECT_TRUE(PlaceIndex().Query(RandomView(1), 5, Any).empty());
}

// Query views are 15 cm and 8 degrees from every third keyframe. Consecutive keyframes show almost
// the same view.
TEST(PlaceIndex, FindsPlacesOfARoom) {
  for (const std::uint64_t seed : {1, 2}) {
    const RoomOfKeyframes& room = MakeRoomOfKeyframes(seed);
    PlaceIndex index;
    for (int i = 0; i < static_cast<int>(room.keyframes.size()); ++i) {
      index.Add(i, room.keyframes[i].view);
    }
    int asked = 0, found = 0;
    for (int i = 0; i < index.keyframe_count(); i += 3) {
      const Rigid3d off(QuaternionExp<double>({0, 0.14, 0}), {0.12, 0, 0.09});
      const auto candidates = index.Query(SeeNearby(room, i, off).view, 3, Any);
      ++asked;
      found += std::any_of(candidates.begin(), candidates.end(), [&](const auto& candidate) {
        return std::abs(candidate.keyframe - i) <= 2;
      });
    }
    EXPECT_GE(found, 0.9 * asked) << seed;
  }
}

TEST(PlaceIndexOptions, RejectInvalidValues) {
  const auto expect_refused = ExpectOptionsRefused<PlaceIndexOptions>;
  Validate(PlaceIndexOptions());
  expect_refused([](auto& o) { o.min_similarity = -1; }, "min_similarity", "-1");
}

// Keyframes along a line, each with a view of 1000 unique features.
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

TEST(LimitKeyframes, KeepsAllKeyframesWithinLimit) {
  std::vector<Keyframe> keyframes = KeyframesAt({0, 1, 2});
  PlaceIndex index = IndexOf(keyframes);
  const std::size_t bytes = 3 * keyframes[0].view.Bytes();
  EXPECT_THAT(LimitKeyframes(bytes, &keyframes, &index), IsEmpty());
  EXPECT_EQ(index.keyframe_count(), 3);
}

TEST(LimitKeyframes, RemovesOlderViewOfMostSimilarPair) {
  std::vector<Keyframe> keyframes = KeyframesAt({0, 1, 2.5, 2.6, 1.2});
  PlaceIndex index = IndexOf(keyframes);
  const std::size_t bytes = 3 * keyframes[0].view.Bytes();
  // 2.5 and 2.6 m have a distance of 0.1 m. The next pair is 1 and 1.2 m.
  EXPECT_THAT(LimitKeyframes(bytes, &keyframes, &index), ElementsAre(2, 1));
  EXPECT_TRUE(keyframes[2].view.empty());
  EXPECT_TRUE(keyframes[1].view.empty());
  EXPECT_FALSE(keyframes[3].view.empty());
  EXPECT_EQ(keyframes[2].world_from_camera.translation.x(), 2.5);
  EXPECT_EQ(index.keyframe_count(), 3);
}

TEST(LimitKeyframes, CountsRotationAsDistance) {
  std::vector<Keyframe> keyframes = KeyframesAt({0, 0.1, 5, 5.2});
  keyframes[1].world_from_camera.rotation = QuaternionExp<double>({0, 0.5, 0});
  PlaceIndex index = IndexOf(keyframes);
  const std::size_t bytes = 3 * keyframes[0].view.Bytes();
  EXPECT_THAT(LimitKeyframes(bytes, &keyframes, &index), ElementsAre(2));
}

// Removal one by one, with all pairs compared. Some poses are equal.
TEST(LimitKeyframes, AgreesWithBruteForce) {
  std::mt19937_64 rng(6);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Keyframe> keyframes = KeyframesAt(std::vector<double>(120, 0));
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    Rigid3d& pose = keyframes[k].world_from_camera;
    pose.translation = {3 * uniform(rng), uniform(rng), uniform(rng)};
    pose.rotation = QuaternionExp<double>({0, uniform(rng), 0});
    if (k % 5 == 4) pose = keyframes[k - 3].world_from_camera;
  }
  std::vector<int> expected;
  std::vector<Keyframe> left = keyframes;
  while (expected.size() < 60) {
    int older = -1;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < left.size(); ++i) {
      for (std::size_t j = i + 1; j < left.size(); ++j) {
        if (left[i].view.empty() || left[j].view.empty()) continue;
        const Rigid3d motion = left[i].world_from_camera.Inverse() * left[j].world_from_camera;
        const double apart = motion.translation.norm() + 2 * RotationAngle(motion.rotation);
        if (apart >= least) continue;
        least = apart;
        older = static_cast<int>(i);
      }
    }
    left[older].view = PlaceView();
    expected.push_back(older);
  }
  PlaceIndex index = IndexOf(keyframes);
  const std::size_t bytes = 60 * keyframes[0].view.Bytes();
  EXPECT_EQ(LimitKeyframes(bytes, &keyframes, &index), expected);
}

TEST(LimitKeyframes, RemovesAllViewsAtZeroLimit) {
  std::vector<Keyframe> keyframes = KeyframesAt({0, 1});
  PlaceIndex index = IndexOf(keyframes);
  EXPECT_THAT(LimitKeyframes(0, &keyframes, &index), ElementsAre(0, 1));
}

}  // namespace

}  // namespace surfit::testing
