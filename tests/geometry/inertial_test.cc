#include "surfit/geometry/inertial.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>

#include "testing/random_pose.h"

namespace surfit::testing {
namespace {

using Eigen::Vector3d;
using Vector9 = Eigen::Matrix<double, 9, 1>;
using Vector15 = Eigen::Matrix<double, 15, 1>;

const Vector3d kDown(0, kGravity_m_per_s2, 0);

// Motion with exact derivatives: sinusoids of position, and two rotations with sinusoidal angles,
// R = exp(a(t) m) exp(b(t) n).
struct SwungSensor {
  double speed = 1;  // factor of all frequencies

  struct Wave {
    double value, first, second;
  };
  static Wave At(double size, double frequency, double phase, double t) {
    const double x = frequency * t + phase;
    return {size * std::sin(x), size * frequency * std::cos(x),
            -size * frequency * frequency * std::sin(x)};
  }

  // Rates up to 3 rad/s at speed 1.
  ImuState State(double t) const {
    const Wave a = At(0.5, 4 * speed, 0.3, t), b = At(0.4, 2.5 * speed, 1, t);
    const Vector3d m = Vector3d(1, 2, -1).normalized(), n = Vector3d(-1, 1, 0.5).normalized();
    ImuState state;
    state.world_from_imu.rotation =
        QuaternionExp<double>(Vector3d(a.value * m)) * QuaternionExp<double>(Vector3d(b.value * n));
    for (int k = 0; k < 3; ++k) {
      const Wave p = Position(k, t);
      state.world_from_imu.translation[k] = p.value;
      state.velocity_m_per_s[k] = p.first;
    }
    return state;
  }
  Wave Position(int k, double t) const { return At(0.2, (3 + 0.7 * k) * speed, k, t); }

  ImuSample Sample(double t, const ImuBias& bias) const {
    const Wave a = At(0.5, 4 * speed, 0.3, t), b = At(0.4, 2.5 * speed, 1, t);
    const Vector3d m = Vector3d(1, 2, -1).normalized(), n = Vector3d(-1, 1, 0.5).normalized();
    const Eigen::Quaterniond second = QuaternionExp<double>(Vector3d(b.value * n));
    const Eigen::Quaterniond rotation = State(t).world_from_imu.rotation;
    const Vector3d accel(Position(0, t).second, Position(1, t).second, Position(2, t).second);
    return {t, a.first * (second.conjugate() * m) + b.first * n + bias.gyro_rad_per_s,
            rotation.conjugate() * (accel - kDown) + bias.accel_m_per_s2};
  }

  std::vector<ImuSample> Samples(double rate_hz, double end_s, const ImuBias& bias = {}) const {
    std::vector<ImuSample> samples;
    for (int i = 0; i <= end_s * rate_hz; ++i) samples.push_back(Sample(i / rate_hz, bias));
    return samples;
  }
};

// Errors of a prediction in the order of PreintegratedImu.
Vector9 ErrorOf(const ImuState& begin, const ImuState& end, const PreintegratedImu& motion) {
  const ImuState predicted = PredictImu(begin, motion, kDown);
  const Eigen::Quaterniond to_begin = begin.world_from_imu.rotation.conjugate();
  Vector9 error;
  error << QuaternionLog<double>(predicted.world_from_imu.rotation.conjugate() *
                                 end.world_from_imu.rotation),
      to_begin * Vector3d(end.world_from_imu.translation - predicted.world_from_imu.translation),
      to_begin * Vector3d(end.velocity_m_per_s - predicted.velocity_m_per_s);
  return error;
}

TEST(PreintegrateImu, IntegratesFastMotionBelowTenthOfSigma) {
  const SwungSensor sensor;
  const std::vector<ImuSample> samples = sensor.Samples(200, 2);
  for (double begin = 0.103; begin < 1.7; begin += 0.1) {
    const auto motion = PreintegrateImu(samples, begin, begin + 0.25, {}, {});
    ASSERT_TRUE(motion);
    const Vector9 error = ErrorOf(sensor.State(begin), sensor.State(begin + 0.25), *motion);
    for (int k = 0; k < 9; ++k) {
      EXPECT_LT(std::abs(error[k]), 0.1 * std::sqrt(motion->covariance(k, k))) << k;
    }
  }
}

// Halving the step divides the error by four: the rule has second order.
TEST(PreintegrateImu, HasSecondOrder) {
  const SwungSensor sensor;
  const auto error_at = [&](double rate_hz) {
    const auto motion = PreintegrateImu(sensor.Samples(rate_hz, 1), 0, 1, {}, {});
    return ErrorOf(sensor.State(0), sensor.State(1), *motion);
  };
  const Vector9 coarse = error_at(50), fine = error_at(100);
  EXPECT_NEAR(coarse.head<3>().norm() / fine.head<3>().norm(), 4, 0.3);
  EXPECT_NEAR(coarse.tail<6>().norm() / fine.tail<6>().norm(), 4, 0.3);
}

TEST(PreintegrateImu, CovarianceOfSingleSampleIsPositiveDefinite) {
  for (const double seconds : {1e-4, 2e-3, 0.01}) {
    const std::vector<ImuSample> samples = {{0, {1, 2, 3}, {1, -9, 2}}, {1, {1, 2, 3}, {1, -9, 2}}};
    ImuNoise noise;
    noise.max_step_s = 2;
    const auto motion = PreintegrateImu(samples, 0, seconds, {}, noise);
    ASSERT_TRUE(motion);
    // Scaled to a unit diagonal, so that units have no effect.
    const Vector15 sigmas = motion->covariance.diagonal().cwiseSqrt();
    const Matrix15d correlation = sigmas.cwiseInverse().asDiagonal() * motion->covariance *
                                  sigmas.cwiseInverse().asDiagonal();
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix15d>(correlation).eigenvalues()[0], 1e-3);
  }
}

// Simulates noise of the given densities and a walking bias. The normalised squared error of 15
// numbers has the mean 15 and the variance 30.
TEST(PreintegrateImu, CovarianceAgreesWithNoise) {
  const SwungSensor sensor{0.5};
  ImuNoise noise;
  noise.gyro_bias_density = 1e-3;
  noise.accel_bias_density = 2e-2;
  constexpr double kRate = 200;
  constexpr int kSeeds = 200;
  double all = 0, of_pose = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    std::mt19937_64 rng(seed);
    std::normal_distribution<double> normal;
    const auto random = [&] { return Vector3d(normal(rng), normal(rng), normal(rng)); };
    std::vector<ImuSample> samples;
    ImuBias bias, first;
    for (int i = 0; i <= 100; ++i) {
      samples.push_back(sensor.Sample(i / kRate, bias));
      samples.back().gyro_rad_per_s += noise.gyro_density * std::sqrt(kRate) * random();
      samples.back().accel_m_per_s2 += noise.accel_density * std::sqrt(kRate) * random();
      if (i == 100) break;
      bias.gyro_rad_per_s += noise.gyro_bias_density / std::sqrt(kRate) * random();
      bias.accel_m_per_s2 += noise.accel_bias_density / std::sqrt(kRate) * random();
    }
    const auto motion = PreintegrateImu(samples, 0, 0.5, first, noise);
    Vector15 error;
    error << ErrorOf(sensor.State(0), sensor.State(0.5), *motion), bias.gyro_rad_per_s,
        bias.accel_m_per_s2;
    all += error.dot(motion->covariance.ldlt().solve(error)) / kSeeds;
    const Eigen::Matrix<double, 6, 6> pose = motion->covariance.topLeftCorner<6, 6>();
    of_pose += error.head<6>().dot(pose.ldlt().solve(error.head<6>())) / kSeeds;
  }
  EXPECT_NEAR(all, 15, 4 * std::sqrt(30. / kSeeds));
  EXPECT_NEAR(of_pose, 6, 4 * std::sqrt(12. / kSeeds));
}

TEST(PreintegrateImu, BiasJacobianAgreesWithDifferences) {
  const SwungSensor sensor;
  const std::vector<ImuSample> samples = sensor.Samples(100, 1);
  const ImuBias bias = {{0.01, -0.02, 0.03}, {0.1, 0.2, -0.3}};
  const auto at = PreintegrateImu(samples, 0.204, 0.713, bias, {});
  for (int k = 0; k < 6; ++k) {
    constexpr double kStep = 1e-5;
    const auto moved = [&](double step) {
      ImuBias other = bias;
      (k < 3 ? other.gyro_rad_per_s[k] : other.accel_m_per_s2[k - 3]) += step;
      const auto motion = PreintegrateImu(samples, 0.204, 0.713, other, {});
      Vector9 d;
      d << QuaternionLog<double>(at->rotation.conjugate() * motion->rotation), motion->position_m,
          motion->velocity_m_per_s;
      return d;
    };
    const Vector9 difference = (moved(kStep) - moved(-kStep)) / (2 * kStep);
    EXPECT_LT((at->bias_jacobian.col(k) - difference).norm(), 1e-7) << k;
  }
}

TEST(PreintegrateImu, GapIncreasesCovarianceOfItsIntervalOnly) {
  const SwungSensor sensor;
  const std::vector<ImuSample> whole = sensor.Samples(100, 1);
  std::vector<ImuSample> samples;
  for (const ImuSample& sample : whole) {
    if (sample.stamp_s < 0.405 || sample.stamp_s > 0.495) samples.push_back(sample);
  }
  const auto within = PreintegrateImu(samples, 0.3, 0.6, {}, {});
  const auto complete = PreintegrateImu(whole, 0.3, 0.6, {}, {});
  EXPECT_EQ(within->gaps, 1);
  EXPECT_EQ(complete->gaps, 0);
  const Vector9 error = ErrorOf(sensor.State(0.3), sensor.State(0.6), *within);
  for (int k = 0; k < 9; ++k) {
    EXPECT_GT(within->covariance(k, k), 4 * complete->covariance(k, k)) << k;
    EXPECT_LT(std::abs(error[k]), 3 * std::sqrt(within->covariance(k, k))) << k;
  }
  for (const auto& [begin, end] : {std::pair(0.1, 0.4), std::pair(0.5, 0.9)}) {
    const auto outside = PreintegrateImu(samples, begin, end, {}, {});
    const auto same = PreintegrateImu(whole, begin, end, {}, {});
    EXPECT_EQ(outside->covariance, same->covariance) << begin;
    EXPECT_EQ(outside->position_m, same->position_m) << begin;
  }
}

TEST(PreintegrateImu, SaturatedSampleIncreasesCovarianceOfItsIntervalsOnly) {
  const SwungSensor sensor;
  std::vector<ImuSample> samples = sensor.Samples(100, 1);
  ImuNoise noise;
  noise.gyro_range = 5;
  noise.accel_range = 40;
  const auto before = PreintegrateImu(samples, 0.3, 0.6, {}, noise);
  EXPECT_EQ(before->saturated, 0);
  samples[45].gyro_rad_per_s.y() = -5;
  const auto with_gyro = PreintegrateImu(samples, 0.3, 0.6, {}, noise);
  EXPECT_EQ(with_gyro->saturated, 2);
  for (int k = 0; k < 3; ++k) {
    EXPECT_GT(with_gyro->covariance(k, k), 100 * before->covariance(k, k));
  }
  samples[45] = sensor.Sample(0.45, {});
  samples[45].accel_m_per_s2.x() = 40;
  const auto with_accel = PreintegrateImu(samples, 0.3, 0.6, {}, noise);
  EXPECT_EQ(with_accel->saturated, 2);
  EXPECT_EQ(with_accel->rotation.coeffs(), before->rotation.coeffs());
  for (int k = 6; k < 9; ++k) {
    EXPECT_GT(with_accel->covariance(k, k), 10 * before->covariance(k, k));
  }
  EXPECT_EQ(PreintegrateImu(samples, 0.5, 0.6, {}, noise)->saturated, 0);
}

TEST(PreintegrateImu, NeedsSamplesAtBothTimes) {
  const std::vector<ImuSample> samples = SwungSensor().Samples(100, 1);
  EXPECT_FALSE(PreintegrateImu(samples, 0.5, 0.5, {}, {}));
  EXPECT_FALSE(PreintegrateImu(samples, 0.5, 0.4, {}, {}));
  EXPECT_FALSE(PreintegrateImu(samples, 0.5, std::nan(""), {}, {}));
  EXPECT_FALSE(PreintegrateImu(samples, 0.5, 1.036, {}, {}));
  EXPECT_FALSE(PreintegrateImu(samples, -0.036, 0.5, {}, {}));
  EXPECT_FALSE(PreintegrateImu({}, 0.1, 0.2, {}, {}));
  const auto motion = PreintegrateImu(samples, -0.03, 1.03, {}, {});
  ASSERT_TRUE(motion);
  EXPECT_NEAR(motion->duration_s, 1.06, 1e-12);
}

TEST(PreintegrateImu, SumsOfPartsAgreeWithWhole) {
  const SwungSensor sensor;
  const std::vector<ImuSample> samples = sensor.Samples(100, 1);
  const auto whole = PreintegrateImu(samples, 0.2, 0.8, {}, {});
  const auto first = PreintegrateImu(samples, 0.2, 0.45, {}, {});
  const auto second = PreintegrateImu(samples, 0.45, 0.8, {}, {});
  const ImuState begin = sensor.State(0.2);
  const ImuState by_parts = PredictImu(PredictImu(begin, *first, kDown), *second, kDown);
  EXPECT_LT(ErrorOf(begin, by_parts, *whole).norm(), 1e-12);
}

TEST(InterpolateImu, IsLinearAndHoldsEnds) {
  const std::vector<ImuSample> samples = {{1, {0, 0, 0}, {2, 0, 0}}, {2, {1, 0, 0}, {4, 0, 0}}};
  EXPECT_EQ(InterpolateImu(samples, 1.25, 0.1)->gyro_rad_per_s.x(), 0.25);
  EXPECT_EQ(InterpolateImu(samples, 1.25, 0.1)->accel_m_per_s2.x(), 2.5);
  EXPECT_EQ(InterpolateImu(samples, 2, 0)->accel_m_per_s2.x(), 4);
  EXPECT_EQ(InterpolateImu(samples, 0.95, 0.1)->accel_m_per_s2.x(), 2);
  EXPECT_EQ(InterpolateImu(samples, 0.95, 0.1)->stamp_s, 0.95);
  EXPECT_EQ(InterpolateImu(samples, 2.0625, 0.1)->accel_m_per_s2.x(), 4);
  EXPECT_FALSE(InterpolateImu(samples, 2.25, 0.1));
  EXPECT_FALSE(InterpolateImu({}, 1, 0.1));
}

}  // namespace
}  // namespace surfit::testing
