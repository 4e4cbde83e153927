#include "tracking/view_comparison.h"

#include "registration/global/view_fit.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

class ViewProjection {
 public:
  ViewProjection(const FrameLevel& to, const ErrorModel& error_model, const Rigid3d& to_from_view)
      : to_(to),
        error_model_(error_model),
        rotation_(to_from_view.rotation.toRotationMatrix().cast<float>()),
        translation_(to_from_view.translation.cast<float>()) {}

  struct ProjectedPixel {
    Side side = Side::kUnknown;
    int pixel = 0;
  };

  ProjectedPixel Of(const Eigen::Vector3f& vertex, const DepthNoise& noise) const {
    if (!(vertex.z() > 0)) return {};
    const Eigen::Vector3f point = rotation_ * vertex + translation_;
    const int pixel = PixelOf(point);
    if (pixel < 0) return {};
    const Eigen::Vector3f surface = At(to_.vertex, pixel), normal = At(to_.normal, pixel);
    if (!(surface.z() > 0) || normal.isZero(0)) return {};
    const double height_m = normal.dot(point - surface);
    const double sigma_m =
        std::hypot(error_model_.Sigma(point.z(), noise), to_.noise.SigmaZ(surface.z()));
    const double bound_m = kFreeSpaceSigmas * sigma_m;
    if (height_m > bound_m) return {Side::kInFront, pixel};
    return {height_m < -bound_m ? Side::kBehind : Side::kAtSurface, pixel};
  }

 private:
  int PixelOf(const Eigen::Vector3f& point) const {
    constexpr float kNearest_m = 0.05f;
    if (!(point.z() > kNearest_m)) return -1;
    const PinholeCamera& camera = to_.camera;
    const double u = camera.fx * point.x() / point.z() + camera.cx + 0.5;
    const double v = camera.fy * point.y() / point.z() + camera.cy + 0.5;
    const bool is_inside = u >= 0 && v >= 0 && u < camera.width && v < camera.height;
    return is_inside ? static_cast<int>(v) * camera.width + static_cast<int>(u) : -1;
  }

  const FrameLevel& to_;
  const ErrorModel& error_model_;
  Eigen::Matrix3f rotation_;
  Eigen::Vector3f translation_;
};

// Correlation. 1 for too few cells or images without texture, where it has no meaning.
double Alike(const CorrelationSums& sums) {
  constexpr double kMinCells = 200, kMinVariance = 0.03 * 0.03;
  const auto variance = [&](double sum, double squares) {
    return squares / sums.count - sum * sum / (sums.count * sums.count);
  };
  const bool tells = sums.count >= kMinCells && variance(sums.a, sums.aa) >= kMinVariance &&
                     variance(sums.b, sums.bb) >= kMinVariance;
  return tells ? sums.Correlation(0) : 1;
}

CorrelationSums CompareBrightness(const FrameLevel& frame, const Image<Rgb8>& color,
                                  const FrameLevel& model, const Image<float>& model_grey,
                                  const ViewProjection& in_frame) {
  CorrelationSums sums;
  const ViewGrid grid(model.camera);
  for (int v = 0; v < grid.height; ++v) {
    for (int u = 0; u < grid.width; ++u) {
      const float model_value = model_grey(u, v);
      if (!(model_value > 0)) continue;
      const auto landing = in_frame.Of(model.vertex(grid.Pixel(u), grid.Pixel(v)), frame.noise);
      if (landing.side != Side::kAtSurface) continue;
      const float value = GreyOf(color[landing.pixel]);
      if (value > 0) sums.Add(model_value, value);
    }
  }
  return sums;
}

}  // namespace

int ViewComparison::CountInFront(const Image<std::uint8_t>& mask) const {
  int count = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) count += mask[i] != 0 && sides[i] == Side::kInFront;
  return count;
}

ViewComparison CompareViews(const FrameLevel& frame, const Image<Rgb8>& color,
                            const FrameLevel& model, const Image<float>& model_grey,
                            const ErrorModel& error_model, const Rigid3d& model_from_frame) {
  const ViewGrid grid(frame.camera);
  const ViewProjection in_model(model, error_model, model_from_frame);
  ViewComparison comparison;
  comparison.sides = Image<Side>(grid.width, grid.height, Side::kUnknown);
  const auto vertex_of = [&](int u, int v) {
    return Eigen::Vector3f(frame.vertex(grid.Pixel(u), grid.Pixel(v)));
  };
  ParallelFor(0, grid.height, kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < grid.width; ++u) {
        comparison.sides(u, v) = in_model.Of(vertex_of(u, v), frame.noise).side;
      }
    }
  });
  for (int v = 0; v < grid.height; ++v) {
    for (int u = 0; u < grid.width; ++u) {
      const Side side = comparison.sides(u, v);
      comparison.points += vertex_of(u, v).z() > 0;
      comparison.compared += side != Side::kUnknown;
      comparison.in_front += side == Side::kInFront;
      comparison.behind += side == Side::kBehind;
    }
  }
  if (!color.empty() && !model_grey.empty()) {
    const ViewProjection in_frame(frame, error_model, model_from_frame.Inverse());
    comparison.alike = Alike(CompareBrightness(frame, color, model, model_grey, in_frame));
  }
  return comparison;
}

}  // namespace surfit
