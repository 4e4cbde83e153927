// Tests the pose graph edges that Slam adds.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "loop_closure/edge_information.h"
#include "slam/simulated_sequence.h"
#include "surfit/poses/pose_store.h"
#include "surfit/slam/slam.h"
#include "testing/matchers.h"
#include "testing/random_pose.h"

namespace surfit::testing {
namespace {

void ExpectSameInformation(const Matrix6d& information, const Matrix6d& expected) {
  EXPECT_LT((information - expected).cwiseAbs().maxCoeff(), 1e-9 * expected.cwiseAbs().maxCoeff());
}

SlamOptions LoopsWithoutCalibration() {
  SlamOptions options;
  options.loops.enabled = true;
  options.calibration.enabled = false;
  return options;
}

TEST(SlamEdges, OdometryHasInformationOfAllFrames) {
  SlamOptions options = LoopsWithoutCalibration();
  options.loops.keyframes.max_distance_m = 0.05;
  const SimulatedSequence& room = IdealRoom();
  Slam slam({room.camera, {}}, options, room.world_from_camera[0]);
  std::vector<FrameReport> reports;
  for (const RgbdFrame& frame : room.frames) reports.push_back(slam.Process(frame));
  slam.Finish();
  const std::vector<KeyframeLink> keyframes = slam.backend()->poses().keyframes();
  const std::vector<PoseGraphEdge>& edges = slam.backend()->poses().edges();
  ASSERT_GE(edges.size(), 2u);
  int most_frames = 0;
  for (const PoseGraphEdge& edge : edges) {
    ASSERT_FALSE(edge.loop);
    const int frame = keyframes[edge.b].frame, frames = frame - keyframes[edge.a].frame;
    most_frames = std::max(most_frames, frames);
    ExpectSameInformation(
        edge.information,
        OdometryInformation(reports[frame].icp, frames, edge.a_from_b, options.loops.noise));
  }
  EXPECT_GE(most_frames, 3);
}

// The second frame is at a given pose in another room. The camera then returns to the place of the
// first frame, and the fourth frame confirms the pose of the third frame.
TEST(SlamEdges, RelocalisationHasInformationOfCorrelatedPointsAndLoopNoise) {
  const SlamOptions options = LoopsWithoutCalibration();
  const SimulatedSequence room = SimulateRoom(1, 4, Sensor::kIdeal);
  const SimulatedSequence other = SimulateRoom(3, 2, Sensor::kIdeal);
  Slam slam({room.camera, {}}, options, room.world_from_camera[0]);
  slam.Process(room.frames[0]);
  RgbdFrame elsewhere = other.frames[1];
  elsewhere.index = 1;
  elsewhere.stamp_s = room.frames[1].stamp_s;
  const Rigid3d beside(Eigen::Quaterniond::Identity(), {20, 0, 0});
  slam.ProcessAt(elsewhere, beside * room.world_from_camera[0]);
  const FrameReport proposed = slam.Process(room.frames[2]);
  ASSERT_EQ(proposed.state, FrameState::kLost);
  ASSERT_EQ(slam.Process(room.frames[3]).state, FrameState::kRelocalized);

  const std::vector<KeyframeLink> keyframes = slam.backend()->poses().keyframes();
  ASSERT_EQ(keyframes.back().frame, 2);
  ASSERT_EQ(keyframes.back().parent_frame, 0);
  const EdgeNoise& noise = options.loops.noise;
  const PoseGraphEdge& edge = slam.backend()->poses().edges().back();
  EXPECT_TRUE(edge.loop);
  ExpectSameInformation(edge.information,
                        RelocalizationInformation(proposed.icp, edge.a_from_b, noise));
  // Loop noise adds to the covariance in every direction.
  const Matrix6d covariance = edge.information.inverse();
  const auto least_sigma = [](const Eigen::Matrix3d& block) {
    return std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(block).eigenvalues()[0]);
  };
  EXPECT_GT(least_sigma(covariance.topLeftCorner<3, 3>()), noise.loop_rad);
  EXPECT_GT(least_sigma(covariance.bottomRightCorner<3, 3>()), noise.loop_m);
}

// An edge has an error relative to the poses of its keyframes. A new calibration moves the
// keyframes and keeps the error.
TEST(Recalibrate, KeepsErrorsOfEdges) {
  std::mt19937_64 random(1);
  const auto poses = [&] {
    return std::vector<Rigid3d>{RandomPose(1, 1, &random), RandomPose(1, 1, &random),
                                RandomPose(1, 1, &random)};
  };
  const std::vector<Rigid3d> before = poses(), after = poses(), errors = poses();
  std::vector<PoseGraphEdge> edges(3);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    edges[i].a = i;
    edges[i].b = (i + 1) % 3;
    edges[i].a_from_b = before[edges[i].a].Inverse() * before[edges[i].b] * errors[i];
  }
  Recalibrate(before, after, &edges);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    EXPECT_THAT(edges[i].a_from_b,
                RigidNear(after[edges[i].a].Inverse() * after[edges[i].b] * errors[i], 1e-9, 1e-9));
  }
}

}  // namespace
}  // namespace surfit::testing
