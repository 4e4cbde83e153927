#include "finishing/final_map.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "finishing/final_refinement.h"
#include "testing/matchers.h"
#include "testing/pixels.h"
#include "testing/sequence_writer.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

// Four frames of a wall at 1 m with a static camera.
class FinalMap : public ::testing::Test {
 protected:
  void SetUp() override {
    WriteTumSequence(folder_, 4);
    for (int i = 0; i < 4; ++i) {
      WriteDepth(folder_ / Format("depth/%03d.png", i), Image<std::uint16_t>(32, 24, 1000));
      trajectory_.push_back({5.003 + 0.1 * i, Rigid3d()});
    }
    sequence_ = Options(folder_);
  }

  std::optional<SurfelMap> Fused(const std::optional<DepthCalibration>& calibration = {},
                                 bool interrupted = false) {
    const PosedSequence known = {sequence_,
                                 slam_,
                                 trajectory_,
                                 frames_,
                                 left_out_,
                                 moving_,
                                 {calibration, color_latency_s_}};
    frames_done_ = 0;
    std::optional<surfit::FinalMap> fused =
        IntegrateFinalMap(known, {}, interrupted, [&](int frames, std::size_t points) {
          EXPECT_GE(frames, std::max(1, frames_done_));
          frames_done_ = frames;
          points_ = points;
        });
    if (!fused) return std::nullopt;
    return std::move(fused->map);
  }

  TempFolder folder_;
  SequenceOptions sequence_;
  SlamOptions slam_;
  Trajectory trajectory_;
  std::vector<int> frames_ = {0, 1, 2, 3};
  std::set<int> left_out_;
  std::map<int, Image<std::uint8_t>> moving_;
  double color_latency_s_ = 0;
  int frames_done_ = 0;
  std::size_t points_ = 0;
};

TEST_F(FinalMap, FusesAllFramesWithAPoseExceptHeldOutFrames) {
  frames_ = {0, 2, 3};
  trajectory_.erase(trajectory_.begin() + 1);
  trajectory_[1].world_from_camera.translation.z() = 0.01;
  left_out_ = {3};
  const std::optional<SurfelMap> map = Fused();
  EXPECT_EQ(frames_done_, 2);
  EXPECT_EQ(points_, map->size());
  ASSERT_GT(map->size(), 100u);
  double z = 0;
  for (const std::int32_t id : map->Ids()) {
    const Surfel surfel = (*map)[id];
    EXPECT_NE(surfel.last_seen, 1);
    EXPECT_LE(surfel.last_seen, 2);
    z += surfel.position_in_world.z() / static_cast<double>(map->size());
  }
  EXPECT_NEAR(z, 1.005, 0.002);  // mean of the two poses
}

// Frames 0, 2, 4, ..., 18 have the stride. Range 5 to 5 has none, and both last ranges have one.
TEST(ReopenSequence, GivesEachFrameOfTheRangesOnce) {
  const TempFolder folder;
  WriteTumSequence(folder, 20);
  SequenceOptions options = Options(folder);
  options.stride = 2;
  const auto frames_of = [&](const std::vector<FrameRange>& ranges) {
    const auto source = ReopenSequence(options, ranges);
    std::vector<int> frames;
    while (const auto read = source->Next()) frames.push_back(read->index);
    EXPECT_EQ(source->info().frame_count, static_cast<int>(frames.size()));
    return frames;
  };
  EXPECT_THAT(frames_of({{1, 3}, {5, 5}, {6, 7}, {8, 8}}), ElementsAre(2, 6, 8));
  EXPECT_THAT(frames_of({{19, 19}}), IsEmpty());  // the next frame of the stride is missing
  EXPECT_THAT(frames_of({{5, 5}, {17, 19}}), ElementsAre(18));
}

TEST(WithoutStereo, KeepsMeasuredSurfels) {
  SurfelMap map;
  Surfel surfel;
  map.Append(surfel);
  surfel.from_stereo = true;
  map.Append(surfel);
  const SurfelMap measured = WithoutStereo(map);
  ASSERT_EQ(measured.size(), 1u);
  EXPECT_FALSE(measured[measured.Ids().front()].from_stereo);
}

TEST(CalibrationWarning, IgnoresUnknownParameters) {
  DepthSensor given = {{640, 480, 500, 500, 320, 240}, {}};
  const DepthCalibration same = {given.camera, {}, 0};
  DepthCalibration wide = same;
  wide.camera.fx = wide.camera.fy = 750;
  EXPECT_THAT(CalibrationWarning(given, wide), Names("contradicts"));
  given.prior.focal_relative_sigma = 0;
  EXPECT_EQ(CalibrationWarning(given, wide), "");
  given.prior = {};
  given.prior.aspect_relative_sigma = given.prior.center_px = given.prior.inverse_depth_sigma = 0;
  EXPECT_EQ(CalibrationWarning(given, same), "");
  EXPECT_THAT(CalibrationWarning(given, wide), Names("contradicts"));
}

TEST_F(FinalMap, UsesTheEstimatedCalibration) {
  const auto centre_and_depth = [](const SurfelMap& map) {
    Eigen::Vector3f mean = Eigen::Vector3f::Zero();
    for (const std::int32_t id : map.Ids()) mean += map[id].position_in_world;
    return Eigen::Vector3f(mean / static_cast<float>(map.size()));
  };
  DepthCalibration found = {{32, 24, 31, 30, 15.5 + 3.1, 11.5, {}}, {{1 / 1.25 - 1}}, 0};
  const Eigen::Vector3f given = centre_and_depth(*Fused());
  const Eigen::Vector3f corrected = centre_and_depth(*Fused(found));
  EXPECT_NEAR(given.z(), 1, 1e-5);
  EXPECT_NEAR(corrected.z(), 1.25, 1e-5);
  // 3.1 px of a focal length of 31 px are 10 % of the depth. Surfel positions are exact to one
  // pixel.
  EXPECT_NEAR(corrected.x() - given.x(), -0.125, 0.01);
}

// Red increases by 4 per pixel to the right. The camera moves to the right at 0.5 m/s, so 50 ms
// earlier a point at 1 m was 0.775 px farther right. The map is coloured from every third frame, so
// the pixels of four frames are 4.65 px apart.
TEST_F(FinalMap, UsesTheEstimatedColorLatency) {
  constexpr int kFrames = 12;
  WriteTumSequence(folder_, kFrames);
  Image<Rgb8> ramp(32, 24);
  for (const auto [u, v] : PixelsOf(ramp)) {
    ramp(u, v) = {static_cast<std::uint8_t>(60 + 4 * u), 20, 30};
  }
  trajectory_.clear();
  frames_.clear();
  for (int i = 0; i < kFrames; ++i) {
    WriteDepth(folder_ / Format("depth/%03d.png", i), Image<std::uint16_t>(32, 24, 1000));
    ramp(0, 0).b = static_cast<std::uint8_t>(i);  // repeated images are ignored
    WriteColor(folder_ / Format("rgb/%03d.png", i), ramp);
    const Eigen::Vector3d position(0.05 * i, 0, 0);
    trajectory_.push_back({5.003 + 0.1 * i, {Eigen::Quaterniond::Identity(), position}});
    frames_.push_back(i);
  }
  const auto mean_red = [](const SurfelMap& map) {
    double sum = 0, count = 0;
    for (const std::int32_t id : map.Ids()) {
      const float x = map[id].position_in_world.x();
      if (x < 0.15f || x > 0.35f) continue;  // seen by all frames
      sum += map[id].color.r;
      ++count;
    }
    return sum / count;
  };
  const double as_given = mean_red(*Fused());
  color_latency_s_ = 0.05;
  EXPECT_NEAR(mean_red(*Fused()) - as_given, 4 * 0.775, 0.2);
}

// The left half of all images is a moving region.
TEST_F(FinalMap, SkipsMovingRegions) {
  Image<std::uint8_t> left(8, 6);
  for (const auto [u, v] : PixelsOf(left)) left(u, v) = u < 4;
  for (int frame = 0; frame < 4; ++frame) moving_[frame] = left;
  const std::optional<SurfelMap> map = Fused();
  ASSERT_GT(map->size(), 50u);
  for (const std::int32_t id : map->Ids()) EXPECT_GE((*map)[id].position_in_world.x(), 0);
}

// Surfels at depth edges that only the last frame observed may be spurious. Surfels between edges
// are kept.
TEST_F(FinalMap, RemovesDepthEdgesObservedOnce) {
  Image<std::uint16_t> depth(32, 24, 1000);
  for (int v = 4; v < 20; ++v) {
    for (int u = 8; u < 24; ++u) depth(u, v) = 700;
  }
  WriteDepth(folder_ / "depth/003.png", depth);
  const auto near_count = [](const SurfelMap& map, bool at_edge) {
    int count = 0;
    for (const std::int32_t id : map.Ids()) {
      count += map[id].position_in_world.z() < 0.9f && map[id].at_edge == at_edge;
    }
    return count;
  };
  const SurfelMap all = *Fused();  // too few frames to remove unstable surfels
  slam_.fusion.max_inactive_frames = 2;
  const SurfelMap lasting = *Fused();
  EXPECT_GT(near_count(all, true), 20);
  EXPECT_EQ(near_count(lasting, true), 0);
  EXPECT_GT(near_count(lasting, false), 50);
  EXPECT_EQ(near_count(lasting, false), near_count(all, false));
}

// Pixels on the wall are 32 mm apart. The maximum surfel spacing for tracking is 40 mm.
TEST_F(FinalMap, IsFinerThanTheTrackingMap) {
  slam_.fusion.max_spacing_m = 0.04f;
  const std::size_t size = Fused()->size();
  slam_.fusion.max_spacing_m = 0.04f / 0.7f;
  EXPECT_GT(size, Fused()->size() * 5 / 4);
}

// One frame of a wall with Kinect noise. Pixels are 5 mm apart.
TEST_F(FinalMap, IsSmootherThanTheMeasurement) {
  Image<std::uint16_t> depth(160, 120);
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0, 3);
  for (std::uint16_t& d : depth) d = static_cast<std::uint16_t>(1000 + noise(random));
  WriteDepth(folder_ / "depth/000.png", depth);
  WriteColor(folder_ / "rgb/000.png", Image<Rgb8>(160, 120, {90, 90, 90}));
  sequence_.intrinsics = {200, 200, 79.5, 59.5};
  frames_ = {0};
  trajectory_.resize(1);
  const std::optional<SurfelMap> map = Fused();
  double squares = 0;
  for (const std::int32_t id : map->Ids()) {
    squares += std::pow((*map)[id].position_in_world.z() - 1, 2);
  }
  ASSERT_GT(map->size(), 1000u);
  EXPECT_LT(std::sqrt(squares / static_cast<double>(map->size())), 0.003 / 2);
}

// Colour images are shifted by 2 px to the left and to the right alternately. Their mean would
// reduce the amplitude of a wave of 16 px by cos(pi / 4).
TEST_F(FinalMap, RegistersTheColors) {
  constexpr double kPeriod_px = 16, kHeight = 60;
  const auto wave = [&](double x, double y) {
    return 120 + kHeight / 2 *
                     (std::sin(2 * M_PI * x / kPeriod_px) + std::sin(2 * M_PI * y / kPeriod_px));
  };
  WriteTumSequence(folder_, 8);
  frames_.clear();
  trajectory_.clear();
  for (int i = 0; i < 8; ++i) {
    WriteDepth(folder_ / Format("depth/%03d.png", i), Image<std::uint16_t>(160, 120, 1000));
    Image<Rgb8> color(160, 120);
    const int shift = i % 4 < 2 ? -2 : 2;
    for (const auto [u, v] : PixelsOf(color)) {
      const auto grey = static_cast<std::uint8_t>(wave(u + shift, v) + 0.5);
      color(u, v) = {grey, grey, grey};
    }
    WriteColor(folder_ / Format("rgb/%03d.png", i), color);
    trajectory_.push_back({5.003 + 0.1 * i, Rigid3d()});
    frames_.push_back(i);
  }
  sequence_.intrinsics = {200, 200, 79.5, 59.5};
  // Amplitude of the colours at the period of the wave.
  const std::optional<SurfelMap> map = Fused();
  ASSERT_GT(map->size(), 1000u);
  double in_phase = 0, out_of_phase = 0;
  for (const std::int32_t id : map->Ids()) {
    const Eigen::Vector3f p = (*map)[id].position_in_world;
    const double phase = 2 * M_PI * (200 * p.x() / p.z() + 79.5) / kPeriod_px;
    const double share = 2. * (*map)[id].color.r / static_cast<double>(map->size());
    in_phase += share * std::sin(phase);
    out_of_phase += share * std::cos(phase);
  }
  EXPECT_GT(std::hypot(in_phase, out_of_phase), 0.85 * kHeight / 2);
}

TEST_F(FinalMap, IsEmptyAfterAnInterruption) {
  EXPECT_FALSE(Fused({}, true).has_value());
  EXPECT_EQ(frames_done_, 0);
}

TEST_F(FinalMap, KeepsPosesWithASingleKeyframe) {
  const std::optional<DepthCalibration> found =
      DepthCalibration{{32, 24, 31, 30, 16, 11.5, {}}, {}, 0};
  const PosedSequence known = {sequence_, slam_, trajectory_, frames_, left_out_, moving_, {found}};
  const auto progress = [](const RefinementRound&) {};
  const auto refined = RefinePosedSequence(known, found->camera, false, progress);
  ASSERT_TRUE(refined.has_value());
  EXPECT_EQ(refined->keyframes, 1u);
  EXPECT_EQ(refined->summary.termination, RefinementTermination::kTooFewSurfels);
  EXPECT_EQ(refined->trajectory.size(), trajectory_.size());
  EXPECT_TRUE(refined->found.calibration && AreSame(*refined->found.calibration, *found));
  EXPECT_FALSE(RefinePosedSequence(known, found->camera, true, progress).has_value());
}

}  // namespace
}  // namespace surfit::testing
