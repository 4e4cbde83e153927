#include "tracking/inertial/imu_filter.h"

#include <gmock/gmock.h>

#include <Eigen/Cholesky>

#include "slam/imu_path.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

using Eigen::Vector3d;

constexpr double kSigma_rad = 0.002, kSigma_m = 0.003, kFilterFrame_s = 1. / 30;

// Filter that has followed the poses of a path for two seconds.
struct Followed {
  SmoothPath path = SwungCamera(4);
  std::vector<ImuSample> samples;
  ImuSimulation simulation;
  std::optional<ImuFilter> filter;

  explicit Followed(int seed, double arm_sigma_m = 0.02) {
    simulation.seed = seed;
    simulation.calibration.camera_from_imu = ImuMount();
    simulation.calibration.time_offset_s = 0.02;
    samples = SimulateImu(path, simulation);
    std::mt19937_64 rng(seed);
    std::normal_distribution<double> normal;
    ImuCalibration given = simulation.calibration;
    given.rotation_sigma_rad = 0;
    given.translation_sigma_m = arm_sigma_m;
    for (int k = 0; k < 3; ++k) given.camera_from_imu.translation[k] += arm_sigma_m * normal(rng);
    std::vector<RegisteredPose> poses;
    for (int i = 0; i <= 20; ++i)
      poses.push_back(NoisyPose(path, i * kFilterFrame_s, kSigma_rad, kSigma_m, &rng));
    filter = ImuFilter::Start(&samples, poses, given, Vector3d::Zero(), 0.01);
    for (int i = 21; filter && i <= 60; ++i)
      filter->Correct(NoisyPose(path, i * kFilterFrame_s, kSigma_rad, kSigma_m, &rng));
  }
};

Vector6d ErrorOf(const ImuPrediction& predicted, const Rigid3d& truth) {
  return FirstOrderIncrement<double>(Rigid3d(), predicted.world_from_camera.Inverse() * truth);
}

// The normalised squared error of six numbers has the mean 6 and the variance 12. The bounds are
// three standard deviations of the mean of sixty seeds.
TEST(ImuFilter, BridgedPoseHasStatedCovariance) {
  double one_second = 0, half_second = 0;
  constexpr int kSeeds = 60;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const Followed followed(seed);
    ASSERT_TRUE(followed.filter);
    for (const double gap_s : {0.5, 1.}) {
      const auto predicted = followed.filter->Predict(2 + gap_s);
      ASSERT_TRUE(predicted);
      const Vector6d error = ErrorOf(*predicted, followed.path.At(2 + gap_s));
      (gap_s == 1 ? one_second : half_second) +=
          error.dot(predicted->covariance.ldlt().solve(error)) / kSeeds;
    }
  }
  EXPECT_GT(half_second, 4.8);
  EXPECT_LT(half_second, 7.4);
  EXPECT_GT(one_second, 4.8);
  EXPECT_LT(one_second, 7.4);
}

TEST(ImuFilter, StateHasStatedCovariance) {
  double sum = 0;
  constexpr int kSeeds = 60;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const Followed followed(seed);
    const ImuFilter& filter = *followed.filter;
    const Rigid3d camera = followed.path.At(2);
    const PathMotion motion = followed.path.MotionAt(2);
    const Rigid3d imu = camera * ImuMount();
    const Vector3d speed = motion.velocity_m_per_s +
                           camera.rotation * motion.rate_rad_per_s.cross(ImuMount().translation);
    Eigen::Matrix<double, 9, 1> error;
    error << QuaternionLog<double>(filter.state().world_from_imu.rotation.conjugate() *
                                   imu.rotation),
        imu.translation - filter.state().world_from_imu.translation,
        speed - filter.state().velocity_m_per_s;
    const Eigen::Matrix<double, 9, 9> covariance = filter.covariance().topLeftCorner<9, 9>();
    sum += error.dot(covariance.ldlt().solve(error)) / kSeeds;
  }
  // Mean 9, variance 18.
  EXPECT_NEAR(sum, 9, 4 * std::sqrt(18. / kSeeds));
}

// Mean normalised squared error of the prediction of the next frame in a map that drifts.
double ErrorInDriftingMap(bool filter_knows) {
  double sum = 0;
  constexpr int kSeeds = 60;
  for (int seed = 0; seed < kSeeds; ++seed) {
    Followed followed(seed);
    std::mt19937_64 rng(seed);
    DriftingMap map(followed.path, &rng);
    map.At(2);
    for (int i = 61; i <= 105; ++i) {
      if (filter_knows) followed.filter->AddMapDrift(kFilterFrame_s);
      const double stamp_s = i * kFilterFrame_s;
      followed.filter->Correct(NoisyPose(map.At(stamp_s), stamp_s, kSigma_rad, kSigma_m, &rng));
    }
    if (filter_knows) followed.filter->AddMapDrift(kFilterFrame_s);
    const auto predicted = followed.filter->Predict(106 * kFilterFrame_s);
    const Vector6d error = ErrorOf(*predicted, map.At(106 * kFilterFrame_s));
    sum += error.dot(predicted->covariance.ldlt().solve(error)) / kSeeds;
  }
  return sum;
}

TEST(ImuFilter, CovarianceContainsTheDriftOfTheMap) {
  const double known = ErrorInDriftingMap(true);
  EXPECT_GT(known, 4.8);
  EXPECT_LT(known, 7.4);
  EXPECT_GT(ErrorInDriftingMap(false), 12);
}

TEST(ImuFilter, BridgesHalfASecondWithinTwoCentimetres) {
  double squares = 0;
  constexpr int kSeeds = 20;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const Followed followed(seed, 0);
    const Vector6d error = ErrorOf(*followed.filter->Predict(2.5), followed.path.At(2.5));
    squares += error.tail<3>().squaredNorm() / kSeeds;
    EXPECT_LT(error.head<3>().norm(), 0.5 * kRadPerDeg);
  }
  EXPECT_LT(std::sqrt(squares), 0.02);
}

TEST(ImuFilter, FindsGravityWithStatedUncertainty) {
  double squares = 0;
  constexpr int kSeeds = 40;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const ImuFilter filter = *Followed(seed).filter;
    const Vector3d up = -filter.gravity_m_per_s2().normalized();
    const double angle = std::acos(std::min(1., up.z()));
    EXPECT_LT(angle, 4 * filter.GravitySigma());
    squares += std::pow(angle / filter.GravitySigma(), 2) / kSeeds;
  }
  // Two directions, both at most as uncertain as the stated one.
  EXPECT_LT(squares, 2 + 4 * 2 / std::sqrt(kSeeds));
  EXPECT_GT(squares, 0.3);
}

// A resting camera gives gravity, and a velocity of zero.
TEST(ImuFilter, StartsAtRest) {
  const Rigid3d pose(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {1, 2, 3});
  const SmoothPath path({{0, pose}, {2, pose}});
  ImuSimulation simulation;
  simulation.seed = 3;
  simulation.calibration.camera_from_imu = ImuMount();
  const auto samples = SimulateImu(path, simulation);
  std::mt19937_64 rng(3);
  std::vector<RegisteredPose> poses;
  for (int i = 0; i <= 30; ++i)
    poses.push_back(NoisyPose(path, i * kFilterFrame_s, 0.001, 0.001, &rng));
  const auto filter = ImuFilter::Start(&samples, poses, simulation.calibration, Vector3d::Zero(),
                                       simulation.calibration.noise.gyro_bias_sigma);
  ASSERT_TRUE(filter);
  EXPECT_LT(filter->state().velocity_m_per_s.norm(), 0.02);
  // An accelerometer bias of 0.1 m/s^2 tilts gravity by 0.6 degrees.
  EXPECT_LT(std::acos(-filter->gravity_m_per_s2().normalized().z()), 4 * filter->GravitySigma());
}

TEST(ImuFilter, NeedsPosesAndSamples) {
  const Followed followed(1);
  std::mt19937_64 rng(1);
  std::vector<RegisteredPose> poses;
  for (int i = 0; i < 4; ++i)
    poses.push_back(NoisyPose(followed.path, 0.2 * i, kSigma_rad, kSigma_m, &rng));
  const auto start = [&](const std::vector<ImuSample>& samples) {
    return ImuFilter::Start(&samples, poses, followed.simulation.calibration, Vector3d::Zero(),
                            0.01)
        .has_value();
  };
  EXPECT_FALSE(start(followed.samples));
  poses.push_back(NoisyPose(followed.path, 0.8, kSigma_rad, kSigma_m, &rng));
  EXPECT_TRUE(start(followed.samples));
  const std::vector<ImuSample> late(followed.samples.begin() + 60, followed.samples.end());
  EXPECT_FALSE(start(late));
  EXPECT_FALSE(followed.filter->Predict(5));
  EXPECT_FALSE(followed.filter->Predict(1));
}

TEST(ImuFilter, MovesWithWorld) {
  Followed followed(2);
  const ImuPrediction before = *followed.filter->Predict(2.4);
  const Rigid3d new_from_old(QuaternionExp<double>(Vector3d(0.4, -0.3, 1)), {3, -2, 1});
  followed.filter->Move(new_from_old);
  const ImuPrediction after = *followed.filter->Predict(2.4);
  EXPECT_THAT(after.world_from_camera,
              RigidNear(new_from_old * before.world_from_camera, 1e-12, 1e-12));
  EXPECT_LT((after.covariance - before.covariance).norm(), 1e-9 * before.covariance.norm());
}

// A pose that is wrong by half a metre moves the state by much less.
TEST(ImuFilter, LimitsInfluenceOfOutlier) {
  Followed followed(4);
  const double stamp_s = 2 + kFilterFrame_s;
  std::mt19937_64 rng(9);
  RegisteredPose wrong = NoisyPose(followed.path, stamp_s, kSigma_rad, kSigma_m, &rng);
  wrong.world_from_camera.translation.x() += 0.5;
  const auto distance2 = followed.filter->Correct(wrong);
  ASSERT_TRUE(distance2);
  EXPECT_GT(*distance2, 1000);
  const auto predicted = followed.filter->Predict(stamp_s + kFilterFrame_s);
  const Vector6d error = ErrorOf(*predicted, followed.path.At(stamp_s + kFilterFrame_s));
  EXPECT_LT(error.tail<3>().norm(), 0.1);
}

}  // namespace
}  // namespace surfit::testing
