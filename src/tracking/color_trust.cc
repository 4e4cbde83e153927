#include "tracking/color_trust.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "surfit/frame/frame_pyramid.h"

namespace surfit {
namespace {

constexpr int kEdgeCellsAcross = 160;  // gradients are averaged in cells
constexpr float kDepthEdge = 0.08F;    // minimum relative depth step
constexpr int kMinEdges = 200;         // pixels
// Minimum mean gradient at depth edges, in standard deviations above the mean of the image.
// Measured over several frames: 0.5 to 4 for registered colour, -0.2 to 0.4 for colour of something
// else.
constexpr double kMinGradient = 0.4;

constexpr int kMinDoubt = 5;          // contradictions
constexpr int kMinAgreement = 15;     // frames of about half a second
constexpr int kMaxRepetitions = 3;    // of a colour image
constexpr std::size_t kSampled = 61;  // every kSampled-th pixel is compared

bool IsDepthEdge(float a, float b) {
  return a > 0 && b > 0 && std::abs(a - b) > kDepthEdge * std::min(a, b);
}

}  // namespace

bool HasColorAtDepthEdges(const Image<float>& depth_m, const Image<Rgb8>& color) {
  const int cell = std::max(1, color.width() / kEdgeCellsAcross), half = cell / 2;
  std::vector<std::pair<int, int>> edges;  // cells
  for (int v = cell; v < depth_m.height() - cell; ++v) {
    for (int u = cell; u < depth_m.width() - cell; ++u) {
      if (IsDepthEdge(depth_m(u - half, v), depth_m(u - half + cell, v)) ||
          IsDepthEdge(depth_m(u, v - half), depth_m(u, v - half + cell)))
        edges.emplace_back(u / cell, v / cell);
    }
  }
  if (edges.size() < kMinEdges) return true;
  const Image<float> cells = GradientCells(color, cell);
  double most = -1;
  for (int down = -1; down <= 1; ++down) {
    for (int right = -1; right <= 1; ++right) {
      double sum = 0;
      for (const auto& [u, v] : edges) {
        const int x = u + right, y = v + down;
        if (x >= 0 && y >= 0 && x < cells.width() && y < cells.height()) sum += cells(x, y);
      }
      most = std::max(most, sum / static_cast<double>(edges.size()));
    }
  }
  return most >= kMinGradient;
}

bool ColorTrust::Accepts(const Image<Rgb8>& color, bool is_new_depth) {
  if (!is_trusted_) return false;
  std::vector<Rgb8> sample;
  for (std::size_t i = 0; i < color.size(); i += kSampled) sample.push_back(color[i]);
  const bool repeats = !sample.empty() && sample == last_sample_;
  last_sample_ = std::move(sample);
  if (!repeats) repetitions_ = 0;
  if (repeats && is_new_depth) ++repetitions_;
  return repetitions_ <= kMaxRepetitions;
}

void ColorTrust::AddBrightness(bool agrees) {
  if (is_proven_) return;
  agreement_ += agrees ? 1 : -1;
  is_proven_ = is_trusted_ && agreement_ >= kMinAgreement;
  doubt_ = std::max(0, doubt_ + (agrees ? -1 : 1));
  if (doubt_ >= kMinDoubt) is_trusted_ = false;
}

bool ColorTrust::TrustsFeatures(const RgbdFrame& frame) {
  if (!is_proven_ && !HasColorAtDepthEdges(frame.depth_m, frame.color)) is_trusted_ = false;
  return is_trusted_;
}

}  // namespace surfit
