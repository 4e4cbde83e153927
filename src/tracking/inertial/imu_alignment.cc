#include "tracking/inertial/imu_alignment.h"

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "core/median.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kMinTurns = 12;
constexpr double kMaxRotationSigma = 1 * kRadPerDeg;
// Step of the search for the time offset, s.
constexpr double kOffsetStep_s = 0.005;
// Smallest standard deviation of the rotation between two poses, per axis, rad.
constexpr double kMinTurnSigma = 5e-4;
// Motion that shows a wrong sign or unit: RMS rate of the weakest axis, rad/s, and its ratio to the
// residual.
constexpr double kMinWeakRate = 0.03, kMinRateRatio = 3;
// A mirrored fit is better if its sum of squares is below this ratio of that of a rotation.
constexpr double kMirrorRatio = 0.25;
constexpr double kMaxLogScale = 0.3;
// RMS rate of the camera that shows a missing correlation, rad/s. Errors of poses give 0.02.
constexpr double kMinRate = 0.1, kNoCorrelation = 0.5;
// Smallest difference of a wrong given rotation.
constexpr double kMinWrongRotation = 10 * kRadPerDeg;

// Mean rates of one turn, and its duration.
struct RatePair {
  Vector3d camera, gyro;
  double seconds = 0;
};

std::vector<RatePair> RatesAt(const GyroIntegral& gyro, const std::vector<CameraTurn>& turns,
                              double offset_s, double margin_s) {
  std::vector<RatePair> pairs;
  for (const CameraTurn& turn : turns) {
    if (!gyro.Covers(turn.begin_s + offset_s - margin_s, turn.end_s + offset_s + margin_s))
      continue;
    const double seconds = turn.end_s - turn.begin_s;
    pairs.push_back({QuaternionLog<double>(turn.begin_from_end) / seconds,
                     gyro.MeanRate(turn.begin_s + offset_s, turn.end_s + offset_s), seconds});
  }
  return pairs;
}

// Orthogonal fit of the rates without their means, which contain the bias.
struct RateFit {
  Matrix3d rotation = Matrix3d::Identity();  // camera from gyroscope
  double squares = 0, mirrored_squares = 0;  // sums of squares of a rotation and a reflection
  double camera_squares = 0, gyro_squares = 0, product = 0;
  double weakest = 0;     // RMS rate of the gyroscope along its weakest axis
  double turn_sigma = 0;  // standard deviation of the rotation about its worst axis, rad
};

// The squared norm of a rotation error is that of the rate times the squared duration.
RateFit FitRates(const std::vector<RatePair>& pairs) {
  Vector3d mean_camera = Vector3d::Zero(), mean_gyro = Vector3d::Zero();
  double weight = 0;
  for (const RatePair& pair : pairs) {
    const double w = pair.seconds * pair.seconds;
    mean_camera += w * pair.camera;
    mean_gyro += w * pair.gyro;
    weight += w;
  }
  mean_camera /= weight;
  mean_gyro /= weight;
  RateFit fit;
  Matrix3d cross = Matrix3d::Zero(), of_gyro = Matrix3d::Zero();
  for (const RatePair& pair : pairs) {
    const double w = pair.seconds * pair.seconds;
    const Vector3d camera = pair.camera - mean_camera, gyro = pair.gyro - mean_gyro;
    cross += w * camera * gyro.transpose();
    of_gyro += w * gyro * gyro.transpose();
    fit.camera_squares += w * camera.squaredNorm();
    fit.gyro_squares += w * gyro.squaredNorm();
  }
  const Eigen::JacobiSVD<Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Vector3d& values = svd.singularValues();
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  fit.rotation = svd.matrixU() * Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
  fit.product = values[0] + values[1] + sign * values[2];
  const double both = fit.camera_squares + fit.gyro_squares;
  fit.squares = std::max(0., both - 2 * fit.product);
  fit.mirrored_squares = std::max(0., both - 2 * (values[0] + values[1] - sign * values[2]));
  const Vector3d energies = Eigen::JacobiSVD<Matrix3d>(of_gyro).singularValues();
  fit.weakest = std::sqrt(energies[2] / weight);
  // The other two axes give the rotation about the strongest axis.
  const double residual2 =
      std::min(fit.squares, fit.mirrored_squares) / 3 / static_cast<double>(pairs.size());
  fit.turn_sigma = std::sqrt(residual2 / (energies[1] + energies[2]));
  return fit;
}

// Reason why the rates cannot be those of the camera; empty: none. `has_enough_motion` is set if a
// wrong sign would be found.
std::string FaultOf(const RateFit& fit, double weight_s2, bool* has_enough_motion) {
  const double residual = std::sqrt(std::min(fit.squares, fit.mirrored_squares) / (3 * weight_s2));
  const double scale = fit.product / fit.gyro_squares;
  const double correlation = fit.product / std::sqrt(fit.gyro_squares * fit.camera_squares);
  const double camera_rate = std::sqrt(fit.camera_squares / weight_s2);
  const double gyro_rate = std::sqrt(fit.gyro_squares / weight_s2);
  if (camera_rate > kMinRate && correlation < kNoCorrelation &&
      fit.mirrored_squares > kMirrorRatio * fit.squares) {
    return Concat("the gyroscope does not follow the rotation of the camera: their correlation is ",
                  correlation);
  }
  *has_enough_motion =
      std::min(fit.weakest, camera_rate) > kMinWeakRate && camera_rate > kMinRateRatio * residual;
  if (*has_enough_motion && fit.mirrored_squares < kMirrorRatio * fit.squares) {
    return "the gyroscope fits the rotation of the camera as a mirror image: the sign of one axis, "
           "or of all three, is wrong, or two axes are exchanged";
  }
  if (*has_enough_motion && std::abs(std::log(scale)) > kMaxLogScale) {
    return Concat("the rates of the gyroscope are ", gyro_rate / camera_rate,
                  " times those of the camera");
  }
  return "";
}

// Reason if the rates have the size of degrees per second; empty: none. Their rotations exceed 180
// degrees within a turn, so the other tests do not find this.
std::string FaultOfUnit(const GyroIntegral& gyro, const std::vector<CameraTurn>& turns,
                        double offset_s) {
  double camera_rad = 0, gyro_rad = 0, seconds = 0;
  for (const CameraTurn& turn : turns) {
    const double begin = turn.begin_s + offset_s, end = turn.end_s + offset_s;
    if (!gyro.Covers(begin, end)) continue;
    camera_rad += RotationAngle(turn.begin_from_end);
    gyro_rad += gyro.PathLength(begin, end);
    seconds += turn.end_s - turn.begin_s;
  }
  const double ratio = gyro_rad / camera_rad;
  if (!(camera_rad > kMinRate * seconds && std::abs(std::log(ratio * kRadPerDeg)) < 0.5)) return "";
  return Concat("the rates of the gyroscope are ", ratio,
                " times those of the camera: their unit is degrees per second, must be rad/s");
}

// Reason why the given rotation cannot be that of the best fit; empty: none.
std::string FaultOfRotation(const RateFit& fit, const ImuCalibration& given) {
  const double angle =
      RotationAngle(Eigen::Quaterniond(fit.rotation) * given.camera_from_imu.rotation.conjugate());
  const double sigma = std::hypot(given.rotation_sigma_rad, fit.turn_sigma);
  if (angle <= std::max(5 * sigma, kMinWrongRotation)) return "";
  return Concat("the rotation of camera_from_imu differs by ", angle / kRadPerDeg,
                " degrees from that of the motion");
}

// Parameters: rotation (left perturbation), time offset, bias.
using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;

struct AlignmentState {
  Eigen::Quaterniond rotation;
  double offset_s = 0;
  Vector3d bias = Vector3d::Zero();
};

// Adds a Gaussian prior to a parameter. A standard deviation of 0 fixes the parameter.
void AddPrior(int at, double value, double sigma, Matrix7d* information, Vector7d* gradient) {
  if (std::isinf(sigma)) return;
  const double weight = 1 / (std::max(sigma, 1e-9) * std::max(sigma, 1e-9));
  (*information)(at, at) += weight;
  (*gradient)[at] += weight * value;
}

struct RateResidual {
  Vector3d error;
  Eigen::Matrix<double, 3, 7> by_state;  // derivative of -error
  double seconds = 0;
};

std::vector<RateResidual> ResidualsAt(const GyroIntegral& gyro,
                                      const std::vector<CameraTurn>& turns,
                                      const AlignmentState& state) {
  const Matrix3d rotation = state.rotation.toRotationMatrix();
  const auto now = RatesAt(gyro, turns, state.offset_s, kOffsetStep_s);
  std::vector<RateResidual> residuals;
  std::size_t k = 0;
  for (const CameraTurn& turn : turns) {
    const double begin = turn.begin_s + state.offset_s, end = turn.end_s + state.offset_s;
    if (!gyro.Covers(begin - kOffsetStep_s, end + kOffsetStep_s)) continue;
    const RatePair& pair = now[k++];
    const Vector3d turned = rotation * (pair.gyro - state.bias);
    const Vector3d change = (gyro.MeanRate(begin + kOffsetStep_s, end + kOffsetStep_s) -
                             gyro.MeanRate(begin - kOffsetStep_s, end - kOffsetStep_s)) /
                            (2 * kOffsetStep_s);
    RateResidual residual;
    residual.error = pair.camera - turned;
    residual.by_state << -CrossMatrix<double>(turned), rotation * change, -rotation;
    residual.seconds = pair.seconds;
    residuals.push_back(residual);
  }
  return residuals;
}

double MedianTurnError(const std::vector<RateResidual>& residuals) {
  std::vector<double> errors;
  errors.reserve(residuals.size());
  for (const RateResidual& r : residuals) errors.push_back(r.error.norm() * r.seconds);
  return MedianOf(std::move(errors));
}

}  // namespace

GyroIntegral::GyroIntegral(const std::vector<ImuSample>* samples) : samples_(samples) {
  rotations_.reserve(samples->size());
  for (std::size_t i = 0; i < samples->size(); ++i) {
    if (i == 0) {
      rotations_.push_back(Eigen::Quaterniond::Identity());
      lengths_.push_back(0);
      continue;
    }
    const ImuSample &a = (*samples)[i - 1], &b = (*samples)[i];
    const Vector3d turn = (a.gyro_rad_per_s + b.gyro_rad_per_s) * ((b.stamp_s - a.stamp_s) / 2);
    lengths_.push_back(lengths_.back() + turn.norm());
    rotations_.push_back((rotations_.back() * QuaternionExp<double>(turn)).normalized());
  }
}

bool GyroIntegral::Covers(double begin_s, double end_s) const {
  return !rotations_.empty() && begin_s >= samples_->front().stamp_s &&
         end_s <= samples_->back().stamp_s && begin_s < end_s;
}

Vector3d GyroIntegral::MeanRate(double begin_s, double end_s) const {
  const Eigen::Quaterniond turn = RotationAt(begin_s).conjugate() * RotationAt(end_s);
  return QuaternionLog<double>(turn) / (end_s - begin_s);
}

double GyroIntegral::PathLength(double begin_s, double end_s) const {
  const auto index = [&](double stamp_s) {
    return std::lower_bound(
               samples_->begin(), samples_->end(), stamp_s,
               [](const ImuSample& sample, double stamp) { return sample.stamp_s < stamp; }) -
           samples_->begin();
  };
  return lengths_[index(end_s)] - lengths_[index(begin_s)];
}

Eigen::Quaterniond GyroIntegral::RotationAt(double stamp_s) const {
  const auto next = std::lower_bound(
      samples_->begin(), samples_->end(), stamp_s,
      [](const ImuSample& sample, double stamp) { return sample.stamp_s < stamp; });
  const auto at = next - samples_->begin();
  if (next->stamp_s == stamp_s || at == 0) return rotations_[at];
  const ImuSample &a = *std::prev(next), &b = *next;
  const double seconds = stamp_s - a.stamp_s, share = seconds / (b.stamp_s - a.stamp_s);
  const Vector3d rate = a.gyro_rad_per_s + share / 2 * (b.gyro_rad_per_s - a.gyro_rad_per_s);
  return rotations_[at - 1] * QuaternionExp<double>(Vector3d(seconds * rate));
}

ImuAlignment AlignImu(const GyroIntegral& gyro, const std::vector<CameraTurn>& turns,
                      const ImuCalibration& given) {
  ImuAlignment alignment;
  alignment.calibration = given;
  alignment.gyro_bias_sigma_rad_per_s = given.noise.gyro_bias_sigma;
  const bool is_given = given.rotation_sigma_rad <= 0.1;
  alignment.is_known = given.rotation_sigma_rad < kMaxRotationSigma;

  if (static_cast<int>(turns.size()) >= kMinTurns)
    alignment.fault = FaultOfUnit(gyro, turns, given.time_offset_s);
  if (!alignment.fault.empty()) return alignment;
  AlignmentState state = {given.camera_from_imu.rotation, given.time_offset_s};
  double best = std::numeric_limits<double>::infinity();
  const int steps = static_cast<int>(std::ceil(3 * given.time_offset_sigma_s / kOffsetStep_s));
  for (int i = -steps; i <= steps; ++i) {
    const double offset_s = given.time_offset_s + i * kOffsetStep_s;
    const std::vector<RatePair> pairs = RatesAt(gyro, turns, offset_s, kOffsetStep_s);
    if (static_cast<int>(pairs.size()) < kMinTurns) continue;
    const RateFit fit = FitRates(pairs);
    const double squares = std::min(fit.squares, fit.mirrored_squares);
    if (!(squares < best)) continue;
    best = squares;
    double weight_s2 = 0;
    for (const RatePair& pair : pairs) weight_s2 += pair.seconds * pair.seconds;
    alignment.has_enough_motion = false;
    alignment.fault = FaultOf(fit, weight_s2, &alignment.has_enough_motion);
    state.offset_s = offset_s;
    if (is_given && alignment.has_enough_motion && alignment.fault.empty()) {
      alignment.fault = FaultOfRotation(fit, given);
    }
    if (!is_given) state.rotation = Eigen::Quaterniond(fit.rotation).normalized();
  }
  if (!std::isfinite(best) || !alignment.fault.empty()) return alignment;

  const AlignmentState prior = {given.camera_from_imu.rotation, given.time_offset_s};
  Matrix7d covariance = Matrix7d::Identity();
  for (int iteration = 0; iteration < 6; ++iteration) {
    const std::vector<RateResidual> residuals = ResidualsAt(gyro, turns, state);
    if (static_cast<int>(residuals.size()) < kMinTurns) return alignment;
    // The norm of three normal errors has the median 1.54 standard deviations.
    const double sigma = std::max(kMinTurnSigma, MedianTurnError(residuals) / 1.54);
    Matrix7d information = Matrix7d::Zero();
    Vector7d gradient = Vector7d::Zero();
    double squares = 0, weights = 0;
    for (const RateResidual& residual : residuals) {
      const double error2 = std::pow(residual.error.norm() * residual.seconds / sigma, 2);
      const double kernel = 1 / (1 + error2 / 9);
      const double weight = kernel * std::pow(residual.seconds / sigma, 2);
      information += weight * residual.by_state.transpose() * residual.by_state;
      gradient += weight * residual.by_state.transpose() * residual.error;
      squares += kernel * error2;
      weights += kernel;
    }
    alignment.residual_rad = sigma * std::sqrt(squares / (3 * weights));
    const Vector3d from_prior = QuaternionLog<double>(prior.rotation * state.rotation.conjugate());
    for (int k = 0; k < 3; ++k) {
      if (is_given) AddPrior(k, from_prior[k], given.rotation_sigma_rad, &information, &gradient);
      AddPrior(4 + k, -state.bias[k], given.noise.gyro_bias_sigma, &information, &gradient);
    }
    AddPrior(3, prior.offset_s - state.offset_s, given.time_offset_sigma_s, &information,
             &gradient);
    information.diagonal().array() += 1e-9;  // unobservable rotations stay
    const Eigen::LDLT<Eigen::MatrixXd> solver(information);
    const Vector7d step = solver.solve(gradient);
    state.rotation =
        (QuaternionExp<double>(Vector3d(step.head<3>())) * state.rotation).normalized();
    state.offset_s += std::clamp(step[3], -2 * kOffsetStep_s, 2 * kOffsetStep_s);
    state.bias += step.tail<3>();
    covariance = solver.solve(Matrix7d::Identity());
  }
  alignment.calibration.camera_from_imu.rotation = state.rotation;
  alignment.calibration.rotation_sigma_rad =
      std::sqrt(covariance.topLeftCorner<3, 3>().diagonal().maxCoeff());
  alignment.calibration.time_offset_s = state.offset_s;
  alignment.calibration.time_offset_sigma_s = std::sqrt(covariance(3, 3));
  alignment.gyro_bias_rad_per_s = state.bias;
  alignment.gyro_bias_sigma_rad_per_s =
      std::sqrt(covariance.bottomRightCorner<3, 3>().diagonal().maxCoeff());
  alignment.is_known = alignment.calibration.rotation_sigma_rad < kMaxRotationSigma;
  return alignment;
}

}  // namespace surfit
