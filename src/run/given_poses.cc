#include "run/given_poses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr int kViewColumns = 80;     // approximate width of the compared images, px
constexpr int kFramesPerTurn = 5;    // frames between comparisons
constexpr int kMaxComparisons = 90;  // bounds the time for long sequences
constexpr std::array<std::size_t, 3> kGaps = {1, 8, 30};  // frames between two compared frames
// Depth agrees within kSame_m + kSameRatio * depth. Poses of other programs are off by 1 to 3 cm.
constexpr float kSame_m = 0.02F, kSameRatio = 0.02F;
constexpr int kMinComparisons = 3;
// Poses contradict the depth if another motion explains 1 / kContradiction times as much depth, and
// more depth in kMostComparisons of the comparisons.
constexpr double kContradiction = 0.85, kMostComparisons = 0.8;

enum class CameraAxes { kOptical, kOpenGl, kRos };

// Convention of a pose file.
struct PoseConvention {
  bool is_w_first = false;
  bool is_inverse = false;
  CameraAxes axes = CameraAxes::kOptical;
  double scale = 1;
};

// All conventions, beginning with the one that is used.
const std::vector<PoseConvention>& Conventions() {
  static const auto* const all = [] {
    auto* list = new std::vector<PoseConvention>;
    for (const double scale : {1., 0.001}) {
      for (const bool is_w_first : {false, true}) {
        for (const bool is_inverse : {false, true}) {
          for (const CameraAxes axes :
               {CameraAxes::kOptical, CameraAxes::kOpenGl, CameraAxes::kRos})
            list->push_back({is_w_first, is_inverse, axes, scale});
        }
      }
    }
    return list;
  }();
  return *all;
}

std::string NameOf(const PoseConvention& c) {
  std::vector<std::string> parts;
  if (c.is_w_first) parts.emplace_back("quaternions have w first (qw qx qy qz)");
  if (c.is_inverse) parts.emplace_back("poses are the inverse, world-to-camera");
  if (c.axes == CameraAxes::kOpenGl)
    parts.emplace_back("the camera has the axes of OpenGL (y up, z back)");
  if (c.axes == CameraAxes::kRos)
    parts.emplace_back("the camera has the axes of ROS (x forward, z up)");
  if (c.scale != 1) parts.emplace_back("translations are in mm");
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", and ") + part;
  return text;
}

// Rotation of optical axes in other camera axes.
Eigen::Quaterniond AxesFromOptical(CameraAxes axes) {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  if (axes == CameraAxes::kOpenGl) rotation = Eigen::Vector3d(1, -1, -1).asDiagonal();
  if (axes == CameraAxes::kRos) rotation << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return Eigen::Quaterniond(rotation);
}

// Pose of the optical camera, if the file has another convention.
Rigid3d Reread(const Rigid3d& pose, const PoseConvention& convention) {
  Rigid3d read = pose;
  const Eigen::Vector4d q = pose.rotation.coeffs();  // columns of the file
  if (convention.is_w_first) read.rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
  read.translation *= convention.scale;
  if (convention.is_inverse) read = read.Inverse();
  read.rotation = read.rotation * AxesFromOptical(convention.axes);
  return read;
}

Image<float> Subsampled(const Image<float>& depth_m, int step) {
  Image<float> small((depth_m.width() + step - 1) / step, (depth_m.height() + step - 1) / step);
  for (int v = 0; v < small.height(); ++v) {
    for (int u = 0; u < small.width(); ++u) small(u, v) = depth_m(u * step, v * step);
  }
  return small;
}

// Ratio of the depth of `from` that agrees with the depth of `to`. Points without measured depth in
// `to` are ignored. Points outside of the image contradict.
double AgreementOf(const Image<float>& from, const Image<float>& to, const Rigid3d& to_from_from,
                   const PinholeCamera& camera) {
  int compared = 0, agreeing = 0;
  const Eigen::Matrix3d rotation = to_from_from.rotation.toRotationMatrix();
  for (int v = 0; v < from.height(); ++v) {
    for (int u = 0; u < from.width(); ++u) {
      if (!(from(u, v) > 0)) continue;
      const Eigen::Vector3d point =
          rotation * (camera.Ray(u, v) * from(u, v)) + to_from_from.translation;
      ++compared;
      if (!(point.z() > 0)) continue;
      const Eigen::Vector2d pixel = camera.Project(point).array().round();
      if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < to.width() && pixel.y() < to.height()))
        continue;
      const float depth_m = to(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
      if (!(depth_m > 0)) {
        --compared;
      } else if (std::abs(depth_m - static_cast<float>(point.z())) <
                 kSame_m + kSameRatio * depth_m) {
        ++agreeing;
      }
    }
  }
  return compared > 0 ? static_cast<double>(agreeing) / compared : 0;
}

}  // namespace

GivenPoseCheck::GivenPoseCheck(const PinholeCamera& camera)
    : step_(std::max(1, camera.width / kViewColumns)), agreements_(Conventions().size()) {
  camera_ = camera.Subsampled(step_);
}

void GivenPoseCheck::Add(const RgbdFrame& frame, const Rigid3d& world_from_camera) {
  if (comparisons_ >= kMaxComparisons) return;
  View view = {Subsampled(frame.depth_m, step_), world_from_camera};
  if (count_++ % kFramesPerTurn == 0) {
    for (const std::size_t gap : kGaps) {
      if (gap <= views_.size()) Compare(views_[views_.size() - gap], view);
    }
  }
  views_.push_back(std::move(view));
  if (views_.size() > kGaps.back()) views_.pop_front();
}

void GivenPoseCheck::Compare(const View& from, const View& to) {
  const std::vector<PoseConvention>& conventions = Conventions();
  for (std::size_t i = 0; i < conventions.size(); ++i) {
    const Rigid3d to_from_from = Reread(to.world_from_camera, conventions[i]).Inverse() *
                                 Reread(from.world_from_camera, conventions[i]);
    Count(AgreementOf(from.depth_m, to.depth_m, to_from_from, camera_), &agreements_[i]);
  }
  Count(AgreementOf(from.depth_m, to.depth_m, Rigid3d(), camera_), &without_motion_);
  ++comparisons_;
}

void GivenPoseCheck::Count(double ratio, Agreement* agreement) {
  if (agreement == &agreements_.front()) given_ = ratio;
  agreement->sum += ratio;
  agreement->better += ratio > given_;
}

bool GivenPoseCheck::IsBetter(const Agreement& agreement) const {
  return agreements_.front().sum < kContradiction * agreement.sum &&
         agreement.better >= kMostComparisons * comparisons_;
}

std::optional<std::string> GivenPoseCheck::Warning() const {
  if (comparisons_ < kMinComparisons) return std::nullopt;
  const auto best =
      std::max_element(agreements_.begin(), agreements_.end(),
                       [](const Agreement& a, const Agreement& b) { return a.sum < b.sum; });
  const bool is_other = IsBetter(*best) && best->sum > without_motion_.sum;
  if (!is_other && !IsBetter(without_motion_)) return std::nullopt;
  const auto percent = [&](const Agreement& agreement) {
    return Concat(std::lround(100 * agreement.sum / comparisons_), " %");
  };
  const std::string told =
      Concat("the given poses contradict the depth images: ", percent(agreements_.front()),
             " of the depth agrees between frames. ");
  if (is_other)
    return Concat(told, percent(*best), " agrees if ",
                  NameOf(Conventions()[best - agreements_.begin()]));
  return Concat(told, percent(without_motion_),
                " agrees for a camera that does not move. Poses must be camera-to-world of the "
                "optical camera (x right, y down, z forward), in m, with qx qy qz qw: no other "
                "convention agrees either");
}

}  // namespace surfit
