// Compares the stated covariance of frames with the errors of simulated runs.
#include <gmock/gmock.h>

#include <cstdio>
#include <string>
#include <vector>

#include "registration/solvers/decompositions.h"
#include "surfit/core/parallel.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"
#include "surfit/slam/slam.h"

namespace surfit::testing {
namespace {

constexpr int kFrameRateOfPath = 30;

Image<float> MeasuredDepth(const std::string& sensor, const Rendering& exact,
                           const PinholeCamera& camera, std::uint64_t seed) {
  if (sensor == "kinect") return KinectDepth(exact.depth_m, camera, seed);
  return TofDepth(exact, camera, seed).depth_m;
}

struct FrameErrors {
  double nees_sum = 0;
  int stated = 0, frames = 0;

  double MeanNees() const { return nees_sum / stated; }
};

// Tracks a path through the room of a seed. The errors are those of poses relative to the last
// keyframe.
void AddRun(const std::string& sensor, int frames, std::uint64_t seed, FrameErrors* errors) {
  const PinholeCamera camera = {160, 120, 131, 131, 79.5, 59.5, {}};
  const Scene scene = MakeScene("room", seed);
  const Trajectory path = MakePath(scene, frames, seed);
  Slam slam({camera, {}}, SlamOptions(), path[0].world_from_camera);
  for (int i = 0; i < frames; ++i) {
    const Rendering exact = Render(scene, camera, path[i].world_from_camera);
    RgbdFrame frame;
    frame.index = i;
    frame.stamp_s = static_cast<double>(i) / kFrameRateOfPath;
    frame.depth_m = MeasuredDepth(sensor, exact, camera, 1000 * seed + i);
    frame.color = exact.color;
    const FrameReport report = slam.Process(frame);
    if (report.keyframe < 0) continue;
    ++errors->frames;
    if (!report.covariance) continue;
    const Rigid3d truth =
        path[report.keyframe].world_from_camera.Inverse() * path[i].world_from_camera;
    const Rigid3d error = report.keyframe_from_camera * truth.Inverse();
    Vector6d increment;
    increment << QuaternionLog<double>(error.rotation), error.translation;
    errors->nees_sum += increment.dot(SymmetricInverse(*report.covariance) * increment);
    ++errors->stated;
  }
}

// The expectation is 6. Errors of frames with one keyframe are correlated, so the mean of a run
// deviates by about 2.
TEST(FrameCovariance, AgreesWithErrorsOfKinect) {
  FrameErrors errors;
  AddRun("kinect", 60, 4, &errors);
  std::printf("NEES %.2f of %d of %d frames\n", errors.MeanNees(), errors.stated, errors.frames);
  EXPECT_GT(errors.stated, 0.8 * errors.frames);
  EXPECT_GT(errors.MeanNees(), 4);
  EXPECT_LT(errors.MeanNees(), 9);
}

class FrameCovarianceSweep : public ::testing::TestWithParam<const char*> {};

TEST_P(FrameCovarianceSweep, AgreesWithErrors) {
  FrameErrors errors;
  for (const std::uint64_t seed : {4, 5, 6, 7}) AddRun(GetParam(), 150, seed, &errors);
  std::printf("%s: NEES %.2f of %d of %d frames\n", GetParam(), errors.MeanNees(), errors.stated,
              errors.frames);
  EXPECT_GT(errors.stated, 0.8 * errors.frames);
  EXPECT_GT(errors.MeanNees(), 4);
  EXPECT_LT(errors.MeanNees(), 9);
}

// The stated covariance of lidar and stereo is too small: their NEES is 19 to 20. Their noise is
// correlated over many pixels.
INSTANTIATE_TEST_SUITE_P(Sensors, FrameCovarianceSweep, ::testing::Values("kinect", "tof"));

TEST(FrameCovariance, DoesNotDependOnNumberOfThreads) {
  const PinholeCamera camera = {160, 120, 131, 131, 79.5, 59.5, {}};
  const Scene scene = MakeScene("room", 3);
  const Trajectory path = MakePath(scene, 4, 3);
  std::vector<Matrix6d> covariances;
  for (const int threads : {1, 3}) {
    const ThreadLimit limit(threads);
    Slam slam({camera, {}}, SlamOptions(), path[0].world_from_camera);
    FrameReport report;
    for (int i = 0; i < 4; ++i) {
      report = slam.Process(RenderFrame(scene, camera, path[i].world_from_camera, i, 0.03 * i));
    }
    ASSERT_TRUE(report.covariance);
    covariances.push_back(*report.covariance);
  }
  EXPECT_EQ(covariances[0], covariances[1]);
}

// The first frame of a map has no keyframe before it.
TEST(FrameCovariance, IsEmptyWithoutKeyframes) {
  const PinholeCamera camera = {160, 120, 131, 131, 79.5, 59.5, {}};
  const Scene scene = MakeScene("room", 1);
  const Trajectory path = MakePath(scene, 2, 1);
  for (const bool has_keyframes : {true, false}) {
    SlamOptions options;
    options.loops.enabled = options.loops.relocalization = has_keyframes;
    options.calibration.enabled = false;
    Slam slam({camera, {}}, options, {});
    const FrameReport first =
        slam.Process(RenderFrame(scene, camera, path[0].world_from_camera, 0, 0));
    EXPECT_EQ(first.keyframe, -1);
    EXPECT_FALSE(first.covariance);
    const FrameReport second =
        slam.Process(RenderFrame(scene, camera, path[1].world_from_camera, 1, 0.03));
    ASSERT_TRUE(second.HasPose());
    EXPECT_EQ(second.keyframe, has_keyframes ? 0 : -1);
    EXPECT_EQ(second.covariance.has_value(), has_keyframes);
  }
}

}  // namespace
}  // namespace surfit::testing
