#include "run/results/localization.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>

#include "core/median.h"
#include "surfit/core/error.h"
#include "surfit/geometry/sensor.h"

namespace surfit {
namespace {

// Largest standard deviation over all directions. The factor shared_points accounts for correlated
// errors.
double LargestSigma(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance, Eigen::EigenvaluesOnly);
  if (eigen.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  return std::sqrt(std::max(0., eigen.eigenvalues()[2]) * EdgeNoise().shared_points);
}

std::string RowOf(int index, double stamp_s, const std::string& state) {
  std::ostringstream row;
  row << index << ',' << std::fixed << std::setprecision(6) << stamp_s << ',' << state;
  return row.str();
}

}  // namespace

LocalizationFile::LocalizationFile(const std::string& path, bool mirrored)
    : file_(path), mirrored_(mirrored) {
  file_.Append("index,stamp_s,state,tx,ty,tz,qx,qy,qz,qw,sigma_m,sigma_rad\n");
}

void LocalizationFile::Add(const FrameReport& report) {
  if (report.confirmed) {
    ++summary_.frames;
    file_.Append(RowOf(report.confirmed->index, report.confirmed->stamp_s, "confirmed") +
                 TextOf(report.confirmed->world_from_camera) + ",,\n");
  }
  const bool has_pose = report.HasPose();
  if (!has_pose && !is_lost_) lost_since_s_ = report.stamp_s;
  if (has_pose && is_lost_) {
    summary_.longest_loss_s = std::max(summary_.longest_loss_s, report.stamp_s - lost_since_s_);
  }
  is_lost_ = !has_pose;
  const std::string begin = RowOf(report.index, report.stamp_s, ToString(report.state));
  if (!has_pose) return file_.Append(begin + ",,,,,,,,,\n");
  ++summary_.frames;
  summary_.relocalisations += report.state == FrameState::kRelocalized;
  const std::string pose = TextOf(report.world_from_camera);
  if (!report.icp.covariance) return file_.Append(begin + pose + ",,\n");
  sigmas_rad_.push_back(LargestSigma(report.icp.covariance->topLeftCorner<3, 3>()));
  sigmas_m_.push_back(LargestSigma(report.icp.covariance->bottomRightCorner<3, 3>()));
  file_.Append(Concat(begin, pose, ',', sigmas_m_.back(), ',', sigmas_rad_.back(), '\n'));
}

std::string LocalizationFile::TextOf(const Rigid3d& world_from_camera) const {
  const Rigid3d pose = mirrored_ ? Mirrored(world_from_camera) : world_from_camera;
  std::ostringstream text;
  text << std::fixed << std::setprecision(9);
  for (const double number : pose.translation) text << ',' << number;
  for (const double number : pose.rotation.coeffs()) text << ',' << number;
  return text.str();
}

Localization LocalizationFile::Summary() const {
  Localization summary = summary_;
  summary.median_sigma_m = MedianOf(sigmas_m_);
  summary.median_sigma_rad = MedianOf(sigmas_rad_);
  return summary;
}

}  // namespace surfit
