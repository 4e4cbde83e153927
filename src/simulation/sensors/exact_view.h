#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "surfit/simulation/render.h"

namespace surfit {

// Exact surface of a rendering, per pixel. Keeps references to its arguments.
class ExactView {
 public:
  // Aborts if an image does not have the size of the camera.
  ExactView(const Rendering& exact, const PinholeCamera& camera);

  int width() const { return camera_.width; }
  int height() const { return camera_.height; }
  const PinholeCamera& camera() const { return camera_; }

  bool Contains(int u, int v) const { return u >= 0 && v >= 0 && u < width() && v < height(); }
  bool HasSurface(int u, int v) const { return Depth(u, v) > 0; }
  float Depth(int u, int v) const { return exact_.depth_m(u, v); }
  Rgb8 Color(int u, int v) const { return exact_.color(u, v); }
  Eigen::Vector3f Normal(int u, int v) const { return exact_.normal(u, v); }
  Eigen::Vector3f Point(int u, int v) const {
    return Depth(u, v) * camera_.Ray(u, v).cast<float>();
  }
  double Range(int u, int v) const { return Depth(u, v) * camera_.Ray(u, v).norm(); }
  // Luminance in linear light, from 0 to 1.
  float Reflectance(int u, int v) const { return reflectance_(u, v); }
  const Image<float>& reflectance() const { return reflectance_; }
  // Cosine of the angle of incidence. 0 without a surface.
  double CosIncidence(int u, int v) const {
    const Eigen::Vector3d ray = camera_.Ray(u, v);
    return std::max(0., -Normal(u, v).cast<double>().dot(ray) / ray.norm());
  }
  // Reflectance times cos(incidence): the argument of RangeNoise::Sigma().
  double Reflected(int u, int v) const { return Reflectance(u, v) * CosIncidence(u, v); }

  // Returns whether a depth edge separates two pixels of the image (see StereoOptions). False if
  // a pixel has no surface.
  bool AreApart(int u, int v, int other_u, int other_v, double edge_ratio) const;

 private:
  const Rendering& exact_;
  const PinholeCamera& camera_;
  Image<float> reflectance_;
};

}  // namespace surfit
