#include "mapping/disc_projector.h"

namespace surfit {
namespace {

// Discs closer to edge-on than this sine are not seen: rho_u and rho_v would overflow.
constexpr float kMinSine = 1e-6f;

}  // namespace

Disc FourDiscs::operator[](int k) const {
  Disc disc;
  disc.u = u[k];
  disc.v = v[k];
  disc.rho = rho[k];
  disc.rho_u = rho_u[k];
  disc.rho_v = rho_v[k];
  disc.aa = aa[k];
  disc.ab = ab[k];
  disc.bb = bb[k];
  disc.nx = normal.x[k];
  disc.ny = normal.y[k];
  disc.nz = normal.z[k];
  disc.u_begin = static_cast<std::int16_t>(u_begin[k]);
  disc.u_end = static_cast<std::int16_t>(u_end[k]);
  disc.v_begin = static_cast<std::int16_t>(v_begin[k]);
  disc.v_end = static_cast<std::int16_t>(v_end[k]);
  return disc;
}

bool DiscProjector::Project(int begin, int end, FourDiscs* discs) const {
  const FourCentres centres = surfels_.Centres(begin, end);
  if (!FindCentres(centres, discs)) return false;
  discs->normal = surfels_.Normals(begin, end);
  const Float4 radius = options_.radius_share * surfels_.Radii(begin, end);
  if (!FindPixels(radius, discs)) return false;
  FindShapes(centres.position, radius, discs);
  return Any(discs->seen);
}

bool DiscProjector::FindCentres(const FourCentres& centres, FourDiscs* discs) const {
  const Float4 u = centres.u, v = centres.v;
  const float margin = static_cast<float>(options_.max_half_window_px);
  discs->seen = centres.in_front & (u > -margin) &
                (u < static_cast<float>(camera_.width) + margin) & (v > -margin) &
                (v < static_cast<float>(camera_.height) + margin);
  discs->rho = centres.rho;
  discs->u = discs->seen ? u : Float4{};
  discs->v = discs->seen ? v : Float4{};
  return Any(discs->seen);
}

bool DiscProjector::FindPixels(const Float4& radius, FourDiscs* discs) const {
  const Float4 extent = Min(camera_.fx * radius * discs->rho,
                            AllLanes(static_cast<float>(options_.max_half_window_px)));
  discs->u_begin = Max(Int4{}, Floor(discs->u - extent) + 1);
  discs->v_begin = Max(Int4{}, Floor(discs->v - extent) + 1);
  discs->u_end = Min(AllLanes(camera_.width), Floor(discs->u + extent) + 1);
  discs->v_end = Min(AllLanes(camera_.height), Floor(discs->v + extent) + 1);
  discs->seen &= (discs->u_begin < discs->u_end) & (discs->v_begin < discs->v_end);
  return Any(discs->seen);
}

void DiscProjector::FindShapes(const Vector4& p, const Float4& radius, FourDiscs* discs) const {
  const Vector4& n = discs->normal;
  const Float4 along = Dot(n, p);
  discs->seen &= along < -kMinSine * p.z;
  const float pixel_x = 1.f / camera_.fx, pixel_y = 1.f / camera_.fy;
  discs->rho_u = pixel_x * n.x / along;
  discs->rho_v = pixel_y * n.y / along;
  const Float4 share = 1.f / radius, a_p = -share * discs->rho_u, b_p = -share * discs->rho_v;
  const Vector4 a = {share * pixel_x + a_p * p.x, a_p * p.y, a_p * p.z};
  const Vector4 b = {b_p * p.x, share * pixel_y + b_p * p.y, b_p * p.z};
  discs->aa = Dot(a, a);
  discs->ab = 2.f * Dot(a, b);
  discs->bb = Dot(b, b);
}

}  // namespace surfit
