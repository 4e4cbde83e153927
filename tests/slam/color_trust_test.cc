// Colour that does not belong to the depth.
#include "tracking/color_trust.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>

#include "slam/simulated_sequence.h"

namespace surfit::testing {
namespace {

TEST(ColorTrust, IsLostAfterFiveContradictions) {
  ColorTrust trust;
  for (int i = 0; i < 4; ++i) trust.AddBrightness(false);
  EXPECT_TRUE(trust.is_trusted());
  trust.AddBrightness(false);
  EXPECT_FALSE(trust.is_trusted());
  EXPECT_FALSE(trust.Accepts(Image<Rgb8>(4, 4), true));
}

TEST(ColorTrust, IsKeptWithMoreAgreements) {
  ColorTrust trust;
  for (int i = 0; i < 100; ++i) trust.AddBrightness(i % 3 != 0);
  EXPECT_TRUE(trust.is_trusted());
}

TEST(ColorTrust, IsKeptAfterManyAgreements) {
  ColorTrust trust;
  for (int i = 0; i < 15; ++i) trust.AddBrightness(true);
  EXPECT_TRUE(trust.is_proven());
  for (int i = 0; i < 100; ++i) trust.AddBrightness(false);
  EXPECT_TRUE(trust.is_trusted());
}

TEST(ColorTrust, RejectsFrozenColorUntilItChanges) {
  ColorTrust trust;
  const Image<Rgb8> frozen(100, 100, {1, 2, 3}), other(100, 100, {3, 2, 1});
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(trust.Accepts(frozen, true));
  EXPECT_FALSE(trust.Accepts(frozen, true));
  EXPECT_TRUE(trust.Accepts(other, true));
  // A camera that stands still repeats both images.
  for (int i = 0; i < 9; ++i) EXPECT_TRUE(trust.Accepts(other, false));
}

// A single frame can be wrong: the numbers are of 11 frames.
TEST(HasColorAtDepthEdges, IsTrueForRegisteredColorOnly) {
  const PinholeCamera camera = {320, 240, 262.5, 262.5, 159.5, 119.5, {}};
  const SimulatedSequence sequence = Simulate("room", 4, 101, Sensor::kIdeal, camera, 10);
  int registered = 0, late = 0, rotated = 0;
  const auto count = static_cast<int>(sequence.frames.size());
  for (int i = 0; i < count; ++i) {
    const Image<float>& depth_m = sequence.frames[i].depth_m;
    Image<Rgb8> color = sequence.frames[i].color;
    registered += HasColorAtDepthEdges(depth_m, color);
    late += HasColorAtDepthEdges(depth_m, sequence.frames[(i + 5) % count].color);
    std::reverse(color.begin(), color.end());
    rotated += HasColorAtDepthEdges(depth_m, color);
  }
  EXPECT_EQ(registered, 11);
  EXPECT_LE(late, 4);
  EXPECT_LE(rotated, 4);
}

TEST(HasColorAtDepthEdges, IsTrueWithoutDepthEdges) {
  const Image<float> plane(160, 120, 1.F);
  EXPECT_TRUE(HasColorAtDepthEdges(plane, Image<Rgb8>(160, 120, {1, 2, 3})));
}

const SlamRun& RunWithoutColor() {
  static const auto* const run = [] {
    SimulatedSequence sequence = SimulateRoom(4, 60, Sensor::kIdeal);
    for (RgbdFrame& frame : sequence.frames) frame.color = {};
    return new SlamRun(RunSlam(sequence, {}, sequence.world_from_camera[0]));
  }();
  return *run;
}

// Each frame is tracked as well as without colour.
void ExpectTrackedByDepth(const std::function<void(SimulatedSequence*)>& change) {
  SimulatedSequence sequence = SimulateRoom(4, 60, Sensor::kIdeal);
  change(&sequence);
  const SlamRun run = RunSlam(sequence, {}, sequence.world_from_camera[0]);
  for (const FrameReport& report : run.reports) EXPECT_TRUE(report.HasPose()) << report.index;
  const std::vector<Rigid3d>& truth = sequence.world_from_camera;
  EXPECT_LT(ErrorsOf(run, truth).max_m, ErrorsOf(RunWithoutColor(), truth).max_m + 0.001);
}

TEST(ColorOfSomethingElse, OfAnotherTimeLosesNoFrame) {
  ExpectTrackedByDepth([](SimulatedSequence* sequence) {
    std::vector<Image<Rgb8>> colors;
    for (const RgbdFrame& frame : sequence->frames) colors.push_back(frame.color);
    for (std::size_t i = 0; i < colors.size(); ++i)
      sequence->frames[i].color = colors[(i + 30) % colors.size()];
  });
}

TEST(ColorOfSomethingElse, RotatedLosesNoFrame) {
  ExpectTrackedByDepth([](SimulatedSequence* sequence) {
    for (RgbdFrame& frame : sequence->frames) std::reverse(frame.color.begin(), frame.color.end());
  });
}

TEST(ColorOfSomethingElse, NoiseLosesNoFrame) {
  ExpectTrackedByDepth([](SimulatedSequence* sequence) {
    std::mt19937_64 random(1);
    for (RgbdFrame& frame : sequence->frames) {
      for (Rgb8& pixel : frame.color) {
        const auto bits = random();
        pixel = {static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8),
                 static_cast<std::uint8_t>(bits >> 16)};
      }
    }
  });
}

TEST(ColorOfSomethingElse, FrozenLosesNoFrame) {
  ExpectTrackedByDepth([](SimulatedSequence* sequence) {
    for (RgbdFrame& frame : sequence->frames) frame.color = sequence->frames[0].color;
  });
}

}  // namespace
}  // namespace surfit::testing
