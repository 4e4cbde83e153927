#include "finishing/color_registration.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <iterator>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "registration/global/view_fit.h"
#include "surfit/core/parallel.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/registration/pose_solver.h"

namespace surfit {
namespace {

constexpr double kKernelWidth = 0.06;      // intensity, from 0 to 1
constexpr double kPointsPerResidual = 25;  // number of points with correlated errors
constexpr int kExposureIterations = 3;
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

// State of a registration.
struct ColorState {
  Rigid3d color_from_drawn;
  Eigen::Vector2d exposure = {1, 0};
};

class ColorRegistration {
 public:
  // `prior`: expected pose of camera from view, with its information.
  ColorRegistration(const Image<float>& image, const std::vector<Point>& points,
                    const DepthSensor& sensor, const CameraMotion& motion, const PriorTerm& prior)
      : image_(image), points_(points), sensor_(sensor), motion_(motion), prior_(prior) {}

  // Makes one Gauss-Newton step. Returns false if fewer than kMinPoints points are visible, or if
  // the step is not finite.
  bool Step(ColorState* state) const {
    System system = SystemAt(*state);
    if (system.points < kMinPoints) return false;
    AddPrior(state->color_from_drawn, &system);
    const Vector8d step = system.hessian.ldlt().solve(-system.gradient);
    if (!step.allFinite()) return false;
    state->color_from_drawn = LeftIncrement<double>(step.head<6>(), state->color_from_drawn);
    state->exposure += step.tail<2>();
    return true;
  }

  // Mean robust cost at a pose, with the best exposure.
  double CostAt(ColorState state) const {
    std::vector<std::optional<Seen>> seen(points_.size());
    ParallelFor(0, static_cast<int>(points_.size()), kPixelGrain, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) seen[i] = SeenFrom(state.color_from_drawn, points_[i]);
    });
    for (int i = 0; i < kExposureIterations; ++i) {
      const ExposureSystem system = ExposureSystemAt(seen, state.exposure);
      const Eigen::Matrix2d hessian = system.hessian + kExposurePrior * Eigen::Matrix2d::Identity();
      state.exposure += hessian.ldlt().solve(-system.gradient);
    }
    const ExposureSystem system = ExposureSystemAt(seen, state.exposure);
    return system.cost / std::max(1, system.points);
  }

 private:
  static constexpr double kExposurePrior = 1;

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

  struct ExposureSystem {
    Eigen::Matrix2d hessian = Eigen::Matrix2d::Zero();
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
    double cost = 0;
    int points = 0;

    ExposureSystem& operator+=(const ExposureSystem& other) {
      hessian += other.hessian;
      gradient += other.gradient;
      cost += other.cost;
      points += other.points;
      return *this;
    }
  };

  // Point seen in the colour image.
  struct Seen {
    Eigen::Vector3d at;     // in the camera at its time of readout
    BilinearSample sample;  // of the image
    double intensity;       // of the point

    double ResidualFor(const Eigen::Vector2d& exposure) const {
      return sample.value - exposure[0] * intensity - exposure[1];
    }
  };

  struct Row {
    double residual;
    Vector8d jacobian;  // derivatives by left perturbation, gain and offset
  };

  // Weight and cost of the Geman-McClure kernel.
  struct Kernel {
    double weight, cost;
  };
  static Kernel KernelAt(double residual) {
    const double share = residual / kKernelWidth, s = 1 + share * share;
    return {1 / (s * s * kKernelWidth * kKernelWidth * kPointsPerResidual), share * share / s};
  }

  System SystemAt(const ColorState& state) const {
    return ParallelSum(0, static_cast<int>(points_.size()), kPixelGrain, System(),
                       [&](int begin, int end) { return SystemOf(begin, end, state); });
  }

  System SystemOf(int begin, int end, const ColorState& state) const {
    System system;
    for (int i = begin; i < end; ++i) {
      const std::optional<Row> row = RowOf(points_[i], state);
      if (!row) continue;
      const double weight = KernelAt(row->residual).weight;
      system.hessian.noalias() += row->jacobian * (weight * row->jacobian).transpose();
      system.gradient += weight * row->residual * row->jacobian;
      ++system.points;
    }
    return system;
  }

  std::optional<Row> RowOf(const Point& point, const ColorState& state) const {
    const std::optional<Seen> seen = SeenFrom(state.color_from_drawn, point);
    if (!seen) return {};
    const Eigen::Vector3d& x = seen->at;
    const double rho = 1 / x.z();
    const double by_u = seen->sample.slope_u * sensor_.camera.fx * rho;
    const double by_v = seen->sample.slope_v * sensor_.camera.fy * rho;
    const Eigen::Vector3d by_x(by_u, by_v, -(by_u * x.x() + by_v * x.y()) * rho);
    Row result;
    result.residual = seen->ResidualFor(state.exposure);
    result.jacobian << x.cross(by_x), by_x, -point.intensity, -1;
    return result;
  }

  std::optional<Seen> SeenFrom(const Rigid3d& color_from_drawn, const Point& point) const {
    const PinholeCamera& camera = sensor_.camera;
    const Eigen::Vector3d here = color_from_drawn * point.at;
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
    return Seen{x, sample, point.intensity};
  }

  static ExposureSystem ExposureSystemAt(const std::vector<std::optional<Seen>>& seen,
                                         const Eigen::Vector2d& exposure) {
    return ParallelSum(0, static_cast<int>(seen.size()), kPixelGrain, ExposureSystem(),
                       [&](int begin, int end) {
                         ExposureSystem system;
                         for (int i = begin; i < end; ++i) {
                           if (!seen[i]) continue;
                           const double residual = seen[i]->ResidualFor(exposure);
                           const Kernel kernel = KernelAt(residual);
                           const Eigen::Vector2d jacobian(-seen[i]->intensity, -1);
                           system.hessian += kernel.weight * jacobian * jacobian.transpose();
                           system.gradient += kernel.weight * residual * jacobian;
                           system.cost += kernel.cost;
                           ++system.points;
                         }
                         return system;
                       });
  }

  void AddPrior(const Rigid3d& color_from_drawn, System* system) const {
    const Vector6d away = FirstOrderIncrement(prior_.target_from_source, color_from_drawn);
    system->hessian.topLeftCorner<6, 6>() += prior_.information;
    system->hessian.diagonal().tail<2>().array() += kExposurePrior;
    system->gradient.head<6>() += prior_.information * away;
  }

  const Image<float>& image_;
  const std::vector<Point>& points_;
  const DepthSensor& sensor_;
  const CameraMotion& motion_;
  const PriorTerm& prior_;
};

}  // namespace

Rigid3d ExtrapolatePose(const Rigid3d& world_from_camera, const CameraMotion& motion,
                        double seconds) {
  Vector6d way;
  way << -seconds * motion.angular_velocity_rad_per_s, -seconds * motion.velocity_m_per_s;
  return world_from_camera * LeftIncrement<double>(way, Rigid3d()).Inverse();
}

BlendedView DrawnDiscs(const ModelView& view, const SurfelMap& map) {
  BlendedView drawn = {ColorsOf(view, map),
                       Image<float>(view.surface.camera.width, view.surface.camera.height)};
  for (int v = 0; v < drawn.depth_m.height(); ++v) {
    for (int u = 0; u < drawn.depth_m.width(); ++u) {
      if (view.surfel_index(u, v) == ModelView::kNoSurfel) continue;
      drawn.depth_m(u, v) = view.surface.vertex(u, v).z();
    }
  }
  return drawn;
}

RegisteredColors RegisterColors(const Image<Rgb8>& color, const BlendedView& drawn,
                                const DepthSensor& sensor, const CameraMotion& motion,
                                const Rigid3d& world_from_drawn, const ExpectedColorPose& expected,
                                const Rigid3d& world_from_compared) {
  const Image<float> grey = Grey(color, color.width() / drawn.color.width());
  const Image<float> grey_drawn = Grey(drawn.color, 1);
  const PriorTerm prior = {expected.world_from_color.Inverse() * world_from_drawn,
                           expected.information};
  RegisteredColors unregistered = {expected.world_from_color};
  ColorState state = {prior.target_from_source};
  RegisteredColors result;
  for (const double smoothing_px : kSmoothings_px) {
    const Image<float> image = Smoothed(grey, smoothing_px);
    const std::vector<Point> points =
        PointsOf(drawn, Smoothed(grey_drawn, smoothing_px), sensor.camera);
    const ColorRegistration registration(image, points, sensor, motion, prior);
    for (int i = 0; i < kIterations; ++i) {
      if (!registration.Step(&state)) return unregistered;
    }
    const bool is_last = smoothing_px == *std::rbegin(kSmoothings_px);
    if (!is_last) continue;
    result.cost_before =
        registration.CostAt({world_from_compared.Inverse() * world_from_drawn, state.exposure});
    result.cost_after = registration.CostAt(state);
  }
  result.world_from_color = world_from_drawn * state.color_from_drawn.Inverse();
  return result;
}

}  // namespace surfit
