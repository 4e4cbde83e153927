#include "finishing/color_registration.h"

#include <gmock/gmock.h>

#include "surfit/frame/preprocess.h"
#include "surfit/mapping/fusion.h"
#include "surfit/simulation/render.h"
#include "testing/matchers.h"
#include "testing/pixels.h"

namespace surfit::testing {
namespace {

// A map of one frame of a room, and colour images from other poses.
class RegisterColorsInARoom : public ::testing::Test {
 protected:
  void SetUp() override {
    const RgbdFrame frame = RenderFrame(scene_, sensor_.camera, pose_);
    const FramePyramid pyramid = PreprocessDepth(frame.depth_m, sensor_, {});
    depth_m_ = frame.depth_m;
    Fusion(FusionOptions()).Fuse(frame, pyramid.levels.front(), pose_, &map_);
  }

  // Rendered with one pose per row.
  Image<Rgb8> ColorsAt(const PoseOfRow& pose_of_row, float gain) const {
    return ToSrgbImage(RenderLight(scene_, sensor_.camera, pose_of_row), {gain, gain, gain});
  }

  Rigid3d Registered(const Image<Rgb8>& color, const CameraMotion& motion = {}) const {
    return RegisterColors(color, DrawBlended(map_, sensor_, pose_), sensor_, motion, pose_, {pose_},
                          pose_)
        .world_from_color;
  }

  // Mean pixel distance of the points of the first frame, seen from two poses. Small rotations and
  // translations can hardly be distinguished, so poses are compared in pixels.
  double DistancePx(const Rigid3d& a, const Rigid3d& b) const {
    double sum = 0, count = 0;
    for (const auto [u, v] : PixelsOf(depth_m_)) {
      if (!(depth_m_(u, v) > 0)) continue;
      const Eigen::Vector3d point = pose_ * (depth_m_(u, v) * sensor_.camera.Ray(u, v));
      sum += (sensor_.camera.Project(a.Inverse() * point) -
              sensor_.camera.Project(b.Inverse() * point))
                 .norm();
      ++count;
    }
    return sum / count;
  }

  const Scene scene_ = MakeScene("room", 1);
  Image<float> depth_m_;
  DepthSensor sensor_ = {{320, 240, 260, 260, 159.5, 119.5, {}}, {}};
  const Rigid3d pose_ = MakePath(scene_, 1, 1).front().world_from_camera;
  SurfelMap map_;
};

// Surfels are one pixel apart. The error of thousands of points is much smaller.
TEST_F(RegisterColorsInARoom, EstimatesThePoseAtAnyExposure) {
  Rigid3d::Vector6 increment;
  increment << 0.008, -0.01, 0.006, -0.006, 0.004, 0.008;
  const Rigid3d taken = pose_ * LeftIncrement<double>(increment, Rigid3d());
  for (const float gain : {1.f, 0.7f}) {
    const Image<Rgb8> color = ColorsAt([&](int) { return taken; }, gain);
    const Rigid3d found = Registered(color);
    EXPECT_GT(DistancePx(pose_, taken), 3);
    EXPECT_LT(DistancePx(found, taken), 0.3) << gain;
  }
}

TEST_F(RegisterColorsInARoom, UsesTheTimeOfEachRow) {
  sensor_.readout_s = 1. / 30;
  const CameraMotion motion = {{0.2, 0.4, -0.3}, {0.1, -0.2, 0.1}};
  const auto pose_of_row = [&](int v) {
    return ExtrapolatePose(pose_, motion, ((v + 0.5) / 240 - 0.5) * sensor_.readout_s);
  };
  const Image<Rgb8> color = ColorsAt(pose_of_row, 1);
  EXPECT_LT(DistancePx(Registered(color, motion), pose_), 0.15);
  EXPECT_GT(DistancePx(Registered(color), pose_), 0.15);
}

TEST_F(RegisterColorsInARoom, KeepsThePoseWithoutVisiblePoints) {
  const Image<Rgb8> grey(320, 240, {90, 90, 90});
  const BlendedView nothing = DrawBlended(SurfelMap(), sensor_, pose_);
  EXPECT_THAT(RegisterColors(grey, nothing, sensor_, {}, pose_, {pose_}, pose_).world_from_color,
              RigidNear(pose_, 0, 0));
}

TEST_F(RegisterColorsInARoom, AcceptsLargerImages) {
  Rigid3d::Vector6 increment;
  increment << 0.008, -0.01, 0.006, -0.006, 0.004, 0.008;
  const Rigid3d taken = pose_ * LeftIncrement<double>(increment, Rigid3d());
  const Image<Rgb8> color = ColorsAt([&](int) { return taken; }, 1);
  DepthSensor coarse = sensor_;
  coarse.camera = sensor_.camera.Binned(2);
  ModelRenderer renderer({});
  const BlendedView drawn = DrawnDiscs(renderer.Render(map_, coarse, pose_), map_);
  EXPECT_LT(
      DistancePx(RegisterColors(color, drawn, coarse, {}, pose_, {pose_}, pose_).world_from_color,
                 taken),
      0.6);
}

TEST(ExtrapolatePose, MovesStaticPointsByTheMotion) {
  const CameraMotion motion = {{0.2, 0.4, -0.3}, {0.1, -0.2, 0.1}};
  const Eigen::Vector3d x(0.3, -0.2, 1.5);
  const double t = 1e-3;
  const Eigen::Vector3d moved = ExtrapolatePose(Rigid3d(), motion, t).Inverse() * x;
  EXPECT_THAT(moved, VectorNear(x - t * (motion.angular_velocity_rad_per_s.cross(x) +
                                         motion.velocity_m_per_s),
                                1e-6));
}

}  // namespace
}  // namespace surfit::testing
