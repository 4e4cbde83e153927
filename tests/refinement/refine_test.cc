// Refinement of simulated keyframes, whose poses and calibration are known.
#include "surfit/refinement/refine.h"

#include <gtest/gtest.h>

#include <cmath>

#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/frame/correct_depth.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"
#include "testing/expect_input_error.h"
#include "testing/random_pose.h"

namespace surfit {
namespace {

using testing::ExpectInputError;
using ::testing::HasSubstr;
using testing::RandomPose;

constexpr double kOffset = 0.02 / 3;  // 1/m: 2 % at 3 m

PinholeCamera TrueCamera() { return {160, 120, 131.25, 131.25, 79.75, 59.75, {}}; }

// Every eighth frame of a path through a room, seen by a Kinect whose inverse depth is off.
struct Recording {
  std::vector<Rigid3d> truth;
  std::vector<RefinementKeyframe> keyframes;
};

Recording Record(int count, double offset_per_m, double pose_error_m, double pose_error_rad) {
  constexpr int kStride = 8;
  constexpr std::uint64_t kSeed = 7;
  const Scene scene = MakeScene("room", kSeed);
  const Trajectory path = MakePath(scene, kStride * count, kSeed);
  std::mt19937_64 random(kSeed);
  Recording recording;
  for (int k = 0; k < count; ++k) {
    const Rigid3d& pose = path[kStride * k].world_from_camera;
    RgbdFrame frame;
    frame.depth_m = KinectDepth(RenderGeometry(scene, TrueCamera(), pose).depth_m, TrueCamera(), k);
    CorrectDepth(TrueCamera(), {{offset_per_m}}, &frame.depth_m);
    const Rigid3d error = k == 0 ? Rigid3d() : RandomPose(pose_error_rad, pose_error_m, &random);
    recording.truth.push_back(pose);
    recording.keyframes.push_back(
        {pose * error, MakeKeyframeImages(frame, TrueCamera(), PreprocessOptions())});
  }
  return recording;
}

double AteOf(const Recording& recording) {
  std::vector<MatchedPose> poses;
  for (std::size_t k = 0; k < recording.truth.size(); ++k) {
    poses.push_back(
        {static_cast<double>(k), recording.truth[k], recording.keyframes[k].world_from_camera});
  }
  return ComputeAbsoluteTrajectoryError(poses)->translation_m.rmse;
}

RefinementSummary RefineAll(const RefinementOptions& options, const PinholeCamera& camera,
                            Recording* recording) {
  return Refine(options, {camera, {}}, &recording->keyframes, [](const RefinementRound&) {});
}

TEST(Refine, FindsFocalLengthAndDepthOffsetAndTheTruePoses) {
  Recording recording = Record(40, kOffset, 0.01, 0.005);
  PinholeCamera camera = TrueCamera();
  camera.fx *= 1.01;
  camera.fy *= 1.01;
  const double ate_before = AteOf(recording);
  const RefinementSummary summary = RefineAll({}, camera, &recording);
  ASSERT_TRUE(summary.Succeeded()) << ToString(summary.termination);
  const DepthCalibration& found = summary.calibration;
  const Eigen::VectorXd sigma = summary.calibration_covariance.diagonal().cwiseSqrt();
  std::printf("fx %.3f +- %.3f fy %.3f +- %.3f c0 %.6f +- %.6f, ATE %.2f -> %.2f mm\n",
              found.camera.fx, sigma[0], found.camera.fy, sigma[1], found.field.coefficients[0],
              sigma[4], 1e3 * ate_before, 1e3 * AteOf(recording));
  EXPECT_NEAR(found.camera.fx, TrueCamera().fx, 2 * sigma[0]);
  EXPECT_NEAR(found.camera.fy, TrueCamera().fy, 2 * sigma[1]);
  EXPECT_NEAR(found.field.coefficients[0], -kOffset, 2 * sigma[4]);
  // Far from where it began.
  EXPECT_LT(sigma[0], 0.003 * TrueCamera().fx);
  EXPECT_LT(sigma[1], 0.003 * TrueCamera().fy);
  EXPECT_LT(sigma[4], kOffset / 8);
  EXPECT_LT(AteOf(recording), ate_before / 3);
}

TEST(Refine, KeepsARightCalibrationAndPosesWithinTheirStandardDeviations) {
  Recording recording = Record(30, 0, 0, 0);
  const RefinementSummary summary = RefineAll({}, TrueCamera(), &recording);
  ASSERT_TRUE(summary.Succeeded()) << ToString(summary.termination);
  EXPECT_LE(summary.calibration_distance, summary.calibration_limit);
  EXPECT_TRUE(summary.calibration_kept);
  EXPECT_EQ(summary.calibration.camera.fx, TrueCamera().fx);
  EXPECT_TRUE(summary.calibration.field.IsZero());
  // Large deviations would be true of anything.
  const double most[] = {0.005 * TrueCamera().fx, 0.005 * TrueCamera().fy, 0.005 * TrueCamera().fx,
                         0.005 * TrueCamera().fy, 0.001};
  for (int i = 0; i < 5; ++i) {
    EXPECT_GT(summary.calibration_covariance(i, i), 0) << i;
    EXPECT_LT(std::sqrt(summary.calibration_covariance(i, i)), most[i]) << i;
  }
  ASSERT_EQ(summary.pose_covariances.size(), recording.keyframes.size());
  EXPECT_EQ(summary.pose_covariances[0], Eigen::MatrixXd::Zero(6, 6));
  for (std::size_t k = 1; k < recording.keyframes.size(); ++k) {
    const Rigid3d &found = recording.keyframes[k].world_from_camera, &truth = recording.truth[k];
    Eigen::Matrix<double, 6, 1> change;
    change << QuaternionLog<double>(found.rotation * truth.rotation.conjugate()),
        found.translation - truth.translation;
    const Eigen::VectorXd sigma = summary.pose_covariances[k].diagonal().cwiseSqrt();
    EXPECT_LT(change.cwiseAbs().cwiseQuotient(sigma).maxCoeff(), 3) << "keyframe " << k;
    EXPECT_LT(sigma.maxCoeff(), 0.01) << "keyframe " << k;
  }
}

TEST(Refine, HoldsWhatIsNotFree) {
  Recording recording = Record(12, kOffset, 0.005, 0.002);
  const Rigid3d first = recording.keyframes[0].world_from_camera;
  RefinementOptions options;
  options.free_intrinsics = options.free_depth_offset = false;
  options.max_rounds = 2;
  const RefinementSummary summary = RefineAll(options, TrueCamera(), &recording);
  ASSERT_TRUE(summary.Succeeded()) << ToString(summary.termination);
  EXPECT_EQ(summary.calibration.camera.fx, TrueCamera().fx);
  EXPECT_TRUE(summary.calibration.field.IsZero());
  EXPECT_EQ(summary.calibration_covariance, Eigen::MatrixXd::Zero(10, 10));
  EXPECT_EQ(recording.keyframes[0].world_from_camera.Matrix(), first.Matrix());
  EXPECT_NE(recording.keyframes[1].world_from_camera.Matrix(), recording.truth[1].Matrix());
}

TEST(Refine, KeepsACalibrationThatIsWrongByNoMoreThanTheModel) {
  const Recording given = Record(12, kOffset, 0, 0);
  RefinementOptions options;
  options.free_intrinsics = false;
  options.max_rounds = 2;
  const auto keeps = [&](double model_error_share) {
    options.model_error_share = model_error_share;
    Recording recording = given;
    const RefinementSummary summary = RefineAll(options, TrueCamera(), &recording);
    EXPECT_TRUE(summary.Succeeded()) << ToString(summary.termination);
    EXPECT_GE(summary.calibration_covariance(4, 4), std::pow(model_error_share / 3, 2));
    EXPECT_EQ(summary.calibration_covariance(0, 0), 0);
    return summary.calibration_kept;
  };
  EXPECT_FALSE(keeps(0.0005));
  EXPECT_TRUE(keeps(0.02));  // as much as the offset is worth at 3 m
}

TEST(Refine, MovesNothingWhereKeyframesShareTooLittle) {
  Recording recording = Record(2, 0, 0.01, 0.005);  // three must see a surfel
  const Rigid3d second = recording.keyframes[1].world_from_camera;
  const RefinementSummary summary = RefineAll({}, TrueCamera(), &recording);
  EXPECT_EQ(summary.termination, RefinementTermination::kTooFewSurfels);
  EXPECT_FALSE(summary.Succeeded());
  EXPECT_EQ(recording.keyframes[1].world_from_camera.Matrix(), second.Matrix());
}

TEST(RefineThreads, GivesTheSameBitForBit) {
  const auto refine = [](int threads) {
    const ThreadLimit limit(threads);
    Recording recording = Record(8, kOffset, 0.005, 0.002);
    RefinementOptions options;
    options.max_rounds = 2;
    const RefinementSummary summary = RefineAll(options, TrueCamera(), &recording);
    EXPECT_TRUE(summary.Succeeded());
    std::vector<double> numbers = {summary.calibration.camera.fx, summary.calibration.camera.cy,
                                   summary.calibration_covariance(0, 0)};
    const Eigen::Matrix4d last = recording.keyframes.back().world_from_camera.Matrix();
    numbers.insert(numbers.end(), last.data(), last.data() + last.size());
    return numbers;
  };
  EXPECT_EQ(refine(1), refine(3));
}

TEST(Refine, RefusesImpossibleOptions) {
  RefinementOptions options;
  options.min_observations = 1;
  ExpectInputError([&] { Validate(options); },
                   HasSubstr("min_observations is 1, must be at least 2"));
}

}  // namespace
}  // namespace surfit
