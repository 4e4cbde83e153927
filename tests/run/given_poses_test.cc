#include "run/given_poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "surfit/core/error.h"
#include "surfit/geometry/mirror.h"
#include "testing/matchers.h"

namespace surfit {
namespace {

using testing::RigidNear;

const Rigid3d kPose(Eigen::Quaterniond(0.8, 0.6, 0, 0), {1, 2, 3});

TEST(ParsePose, ReadsTranslationAndNormalisedQuaternion) {
  EXPECT_THAT(ParsePose("x", "1,2,3,1.2,0,0,1.6"), RigidNear(kPose, 1e-15, 1e-15));
}

TEST(ParsePose, RefusesAllElseByNameAndText) {
  for (const char* text : {"", "1,2,3", "1,2,3,0,0,0,0", "1,2,3,0,0,0,1,5", "1;2;3;0;0;0;1",
                           "a,2,3,0,0,0,1", "1,2,3,0,0,0,1x"}) {
    try {
      ParsePose("initial_pose", text);
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()),
                std::string("initial_pose is '") + text + "', must be tx,ty,tz,qx,qy,qz,qw");
    }
  }
}

TEST(InitialPose, IsIdentityTruthOrNumbers) {
  SequenceInfo info;
  info.ground_truth = {{10.0, kPose}};
  EXPECT_THAT(InitialPose("identity", info, 10), RigidNear(Rigid3d(), 0, 0));
  EXPECT_THAT(InitialPose("groundtruth", info, 10.01), RigidNear(kPose, 0, 0));
  EXPECT_THROW(InitialPose("groundtruth", info, 10.1), InputError);
  EXPECT_THAT(InitialPose("1,2,3,.6,0,0,.8", info, 10), RigidNear(kPose, 1e-15, 1e-15));
}

TEST(InitialPose, TakesNumbersInTheSourcesConvention) {
  SequenceInfo info;
  info.mirrored = true;
  info.ground_truth = {{10.0, kPose}};  // our convention already
  EXPECT_THAT(InitialPose("1,2,3,.6,0,0,.8", info, 10), RigidNear(Mirrored(kPose), 1e-15, 1e-15));
  EXPECT_THAT(InitialPose("groundtruth", info, 10), RigidNear(kPose, 0, 0));
}

}  // namespace
}  // namespace surfit
