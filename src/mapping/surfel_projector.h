#pragma once

#include <algorithm>
#include <vector>

#include "mapping/posed_camera.h"
#include "mapping/vector4.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Surfels with less depth than this, those behind the camera included, are not seen.
constexpr float kMinDepth = 0.05f;  // metres

// Where a camera sees four surfels.
struct FourCentres {
  Vector4 position;  // in the camera frame, metres
  Int4 in_front;     // mask; what follows is meaningless for the others
  Float4 rho;        // inverse depth, 1/m
  Float4 u, v;       // px
};

// Brings surfels that follow each other in a map, [begin, end), into a camera's frame and image:
// four at a time, or fewer where the map ends.
class SurfelProjector {
 public:
  SurfelProjector(const SurfelMap& map, const PosedCamera& camera) : map_(map), camera_(camera) {}

  FourCentres Centres(int begin, int end) const {
    FourCentres c;
    c.position = Rotate(camera_.rotation, Load(map_.x, map_.y, map_.z, begin, end));
    c.position.x += camera_.translation.x();
    c.position.y += camera_.translation.y();
    c.position.z += camera_.translation.z();
    c.in_front = (c.position.z > kMinDepth) & (kLanes < end - begin);
    c.rho = 1.f / (c.in_front ? c.position.z : AllLanes(1.f));
    c.u = camera_.fx * c.position.x * c.rho + camera_.cx;
    c.v = camera_.fy * c.position.y * c.rho + camera_.cy;
    return c;
  }
  Vector4 Normals(int begin, int end) const {
    return Rotate(camera_.rotation, Load(map_.nx, map_.ny, map_.nz, begin, end));
  }
  Float4 Radii(int begin, int end) const { return Load(map_.radius_m, begin, end); }

 private:
  static Float4 Load(const std::vector<float>& array, int begin, int end) {
    if (end - begin >= 4) return Load4(&array[begin]);
    Float4 result = {};
    for (int i = begin; i < end; ++i) result[i - begin] = array[i];
    return result;
  }
  static Vector4 Load(const std::vector<float>& x, const std::vector<float>& y,
                      const std::vector<float>& z, int begin, int end) {
    return {Load(x, begin, end), Load(y, begin, end), Load(z, begin, end)};
  }

  const SurfelMap& map_;
  const PosedCamera& camera_;
};

}  // namespace surfit
