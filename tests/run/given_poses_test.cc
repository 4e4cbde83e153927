#include "run/given_poses.h"

#include <gmock/gmock.h>

#include <functional>

#include "slam/simulated_sequence.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using Convention = std::function<Rigid3d(const Rigid3d&)>;

const SimulatedSequence& Room() {
  static const auto* const room = new SimulatedSequence(SimulateRoom(4, 45, Sensor::kKinect));
  return *room;
}

std::string WarningFor(const Convention& convention, int frames = 45) {
  GivenPoseCheck check(Room().camera);
  for (int i = 0; i < frames; ++i)
    check.Add(Room().frames[i], convention(Room().world_from_camera[i]));
  return check.Warning().value_or("");
}

Rigid3d OpenGl(const Rigid3d& pose) {
  return pose * Rigid3d(Eigen::Quaterniond(0, 1, 0, 0), Eigen::Vector3d::Zero());
}

TEST(GivenPoseCheck, AcceptsTruePosesAndPosesWithErrorsOfCentimetres) {
  EXPECT_EQ(WarningFor([](const Rigid3d& pose) { return pose; }), "");
  int frame = 0;
  EXPECT_EQ(WarningFor([&](Rigid3d pose) {
              pose.translation.x() += ++frame % 2 == 0 ? 0.01 : -0.01;
              return pose;
            }),
            "");
  // Poses in another world frame are the same motion.
  const Rigid3d other(Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5), {3, 4, 5});
  EXPECT_EQ(WarningFor([&](const Rigid3d& pose) { return other * pose; }), "");
}

TEST(GivenPoseCheck, NamesTheConventionThatAgrees) {
  EXPECT_THAT(WarningFor([](const Rigid3d& pose) { return pose.Inverse(); }),
              Names("contradict", "inverse"));
  EXPECT_THAT(WarningFor([](const Rigid3d& pose) {
                const Eigen::Quaterniond& q = pose.rotation;
                // The columns w, x, y, z are read as x, y, z, w.
                return Rigid3d(Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y()), pose.translation);
              }),
              AllOf(Names("contradict"), HasSubstr("w first")));
  EXPECT_THAT(WarningFor(OpenGl), Names("contradict", "OpenGL"));
  EXPECT_THAT(WarningFor([](const Rigid3d& pose) {
                return Rigid3d(pose.rotation, 1000 * pose.translation);
              }),
              Names("contradict", "mm"));
  EXPECT_THAT(WarningFor([](const Rigid3d& pose) { return OpenGl(pose.Inverse()); }),
              Names("contradict"));
}

TEST(GivenPoseCheck, NamesNoConventionForPosesOfAnotherRecording) {
  int frame = 0;
  const std::string warning = WarningFor([&](const Rigid3d&) {
    ++frame;
    return Rigid3d(QuaternionExp<double>({0.09 * frame, 0.05 * frame, 0}), {0.1 * frame, 0, 0});
  });
  EXPECT_THAT(warning, AllOf(Names("contradict"), HasSubstr("no other convention")));
}

TEST(GivenPoseCheck, IsSilentWithFewFrames) {
  EXPECT_EQ(WarningFor([](const Rigid3d& pose) { return pose.Inverse(); }, 2), "");
}

}  // namespace
}  // namespace surfit::testing
