#include <gtest/gtest.h>

#include "slam/simulated_sequence.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

// Adds a vertical board with blocks, 0.55 m in front of the camera. The board begins at this
// distance to the right.
void AddBoard(const Rigid3d& world_from_camera, double from_right_m, Scene* scene) {
  const auto add = [&](const Eigen::Vector3d& size, const Eigen::Vector3d& center) {
    const Texture texture = [](const Eigen::Vector3d& p) -> Eigen::Vector3f {
      const double wave = std::sin(40 * p.x()) * std::sin(33 * p.y() + 7 * p.x());
      return Eigen::Vector3f::Constant(static_cast<float>(0.5 + 0.3 * wave));
    };
    scene->Add(MakeBox(size), world_from_camera * Rigid3d(Eigen::Quaterniond::Identity(), center),
               texture);
  };
  constexpr double kWidth_m = 1.2, kDepth_m = 0.55;
  add({kWidth_m, 2, 0.1}, {from_right_m + kWidth_m / 2, 0, kDepth_m + 0.05});
  for (int i = 0; i < 24; ++i) {
    const double x = from_right_m + 0.04 + 0.05 * i, y = 0.11 * (i * 5 % 7 - 3);
    add({0.04, 0.05 + 0.01 * (i % 3), 0.06}, {x, y, kDepth_m - 0.02});
  }
}

// A camera passes the side of a doorway: within 20 frames it occludes most of a well mapped room.
// It is not a moving object and does not contradict the pose.
TEST(Slam, TracksPastSideOfDoorway) {
  Scene scene = MakeScene("room", 1);
  const Rigid3d first = MakePath(scene, 2, 1)[0].world_from_camera;
  AddBoard(first, 0.5, &scene);
  Slam slam({SimulatedCamera(), {}}, SlamOptions(), first);
  const auto process = [&](int index, double to_right_m) {
    const Rigid3d truth =
        first * Rigid3d(Eigen::Quaterniond::Identity(), Eigen::Vector3d(to_right_m, 0, 0));
    const FrameReport report =
        slam.Process(RenderFrame(scene, SimulatedCamera(), truth, index, index / 30.));
    EXPECT_NE(report.state, FrameState::kLost) << index;
    EXPECT_THAT(report.world_from_camera, RigidNear(truth, kPixelAt2m, kPixelRad)) << index;
  };
  constexpr int kBefore = 30, kPassing = 19;
  for (int i = 0; i < kBefore; ++i) process(i, 0.002 * (i % 2));
  for (int i = 0; i < kPassing; ++i) process(kBefore + i, 0.045 * i);
}

}  // namespace
}  // namespace surfit::testing
