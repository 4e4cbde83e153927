#include "surfit/geometry/inertial.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Densities of the Brownian bridge in a gap: (rad/s)^2/s and (m/s^2)^2/s.
constexpr double kGyroBridge = 9, kAccelBridge = 100;
// Standard deviation of the true value beyond the range, as a factor of the range.
constexpr double kSaturationSigma = 0.3;

// First index of each error in PreintegratedImu::covariance.
enum ErrorBlock { kTurn = 0, kShift = 3, kSpeed = 6, kGyroBias = 9, kAccelBias = 12 };

// J with exp(w + d) = exp(w) exp(J d) for small d.
Matrix3d RightJacobian(const Vector3d& w) {
  const double angle2 = w.squaredNorm(), angle = std::sqrt(angle2);
  double first = 0.5 - angle2 / 24, second = 1. / 6 - angle2 / 120;
  if (angle2 > 1e-6) {
    first = (1 - std::cos(angle)) / angle2;
    second = (angle - std::sin(angle)) / (angle2 * angle);
  }
  const Matrix3d cross = CrossMatrix<double>(w);
  return Matrix3d::Identity() - first * cross + second * cross * cross;
}

ImuSample Mix(const ImuSample& a, const ImuSample& b, double stamp_s) {
  const double t = (stamp_s - a.stamp_s) / (b.stamp_s - a.stamp_s);
  return {stamp_s, a.gyro_rad_per_s + t * (b.gyro_rad_per_s - a.gyro_rad_per_s),
          a.accel_m_per_s2 + t * (b.accel_m_per_s2 - a.accel_m_per_s2)};
}

bool IsSaturated(const Vector3d& value, double range) {
  return range > 0 && value.cwiseAbs().maxCoeff() >= range;
}

// White-noise densities of one step, squared.
struct StepNoise {
  double gyro = 0, accel = 0;
};

// Step between two measurements, within an interval between two samples.
struct ImuStep {
  ImuSample begin, end;
  double interval_s = 0;  // between both samples
  bool gyro_is_saturated = false, accel_is_saturated = false;

  double seconds() const { return end.stamp_s - begin.stamp_s; }
};

StepNoise NoiseOf(const ImuStep& step, const ImuNoise& noise) {
  StepNoise square = {noise.gyro_density * noise.gyro_density,
                      noise.accel_density * noise.accel_density};
  if (step.interval_s > noise.max_step_s) {
    const double square_s = step.interval_s * step.interval_s / 12;
    square.gyro += kGyroBridge * square_s;
    square.accel += kAccelBridge * square_s;
  }
  // A constant error e in an interval of length T has the variance (e T)^2, like the density e^2 T.
  if (step.gyro_is_saturated) {
    square.gyro += std::pow(kSaturationSigma * noise.gyro_range, 2) * step.interval_s;
  }
  if (step.accel_is_saturated) {
    square.accel += std::pow(kSaturationSigma * noise.accel_range, 2) * step.interval_s;
  }
  return square;
}

// Covariance of the errors that a step of length T adds. The white noises have the densities a
// (turn rate), b (acceleration), c and d (rates of both biases). Their effects after the time s are
//   a: turn 1, speed S s, shift S s^2 / 2              S: derivative of the speed rate by the turn
//   b: speed 1, shift s                                R: rotation
//   c: gyro bias 1, turn -s, speed -S s^2 / 2, shift -S s^3 / 6
//   d: accel bias 1, speed -R s, shift -R s^2 / 2
// The covariance is the integral of the products of these effects over s from 0 to T.
Matrix15d StepCovariance(const Matrix3d& speed_by_turn, const Matrix3d& rotation, double seconds,
                         const StepNoise& white, const ImuNoise& noise) {
  const double t = seconds, t2 = t * t, t3 = t2 * t, t4 = t3 * t, t5 = t4 * t;
  const double a = white.gyro, b = white.accel;
  const double c = noise.gyro_bias_density * noise.gyro_bias_density;
  const double d = noise.accel_bias_density * noise.accel_bias_density;
  const Matrix3d one = Matrix3d::Identity();
  const Matrix3d by_turn2 = speed_by_turn * speed_by_turn.transpose();
  const Matrix3d rotation2 = rotation * rotation.transpose();
  Matrix15d sum = Matrix15d::Zero();
  const auto set = [&](int row, int column, const Matrix3d& block) {
    sum.block<3, 3>(row, column) = block;
    if (row != column) sum.block<3, 3>(column, row) = block.transpose();
  };
  set(kTurn, kTurn, (a * t + c * t3 / 3) * one);
  set(kShift, kTurn, (a * t3 / 6 + c * t5 / 30) * speed_by_turn);
  set(kSpeed, kTurn, (a * t2 / 2 + c * t4 / 8) * speed_by_turn);
  set(kShift, kShift,
      (a * t5 / 20 + c * t5 * t2 / 252) * by_turn2 + b * t3 / 3 * one + d * t5 / 20 * rotation2);
  set(kShift, kSpeed,
      (a * t4 / 8 + c * t5 * t / 72) * by_turn2 + b * t2 / 2 * one + d * t4 / 8 * rotation2);
  set(kSpeed, kSpeed, (a * t3 / 3 + c * t5 / 20) * by_turn2 + b * t * one + d * t3 / 3 * rotation2);
  set(kTurn, kGyroBias, -c * t2 / 2 * one);
  set(kShift, kGyroBias, -c * t4 / 24 * speed_by_turn);
  set(kSpeed, kGyroBias, -c * t3 / 6 * speed_by_turn);
  set(kShift, kAccelBias, -d * t3 / 6 * rotation);
  set(kSpeed, kAccelBias, -d * t2 / 2 * rotation);
  set(kGyroBias, kGyroBias, c * t * one);
  set(kAccelBias, kAccelBias, d * t * one);
  return sum;
}

// Integrates one step, and propagates covariance and bias derivatives by the derivatives of the
// same formulas. With f = a - bias and the rotation R0 at the begin, R1 = R0 exp(w T) at the end:
//   v1 = v0 + (R0 f0 + R1 f1) T / 2,  p1 = p0 + v0 T + (2 R0 f0 + R1 f1) T^2 / 6.
void AddStep(const ImuStep& step, const ImuNoise& noise, PreintegratedImu* sum) {
  const double seconds = step.seconds();
  const Vector3d turn = seconds * ((step.begin.gyro_rad_per_s + step.end.gyro_rad_per_s) / 2 -
                                   sum->bias.gyro_rad_per_s);
  const Vector3d force_0 = step.begin.accel_m_per_s2 - sum->bias.accel_m_per_s2;
  const Vector3d force_1 = step.end.accel_m_per_s2 - sum->bias.accel_m_per_s2;
  const Matrix3d step_rotation = QuaternionExp<double>(turn).toRotationMatrix();
  const Matrix3d rotation_0 = sum->rotation.toRotationMatrix();
  const Matrix3d rotation_1 = rotation_0 * step_rotation;

  // Derivatives of both accelerations by the errors at the begin of the step.
  using Rows = Eigen::Matrix<double, 3, 15>;
  Rows turn_1 = Rows::Zero(), accel_0 = Rows::Zero();
  turn_1.block<3, 3>(0, kTurn) = step_rotation.transpose();
  turn_1.block<3, 3>(0, kGyroBias) = -seconds * RightJacobian(turn);
  const Matrix3d by_turn_0 = -rotation_0 * CrossMatrix<double>(force_0);
  const Matrix3d by_turn_1 = -rotation_1 * CrossMatrix<double>(force_1);
  accel_0.block<3, 3>(0, kTurn) = by_turn_0;
  accel_0.block<3, 3>(0, kAccelBias) = -rotation_0;
  Rows accel_1 = by_turn_1 * turn_1;
  accel_1.block<3, 3>(0, kAccelBias) -= rotation_1;

  Matrix15d transition = Matrix15d::Identity();
  transition.middleRows<3>(kTurn) = turn_1;
  transition.block<3, 3>(kShift, kSpeed) = seconds * Matrix3d::Identity();
  transition.middleRows<3>(kShift) += seconds * seconds / 6 * (2 * accel_0 + accel_1);
  transition.middleRows<3>(kSpeed) += seconds / 2 * (accel_0 + accel_1);

  sum->covariance = transition * sum->covariance * transition.transpose() +
                    StepCovariance((by_turn_0 + by_turn_1) / 2, (rotation_0 + rotation_1) / 2,
                                   seconds, NoiseOf(step, noise), noise);
  sum->covariance = (sum->covariance + sum->covariance.transpose()).eval() / 2;
  sum->bias_jacobian =
      (transition.topLeftCorner<9, 9>() * sum->bias_jacobian + transition.topRightCorner<9, 6>())
          .eval();
  const Vector3d a_0 = rotation_0 * force_0, a_1 = rotation_1 * force_1;
  sum->position_m += seconds * sum->velocity_m_per_s + seconds * seconds / 6 * (2 * a_0 + a_1);
  sum->velocity_m_per_s += seconds / 2 * (a_0 + a_1);
  sum->rotation = (sum->rotation * QuaternionExp<double>(turn)).normalized();
  sum->duration_s += seconds;
  sum->gaps += step.interval_s > noise.max_step_s;
  sum->saturated += step.gyro_is_saturated || step.accel_is_saturated;
}

bool IsEarlier(const ImuSample& sample, double stamp_s) { return sample.stamp_s < stamp_s; }

}  // namespace

void ImuNoise::Visit(OptionVisitor& v) {
  v.Add(gyro_density, "gyro_density", "white noise of the gyroscope, rad/s/sqrt(Hz)", Positive());
  v.Add(accel_density, "accel_density", "white noise of the accelerometer, m/s^2/sqrt(Hz)",
        Positive());
  v.Add(gyro_bias_density, "gyro_bias_density",
        "random walk of the gyroscope bias, rad/s^2/sqrt(Hz)", Positive());
  v.Add(accel_bias_density, "accel_bias_density",
        "random walk of the accelerometer bias, m/s^3/sqrt(Hz)", Positive());
  v.Add(gyro_bias_sigma, "gyro_bias_sigma",
        "standard deviation of the gyroscope bias before the recording, rad/s", Positive());
  v.Add(accel_bias_sigma, "accel_bias_sigma",
        "standard deviation of the accelerometer bias before the recording, m/s^2", Positive());
  v.Add(gyro_range, "gyro_range", "range of the gyroscope, rad/s", ZeroIs("unlimited"));
  v.Add(accel_range, "accel_range", "range of the accelerometer, m/s^2", ZeroIs("unlimited"));
  v.Add(max_step_s, "max_step_s", "longer intervals between samples are gaps", Positive());
}

void ImuNoise::Validate(const std::string& what) const {
  WithContext(what, [&] { surfit::Validate(*this); });
}

std::optional<ImuSample> InterpolateImu(const std::vector<ImuSample>& samples, double stamp_s,
                                        double max_step_s) {
  if (samples.empty() || !std::isfinite(stamp_s)) return std::nullopt;
  const auto next = std::lower_bound(samples.begin(), samples.end(), stamp_s, IsEarlier);
  if (next != samples.end() && next->stamp_s == stamp_s) return *next;
  if (next != samples.begin() && next != samples.end())
    return Mix(*std::prev(next), *next, stamp_s);
  ImuSample held = next == samples.end() ? samples.back() : samples.front();
  if (std::abs(held.stamp_s - stamp_s) > max_step_s) return std::nullopt;
  held.stamp_s = stamp_s;
  return held;
}

std::optional<PreintegratedImu> PreintegrateImu(const std::vector<ImuSample>& samples,
                                                double begin_s, double end_s, const ImuBias& bias,
                                                const ImuNoise& noise) {
  if (!(begin_s < end_s)) return std::nullopt;
  const std::optional<ImuSample> first = InterpolateImu(samples, begin_s, noise.max_step_s);
  const std::optional<ImuSample> last = InterpolateImu(samples, end_s, noise.max_step_s);
  if (!first || !last) return std::nullopt;
  PreintegratedImu sum;
  sum.bias = bias;
  ImuSample at = *first;
  auto next = std::upper_bound(samples.begin(), samples.end(), begin_s,
                               [](double s, const ImuSample& x) { return s < x.stamp_s; });
  while (at.stamp_s < end_s) {
    const bool ends_at_sample = next != samples.end() && next->stamp_s < end_s;
    const ImuSample& to = ends_at_sample ? *next : *last;
    const bool has_both = next != samples.begin() && next != samples.end();
    ImuStep step = {at, to,
                    has_both ? next->stamp_s - std::prev(next)->stamp_s : to.stamp_s - at.stamp_s};
    for (const auto& end :
         {next == samples.begin() ? at : *std::prev(next), next == samples.end() ? to : *next}) {
      step.gyro_is_saturated |= IsSaturated(end.gyro_rad_per_s, noise.gyro_range);
      step.accel_is_saturated |= IsSaturated(end.accel_m_per_s2, noise.accel_range);
    }
    AddStep(step, noise, &sum);
    at = to;
    if (ends_at_sample) ++next;
  }
  return sum;
}

ImuState PredictImu(const ImuState& begin, const PreintegratedImu& motion,
                    const Eigen::Vector3d& gravity_m_per_s2) {
  const double seconds = motion.duration_s;
  const Eigen::Quaterniond& rotation = begin.world_from_imu.rotation;
  ImuState end;
  end.world_from_imu.rotation = (rotation * motion.rotation).normalized();
  end.world_from_imu.translation =
      begin.world_from_imu.translation + seconds * begin.velocity_m_per_s +
      seconds * seconds / 2 * gravity_m_per_s2 + rotation * motion.position_m;
  end.velocity_m_per_s =
      begin.velocity_m_per_s + seconds * gravity_m_per_s2 + rotation * motion.velocity_m_per_s;
  return end;
}

}  // namespace surfit
