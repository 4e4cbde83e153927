#include "simulation/sensors/multipath.h"

#include <algorithm>
#include <cmath>

namespace surfit {
namespace {

constexpr double kLightSpeed = 299792458;  // m/s
constexpr int kPatchesAcross = 24;
constexpr float kMinCosine = 0.05f;  // limits the area of patches at grazing incidence

}  // namespace

// A block of pixels has the solid angle n / (fx fy |ray|^3) for n pixels. At range r and incidence
// i it covers the area solid angle r^2 / cos(i). The light source at the camera has the intensity
// 1, so the patch receives the power area cos(i) / r^2 = solid angle, and reflects its share
// `reflectance`.
Multipath::Multipath(const ExactView& exact, const TofOptions& options)
    : exact_(exact),
      gain_(options.multipath_gain),
      coherence_m_(static_cast<float>(kLightSpeed / (4 * M_PI * options.modulation_hz))) {
  if (gain_ == 0) return;
  const PinholeCamera& camera = exact.camera();
  const int step = std::max(1, camera.width / kPatchesAcross);
  int lane = kLanes;
  for (int v = step / 2; v < camera.height; v += step) {
    for (int u = step / 2; u < camera.width; u += step) {
      if (!exact.HasSurface(u, v)) continue;
      if (lane == kLanes) {
        const Lanes none = Lanes::Zero();
        patches_.push_back({none, none, none, none, none, none, none, Lanes::Ones(), none});
        lane = 0;
      }
      const Eigen::Vector3f point = exact.Point(u, v), normal = exact.Normal(u, v);
      const double range = exact.Range(u, v), ray = camera.Ray(u, v).norm();
      const double solid_angle = step * step / (std::abs(camera.fx * camera.fy) * ray * ray * ray);
      const double cosine = std::max<double>(kMinCosine, exact.CosIncidence(u, v));
      Patches& patches = patches_.back();
      patches.x[lane] = point.x();
      patches.y[lane] = point.y();
      patches.z[lane] = point.z();
      patches.normal_x[lane] = normal.x();
      patches.normal_y[lane] = normal.y();
      patches.normal_z[lane] = normal.z();
      patches.range[lane] = static_cast<float>(range);
      patches.area[lane] = static_cast<float>(solid_angle * range * range / cosine);
      patches.power[lane] = static_cast<float>(exact.Reflectance(u, v) * solid_angle);
      ++lane;
    }
  }
}

// A patch with the diffusely reflected power P irradiates x by P cos cos' / (pi d^2 + area). The
// area in the denominator limits the irradiance near the patch (form factor of a disc). The direct
// irradiance of x is cos(i) / |x|^2.
double Multipath::Bias(int u, int v) const {
  const Eigen::Vector3f point = exact_.Point(u, v), normal = exact_.Normal(u, v);
  const float range = point.norm();
  const float cosine = std::max(kMinCosine, static_cast<float>(exact_.CosIncidence(u, v)));
  Lanes irradiance_sum = Lanes::Zero(), excess_sum = Lanes::Zero();
  for (const Patches& patch : patches_) {
    const Lanes dx = patch.x - point.x(), dy = patch.y - point.y(), dz = patch.z - point.z();
    const Lanes squared = (dx * dx + dy * dy + dz * dz).max(1e-12f);
    const Lanes distance = squared.sqrt();
    const Lanes received = (normal.x() * dx + normal.y() * dy + normal.z() * dz).max(0.f);
    const Lanes emitted =
        (-(patch.normal_x * dx + patch.normal_y * dy + patch.normal_z * dz)).max(0.f);
    const Lanes seen = received * emitted;
    if (!(seen.maxCoeff() > 0)) continue;  // on one plane, or behind it
    const Lanes excess = (0.5f * (patch.range + distance - range)).max(0.f);
    const Lanes irradiance = patch.power * seen * (-0.5f * (excess / coherence_m_).square()).exp() /
                             (squared * (static_cast<float>(M_PI) * squared + patch.area));
    irradiance_sum += irradiance;
    excess_sum += irradiance * excess;
  }
  const double scale = gain_ * range * range / cosine;
  return scale * excess_sum.sum() / (1 + scale * irradiance_sum.sum());
}

}  // namespace surfit
