#include "tracking/motion/prior_poses.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/median.h"
#include "registration/solvers/decompositions.h"

namespace surfit {
namespace {

constexpr int kMinSamples = 32;          // before the first use
constexpr int kMinAgreeingMotions = 16;  // motions that agree before the prior is used
constexpr int kScales = 9;               // windows of 1, 2, 4, ..., 256 motions
constexpr int kMinWindows = 8;           // independent windows for a spread
constexpr double kGateSigmas = 8;
// In shorter windows, a prior that is smoother than the registration is not rejected.
constexpr int kMinSmoothWindow = 32;
// Smallest standard deviations: rounding of pose files.
constexpr std::array<double, 2> kSmallest = {1e-5, 1e-5};  // rad, m

// Windows of the fit of the offset.
constexpr double kMountWindow_s = 0.5;
constexpr int kMinMountWindows = 8;
constexpr int kMountIterations = 8;
constexpr double kMountSigmaRad = 1, kMountSigmaM = 1;  // weak prior: unobservable directions
// The offset changes only if the cost of the fit decreases by this amount. Noise decreases it by
// half of a chi-square variable with 6 degrees of freedom, which is below 11 with 99.9 %.
constexpr double kMountGain = 15;

double SquareOf(const Vector6d& v, int channel) { return v.segment<3>(3 * channel).squaredNorm(); }

Vector6d AsVector(const Rigid3d& motion) {
  Vector6d v;
  v << QuaternionLog<double>(motion.rotation), motion.translation;
  return v;
}

// Mean variances of the components of the increments, without unobservable directions.
std::array<double, 2> MeanVariances(const Matrix6d& information) {
  const Matrix6d loose = SymmetricInverse(Variances(0.1, 0.1));
  const Matrix6d covariance = SymmetricInverse(information + loose);
  return {covariance.diagonal().head<3>().mean(), covariance.diagonal().tail<3>().mean()};
}

// Eigenvector of the largest eigenvalue, by repeated squaring. x if the matrix is 0.
Eigen::Vector3d MainAxis(Eigen::Matrix3d matrix) {
  if (!(matrix.trace() > 0)) return Eigen::Vector3d::UnitX();
  for (int i = 0; i < 10; ++i) {
    matrix /= matrix.trace();
    matrix = matrix * matrix.eval();
  }
  int column = 0;
  matrix.colwise().squaredNorm().maxCoeff(&column);
  return matrix.col(column).normalized();
}

Matrix6d FromVariances(double rad2, double m2) {
  return Variances(std::sqrt(std::max(0., rad2)), std::sqrt(std::max(0., m2)));
}

}  // namespace

PriorPoses::PriorPoses(Trajectory world_from_body) : world_from_body_(std::move(world_from_body)) {}

std::optional<Rigid3d> PriorPoses::BodyMotion(double from_s, double to_s) const {
  const std::optional<Rigid3d> from = InterpolatePose(world_from_body_, from_s);
  const std::optional<Rigid3d> to = InterpolatePose(world_from_body_, to_s);
  if (!from || !to) return std::nullopt;
  return from->Inverse() * *to;
}

void PriorPoses::Add(const RegisteredMotion& motion) {
  const std::optional<Rigid3d> body = BodyMotion(motion.from_s, motion.to_s);
  if (!body || !(motion.to_s > motion.from_s)) {
    ++without_;
    return;
  }
  const bool follows = !samples_.empty() && samples_.back().to_s == motion.from_s;
  Sample sample = {motion.from_s,
                   motion.to_s,
                   0,
                   motion.from_camera_to_camera,
                   *body,
                   MeanVariances(motion.information),
                   motion.model_age_s};
  if (follows) {
    sample.run = samples_.back().run;
    sample.camera = samples_.back().camera * sample.camera;
    sample.body = samples_.back().body * sample.body;
  } else if (!samples_.empty()) {
    sample.run = samples_.back().run + 1;
  }
  samples_.push_back(sample);
  const int count = static_cast<int>(samples_.size());
  if (count < kMinSamples) return;
  if (count >= next_fit_) {
    Fit();
    next_fit_ = std::max(count + 16, count + count / 10);
  }
  UpdateTrust();
}

bool PriorPoses::IsOneRun(int begin, int end) const {
  return begin >= 0 && samples_[begin].run == samples_[end - 1].run;
}

Rigid3d PriorPoses::CameraOver(int begin, int end) const {
  const bool is_first = begin == 0 || samples_[begin - 1].run != samples_[begin].run;
  const Rigid3d& to = samples_[end - 1].camera;
  return is_first ? to : samples_[begin - 1].camera.Inverse() * to;
}

Rigid3d PriorPoses::BodyOver(int begin, int end) const {
  const bool is_first = begin == 0 || samples_[begin - 1].run != samples_[begin].run;
  const Rigid3d& to = samples_[end - 1].body;
  return is_first ? to : samples_[begin - 1].body.Inverse() * to;
}

Rigid3d PriorPoses::PriorOver(int begin, int end) const {
  return body_from_camera_.Inverse() * BodyOver(begin, end) * body_from_camera_;
}

Vector6d PriorPoses::Difference(int begin, int end, const Rigid3d& body_from_camera) const {
  const Rigid3d by_prior = body_from_camera.Inverse() * BodyOver(begin, end) * body_from_camera;
  return AsVector(by_prior.Inverse() * CameraOver(begin, end));
}

// Beyond the largest measured scale, the difference is a random walk.
double PriorPoses::Spread(const SourceNoise& noise, int scale) const {
  const int last = static_cast<int>(noise.spread.size()) - 1;
  const double spread = scale <= last
                            ? noise.spread[scale]
                            : noise.spread[last] * static_cast<double>(1 << (scale - last));
  return spread;
}

// Compares the largest changes of velocity in a window. A jump of the prior differs from an outlier
// of the registration.
bool PriorPoses::IsPriorRougher(int begin, int end, int channel) const {
  double of_prior = 0, of_registered = 0;
  for (int i = std::max(1, begin); i < end; ++i) {
    if (!IsOneRun(i - 1, i + 1)) continue;
    const Vector6d registered = AsVector(CameraOver(i, i + 1)) - AsVector(CameraOver(i - 1, i));
    const Vector6d prior = AsVector(PriorOver(i, i + 1)) - AsVector(PriorOver(i - 1, i));
    of_registered = std::max(of_registered, SquareOf(registered, channel));
    of_prior = std::max(of_prior, SquareOf(prior, channel));
  }
  return of_prior > of_registered;
}

bool PriorPoses::Contradicts(int begin, int end) const {
  int scale = 0;
  while ((1 << scale) < end - begin) ++scale;
  const Vector6d difference = Difference(begin, end, body_from_camera_);
  for (const int channel : {0, 1}) {
    if (SquareOf(difference, channel) >
            kGateSigmas * kGateSigmas * Spread(noise_[channel], scale) &&
        (end - begin >= kMinSmoothWindow || IsPriorRougher(begin, end, channel))) {
      return true;
    }
  }
  return false;
}

std::vector<int> PriorPoses::WindowsOf(int length, int step) const {
  std::vector<int> begins;
  for (int begin = 0; begin + length <= static_cast<int>(samples_.size()); begin += step) {
    if (IsOneRun(begin, begin + length)) begins.push_back(begin);
  }
  return begins;
}

void PriorPoses::Fit() {
  std::vector<double> times;
  for (const Sample& sample : samples_) times.push_back(sample.to_s - sample.from_s);
  frame_s_ = MedianOf(std::move(times));
  MeasureNoise();
  FitMount();
  MeasureNoise();
  ScaleRegistration();
}

// Cauchy cost, which bounds the influence of wrong stretches.
double PriorPoses::MountCost(const Rigid3d& mount, const std::vector<int>& windows,
                             int length) const {
  int scale = 0;
  while ((1 << scale) < length) ++scale;
  double cost = 0;
  for (const int begin : windows) {
    const Vector6d difference = Difference(begin, begin + length, mount);
    cost += std::log1p(SquareOf(difference, 0) / Spread(noise_[0], scale) +
                       SquareOf(difference, 1) / Spread(noise_[1], scale));
  }
  const Vector6d offset = AsVector(mount);
  return cost + SquareOf(offset, 0) / (kMountSigmaRad * kMountSigmaRad) +
         SquareOf(offset, 1) / (kMountSigmaM * kMountSigmaM);
}

// Iteratively reweighted Gauss-Newton over the right increment of the offset.
Rigid3d PriorPoses::RefinedMount(Rigid3d mount, const std::vector<int>& windows, int length) const {
  constexpr double kStep = 1e-6;
  int scale = 0;
  while ((1 << scale) < length) ++scale;
  const Matrix6d weight =
      SymmetricInverse(FromVariances(Spread(noise_[0], scale), Spread(noise_[1], scale)));
  const Matrix6d weak = SymmetricInverse(Variances(kMountSigmaRad, kMountSigmaM));
  for (int iteration = 0; iteration < kMountIterations; ++iteration) {
    Matrix6d hessian = weak;
    Vector6d right_side = -weak * AsVector(mount);
    for (const int begin : windows) {
      const Vector6d residual = Difference(begin, begin + length, mount);
      Matrix6d jacobian;
      for (int i = 0; i < 6; ++i) {
        const Vector6d step = kStep * Vector6d::Unit(i);
        const Rigid3d moved = mount * LeftIncrement<double>(step, Rigid3d());
        jacobian.col(i) = (Difference(begin, begin + length, moved) - residual) / kStep;
      }
      const double cauchy = 1 / (1 + residual.dot(weight * residual));
      hessian += cauchy * jacobian.transpose() * weight * jacobian;
      right_side -= cauchy * jacobian.transpose() * weight * residual;
    }
    mount = mount * LeftIncrement<double>(SolveLdlt(hessian, right_side), Rigid3d());
  }
  return mount;
}

// Rotations between the motions of both sources, and their turns about the main axis. Rotations
// about one axis do not determine this turn.
std::vector<Rigid3d> PriorPoses::MountCandidates(const std::vector<int>& windows,
                                                 int length) const {
  Eigen::Matrix3d of_rotations = Eigen::Matrix3d::Zero(), of_translations = of_rotations;
  Eigen::Matrix3d axes = of_rotations;
  for (const int begin : windows) {
    const Vector6d camera = AsVector(CameraOver(begin, begin + length));
    const Vector6d body = AsVector(BodyOver(begin, begin + length));
    of_rotations += body.head<3>() * camera.head<3>().transpose();
    of_translations += body.tail<3>() * camera.tail<3>().transpose();
    axes += camera.head<3>() * camera.head<3>().transpose();
  }
  std::vector<Rigid3d> candidates = {body_from_camera_};
  const Eigen::Vector3d axis = MainAxis(axes);
  for (const Eigen::Matrix3d& products :
       {Eigen::Matrix3d(of_rotations), Eigen::Matrix3d(of_rotations + of_translations)}) {
    const Eigen::Matrix3d rotation = NearestRotation(products);
    for (int turn = 0; turn < 4; ++turn) {
      const Eigen::AngleAxisd about(turn * EIGEN_PI / 2, axis);
      candidates.emplace_back(Eigen::Matrix3d(rotation * about.toRotationMatrix()),
                              Eigen::Vector3d::Zero());
    }
  }
  return candidates;
}

void PriorPoses::FitMount() {
  const int length = std::max(1, static_cast<int>(std::lround(kMountWindow_s / frame_s_)));
  const std::vector<int> windows = WindowsOf(length, std::max(1, length / 4));
  if (static_cast<int>(windows.size()) < kMinMountWindows) return;
  const double present = MountCost(body_from_camera_, windows, length);
  double best = present - kMountGain;
  const Rigid3d before = body_from_camera_;
  for (const Rigid3d& candidate : MountCandidates(windows, length)) {
    const Rigid3d mount = RefinedMount(candidate, windows, length);
    const double cost = MountCost(mount, windows, length);
    if (!(cost < best)) continue;
    best = cost;
    body_from_camera_ = mount;
  }
  if (body_from_camera_ == before) return;
  is_trusted_ = false;
  checked_from_ = std::max(0, static_cast<int>(samples_.size()) - kMinAgreeingMotions);
  needed_ = kMinAgreeingMotions;
}

void PriorPoses::AddThirdDifferences(int channel, NoiseStatistics* statistics) const {
  for (const int stride : {1, 2}) {
    const auto third = [&](int i, const auto& motion) -> Eigen::Vector3d {
      const Vector6d v = AsVector(motion(i, i + stride)) -
                         2 * AsVector(motion(i + stride, i + 2 * stride)) +
                         AsVector(motion(i + 2 * stride, i + 3 * stride));
      return v.segment<3>(3 * channel);
    };
    std::vector<Eigen::Vector3d> prior, registered;
    std::vector<double> of_prior;
    for (const int i : WindowsOf(3 * stride, 1)) {
      prior.push_back(third(i, [&](int from, int to) { return PriorOver(from, to); }));
      registered.push_back(third(i, [&](int from, int to) { return CameraOver(from, to); }));
      of_prior.push_back(prior.back().squaredNorm());
    }
    (stride == 1 ? statistics->part : statistics->part_of_two) =
        MeasurePriorPart(prior, registered);
    if (stride == 1) statistics->prior_third = QuartileVariance(std::move(of_prior));
  }
}

void PriorPoses::MeasureNoise() {
  double age_s = 0;
  for (const Sample& sample : samples_) age_s += sample.model_age_s / samples_.size();
  for (const int channel : {0, 1}) {
    NoiseStatistics statistics;
    statistics.smallest = kSmallest[channel] * kSmallest[channel];
    statistics.model_age_frames = age_s / frame_s_;
    for (int scale = 0; scale < kScales; ++scale) {
      const int length = 1 << scale;
      std::vector<double> squares;
      for (const int begin : WindowsOf(length, std::max(1, length / 4))) {
        squares.push_back(SquareOf(Difference(begin, begin + length, body_from_camera_), channel));
      }
      const std::size_t independent = squares.size() * std::max(1, length / 4) / length;
      if (scale > 0 && independent < kMinWindows) break;
      statistics.spread.push_back(
          std::max(statistics.smallest, QuartileVariance(std::move(squares))));
      statistics.windows.push_back(static_cast<double>(std::max<std::size_t>(1, independent)));
    }
    AddThirdDifferences(channel, &statistics);
    noise_[channel] = EstimateNoise(statistics);
  }
}

// The last motions are compared over all scales. After a contradiction over n motions, the next 2 n
// motions must agree.
void PriorPoses::UpdateTrust() {
  const int count = static_cast<int>(samples_.size());
  for (int scale = 0; scale < kScales; ++scale) {
    const int begin = count - (1 << scale);
    if (begin < checked_from_ || !IsOneRun(begin, count)) break;
    if (!Contradicts(begin, count)) continue;
    is_trusted_ = false;
    checked_from_ = count;
    needed_ = std::max(kMinAgreeingMotions, 2 << scale);
    return;
  }
  if (count - checked_from_ >= std::max(needed_, kMinAgreeingMotions)) is_trusted_ = true;
}

// Short windows come first, so that a jump rejects one motion only.
const std::vector<PriorPoses::Interval>& PriorPoses::Rejected() const {
  if (rejected_at_ == samples_.size()) return rejected_;
  rejected_at_ = samples_.size();
  rejected_.clear();
  const int count = static_cast<int>(samples_.size());
  if (count < kMinSamples) {
    rejected_.push_back({0, count});
    return rejected_;
  }
  std::vector<int> rejected_before(samples_.size() + 1, 0);
  std::vector<bool> is_rejected(samples_.size(), false);
  for (int scale = 0; scale < kScales; ++scale) {
    const int length = 1 << scale;
    for (int i = 0; i < count; ++i) rejected_before[i + 1] = rejected_before[i] + is_rejected[i];
    for (int begin = 0; begin + length <= count; ++begin) {
      if (rejected_before[begin + length] != rejected_before[begin]) continue;
      if (!IsOneRun(begin, begin + length) || !Contradicts(begin, begin + length)) continue;
      std::fill_n(is_rejected.begin() + begin, length, true);
    }
  }
  for (int i = 0; i < count; ++i) {
    if (!is_rejected[i]) continue;
    if (!rejected_.empty() && rejected_.back().end == i) {
      ++rejected_.back().end;
    } else {
      rejected_.push_back({i, i + 1});
    }
  }
  return rejected_;
}

Matrix6d PriorPoses::PriorCovariance(double seconds) const {
  const double frames = seconds / frame_s_;
  return FromVariances(frames * noise_[0].prior_drift + 2 * noise_[0].prior_noise,
                       frames * noise_[1].prior_drift + 2 * noise_[1].prior_noise);
}

std::optional<PriorMotion> PriorPoses::Trusted(double from_s, double to_s) const {
  if (!is_trusted_ || !(to_s > from_s)) return std::nullopt;
  const std::optional<Rigid3d> body = BodyMotion(from_s, to_s);
  if (!body) return std::nullopt;
  return PriorMotion{body_from_camera_.Inverse() * *body * body_from_camera_,
                     PriorCovariance(to_s - from_s)};
}

std::optional<PriorMotion> PriorPoses::Accepted(double from_s, double to_s) const {
  const auto from = std::lower_bound(
      samples_.begin(), samples_.end(), from_s,
      [](const Sample& sample, double stamp_s) { return sample.from_s < stamp_s; });
  const auto to =
      std::lower_bound(from, samples_.end(), to_s,
                       [](const Sample& sample, double stamp_s) { return sample.to_s < stamp_s; });
  if (from == samples_.end() || to == samples_.end()) return std::nullopt;
  if (from->from_s != from_s || to->to_s != to_s || from->run != to->run) return std::nullopt;
  const int begin = static_cast<int>(from - samples_.begin());
  const int end = static_cast<int>(to - samples_.begin()) + 1;
  for (const Interval& rejected : Rejected()) {
    if (rejected.begin < end && begin < rejected.end) return std::nullopt;
  }
  return PriorMotion{PriorOver(begin, end), PriorCovariance(to_s - from_s)};
}

std::optional<Rigid3d> PriorPoses::CameraAt(double stamp_s) const {
  const std::optional<Rigid3d> body = InterpolatePose(world_from_body_, stamp_s);
  if (!body) return std::nullopt;
  return *body * body_from_camera_;
}

void PriorPoses::ScaleRegistration() {
  for (const int channel : {0, 1}) {
    std::vector<double> variances;
    for (const Sample& sample : samples_) variances.push_back(sample.variance[channel]);
    const double median = MedianOf(std::move(variances));
    registration_scale_.segment<3>(3 * channel)
        .setConstant(std::sqrt(std::max(1., noise_[channel].registered_noise / median)));
  }
}

Matrix6d PriorPoses::RegisteredDrift(double seconds) const {
  const double frames = seconds / frame_s_;
  return FromVariances(frames * noise_[0].registered_drift, frames * noise_[1].registered_drift);
}

Matrix6d PriorPoses::RegistrationNoise() const {
  return FromVariances(noise_[0].registered_bounded, noise_[1].registered_bounded);
}

PriorPoseSummary PriorPoses::Summary() const {
  PriorPoseSummary summary;
  summary.frames_compared = static_cast<int>(samples_.size());
  summary.frames_without = without_;
  summary.frames_used = used_;
  summary.body_from_camera = body_from_camera_;
  if (frame_s_ > 0) {
    summary.sigma_rad = std::sqrt(noise_[0].prior_drift / frame_s_);
    summary.sigma_m = std::sqrt(noise_[1].prior_drift / frame_s_);
  }
  for (const Interval& rejected : Rejected()) {
    summary.rejected.emplace_back(samples_[rejected.begin].to_s, samples_[rejected.end - 1].to_s);
    summary.frames_rejected += rejected.end - rejected.begin;
  }
  return summary;
}

}  // namespace surfit
