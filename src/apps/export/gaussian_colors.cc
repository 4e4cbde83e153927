#include <algorithm>
#include <cmath>
#include <cstdint>

#include "apps/export/gaussians.h"
#include "surfit/core/parallel.h"
#include "surfit/mapping/surfel_block.h"

namespace surfit {
namespace {

constexpr int kMaxColumns = 320;
constexpr int kRows = 16;  // of a band
constexpr int kSteps = 4;
constexpr float kDilation_px2 = 0.3f;
constexpr float kNearest_m = 0.2f;
constexpr float kMinAlpha = 1.f / 255, kMaxAlpha = 0.99f;
constexpr float kMaxBackground = 0.5f;  // weight of the background in a pixel
constexpr float kMinWeight = 0.1f;      // sum of weights, px

// Projected Gaussian.
struct Splat {
  float z, u, v;     // m, px
  float aa, ab, bb;  // -d^2 / 2 = aa du^2 + ab du dv + bb dv^2
  std::int32_t gaussian;
  std::int16_t u_begin, u_end, v_begin, v_end;
};

// Splat with an empty rectangle if the view does not show the Gaussian.
Splat Project(const Gaussian& gaussian, std::int32_t index, const GaussianView& view,
              const Rigid3f& camera_from_world) {
  const PinholeCamera& camera = view.camera;
  Splat splat = {};
  splat.gaussian = index;
  const Eigen::Vector3f p = camera_from_world * gaussian.position_m;
  if (!(p.z() > kNearest_m)) return splat;
  const float fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy);
  splat.z = p.z();
  splat.u = fx * p.x() / p.z() + static_cast<float>(camera.cx);
  splat.v = fy * p.y() / p.z() + static_cast<float>(camera.cy);
  Eigen::Matrix<float, 2, 3> jacobian;
  jacobian << fx / p.z(), 0, -fx * p.x() / (p.z() * p.z()), 0, fy / p.z(),
      -fy * p.y() / (p.z() * p.z());
  // The covariance is sigma^2 (I - (1 - flatness^2) n n^T).
  const Eigen::Vector2f n = jacobian * (camera_from_world.rotation * gaussian.normal);
  const float sigma2 = gaussian.sigma_m * gaussian.sigma_m;
  const Eigen::Matrix2f covariance =
      sigma2 * (jacobian * jacobian.transpose() - (1 - kFlatness * kFlatness) * n * n.transpose()) +
      view.dilation_px2 * Eigen::Matrix2f::Identity();
  const float half_trace = covariance.trace() / 2, determinant = covariance.determinant();
  const float eigenvalue =
      half_trace + std::sqrt(std::max(0.f, half_trace * half_trace - determinant));
  const float reach = 3 * std::sqrt(eigenvalue);
  if (!(determinant > 0) || !(reach < 1e4f) || !(std::abs(splat.u) < 1e4f) ||
      !(std::abs(splat.v) < 1e4f)) {
    return splat;
  }
  splat.aa = -0.5f * covariance(1, 1) / determinant;
  splat.ab = covariance(0, 1) / determinant;
  splat.bb = -0.5f * covariance(0, 0) / determinant;
  const auto clamp = [](float x, int end) {
    return static_cast<std::int16_t>(std::clamp(x, 0.f, static_cast<float>(end)));
  };
  splat.u_begin = clamp(std::ceil(splat.u - reach), camera.width);
  splat.u_end = clamp(std::floor(splat.u + reach) + 1, camera.width);
  splat.v_begin = clamp(std::ceil(splat.v - reach), camera.height);
  splat.v_end = clamp(std::floor(splat.v + reach) + 1, camera.height);
  return splat;
}

// Visible splats from front to back.
std::vector<Splat> SplatsOf(const std::vector<Gaussian>& gaussians, const GaussianView& view) {
  const Rigid3f camera_from_world = view.world_from_camera.Inverse().cast<float>();
  std::vector<Splat> splats(gaussians.size());
  constexpr int kChunk = 4096;
  ParallelFor(0, static_cast<int>(gaussians.size()), kChunk, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) splats[i] = Project(gaussians[i], i, view, camera_from_world);
  });
  splats.erase(
      std::remove_if(splats.begin(), splats.end(),
                     [](const Splat& s) { return s.u_begin >= s.u_end || s.v_begin >= s.v_end; }),
      splats.end());
  std::sort(splats.begin(), splats.end(), [](const Splat& a, const Splat& b) {
    return a.z != b.z ? a.z < b.z : a.gaussian < b.gaussian;
  });
  return splats;
}

// Sums of a Gaussian over pixels.
struct ColorSums {
  std::int32_t gaussian = 0;
  Eigen::Vector3f residual = Eigen::Vector3f::Zero();
  float weight = 0;
};

// Draws the splats in the rows of one band.
class SplatBand {
 public:
  SplatBand(int band, const GaussianView& view, const std::vector<Splat>& splats)
      : view_(view),
        splats_(splats),
        v_begin_(band * kRows),
        v_end_(std::min(view.camera.height, v_begin_ + kRows)) {}

  std::vector<ColorSums> SumsOf(const std::vector<Gaussian>& gaussians) {
    const int width = view_.camera.width;
    std::vector<Eigen::Vector3f> residuals;
    for (int v = v_begin_; v < v_end_; ++v) {
      for (int u = 0; u < width; ++u) {
        const Rgb8 color = view_.color(u, v);
        residuals.emplace_back(Eigen::Vector3f(color.r, color.g, color.b) / 255.f);
      }
    }
    ForEachWeight([&](const Splat& splat, std::size_t pixel, float weight) {
      residuals[pixel] -= weight * gaussians[splat.gaussian].color;
    });
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      if (background_[i] > kMaxBackground) residuals[i].setZero();
    }
    std::vector<ColorSums> sums;
    ForEachWeight([&](const Splat& splat, std::size_t pixel, float weight) {
      if (sums.empty() || sums.back().gaussian != splat.gaussian) {
        sums.push_back({splat.gaussian});
      }
      sums.back().residual += weight * residuals[pixel];
      sums.back().weight += weight;
    });
    return sums;
  }

 private:
  template <typename F>
  void ForEachWeight(const F& f) {
    const int width = view_.camera.width;
    background_.assign(static_cast<std::size_t>(v_end_ - v_begin_) * width, 1.f);
    for (const Splat& splat : splats_) {
      const int begin = std::max<int>(v_begin_, splat.v_begin);
      const int end = std::min<int>(v_end_, splat.v_end);
      for (int v = begin; v < end; ++v) {
        const float dv = static_cast<float>(v) - splat.v;
        for (int u = splat.u_begin; u < splat.u_end; ++u) {
          const float du = static_cast<float>(u) - splat.u;
          const float power = du * (splat.aa * du + splat.ab * dv) + splat.bb * dv * dv;
          const float alpha = std::min(kMaxAlpha, kGaussianOpacity * std::exp(power));
          if (alpha < kMinAlpha) continue;
          const std::size_t pixel = static_cast<std::size_t>(v - v_begin_) * width + u;
          f(splat, pixel, alpha * background_[pixel]);
          background_[pixel] *= 1 - alpha;
        }
      }
    }
  }

  const GaussianView& view_;
  const std::vector<Splat>& splats_;
  const int v_begin_, v_end_;
  std::vector<float> background_;  // weight of the background per pixel
};

void AddView(const GaussianView& view, const std::vector<Gaussian>& gaussians,
             std::vector<ColorSums>* sums) {
  const std::vector<Splat> splats = SplatsOf(gaussians, view);
  std::vector<std::vector<ColorSums>> of_band((view.camera.height + kRows - 1) / kRows);
  ParallelFor(0, static_cast<int>(of_band.size()), 1, [&](int band, int) {
    of_band[band] = SplatBand(band, view, splats).SumsOf(gaussians);
  });
  for (const std::vector<ColorSums>& band : of_band) {
    for (const ColorSums& found : band) {
      ColorSums& sum = (*sums)[found.gaussian];
      sum.residual += found.residual;
      sum.weight += found.weight;
    }
  }
}

}  // namespace

GaussianView ReducedView(const Image<Rgb8>& color, PinholeCamera camera,
                         const Rigid3d& world_from_camera) {
  const int step = (camera.width + kMaxColumns - 1) / kMaxColumns;
  camera.width /= step;
  camera.height /= step;
  camera.fx /= step;
  camera.fy /= step;
  camera.cx = (camera.cx + 0.5) / step - 0.5;
  camera.cy = (camera.cy + 0.5) / step - 0.5;
  GaussianView view = {Image<Rgb8>(camera.width, camera.height), camera,
                       kDilation_px2 / static_cast<float>(step * step), world_from_camera};
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (int i = 0; i < step * step; ++i) {
        const Rgb8 pixel = color(u * step + i % step, v * step + i / step);
        sum += Eigen::Vector3f(pixel.r, pixel.g, pixel.b);
      }
      view.color(u, v) = ToRgb8(sum / static_cast<float>(step * step));
    }
  }
  return view;
}

void FitColors(const std::vector<GaussianView>& views,
               const std::function<void(int, int)>& progress, std::vector<Gaussian>* gaussians) {
  const int all = kSteps * static_cast<int>(views.size());
  int drawn = 0;
  for (int step = 0; step < kSteps; ++step) {
    std::vector<ColorSums> sums(gaussians->size());
    for (const GaussianView& view : views) {
      AddView(view, *gaussians, &sums);
      progress(++drawn, all);
    }
    for (std::size_t i = 0; i < sums.size(); ++i) {
      if (sums[i].weight < kMinWeight) continue;
      Eigen::Vector3f& color = (*gaussians)[i].color;
      color = (color + sums[i].residual / sums[i].weight).cwiseMax(0.f).cwiseMin(1.f);
    }
  }
}

}  // namespace surfit
