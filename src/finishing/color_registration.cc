#include "finishing/color_registration.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "registration/global/view_fit.h"
#include "surfit/core/parallel.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/registration/normal_system.h"

namespace surfit {
namespace {

constexpr double kKernelWidth = 0.06;      // intensity, from 0 to 1
constexpr double kPointsPerResidual = 25;  // number of points with correlated errors
constexpr double kSigma = 0.01;
constexpr double kMinSlope = 0.008;
constexpr int kStride_px = 2;
constexpr int kMinPoints = 500;
constexpr int kPixelGrain = 4096;
// Standard deviation of the image smoothing in each pass. The first pass converges from larger
// errors.
constexpr double kSmoothings_px[] = {2, 0.75};
constexpr int kIterations = 6;

using Vector8d = Eigen::Matrix<double, 8, 1>;
using Matrix8d = Eigen::Matrix<double, 8, 8>;

Image<float> Grey(const Image<Rgb8>& color, int binning) {
  Image<float> grey(color.width(), color.height());
  std::transform(color.begin(), color.end(), grey.begin(), GreyOf);
  Image<float> binned(color.width() / binning, color.height() / binning);
  const cv::Mat from(grey.height(), grey.width(), CV_32F, grey.data());
  cv::Mat to(binned.height(), binned.width(), CV_32F, binned.data());
  cv::resize(from, to, to.size(), 0, 0, cv::INTER_AREA);
  return binned;
}

Image<float> Smoothed(const Image<float>& grey, double smoothing_px) {
  Image<float> smoothed = grey;
  cv::Mat image(smoothed.height(), smoothed.width(), CV_32F, smoothed.data());
  cv::GaussianBlur(image, image, cv::Size(), smoothing_px);
  return smoothed;
}

struct Point {
  Eigen::Vector3d at;
  double intensity;
};

std::vector<Point> PointsOf(const BlendedView& view, const Image<float>& grey,
                            const PinholeCamera& camera) {
  std::vector<Point> points;
  for (int v = kStride_px; v + kStride_px < camera.height; v += kStride_px) {
    for (int u = kStride_px; u + kStride_px < camera.width; u += kStride_px) {
      bool is_seen = true;
      for (const int du : {-1, 0, 1}) {
        for (const int dv : {-1, 0, 1}) {
          is_seen &= view.depth_m(u + du * kStride_px, v + dv * kStride_px) > 0;
        }
      }
      if (!is_seen) continue;
      const double slope_u = 0.5 * (grey(u + 1, v) - grey(u - 1, v));
      const double slope_v = 0.5 * (grey(u, v + 1) - grey(u, v - 1));
      if (!(slope_u * slope_u + slope_v * slope_v > kMinSlope * kMinSlope)) continue;
      points.push_back({view.depth_m(u, v) * camera.Ray(u, v), grey(u, v)});
    }
  }
  return points;
}

class ColorRegistration {
 public:
  ColorRegistration(const Image<float>& image, const std::vector<Point>& points,
                    const DepthSensor& sensor, const CameraMotion& motion)
      : image_(image), points_(points), sensor_(sensor), motion_(motion) {}

  // Makes one Gauss-Newton step. Returns false if fewer than kMinPoints points are visible, or if
  // the step is not finite.
  bool Step(Rigid3d* color_from_expected, Eigen::Vector2d* exposure) const {
    System system = ParallelSum(
        0, static_cast<int>(points_.size()), kPixelGrain, System(),
        [&](int begin, int end) { return SystemOf(begin, end, *color_from_expected, *exposure); });
    if (system.points < kMinPoints) return false;
    AddPrior(*color_from_expected, &system);
    const Vector8d step =
        system.hessian.selfadjointView<Eigen::Lower>().ldlt().solve(-system.gradient);
    if (!step.allFinite()) return false;
    *color_from_expected = LeftIncrement<double>(step.head<6>(), *color_from_expected);
    *exposure += step.tail<2>();
    return true;
  }

 private:
  // `hessian` has the lower triangle only.
  struct System {
    Matrix8d hessian = Matrix8d::Zero();
    Vector8d gradient = Vector8d::Zero();
    int points = 0;

    System& operator+=(const System& other) {
      hessian += other.hessian;
      gradient += other.gradient;
      points += other.points;
      return *this;
    }
  };

  struct Row {
    double residual;
    Vector8d jacobian;  // derivatives by left perturbation, gain and offset
  };

  System SystemOf(int begin, int end, const Rigid3d& color_from_expected,
                  const Eigen::Vector2d& exposure) const {
    System system;
    for (int i = begin; i < end; ++i) {
      const std::optional<Row> row = RowOf(points_[i], color_from_expected, exposure);
      if (!row) continue;
      const double share = row->residual / kKernelWidth, s = 1 + share * share;
      const double weight = 1 / (s * s * kKernelWidth * kKernelWidth * kPointsPerResidual);
      system.hessian.selfadjointView<Eigen::Lower>().rankUpdate(row->jacobian, weight);
      system.gradient += weight * row->residual * row->jacobian;
      ++system.points;
    }
    return system;
  }

  std::optional<Row> RowOf(const Point& point, const Rigid3d& color_from_expected,
                           const Eigen::Vector2d& exposure) const {
    const PinholeCamera& camera = sensor_.camera;
    const Eigen::Vector3d here = color_from_expected * point.at;
    if (!(here.z() > 0)) return {};
    const double row = camera.fy * here.y() / here.z() + camera.cy;
    const double tau = ((row + 0.5) / camera.height - 0.5) * sensor_.readout_s;
    const Eigen::Vector3d x =
        here - tau * (motion_.angular_velocity_rad_per_s.cross(here) + motion_.velocity_m_per_s);
    if (!(x.z() > 0)) return {};
    const double rho = 1 / x.z();
    const double u = camera.fx * x.x() * rho + camera.cx, v = camera.fy * x.y() * rho + camera.cy;
    if (!(u >= 1 && v >= 1 && u <= camera.width - 2 && v <= camera.height - 2)) return {};
    const BilinearSample sample = SampleAt(image_, static_cast<float>(u), static_cast<float>(v));
    const double by_u = sample.slope_u * camera.fx * rho, by_v = sample.slope_v * camera.fy * rho;
    const Eigen::Vector3d by_x(by_u, by_v, -(by_u * x.x() + by_v * x.y()) * rho);
    Row result;
    result.residual = sample.value - exposure[0] * point.intensity - exposure[1];
    result.jacobian << x.cross(by_x), by_x, -point.intensity, -1;
    return result;
  }

  static void AddPrior(const Rigid3d& color_from_expected, System* system) {
    constexpr double kInformation = 1 / (kSigma * kSigma), kOfExposure = 1;
    Vector8d away = Vector8d::Zero();
    away << QuaternionLog(color_from_expected.rotation), color_from_expected.translation, 0, 0;
    system->hessian.diagonal().head<6>().array() += kInformation;
    system->hessian.diagonal().tail<2>().array() += kOfExposure;
    system->gradient += kInformation * away;
  }

  const Image<float>& image_;
  const std::vector<Point>& points_;
  const DepthSensor& sensor_;
  const CameraMotion& motion_;
};

}  // namespace

Rigid3d ExtrapolatePose(const Rigid3d& world_from_camera, const CameraMotion& motion,
                        double seconds) {
  Vector6d way;
  way << -seconds * motion.angular_velocity_rad_per_s, -seconds * motion.velocity_m_per_s;
  return world_from_camera * LeftIncrement<double>(way, Rigid3d()).Inverse();
}

BlendedView RenderDiscs(const SurfelMap& map, const DepthSensor& sensor,
                        const Rigid3d& world_from_view, ModelRenderer* renderer) {
  const ModelView view = renderer->Render(map, sensor, world_from_view);
  BlendedView drawn = {ColorsOf(view, map),
                       Image<float>(sensor.camera.width, sensor.camera.height)};
  for (int v = 0; v < drawn.depth_m.height(); ++v) {
    for (int u = 0; u < drawn.depth_m.width(); ++u) {
      if (view.surfel_index(u, v) == ModelView::kNoSurfel) continue;
      drawn.depth_m(u, v) = view.surface.vertex(u, v).z();
    }
  }
  return drawn;
}

Rigid3d RegisterColors(const Image<Rgb8>& color, const BlendedView& drawn,
                       const DepthSensor& sensor, const CameraMotion& motion,
                       const Rigid3d& world_from_drawn) {
  const Image<float> grey = Grey(color, color.width() / drawn.color.width());
  const Image<float> grey_drawn = Grey(drawn.color, 1);
  Rigid3d color_from_drawn;
  Eigen::Vector2d exposure(1, 0);
  for (const double smoothing_px : kSmoothings_px) {
    const Image<float> image = Smoothed(grey, smoothing_px);
    const std::vector<Point> points =
        PointsOf(drawn, Smoothed(grey_drawn, smoothing_px), sensor.camera);
    const ColorRegistration registration(image, points, sensor, motion);
    for (int i = 0; i < kIterations; ++i) {
      if (!registration.Step(&color_from_drawn, &exposure)) return world_from_drawn;
    }
  }
  return world_from_drawn * color_from_drawn.Inverse();
}

}  // namespace surfit
