#include "tracking/inertial/imu_smoother.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "cost_functions/analytic_relative_pose.h"
#include "cost_functions/inertial_motion.h"
#include "cost_functions/pose_manifold.h"
#include "cost_functions/sensor_prior.h"
#include "registration/solvers/decompositions.h"
#include "surfit/core/parallel.h"
#include "tracking/inertial/imu_filter.h"

namespace surfit {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kMinPoses = 5;
constexpr double kMinChain_s = 0.4;
// Frames of a chunk, and frames of its neighbours on both sides.
constexpr std::size_t kChunk = 450, kOverlap = 150;
// Time between two poses of the map, and the time constant of its drift.
constexpr double kMapStep_s = 0.25, kMapTime_s = 10;
// Squared error of a registered pose from which it counts less: 99.9 % of chi-square with 6 degrees
// of freedom.
constexpr double kMaxSquaredError = 22.457744;

// Prior of the biases of the first pose (kMotionSize).
class BiasPrior {
 public:
  explicit BiasPrior(const ImuNoise& noise) : noise_(noise) {}

  template <typename T>
  bool operator()(const T* motion, T* residuals) const {
    for (int k = 0; k < 3; ++k) {
      residuals[k] = motion[3 + k] / noise_.gyro_bias_sigma;
      residuals[3 + k] = motion[6 + k] / noise_.accel_bias_sigma;
    }
    return true;
  }

 private:
  ImuNoise noise_;
};

// Poses [begin, end) as a Ceres problem.
class Chunk {
 public:
  Chunk(const std::vector<ImuSample>& samples, const ImuCalibration& calibration,
        const std::vector<PoseToSmooth>& poses, std::size_t begin, std::size_t end)
      : calibration_(calibration), poses_(end - begin), motions_(end - begin) {
    for (std::size_t i = 0; i < poses_.size(); ++i) AddPose(poses[begin + i], i);
    AddRegistrations(poses, begin);
    Vector3d force = Vector3d::Zero();
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      const PoseToSmooth& pose = poses[begin + i];
      const double stamp_s = pose.stamp_s + calibration.time_offset_s;
      if (const auto sample = InterpolateImu(samples, stamp_s, calibration.noise.max_step_s)) {
        force += pose.world_from_camera.rotation *
                 (calibration.camera_from_imu.rotation * sample->accel_m_per_s2);
      }
      if (i > 0) AddMotion(samples, poses[begin + i - 1], pose, i);
    }
    const Vector3d down = -kGravity_m_per_s2 * force.normalized();
    std::copy(down.data(), down.data() + 3, gravity_.data());
    problem_.AddParameterBlock(gravity_.data(), 3, new ceres::SphereManifold<3>);
    problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<BiasPrior, 6, kMotionSize>(
                                  new BiasPrior(calibration.noise)),
                              nullptr, motions_[0].data());
  }

  // Keeps a pose of the chunk before.
  void Fix(std::size_t i, const Rigid3d& world_from_camera) {
    PoseToBlock(world_from_camera, poses_[i].data());
    problem_.SetParameterBlockConstant(poses_[i].data());
  }

  // Returns false if there is no solution.
  bool Solve() {
    const SingleThreadedLibraries single_threaded;
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    return summary.IsSolutionUsable();
  }

  Rigid3d Pose(std::size_t i) const { return PoseFromBlock(poses_[i].data()); }
  Vector3d Up() const { return -Vector3d(gravity_.data()).normalized(); }

 private:
  void AddPose(const PoseToSmooth& pose, std::size_t i) {
    double* const block = poses_[i].data();
    PoseToBlock(pose.world_from_camera, block);
    problem_.AddParameterBlock(block, kPoseSize, new ProductPoseManifold);
    problem_.AddParameterBlock(motions_[i].data(), kMotionSize);
  }

  // Registered poses are poses in the map. Their residuals are those of an edge from the map.
  void AddRegistrations(const std::vector<PoseToSmooth>& poses, std::size_t begin) {
    maps_.reserve(poses_.size());  // Ceres keeps pointers to the blocks
    double since_s = 0;
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      const PoseToSmooth& pose = poses[begin + i];
      if (!pose.registered) continue;
      const double seconds = maps_.empty() ? kMapStep_s : pose.stamp_s - since_s;
      if (seconds >= kMapStep_s) {
        AddMap(seconds, *pose.registered);
        since_s = pose.stamp_s;
      }
      problem_.AddResidualBlock(
          new AnalyticRelativePose(*pose.registered, InMap(pose.covariance, *pose.registered)),
          new ceres::HuberLoss(std::sqrt(kMaxSquaredError)), maps_.back().data(), poses_[i].data());
    }
  }

  // Adds the next pose of the map. Its drift since the last pose is a random walk. Its drift from
  // the identity has the variance of a random walk over the time constant. Both are the terms of an
  // Ornstein-Uhlenbeck process.
  void AddMap(double seconds, const Rigid3d& map_from_camera) {
    double* const map = maps_.emplace_back().data();
    PoseToBlock(Rigid3d(), map);
    problem_.AddParameterBlock(map, kPoseSize, new ProductPoseManifold);
    const Matrix6d in_all = MapDrift(kMapTime_s * kMapTime_s / seconds);
    problem_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<SensorPrior, 6, kPoseSize>(
            new SensorPrior(Rigid3d(), Rigid3d(), InMap(in_all, map_from_camera))),
        nullptr, map);
    if (maps_.size() == 1) return;
    problem_.AddResidualBlock(
        new AnalyticRelativePose(Rigid3d(), InMap(MapDrift(seconds), map_from_camera)), nullptr,
        maps_[maps_.size() - 2].data(), map);
  }

  // Information in the map of a covariance in the camera frame.
  static PoseInformation InMap(const Matrix6d& covariance, const Rigid3d& map_from_camera) {
    const Matrix6d transform = IncrementTransform(map_from_camera);
    return SymmetricInverse(transform * covariance * transform.transpose());
  }

  // The start of each velocity is that of the camera.
  void AddMotion(const std::vector<ImuSample>& samples, const PoseToSmooth& from,
                 const PoseToSmooth& to, std::size_t i) {
    const double seconds = to.stamp_s - from.stamp_s;
    const Vector3d velocity =
        (to.world_from_camera.translation - from.world_from_camera.translation) / seconds;
    std::copy(velocity.data(), velocity.data() + 3, motions_[i].data());
    if (i == 1) motions_[0] = motions_[1];
    const auto motion =
        PreintegrateImu(samples, from.stamp_s + calibration_.time_offset_s,
                        to.stamp_s + calibration_.time_offset_s, ImuBias(), calibration_.noise);
    problem_.AddResidualBlock(new AnalyticInertialMotion(*motion, calibration_.camera_from_imu),
                              nullptr, poses_[i - 1].data(), motions_[i - 1].data(),
                              poses_[i].data(), motions_[i].data(), gravity_.data());
  }

  ImuCalibration calibration_;
  std::vector<std::array<double, kPoseSize>> poses_;
  std::vector<std::array<double, kMotionSize>> motions_;
  std::vector<std::array<double, kPoseSize>> maps_;  // world_from_map, in the order of time
  std::array<double, 3> gravity_ = {0, 0, 0};
  ceres::Problem problem_;
};

bool AreConnected(const std::vector<ImuSample>& samples, const ImuCalibration& calibration,
                  const PoseToSmooth& from, const PoseToSmooth& to) {
  const double seconds = to.stamp_s - from.stamp_s;
  if (!to.continues || !(seconds > 0 && seconds <= kMaxImuBridge_s)) return false;
  const auto has_sample = [&](const PoseToSmooth& pose) {
    return InterpolateImu(samples, pose.stamp_s + calibration.time_offset_s,
                          calibration.noise.max_step_s)
        .has_value();
  };
  return has_sample(from) && has_sample(to);
}

// Smooths the chain [begin, end). Returns the sum of the up directions of its frames.
Vector3d SmoothChain(const std::vector<ImuSample>& samples, const ImuCalibration& calibration,
                     const std::vector<PoseToSmooth>& poses, std::size_t begin, std::size_t end,
                     std::vector<Rigid3d>* smoothed) {
  Vector3d up = Vector3d::Zero();
  std::size_t solved = 0;  // end of the last chunk with a solution
  for (std::size_t from = begin; from < end; from += kChunk) {
    const std::size_t to = std::min(end, from + kChunk);
    const std::size_t first = from - std::min(from - begin, kOverlap);
    const std::size_t last = std::min(end, to + kOverlap);
    if (last - first < kMinPoses || poses[last - 1].stamp_s - poses[first].stamp_s < kMinChain_s)
      continue;
    Chunk chunk(samples, calibration, poses, first, last);
    for (std::size_t i = first; solved == from && i < from; ++i)
      chunk.Fix(i - first, (*smoothed)[i]);
    if (!chunk.Solve()) continue;
    solved = to;
    for (std::size_t i = from; i < to; ++i) (*smoothed)[i] = chunk.Pose(i - first);
    up += static_cast<double>(to - from) * chunk.Up();
  }
  return up;
}

}  // namespace

SmoothedPoses SmoothByImu(const std::vector<ImuSample>& samples, const ImuCalibration& calibration,
                          const std::vector<PoseToSmooth>& poses) {
  SmoothedPoses smoothed;
  for (const PoseToSmooth& pose : poses)
    smoothed.world_from_camera.push_back(pose.world_from_camera);
  Vector3d longest = Vector3d::Zero();
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= poses.size(); ++i) {
    if (i < poses.size() && AreConnected(samples, calibration, poses[i - 1], poses[i])) continue;
    const Vector3d up =
        SmoothChain(samples, calibration, poses, begin, i, &smoothed.world_from_camera);
    if (up.norm() > longest.norm()) longest = up;
    begin = i;
  }
  if (!longest.isZero(0)) smoothed.up_in_world = longest.normalized();
  return smoothed;
}

}  // namespace surfit
