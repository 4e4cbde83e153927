// Depth noise that is measured from the first frames.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "calibration/calibrator.h"
#include "run/depth_frames.h"
#include "slam/simulated_sequence.h"
#include "surfit/io/camera_files.h"
#include "surfit/run/slam_run.h"
#include "testing/sequence_writer.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

PinholeCamera PhoneDepthCamera() { return {256, 192, 180.3, 180.3, 127.5, 95.5, {}}; }

// First frames of a room, measured by a sensor, with the errors of inverse depth.
struct NoisyFrames {
  PinholeCamera camera;
  std::vector<Image<float>> depths_m;
  std::vector<float> errors;  // 1/m

  // RMS of the errors within three standard deviations, 1/m. Larger errors are bleeding edges,
  // flying pixels and interpolation over edges.
  double Sigma() const {
    constexpr double kSigmasOfMedian = 1.4826;
    std::vector<float> sizes;
    for (const float error : errors) sizes.push_back(std::abs(error));
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());
    const double limit = 3 * kSigmasOfMedian * *middle;
    double squares = 0, count = 0;
    for (const float error : errors) {
      if (std::abs(error) > limit) continue;
      squares += error * error;
      ++count;
    }
    return std::sqrt(squares / count);
  }
};

template <typename Measure>
NoisyFrames FramesOf(std::uint64_t seed, const PinholeCamera& camera, const Measure& measure) {
  constexpr int kPathFrames = 80, kFrames = 6;
  const Scene scene = MakeScene("room", seed);
  const Trajectory path = MakePath(scene, kPathFrames, seed);
  NoisyFrames frames = {camera, {}, {}};
  for (int i = 0; i < kFrames; ++i) {
    const Rendering exact = Render(scene, camera, path[i].world_from_camera);
    Image<float> depth_m = measure(exact, seed + i);
    for (std::size_t k = 0; k < depth_m.size(); ++k) {
      if (depth_m[k] > 0 && exact.depth_m[k] > 0)
        frames.errors.push_back(1 / depth_m[k] - 1 / exact.depth_m[k]);
    }
    frames.depths_m.push_back(std::move(depth_m));
  }
  return frames;
}

double MeasuredSigma(const NoisyFrames& frames) {
  const auto measured = MeasureNoise(frames.depths_m, frames.camera);
  return measured ? measured->inverse_depth_sigma : 0;
}

constexpr std::uint64_t kNoisyRoom = 3;

TEST(MeasuredNoise, KinectWithin10Percent) {
  const PinholeCamera camera = SimulatedCamera();
  const NoisyFrames frames = FramesOf(kNoisyRoom, camera, [&](const Rendering& exact, int seed) {
    return KinectDepth(exact.depth_m, camera, seed);
  });
  EXPECT_NEAR(MeasuredSigma(frames), frames.Sigma(), 0.1 * frames.Sigma());
}

TEST(MeasuredNoise, CorrelatedNoiseOfStereoWithin10Percent) {
  const PinholeCamera camera = SimulatedCamera();
  const NoisyFrames frames = FramesOf(kNoisyRoom, camera, [&](const Rendering& exact, int seed) {
    return StereoDepth(exact, camera, seed).depth_m;
  });
  EXPECT_NEAR(MeasuredSigma(frames), frames.Sigma(), 0.1 * frames.Sigma());
}

// Multipath is a bias that moves with the scene.
TEST(MeasuredNoise, TimeOfFlightWithoutMultipathWithin10Percent) {
  const PinholeCamera camera = SimulatedCamera();
  TofOptions options;
  options.multipath_gain = 0;
  const NoisyFrames frames = FramesOf(kNoisyRoom, camera, [&](const Rendering& exact, int seed) {
    return TofDepth(exact, camera, seed, options).depth_m;
  });
  EXPECT_NEAR(MeasuredSigma(frames), frames.Sigma(), 0.1 * frames.Sigma());
}

// Noise of a dot is smoothed over about ten pixels. The true error includes interpolation between
// surfaces, which moves with the scene, so the estimate is 4 % to 34 % too small in three
// rooms.
// Low confidence is missing depth, and the truth has high confidence.
TEST(MeasuredNoise, SmoothedDepthOfLidarWithin40Percent) {
  const PinholeCamera camera = PhoneDepthCamera();
  std::vector<float> errors;
  NoisyFrames frames = FramesOf(kNoisyRoom, camera, [&](const Rendering& exact, int seed) {
    SensorImage image = LidarDepth(exact, camera, seed);
    for (std::size_t k = 0; k < image.depth_m.size(); ++k) {
      if (image.confidence[k] == 2) errors.push_back(1 / image.depth_m[k] - 1 / exact.depth_m[k]);
      if (image.confidence[k] == 0) image.depth_m[k] = 0;
    }
    return image.depth_m;
  });
  frames.errors = errors;
  EXPECT_NEAR(MeasuredSigma(frames), frames.Sigma(), 0.4 * frames.Sigma());
}

TEST(MeasuredNoise, ExactDepthHasTheMinimumAndKeepsTheDefault) {
  const SimulatedSequence& room = IdealRoom();
  std::vector<Image<float>> depths_m;
  for (int i = 0; i < MeasuredNoise::kFrames; ++i) depths_m.push_back(room.frames[i].depth_m);
  const auto measured = MeasureNoise(depths_m, room.camera);
  ASSERT_TRUE(measured);
  EXPECT_LT(measured->inverse_depth_sigma, 0.0005);
  EXPECT_EQ(measured->Noise().inverse_depth_sigma, MeasuredNoise::kMinSigma);
  EXPECT_FALSE(measured->Contradicts(DepthNoise()));
  EXPECT_TRUE(measured->Contradicts({5 * DepthNoise().inverse_depth_sigma}));
}

TEST(MeasuredNoise, IsUnknownWithoutMotion) {
  const Image<float> depth_m = IdealRoom().frames[0].depth_m;
  EXPECT_FALSE(
      MeasureNoise(std::vector<Image<float>>(MeasuredNoise::kFrames, depth_m), IdealRoom().camera));
  EXPECT_FALSE(MeasureNoise({}, IdealRoom().camera));
}

// Recording of a room by a Kinect.
class MeasuredNoiseRun : public ::testing::Test {
 protected:
  static constexpr int kRunFrames = 20;

  MeasuredNoiseRun() {
    const SimulatedSequence room = SimulateRoom(2, kRunFrames, Sensor::kKinect);
    WriteDepthFrames(room.frames, 5000, sequence_);
    camera_.depth = room.camera;
    options_.sequence = Options(sequence_);
    options_.sequence.format = "tum";
    options_.output = output_.path() + "/out";
    options_.pictures = false;
    SetStart(0.002);
  }

  void SetStart(double inverse_depth_sigma) {
    camera_.noise.inverse_depth_sigma = inverse_depth_sigma;
    WriteCameraYaml(camera_, sequence_ / "camera.yaml");
  }
  SlamRunSummary Run() const {
    return RunSlam(options_, false, [](const SlamRunProgress&) {});
  }
  double WrittenSigma() const {
    return ReadCameraYaml(options_.output + "/camera.yaml").noise.inverse_depth_sigma;
  }

  TempFolder sequence_, output_;
  RgbdCamera camera_;
  SlamRunOptions options_;
};

// Equal digests of a run with the option and a run with the measured noise show that all stages use
// the measured noise.
TEST_F(MeasuredNoiseRun, ReplacesAWrongNoiseInAllStages) {
  const double right = *Run().noise.measured;
  std::vector<std::string> digests;
  for (const double ratio : {0.2, 5.}) {
    SetStart(ratio * right);
    const SlamRunSummary summary = Run();
    EXPECT_TRUE(summary.noise.is_applied);
    EXPECT_EQ(summary.noise.start, ratio * right);
    EXPECT_EQ(summary.noise.measured, right);
    EXPECT_EQ(summary.noise.used, right);
    EXPECT_EQ(summary.noise.frames, MeasuredNoise::kFrames);
    EXPECT_EQ(WrittenSigma(), right);
    digests.push_back(summary.digest);
  }
  options_.sequence.inverse_depth_sigma = right;
  const SlamRunSummary fixed = Run();
  EXPECT_FALSE(fixed.noise.is_applied);
  EXPECT_THAT(digests, ::testing::Each(fixed.digest));
}

TEST_F(MeasuredNoiseRun, KeepsAPlausibleNoise) {
  const SlamRunSummary summary = Run();
  EXPECT_FALSE(summary.noise.is_applied);
  EXPECT_EQ(summary.noise.used, 0.002);
  options_.sequence.inverse_depth_sigma = 0.002;
  EXPECT_EQ(Run().digest, summary.digest);
}

TEST_F(MeasuredNoiseRun, KeepsTheOption) {
  const double wrong = 5 * *Run().noise.measured;
  options_.sequence.inverse_depth_sigma = wrong;
  const SlamRunSummary summary = Run();
  EXPECT_TRUE(summary.noise.measured);
  EXPECT_FALSE(summary.noise.is_applied);
  EXPECT_EQ(summary.noise.used, wrong);
}

// The runs of a session must have the same sensor.
TEST_F(MeasuredNoiseRun, KeepsTheNoiseOfASession) {
  SetStart(0.02);
  options_.session = output_.path() + "/session";
  const SlamRunSummary summary = Run();
  EXPECT_TRUE(summary.noise.measured);
  EXPECT_FALSE(summary.noise.is_applied);
  EXPECT_EQ(summary.noise.used, 0.02);
}

TEST_F(MeasuredNoiseRun, DoesNotDependOnThreads) {
  SetStart(0.02);
  std::vector<std::string> digests;
  for (const int threads : {1, 2}) {
    options_.threads = threads;
    const SlamRunSummary summary = Run();
    EXPECT_TRUE(summary.noise.is_applied);
    digests.push_back(summary.digest);
  }
  EXPECT_EQ(digests[0], digests[1]);
}

}  // namespace
}  // namespace surfit::testing
