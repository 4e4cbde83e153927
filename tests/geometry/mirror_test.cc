#include <gtest/gtest.h>

#include "surfit/geometry/sensor.h"

namespace surfit {
namespace {

const Eigen::Matrix3d kMirror = Eigen::Vector3d(1, -1, 1).asDiagonal();

Rigid3d SomePose() { return Rigid3d(QuaternionExp<double>({0.4, -0.7, 0.2}), {0.5, -1.5, 2.5}); }

TEST(Mirror, OfAPoseIsItsConjugateByS) {
  Eigen::Matrix4d s = Eigen::Matrix4d::Identity();
  s(1, 1) = -1;
  const Eigen::Matrix4d expected = s * SomePose().Matrix() * s;
  EXPECT_LT((Mirrored(SomePose()).Matrix() - expected).norm(), 1e-14);
  EXPECT_LT((Mirrored(Mirrored(SomePose())).Matrix() - SomePose().Matrix()).norm(), 1e-14);
}

TEST(Mirror, ACameraSeesTheMirroredPointAtTheSamePixel) {
  PinholeCamera camera;
  camera.fx = 481.2;
  camera.fy = -480;
  camera.cx = 319.5;
  camera.cy = 239.5;
  const Eigen::Vector3d point_in_camera(0.3, 0.4, 2);  // y up: above the optical axis
  const Eigen::Vector2d pixel = camera.Project(point_in_camera);
  EXPECT_LT(pixel.y(), camera.cy);  // and so it is in the upper half of the image
  const PinholeCamera mirrored = Mirrored(camera);
  EXPECT_EQ(mirrored.fy, 480);
  EXPECT_LT((mirrored.Project(kMirror * point_in_camera) - pixel).norm(), 1e-12);
}

TEST(Mirror, WorldPointsAreMirroredThroughPoseAndCamera) {
  const Eigen::Vector3d point_in_camera(0.3, 0.4, 2);
  const Eigen::Vector3d expected = kMirror * (SomePose() * point_in_camera);
  EXPECT_LT((Mirrored(SomePose()) * (kMirror * point_in_camera) - expected).norm(), 1e-14);
}

}  // namespace
}  // namespace surfit
