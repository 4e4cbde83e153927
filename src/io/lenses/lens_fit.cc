#include "io/lenses/lens_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>

#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr int kLensGrid = 40;  // rows and columns of sampled pixels
constexpr double kMaxLensError_px = 0.5;
constexpr int kNewtonSteps = 30;          // of Newton's method
constexpr double kDerivativeStep = 1e-6;  // of numeric derivatives
constexpr double kSolved = 1e-9;          // residual of an inverted lens

using Lens2 = std::function<Eigen::Vector2d(const Eigen::Vector2d&)>;

Lens2 RationalLens(std::vector<double> n) {
  n.resize(12, 0);
  return [n](const Eigen::Vector2d& ray) {
    const double x = ray.x(), y = ray.y(), r2 = ray.squaredNorm();
    const double k =
        (1 + r2 * (n[0] + r2 * (n[1] + r2 * n[4]))) / (1 + r2 * (n[5] + r2 * (n[6] + r2 * n[7])));
    return Eigen::Vector2d(
        x * k + 2 * n[2] * x * y + n[3] * (r2 + 2 * x * x) + r2 * (n[8] + r2 * n[9]),
        y * k + n[2] * (r2 + 2 * y * y) + 2 * n[3] * x * y + r2 * (n[10] + r2 * n[11]));
  };
}

Lens2 FisheyeLens(const std::vector<double>& n) {
  return [n](const Eigen::Vector2d& ray) {
    const double r = ray.norm();
    if (r < 1e-12) return ray;
    const double a = std::atan(r), a2 = a * a;
    const double bent = a * (1 + a2 * (n[0] + a2 * (n[1] + a2 * (n[2] + a2 * n[3]))));
    return Eigen::Vector2d(ray * (bent / r));
  };
}

// Ray with this image under the lens, by Newton's method. Returns false without convergence.
bool Invert(const Lens2& lens, const Eigen::Vector2d& image, Eigen::Vector2d* ray) {
  *ray = image;
  for (int i = 0; i < kNewtonSteps; ++i) {
    const Eigen::Vector2d error = lens(*ray) - image;
    if (!error.allFinite()) return false;
    if (error.norm() < kSolved) return true;
    Eigen::Matrix2d slope;
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2d step = kDerivativeStep * Eigen::Vector2d::Unit(axis);
      slope.col(axis) = (lens(*ray + step) - lens(*ray - step)) / (2 * kDerivativeStep);
    }
    if (!(slope.determinant() > 1e-6)) return false;
    *ray -= slope.inverse() * error;
  }
  return false;
}

Lens2 LensOf(const std::string& model, const std::vector<double>& numbers,
             const std::string& what) {
  if (model == "fisheye" || model == "equidistant") {
    ThrowIf(numbers.size() != 4, what, ": the distortion model '", model, "' has ", numbers.size(),
            " coefficients, must have 4");
    return FisheyeLens(numbers);
  }
  ThrowIf(model != "rational" && model != "rational_polynomial" && model != "thin_prism", what,
          ": the distortion model is '", model,
          "', must be plumb_bob with 5 coefficients, rational_polynomial with 8 or 12, or "
          "equidistant (fisheye) with 4; rectify the images and set intrinsics");
  ThrowIf(numbers.size() != 8 && numbers.size() != 12, what, ": the distortion model '", model,
          "' has ", numbers.size(), " coefficients, must have 8 or 12");
  return RationalLens(numbers);
}

// Terms of the model of PinholeCamera that are linear in k1 k2 p1 p2 k3, as rows for x and y.
Eigen::Matrix<double, 2, 5> TermsAt(const Eigen::Vector2d& ray) {
  const double x = ray.x(), y = ray.y(), r2 = ray.squaredNorm();
  Eigen::Matrix<double, 2, 5> terms;
  terms << x * r2, x * r2 * r2, 2 * x * y, r2 + 2 * x * x, x * r2 * r2 * r2,  //
      y * r2, y * r2 * r2, r2 + 2 * y * y, 2 * x * y, y * r2 * r2 * r2;
  return terms;
}

}  // namespace

std::array<double, 5> FitDistortion(const std::string& model, const std::vector<double>& numbers,
                                    const PinholeCamera& camera, const std::string& what) {
  const Lens2 lens = LensOf(model, numbers, what);
  std::vector<Eigen::Vector2d> rays, images;
  for (int row = 0; row <= kLensGrid; ++row) {
    for (int column = 0; column <= kLensGrid; ++column) {
      const Eigen::Vector2d image(
          ((camera.width - 1.) * column / kLensGrid - camera.cx) / camera.fx,
          ((camera.height - 1.) * row / kLensGrid - camera.cy) / camera.fy);
      Eigen::Vector2d ray;
      // The corners of a fisheye image can be outside of the lens.
      if (!Invert(lens, image, &ray)) continue;
      rays.push_back(ray);
      images.push_back(image);
    }
  }
  const auto count = static_cast<Eigen::Index>(rays.size());
  ThrowIf(count < kLensGrid * kLensGrid / 2, what, ": the distortion model '", model,
          "' has no ray for most pixels: check the coefficients and intrinsics");
  Eigen::Matrix<double, Eigen::Dynamic, 5> terms(2 * count, 5);
  Eigen::VectorXd offsets(2 * count);
  for (Eigen::Index i = 0; i < count; ++i) {
    terms.middleRows<2>(2 * i) = TermsAt(rays[i]);
    offsets.segment<2>(2 * i) = images[i] - rays[i];
  }
  const Eigen::Matrix<double, 5, 1> fit = terms.colPivHouseholderQr().solve(offsets);
  const Eigen::VectorXd errors = terms * fit - offsets;
  double most_px = 0;
  for (Eigen::Index i = 0; i < count; ++i)
    most_px =
        std::max(most_px, std::hypot(camera.fx * errors[2 * i], camera.fy * errors[2 * i + 1]));
  ThrowIf(!(most_px <= kMaxLensError_px), what, ": the distortion model '", model,
          "' differs by up to ", most_px, " px from k1 k2 p1 p2 k3, must be at most ",
          kMaxLensError_px, " px: rectify the images and set intrinsics");
  return {fit[0], fit[1], fit[2], fit[3], fit[4]};
}

}  // namespace surfit
