// Tests the refinement of keyframes of one textured wall, whose geometry does not constrain motion
// along it. Tests the refinement of simulated keyframes with known poses and calibration.
#include "surfit/optimization/refine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/frame/rectify_frame.h"
#include "surfit/optimization/keyframes.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"
#include "testing/matchers.h"
#include "testing/random_pose.h"

namespace surfit::testing {
namespace {

// Camera that moves by 1 cm per frame along x, at 30 Hz.
Trajectory Straight(int count) {
  Trajectory trajectory;
  for (int i = 0; i < count; ++i) {
    trajectory.push_back({i / 30., Rigid3d(Eigen::Quaterniond::Identity(), {0.01 * i, 0, 0})});
  }
  return trajectory;
}

TEST(ChooseKeyframes, SelectsFirstFrameAndFramesAfterTranslation) {
  EXPECT_EQ(ChooseKeyframes(Straight(10), 0.035, 1, 0), (std::vector<std::size_t>{0, 4, 8}));
  EXPECT_TRUE(ChooseKeyframes({}, 0.1, 1, 0).empty());
}

TEST(ChooseKeyframes, EndsWithThresholdsOfZero) {
  for (const double rotation_rad : {0., 1.}) {
    const std::vector<std::size_t> chosen = ChooseKeyframes(Straight(100), 0, rotation_rad, 10);
    EXPECT_LE(chosen.size(), 10u);
    EXPECT_GE(chosen.size(), 7u);
  }
  EXPECT_EQ(ChooseKeyframes(Straight(20), 0, 0, 0).size(), 20u);
}

TEST(ChooseKeyframes, SelectsFramesAfterRotation) {
  Trajectory turning = Straight(3);
  turning[2].world_from_camera.rotation = QuaternionExp<double>({0, 0.2, 0});
  EXPECT_EQ(ChooseKeyframes(turning, 1, 0.15, 0), (std::vector<std::size_t>{0, 2}));
}

TEST(ChooseKeyframes, LimitsNumberOfKeyframes) {
  const std::vector<std::size_t> chosen = ChooseKeyframes(Straight(1000), 0.015, 1, 20);
  EXPECT_LE(chosen.size(), 20u);
  EXPECT_GT(chosen.size(), 10u);
}

TEST(CorrectTrajectory, KeepsPosesOfUnchangedKeyframes) {
  const Trajectory given = Straight(7);
  const Trajectory same = CorrectTrajectory(
      given, {0, 3, 5},
      {given[0].world_from_camera, given[3].world_from_camera, given[5].world_from_camera});
  for (std::size_t i = 0; i < given.size(); ++i) {
    EXPECT_THAT(same[i].world_from_camera, RigidNear(given[i].world_from_camera, 1e-12, 1e-12));
  }
}

TEST(CorrectTrajectory, InterpolatesCorrectionsOfKeyframes) {
  const Trajectory given = Straight(7);
  const Rigid3d up(Eigen::Quaterniond::Identity(), {0, 0, 0.04});
  const Trajectory moved = CorrectTrajectory(
      given, {0, 4}, {given[0].world_from_camera, up * given[4].world_from_camera});
  EXPECT_THAT(moved[1].world_from_camera,
              RigidNear(Rigid3d(Eigen::Quaterniond::Identity(), {0.01, 0, 0.01}), 1e-12, 1e-12));
  EXPECT_THAT(moved[4].world_from_camera, RigidNear(up * given[4].world_from_camera, 1e-12, 1e-12));
  // Frames after the last keyframe get its correction.
  EXPECT_THAT(moved[6].world_from_camera, RigidNear(up * given[6].world_from_camera, 1e-12, 1e-12));
  EXPECT_EQ(moved[6].stamp_s, given[6].stamp_s);
}

constexpr double kDepth = 2;  // m, depth of a wall that all keyframes face

PinholeCamera Camera() { return {160, 120, 131.25, 131.25, 79.75, 59.75, {}}; }

// Waves with a length of a few dozen pixels.
float TextureAt(double x, double y) {
  return static_cast<float>(0.5 + 0.2 * std::sin(20 * x + 5 * y) + 0.2 * std::cos(18 * y - 7 * x));
}

// Images of a camera with this translation along the wall.
KeyframeImages ImagesAt(const Eigen::Vector2d& shift, float brighter) {
  const PinholeCamera camera = Camera();
  KeyframeImages images;
  images.inverse_depth = Image<float>(camera.width, camera.height, 1 / kDepth);
  images.slope_u = images.slope_v = Image<float>(camera.width, camera.height, 0.f);
  images.intensity = Image<float>(camera.width, camera.height);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector2d at = kDepth * camera.Ray(u, v).head<2>() + shift;
      images.intensity(u, v) = TextureAt(at.x(), at.y()) + brighter;
    }
  }
  return images;
}

struct Wall {
  std::vector<Eigen::Vector2d> truth;
  std::vector<RefinementKeyframe> keyframes;

  // Largest position error along the wall, m.
  double Error() const {
    double error = 0;
    for (std::size_t k = 0; k < truth.size(); ++k) {
      const Eigen::Vector2d found = keyframes[k].world_from_camera.translation.head<2>();
      error = std::max(error, (found - truth[k]).norm());
    }
    return error;
  }
};

// All keyframes except the first keyframe have an initial error of 12 mm (0.8 px). The exposure
// increases from keyframe to keyframe.
Wall MakeWall() {
  Wall wall;
  for (int k = 0; k < 5; ++k) {
    const Eigen::Vector2d shift(0.06 * k, 0.03 * (k % 3));
    const Eigen::Vector2d error = k == 0 ? Eigen::Vector2d(0, 0) : Eigen::Vector2d(0.0096, -0.0072);
    Rigid3d pose;
    pose.translation.head<2>() = shift + (k % 2 == 0 ? error : -error);
    wall.truth.push_back(shift);
    wall.keyframes.push_back({pose, ImagesAt(shift, 0.02f * static_cast<float>(k))});
  }
  return wall;
}

RefinementSummary RefineWall(double photometric_weight, Wall* wall) {
  RefinementOptions options;
  options.estimate_intrinsics = options.estimate_depth_offset = false;
  options.motion_sigma_m = 0;
  options.error_model.photometric_weight = photometric_weight;
  return Refine(options, {Camera(), {}}, &wall->keyframes, [](const RefinementRound&) {});
}

TEST(RefineTexture, ConstrainsMotionAlongWall) {
  Wall wall = MakeWall(), shape_only = MakeWall();
  const double before = wall.Error();
  const RefinementSummary summary = RefineWall(1, &wall);
  ASSERT_TRUE(summary.Succeeded()) << ToString(summary.termination);
  EXPECT_GT(summary.rounds.back().texture_observations, 0u);
  EXPECT_LT(summary.after.rms_intensity, summary.before.rms_intensity / 5);
  EXPECT_LT(wall.Error(), before / 10);

  const RefinementSummary without = RefineWall(0, &shape_only);
  EXPECT_EQ(without.rounds.back().texture_observations, 0u);
  EXPECT_EQ(without.after.rms_intensity, 0);
  EXPECT_GT(shape_only.Error(), before / 2);
}

TEST(RefineTexture, HasNoTextureWithoutIntensities) {
  Wall wall = MakeWall();
  for (RefinementKeyframe& keyframe : wall.keyframes) {
    keyframe.images.intensity =
        Image<float>(Camera().width, Camera().height, std::numeric_limits<float>::quiet_NaN());
  }
  const RefinementSummary summary = RefineWall(1, &wall);
  ASSERT_TRUE(summary.Succeeded()) << ToString(summary.termination);
  EXPECT_EQ(summary.rounds.back().texture_observations, 0u);
}

constexpr double kOffset = 0.02 / 3;  // 1/m: 2 % at 3 m

PinholeCamera TrueCamera() { return {160, 120, 131.25, 131.25, 79.75, 59.75, {}}; }

// Every eighth frame of a path through a room, with Kinect noise and an error of inverse depth.
struct Recording {
  std::vector<Rigid3d> truth;
  std::vector<RefinementKeyframe> keyframes;
};

Recording Record(int count, const InverseDepthField& first_half, const InverseDepthField& last_half,
                 double pose_error_m, double pose_error_rad) {
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
    CorrectDepth(TrueCamera(), k < count / 2 ? first_half : last_half, &frame.depth_m);
    const Rigid3d error = k == 0 ? Rigid3d() : RandomPose(pose_error_rad, pose_error_m, &random);
    recording.truth.push_back(pose);
    recording.keyframes.push_back(
        {pose * error, MakeKeyframeImages(frame, {TrueCamera(), {}}, {}, PreprocessOptions())});
  }
  return recording;
}

Recording Record(int count, double offset_per_m, double pose_error_m, double pose_error_rad) {
  const InverseDepthField offset = {{offset_per_m}};
  return Record(count, offset, offset, pose_error_m, pose_error_rad);
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

TEST(Refine, FindsFocalLengthDepthOffsetAndPoses) {
  Recording recording = Record(40, kOffset, 0.01, 0.005);
  PinholeCamera camera = TrueCamera();
  camera.fx *= 1.01;
  camera.fy *= 1.01;
  const double ate_before = AteOf(recording);
  RefinementOptions options;
  options.estimate_depth_field = false;
  const RefinementSummary summary = RefineAll(options, camera, &recording);
  ASSERT_TRUE(summary.Succeeded()) << ToString(summary.termination);
  const DepthCalibration& found = summary.calibration;
  const Eigen::VectorXd sigma = summary.calibration_covariance.diagonal().cwiseSqrt();
  std::printf("fx %.3f +- %.3f fy %.3f +- %.3f c0 %.6f +- %.6f, ATE %.2f -> %.2f mm\n",
              found.camera.fx, sigma[0], found.camera.fy, sigma[1], found.field.coefficients[0],
              sigma[4], 1e3 * ate_before, 1e3 * AteOf(recording));
  EXPECT_NEAR(found.camera.fx, TrueCamera().fx, 2 * sigma[0]);
  EXPECT_NEAR(found.camera.fy, TrueCamera().fy, 2 * sigma[1]);
  EXPECT_NEAR(found.field.coefficients[0], -kOffset, 2 * sigma[4]);
  // The standard deviations are smaller than the initial errors.
  EXPECT_LT(sigma[0], 0.003 * TrueCamera().fx);
  EXPECT_LT(sigma[1], 0.003 * TrueCamera().fy);
  EXPECT_LT(sigma[4], kOffset / 8);
  EXPECT_LT(AteOf(recording), ate_before / 3);
}

TEST(Refine, KeepsCorrectCalibrationAndPosesWithinStandardDeviations) {
  Recording recording = Record(30, 0, 0, 0);
  const RefinementSummary summary = RefineAll({}, TrueCamera(), &recording);
  ASSERT_TRUE(summary.Succeeded()) << ToString(summary.termination);
  EXPECT_LE(summary.calibration_distance, summary.calibration_limit);
  EXPECT_TRUE(summary.calibration_kept);
  EXPECT_EQ(summary.calibration.camera.fx, TrueCamera().fx);
  EXPECT_TRUE(summary.calibration.field.IsZero());
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

TEST(Refine, KeepsFixedParameters) {
  Recording recording = Record(12, kOffset, 0.005, 0.002);
  const Rigid3d first = recording.keyframes[0].world_from_camera;
  RefinementOptions options;
  options.estimate_intrinsics = options.estimate_depth_offset = options.estimate_depth_field =
      false;
  options.max_rounds = 2;
  const RefinementSummary summary = RefineAll(options, TrueCamera(), &recording);
  ASSERT_TRUE(summary.Succeeded()) << ToString(summary.termination);
  EXPECT_EQ(summary.calibration.camera.fx, TrueCamera().fx);
  EXPECT_TRUE(summary.calibration.field.IsZero());
  EXPECT_EQ(summary.calibration_covariance, Eigen::MatrixXd::Zero(11, 11));
  EXPECT_EQ(recording.keyframes[0].world_from_camera.Matrix(), first.Matrix());
  EXPECT_NE(recording.keyframes[1].world_from_camera.Matrix(), recording.truth[1].Matrix());
}

// Depth is tilted. In the second recording, the tilt has another direction in each half.
TEST(Refine, KeepsCalibrationUnlessHalvesConfirmIt) {
  const InverseDepthField along_x = {{0, 0.01}}, along_y = {{0, 0, 0.01}};
  const auto refine = [](const InverseDepthField& first_half, const InverseDepthField& last_half) {
    Recording recording = Record(16, first_half, last_half, 0, 0);
    RefinementOptions options;
    options.max_rounds = 6;
    RefinementSummary summary = RefineAll(options, TrueCamera(), &recording);
    EXPECT_TRUE(summary.Succeeded()) << ToString(summary.termination);
    EXPECT_GT(summary.calibration_distance, summary.calibration_limit);
    return summary;
  };
  const RefinementSummary confirmed = refine(along_x, along_x);
  EXPECT_TRUE(confirmed.AreGainsAboveLimit());
  EXPECT_FALSE(confirmed.calibration_kept);
  for (const double gain : confirmed.half_gains) EXPECT_GT(gain, confirmed.gain_limit);
  EXPECT_NEAR(confirmed.calibration.field.coefficients[1], -0.01, 0.005);

  const RefinementSummary refuted = refine(along_x, along_y);
  EXPECT_FALSE(refuted.AreGainsAboveLimit());
  EXPECT_LT(refuted.held_out_gains[0] + refuted.held_out_gains[1], 0);
  EXPECT_TRUE(refuted.calibration_kept);
  EXPECT_TRUE(refuted.calibration.field.IsZero());
  EXPECT_EQ(refuted.calibration.camera.cy, TrueCamera().cy);
}

// The calibration of four fifths is less accurate than the true calibration, and more accurate than
// a wrong one. Limit: three standard deviations of a squared Mahalanobis distance.
TEST(Refine, GainsNothingInHeldOutKeyframesOverTheTrueCalibration) {
  const InverseDepthField tilt = {{0, 0.01}};
  Recording recording = Record(16, tilt, tilt, 0, 0);
  const DepthCalibration given = {TrueCamera(), {}}, truth = {TrueCamera(), {{0, -0.01}}};
  const DepthCalibration wrong = {TrueCamera(), {{0, 0.01}}};
  RefinementOptions options;
  options.max_rounds = 6;
  const RefinementSummary summary =
      Refine(options, given, truth, &recording.keyframes, [](const RefinementRound&) {});
  ASSERT_TRUE(summary.Succeeded()) << ToString(summary.termination);
  EXPECT_FALSE(summary.calibration_kept);
  EXPECT_EQ(summary.gain_limit, 0);
  EXPECT_GT(summary.held_out_gains[0] + summary.held_out_gains[1], 0);
  const auto gain_over = [&](const DepthCalibration& start) {
    return HeldOutGain(options, given, start, summary.calibration, recording.keyframes);
  };
  EXPECT_LT(gain_over(truth), summary.calibration_limit);
  EXPECT_GT(gain_over(wrong), summary.calibration_limit);
}

TEST(Refine, KeepsCalibrationWithinModelError) {
  const Recording given = Record(12, 2 * kOffset, 0, 0);
  RefinementOptions options;
  options.estimate_intrinsics = options.estimate_depth_field = false;
  options.max_rounds = 2;
  const auto keeps = [&](double model_error_ratio) {
    options.model_error_ratio = model_error_ratio;
    Recording recording = given;
    const RefinementSummary summary = RefineAll(options, TrueCamera(), &recording);
    EXPECT_TRUE(summary.Succeeded()) << ToString(summary.termination);
    EXPECT_GE(summary.calibration_covariance(4, 4), std::pow(model_error_ratio / 3, 2));
    EXPECT_EQ(summary.calibration_covariance(0, 0), 0);
    return summary.calibration_kept;
  };
  EXPECT_FALSE(keeps(0.0005));
  EXPECT_TRUE(keeps(0.04));  // the effect of the offset at 3 m
}

// The calibration is kept, but the gates of the pose refinement accept no surfel.
TEST(Refine, HasNoCovarianceAfterFailedPoseRefinement) {
  const Recording given = Record(12, 0, 0, 0);
  RefinementOptions options;
  options.estimate_intrinsics = options.estimate_depth_field = false;
  options.model_error_ratio = 0.02;
  options.max_rounds = 2;
  options.kept_angle_ratio = 1e-6;
  Recording recording = given;
  const RefinementSummary summary = RefineAll(options, TrueCamera(), &recording);
  EXPECT_TRUE(summary.calibration_kept);
  EXPECT_EQ(summary.rounds.size(), 2u);
  EXPECT_EQ(summary.termination, RefinementTermination::kTooFewSurfels);
  EXPECT_EQ(summary.calibration_covariance.size(), 0);
  EXPECT_TRUE(summary.pose_covariances.empty());
  EXPECT_EQ(summary.after.rms_m, 0);
  for (std::size_t k = 0; k < given.keyframes.size(); ++k) {
    EXPECT_EQ(recording.keyframes[k].world_from_camera.Matrix(),
              given.keyframes[k].world_from_camera.Matrix());
  }
}

TEST(Refine, KeepsPosesWithoutSharedSurfels) {
  Recording recording = Record(2, 0, 0.01, 0.005);  // a surfel needs three observations
  const Rigid3d second = recording.keyframes[1].world_from_camera;
  const RefinementSummary summary = RefineAll({}, TrueCamera(), &recording);
  EXPECT_EQ(summary.termination, RefinementTermination::kTooFewSurfels);
  EXPECT_FALSE(summary.Succeeded());
  EXPECT_EQ(recording.keyframes[1].world_from_camera.Matrix(), second.Matrix());
}

TEST(RefineThreads, IsBitwiseIdentical) {
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

TEST(Refine, RejectsInvalidOptions) {
  RefinementOptions options;
  options.cells_across = 0;
  ExpectInputError([&] { Validate(options); }, Names("cells_across", 0, 1));
}

}  // namespace
}  // namespace surfit::testing
