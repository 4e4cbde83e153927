#include "mapping/band_canvas.h"

#include <algorithm>
#include <limits>

namespace surfit {
namespace {

constexpr std::int32_t kNone = -1;
constexpr float kClosed = std::numeric_limits<float>::infinity();
constexpr float kOutside = 2;  // more than the offset2 of any pixel on a disc

// Inverse depth of the back of a surface that starts at an inverse depth rho: behind it by the
// thickness of surfaces and 4 sigma of the depth 1 / rho, sigma = inverse_depth_sigma / rho^2.
float BackOfSurface(float rho, float thickness, float inverse_depth_sigma) {
  return rho / (1.f + thickness * rho + 4.f * inverse_depth_sigma / rho);
}

}  // namespace

BandCanvas::BandCanvas(int band, const PosedCamera& camera, const RenderOptions& options)
    : band_(band),
      v_begin_(band * kBandRows),
      v_end_(std::min(camera.height, v_begin_ + kBandRows)),
      camera_(camera),
      options_(options) {
  // Four pixels are read and written back at once, also where a row ends.
  const std::size_t size = static_cast<std::size_t>(v_end_ - v_begin_) * camera.width + 3;
  first_.assign(size, 0.f);
  back_.assign(size, 0.f);
  offset2_.assign(size, kOutside);
  drawn_.assign(size, kNone);
}

void BandCanvas::Draw(const std::vector<DiscList>& lists, Layer layer) {
  const std::size_t begin = discs_.size();
  for (const DiscList& list : lists) {
    for (const Disc& disc : list.In(layer, band_)) {
      if (FindFirst(disc)) discs_.push_back(&disc);
    }
  }
  FindBacks();
  for (std::size_t id = begin; id < discs_.size(); ++id) {
    Pick(*discs_[id], static_cast<std::int32_t>(id));
  }
  CloseDrawnPixels();
}

// Calls f(first of the four in the arrays, DiscRow::Hits) for all pixels of a disc.
template <typename F>
void BandCanvas::ForEachFourPixels(const Disc& stored_disc, const F& f) const {
  const Disc disc = stored_disc;  // in registers: what f writes cannot change it
  const int v_begin = std::max<int>(v_begin_, disc.v_begin);
  const int v_end = std::min<int>(v_end_, disc.v_end);
  const int u_begin = disc.u_begin, u_end = disc.u_end;
  for (int v = v_begin; v < v_end; ++v) {
    const DiscRow row(disc, v);
    const int pixel = (v - v_begin_) * camera_.width;
    for (int u = u_begin; u < u_end; u += 4) f(pixel + u, row.At(u));
  }
}

// Whether the disc is met by a pixel that can still be drawn.
bool BandCanvas::FindFirst(const Disc& disc) {
  const float* back = back_.data();
  float* first = first_.data();
  Int4 met = {};
  ForEachFourPixels(disc, [&](int pixel, const DiscRow::Hits& hits) {
    const Int4 open = hits.met & (hits.rho >= Load4(back + pixel));
    const Float4 before = Load4(first + pixel);
    Store4((open & (hits.rho > before)) ? hits.rho : before, first + pixel);
    met |= open;
  });
  return Any(met);
}

void BandCanvas::FindBacks() {
  const float thickness = options_.surface_thickness_m;
  const float sigma = static_cast<float>(options_.noise.inverse_depth_sigma);
  const float* first = first_.data();
  float* back = back_.data();
  for (std::size_t i = 0, size = back_.size(); i < size; ++i) {
    const float surface = BackOfSurface(first[i], thickness, sigma);
    const bool open = first[i] > 0 && back[i] < kClosed;
    back[i] = open ? surface : back[i];
  }
}

// Draws the disc where it is on the first surface, and closer to the ray than those before.
void BandCanvas::Pick(const Disc& disc, std::int32_t id) {
  const float* back = back_.data();
  float* best = offset2_.data();
  std::int32_t* drawn = drawn_.data();
  ForEachFourPixels(disc, [&](int pixel, const DiscRow::Hits& hits) {
    const Float4 offset2 = hits.across2 / (hits.rho * hits.rho);
    const Float4 before = Load4(best + pixel);
    const Int4 better = hits.met & (hits.rho >= Load4(back + pixel)) & (offset2 < before);
    Store4(better ? offset2 : before, best + pixel);
    Store4(better ? AllLanes(id) : Load4(drawn + pixel), drawn + pixel);
  });
}

void BandCanvas::CloseDrawnPixels() {
  const std::int32_t* drawn = drawn_.data();
  float* back = back_.data();
  for (std::size_t i = 0, size = back_.size(); i < size; ++i) {
    back[i] = drawn[i] == kNone ? back[i] : kClosed;
  }
}

void BandCanvas::WriteTo(ModelView* view) const {
  for (int v = v_begin_; v < v_end_; ++v) {
    const std::int32_t* drawn = &drawn_[(v - v_begin_) * camera_.width];
    for (int u = 0; u < camera_.width; ++u) {
      if (drawn[u] == kNone) continue;
      const Disc& disc = *discs_[drawn[u]];
      view->surface.vertex.Set(u, v, camera_.PointAt(u, v, 1.f / disc.Rho(u, v)));
      view->surface.normal.Set(u, v, {disc.nx, disc.ny, disc.nz});
      view->color(u, v) = {disc.red, disc.green, disc.blue};
      view->surfel_index(u, v) = disc.surfel;
    }
  }
}

}  // namespace surfit
