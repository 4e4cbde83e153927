#include "io/openni/image_pairs.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace surfit {
namespace {

DeviceImage DepthAt(std::uint64_t stamp_us) {
  DeviceImage image;
  image.stamp_us = stamp_us;
  image.depth = Image<std::uint16_t>(1, 1);
  return image;
}

DeviceImage ColorAt(std::uint64_t stamp_us) {
  DeviceImage image;
  image.stamp_us = stamp_us;
  image.color = Image<Rgb8>(1, 1);
  return image;
}

// Timestamps of depth and colour of all complete pairs; 0: no colour.
std::vector<std::pair<std::uint64_t, std::uint64_t>> TakeAll(ImagePairs* pairs) {
  std::vector<std::pair<std::uint64_t, std::uint64_t>> stamps;
  while (const auto pair = pairs->Take()) {
    const bool has_color = !pair->color.color.empty();
    stamps.emplace_back(pair->depth.stamp_us, has_color ? pair->color.stamp_us : 0);
  }
  return stamps;
}

using Stamps = std::vector<std::pair<std::uint64_t, std::uint64_t>>;

TEST(ImagePairs, WaitForTheClosestColour) {
  ImagePairs pairs(/*has_color=*/true);
  pairs.Add(ColorAt(90000));
  pairs.Add(DepthAt(100000));
  EXPECT_EQ(TakeAll(&pairs), Stamps());  // a closer colour image may arrive
  pairs.Add(ColorAt(104000));
  EXPECT_EQ(TakeAll(&pairs), (Stamps{{100000, 104000}}));
}

TEST(ImagePairs, UseEachColourOnce) {
  ImagePairs pairs(/*has_color=*/true);
  pairs.Add(ColorAt(100000));
  pairs.Add(DepthAt(95000));
  pairs.Add(DepthAt(105000));
  pairs.Add(ColorAt(133000));
  EXPECT_EQ(TakeAll(&pairs), (Stamps{{95000, 100000}, {105000, 0}}));
}

TEST(ImagePairs, KeepDepthAloneIfColourIsFarOrMissing) {
  ImagePairs pairs(/*has_color=*/true);
  pairs.Add(ColorAt(10000));
  for (const std::uint64_t stamp_us : {100000, 133000, 166000}) pairs.Add(DepthAt(stamp_us));
  EXPECT_EQ(TakeAll(&pairs), (Stamps{{100000, 0}}));
  pairs.Add(ColorAt(140000));
  EXPECT_EQ(TakeAll(&pairs), (Stamps{{133000, 140000}}));
}

TEST(ImagePairs, WithoutColourStreamDoNotWait) {
  ImagePairs pairs(/*has_color=*/false);
  pairs.Add(DepthAt(100000));
  EXPECT_EQ(TakeAll(&pairs), (Stamps{{100000, 0}}));
}

TEST(ImagePairs, DropWaitingImagesOnReset) {
  ImagePairs pairs(/*has_color=*/true);
  pairs.Add(DepthAt(100000));
  pairs.Clear();
  pairs.Add(ColorAt(100000));
  EXPECT_EQ(TakeAll(&pairs), Stamps());
}

}  // namespace
}  // namespace surfit
