#include "surfit/geometry/pinhole_camera.h"

#include <algorithm>
#include <cmath>

#include "surfit/core/error.h"

namespace surfit {

bool PinholeCamera::HasDistortion() const {
  return std::any_of(distortion.begin(), distortion.end(), [](double k) { return k != 0; });
}

void PinholeCamera::Validate(const std::string& what) const {
  const auto require = [&](bool holds, const char* field, double value, const char* constraint) {
    ThrowIf(!holds, what, ": ", field, " is ", value, ", must be ", constraint);
  };
  require(width > 0 && width <= 16384, "width", width, "from 1 to 16384");
  require(height > 0 && height <= 16384, "height", height, "from 1 to 16384");
  require(std::isfinite(fx) && fx > 0, "fx", fx, "finite and positive");
  require(std::isfinite(fy) && fy != 0, "fy", fy, "finite and not zero");
  require(std::isfinite(cx), "cx", cx, "finite");
  require(std::isfinite(cy), "cy", cy, "finite");
  for (const double k : distortion) require(std::isfinite(k), "distortion", k, "finite");
}

PinholeCamera PinholeCamera::Subsampled(int factor) const {
  PinholeCamera c = *this;
  c.width = (width + factor - 1) / factor;
  c.height = (height + factor - 1) / factor;
  c.fx = fx / factor;
  c.fy = fy / factor;
  c.cx = cx / factor;
  c.cy = cy / factor;
  return c;
}

PinholeCamera PinholeCamera::Binned(int factor) const {
  PinholeCamera c = *this;
  c.width = width / factor;
  c.height = height / factor;
  c.fx = fx / factor;
  c.fy = fy / factor;
  c.cx = (cx + 0.5) / factor - 0.5;
  c.cy = (cy + 0.5) / factor - 0.5;
  return c;
}

}  // namespace surfit
