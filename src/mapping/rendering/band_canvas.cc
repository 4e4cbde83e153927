#include "mapping/rendering/band_canvas.h"

#include <glog/logging.h>

#include <algorithm>
#include <cstddef>
#include <limits>

#include "mapping/map/eight_records.h"

namespace surfit {
namespace {

constexpr float kNone = 0;  // index of kNoDisc
constexpr Disc kNoDisc = {0, 0, 0, 0, 0, 0, 0, 0, ModelView::kNoSurfel, 0, 0, 0, 0};
constexpr float kClosed = std::numeric_limits<float>::infinity();
constexpr float kOutside = 2;
constexpr std::size_t kDiscsAhead = 8;
constexpr std::size_t kMaxDiscs = 1 << 24;  // largest count whose indices are exact in a float
constexpr int kLanes = Lanes<float>::kCount;

// Inverse depth of the back of a surface. `rho`: inverse depth of its front. Thickness: `thickness`
// metres plus 4 standard deviations of depth.
float BackOfSurface(float rho, float thickness, float inverse_depth_sigma) {
  return rho / (1.f + thickness * rho + 4.f * inverse_depth_sigma / rho);
}

}  // namespace

BandCanvas::BandCanvas(int band, const PosedCamera& camera, const DepthNoise& noise,
                       const RenderOptions& options)
    : band_(band),
      v_begin_(band * kBandRows),
      v_end_(std::min(camera.height, v_begin_ + kBandRows)),
      camera_(camera),
      noise_(noise),
      options_(options),
      discs_(1, &kNoDisc) {
  // Vector code rewrites up to three pixels after a row, and reads up to seven.
  const std::size_t size = static_cast<std::size_t>(v_end_ - v_begin_ + 1) * camera.width + 7;
  first_.assign(size, 0.f);
  back_.assign(size, 0.f);
  offset2_.assign(size, kOutside);
  drawn_.assign(size, kNone);
}

void BandCanvas::Draw(const std::vector<DiscList>& lists, Layer layer) {
  std::size_t most = discs_.size();
  for (const DiscList& list : lists) most += list[layer].bands.In(band_).size();
  CHECK_LT(most, kMaxDiscs);
  discs_.reserve(most);
  WithInstructions([&](auto instructions) { DrawWith<decltype(instructions)>(lists, layer); });
}

template <typename Instructions>
void BandCanvas::DrawWith(const std::vector<DiscList>& lists, Layer layer) {
  const std::size_t begin = discs_.size();
  for (const DiscList& list : lists) {
    const DiscLayer& in = list[layer];
    const std::vector<int>& numbers = in.bands.In(band_);
    for (std::size_t k = 0, end = numbers.size(); k < end; ++k) {
      __builtin_prefetch(&in.discs[numbers[std::min(k + kDiscsAhead, end - 1)]]);
      const Disc& disc = in.discs[numbers[k]];
      if (FindFirst<Instructions>(disc)) discs_.push_back(&disc);
    }
  }
  FindBacks();
  for (std::size_t id = begin; id < discs_.size(); ++id) {
    Pick<Instructions>(*discs_[id], static_cast<float>(id));
  }
  CloseDrawnPixels();
}

// Updates the nearest surface of the pixels that the disc covers. Returns true if the disc covers a
// pixel without a drawn disc.
template <typename Instructions>
bool BandCanvas::FindFirst(const Disc& disc) {
  using Numbers = Lanes<float, Instructions>;
  using Mask = typename Numbers::Mask;
  const float* back = back_.data();
  float* first = first_.data();
  const int width = camera_.width, band_begin = v_begin_;
  const Numbers closed = kClosed;
  bool met_any = false;
  ForEachEightPixels<Instructions>(
      disc, std::max<int>(v_begin_, disc.v_begin), std::min(v_end_, disc.v_end()),
      [&](int u, int v) {
        const float* at = back + (v - band_begin) * width + u;
        return Numbers::Any(Numbers::LoadHalves(at, at + width) < closed);
      },
      [&](int u, int v, const Mask& met, const Numbers& rho, const Numbers&) {
        const int pixel = (v - band_begin) * width + u, below = pixel + width;
        const Mask open =
            Numbers::Both(met, rho >= Numbers::LoadHalves(back + pixel, back + below));
        const Numbers before = Numbers::LoadHalves(first + pixel, first + below);
        Select(Numbers::Both(open, rho > before), rho, before)
            .StoreHalves(first + pixel, first + below);
        met_any |= Numbers::Any(open);
      });
  return met_any;
}

void BandCanvas::FindBacks() {
  const float thickness = options_.surface_thickness_m;
  const float sigma = static_cast<float>(noise_.inverse_depth_sigma);
  const float* first = first_.data();
  float* back = back_.data();
  for (std::size_t i = 0, size = back_.size(); i < size; ++i) {
    const float surface = BackOfSurface(first[i], thickness, sigma);
    const bool open = first[i] > 0 && back[i] < kClosed;
    back[i] = open ? surface : back[i];
  }
}

// Draws the disc at pixels where it lies on the nearest surface. Among such discs, the disc with
// the smallest centre distance, relative to its radius, wins.
template <typename Instructions>
void BandCanvas::Pick(const Disc& disc, float id) {
  using Numbers = Lanes<float, Instructions>;
  using Mask = typename Numbers::Mask;
  const float* back = back_.data();
  float *best = offset2_.data(), *drawn = drawn_.data();
  const int width = camera_.width, band_begin = v_begin_;
  const Numbers own_id = id;
  ForEachEightPixels<Instructions>(
      disc, std::max<int>(v_begin_, disc.v_begin), std::min(v_end_, disc.v_end()),
      [](int, int) { return true; },
      [&](int u, int v, const Mask& met, const Numbers& rho, const Numbers& across2) {
        const int pixel = (v - band_begin) * width + u, below = pixel + width;
        const Mask open =
            Numbers::Both(met, rho >= Numbers::LoadHalves(back + pixel, back + below));
        const Numbers offset2 = across2 / (rho * rho);
        const Numbers before = Numbers::LoadHalves(best + pixel, best + below);
        const Mask better = Numbers::Both(open, offset2 < before);
        Select(better, offset2, before).StoreHalves(best + pixel, best + below);
        Select(better, own_id, Numbers::LoadHalves(drawn + pixel, drawn + below))
            .StoreHalves(drawn + pixel, drawn + below);
      });
}

void BandCanvas::CloseDrawnPixels() {
  const float* drawn = drawn_.data();
  float* back = back_.data();
  for (std::size_t i = 0, size = back_.size(); i < size; ++i) {
    back[i] = drawn[i] == kNone ? back[i] : kClosed;
  }
}

void BandCanvas::WriteTo(ModelView* view) const {
  WithInstructions([&](auto instructions) {
    for (int v = v_begin_; v < v_end_; ++v) {
      for (int u = 0; u < camera_.width; u += kLanes) {
        WriteLanes<decltype(instructions)>(u, v, view);
      }
    }
  });
}

// Computes vertices and normals of the pixels. A disc with centre p and normal n has the inverse
// depth rho(r) = n . r / (n . p) on the ray r. So the normal is the normalised gradient of -rho.
template <typename Instructions>
void BandCanvas::WriteLanes(int u, int v, ModelView* view) const {
  using V = Lanes<float, Instructions>;
  static_assert(V::kCount == kLanes && offsetof(Disc, u) == 0 &&
                offsetof(Disc, rho_v) == 4 * sizeof(float) &&
                offsetof(Disc, bb) == 7 * sizeof(float));
  constexpr float kSteps[] = {0, 1, 2, 3, 4, 5, 6, 7};
  const int count = std::min(kLanes, camera_.width - u);
  // Discs after the end of the row are valid, but not written.
  const float* const drawn = &drawn_[static_cast<std::size_t>(v - v_begin_) * camera_.width + u];
  const Disc* discs[kLanes];
  const float* records[kLanes];
  for (int k = 0; k < kLanes; ++k) {
    discs[k] = discs_[static_cast<std::size_t>(drawn[k])];
    records[k] = &discs[k]->u;
  }
  std::int32_t* const surfels = view->surfel_index.row(v) + u;
  for (int k = 0; k < count; ++k) surfels[k] = discs[k]->surfel;
  V columns[kLanes];
  EightRecords<Instructions>::Load(records, columns);
  const V disc_u = columns[0], disc_v = columns[1], rho_0 = columns[2];
  const V rho_u = columns[3], rho_v = columns[4];
  const V zero = 0.f, one = 1.f;
  const V fx = camera_.fx, fy = camera_.fy, cx = camera_.cx, cy = camera_.cy;
  const V pixel_u = V(static_cast<float>(u)) + V::Load(kSteps), pixel_v = static_cast<float>(v);
  const V rho = rho_0 + rho_u * (pixel_u - disc_u) + rho_v * (pixel_v - disc_v);
  const auto is_shown = rho > zero;
  const V depth = Select(is_shown, one / Select(is_shown, rho, one), zero);
  const V a = fx * rho_u, b = fy * rho_v;
  const V c = rho_0 + rho_u * (cx - disc_u) + rho_v * (cy - disc_v);
  const V length2 = a * a + b * b + c * c;
  const auto has_normal = length2 > zero;
  const V scale = Select(has_normal, V(-1.f) / sqrt(Select(has_normal, length2, one)), zero);
  VectorImage &vertex = view->surface.vertex, &normal = view->surface.normal;
  (depth * ((pixel_u - cx) / fx)).StoreUpTo(vertex.x.row(v) + u, count);
  (depth * ((pixel_v - cy) / fy)).StoreUpTo(vertex.y.row(v) + u, count);
  depth.StoreUpTo(vertex.z.row(v) + u, count);
  (scale * a).StoreUpTo(normal.x.row(v) + u, count);
  (scale * b).StoreUpTo(normal.y.row(v) + u, count);
  (scale * c).StoreUpTo(normal.z.row(v) + u, count);
}

}  // namespace surfit
