#include "apps/export/gaussians.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "io/clouds/ply.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

// Standard deviation relative to the radius of the surfel, and opacity. Larger Gaussians blur.
// The background shines through smaller or fainter Gaussians. With 0.42 and 0.5, the mean PSNR of
// three simulated rooms is 1.0 dB lower.
constexpr float kSigmaRatio = 0.28f;
constexpr float kOpacity = 0.95f;
constexpr float kThicknessRatio =
    0.05f;  // ratio of the standard deviation along the normal to the tangential standard deviation
constexpr float kMinSigma_m = 1e-5f;
constexpr float kHarmonic0 = 0.28209479177387814f;  // spherical harmonic of degree 0
constexpr int kRestCoefficients = 45;               // of degrees 1 to 3

std::vector<PlyProperty> GaussianProperties() {
  std::vector<PlyProperty> properties;
  const auto add = [&](const std::string& name) { properties.push_back({name}); };
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"}) {
    add(name);
  }
  for (int i = 0; i < kRestCoefficients; ++i) add(Concat("f_rest_", i));
  for (const char* name :
       {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"}) {
    add(name);
  }
  return properties;
}

}  // namespace

void WriteGaussians(const std::vector<Surfel>& surfels, const Rigid3d& export_from_world,
                    const std::string& path) {
  const Rigid3f transform = export_from_world.cast<float>();
  const float opacity = std::log(kOpacity / (1 - kOpacity));
  WritePlyVertices(path, surfels.size(), GaussianProperties(), [&](std::size_t i, PlyRow* row) {
    const Surfel& surfel = surfels[i];
    const Eigen::Vector3f position =
        (export_from_world * surfel.position_in_world.cast<double>()).cast<float>();
    const Eigen::Vector3f normal = transform.rotation * surfel.normal_in_world;
    for (const float number : position) row->Put(number);
    for (const float number : normal) row->Put(number);
    for (const std::uint8_t channel : {surfel.color.r, surfel.color.g, surfel.color.b}) {
      row->Put((static_cast<float>(channel) / 255.f - 0.5f) / kHarmonic0);
    }
    for (int k = 0; k < kRestCoefficients; ++k) row->Put(0.f);
    row->Put(opacity);
    const float sigma = std::max(kMinSigma_m, kSigmaRatio * surfel.radius_m);
    row->Put(std::log(sigma));
    row->Put(std::log(sigma));
    row->Put(std::log(kThicknessRatio * sigma));
    const auto rotation = Eigen::Quaternionf::FromTwoVectors(Eigen::Vector3f::UnitZ(), normal);
    row->Put(rotation.w());
    row->Put(rotation.x());
    row->Put(rotation.y());
    row->Put(rotation.z());
  });
}

}  // namespace surfit
