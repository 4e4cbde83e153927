#include "tracking/frame_registration.h"

#include <gmock/gmock.h>

#include "surfit/frame/preprocess.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"

namespace surfit::testing {
namespace {

using ::testing::IsEmpty;
using ::testing::Not;

constexpr double kSensorNoise = 1e-3;  // rad and m

// Depth of a static room from a camera pose.
RgbdFrame StaticFrame(const Scene& scene, const PinholeCamera& camera,
                      const Rigid3d& world_from_camera, double stamp_s) {
  RgbdFrame frame;
  frame.stamp_s = stamp_s;
  frame.depth_m = Render(scene, camera, world_from_camera).depth_m;
  return frame;
}

// A prediction 0.3 m behind the true pose moves all surfaces towards the camera, into free space.
TEST(FrameRegistration, WrongInertialPriorDoesNotMakeStaticSurfacesMove) {
  const PinholeCamera camera = {160, 120, 131, 131, 79.5, 59.5, {}};
  const DepthSensor sensor = {camera, {}};
  const Scene scene = MakeScene("room", 1);
  const Rigid3d pose = MakePath(scene, 100, 1)[0].world_from_camera;
  const RgbdFrame first = StaticFrame(scene, camera, pose, 0);
  MovingRegions regions;
  ReferenceView reference;
  reference.view.pyramid = PreprocessDepth(first.depth_m, sensor, {});
  reference.world_from_view = pose;
  regions.Remember(reference.view.pyramid.levels.front(), {}, pose, 0);

  const RgbdFrame second = StaticFrame(scene, camera, pose, 1);
  const PreprocessedFrame frame = {
      second, second, {PreprocessDepth(second.depth_m, sensor, {}), {}}, {}};
  const TrackingOptions options;
  const FrameRegistration registration(options, regions);
  MotionUncertainty motion;
  motion.covariance = 1e-12 * Matrix6d::Identity();
  const Rigid3d behind = pose * Rigid3d(Eigen::Quaterniond::Identity(), {0, 0, -0.3});
  const Tracked held = registration.Register(frame, reference, behind, options.icp, motion);
  EXPECT_THAT(held.moving, Not(IsEmpty()));
  motion.registration_noise = kSensorNoise * kSensorNoise * Matrix6d::Identity();
  const Tracked tracked = registration.Register(frame, reference, behind, options.icp, motion);
  EXPECT_THAT(tracked.moving, IsEmpty());
}

}  // namespace
}  // namespace surfit::testing
