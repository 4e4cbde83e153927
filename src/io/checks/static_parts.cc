#include "io/checks/static_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/median.h"

namespace surfit {
namespace {

constexpr int kPartCellsAcross = 80;
constexpr std::size_t kMinPartImages = 5;
// A static cell has depth in this ratio of the images, and its depth is within kSameDepth of the
// median in kMostImages of them. Recordings without static parts have at most 0.5 % static cells.
constexpr double kWithDepth = 0.8, kMostImages = 0.9;
constexpr float kSameDepth = 0.02F;
constexpr double kMinMoving = 0.5;    // ratio of cells whose depth changes
constexpr double kMaxStatic = 0.45;   // ratio of static cells; above: the camera may stand still
constexpr double kMinRegion = 0.01;   // of all cells
constexpr double kMinSteps = 0.6;     // ratio of the outline with a depth step
constexpr float kOutlineStep = 0.1F;  // relative depth step at the outline

// Depth of the centre pixels of cells, in units of the file; 0: missing.
Image<float> CellDepths(const RawDepth& raw, int cell) {
  return std::visit(
      [&](const auto& depth) {
        Image<float> cells(depth.width() / cell, depth.height() / cell);
        for (int v = 0; v < cells.height(); ++v) {
          for (int u = 0; u < cells.width(); ++u) {
            const auto value = static_cast<float>(depth(u * cell + cell / 2, v * cell + cell / 2));
            cells(u, v) = value > 0 && value < 65535 ? value : 0;  // 0 for NaN
          }
        }
        return cells;
      },
      raw);
}

int DepthWidth(const RawDepth& raw) {
  return std::visit([](const auto& depth) { return depth.width(); }, raw);
}
int DepthHeight(const RawDepth& raw) {
  return std::visit([](const auto& depth) { return depth.height(); }, raw);
}

bool IsOutlineStep(float a, float b) {
  return a > 0 && b > 0 && std::abs(a - b) > kOutlineStep * std::min(a, b);
}

enum class CellMotion : std::uint8_t { kUnknown, kStatic, kMoving };

CellMotion CellMotionOf(const std::vector<Image<float>>& frames, std::size_t cell) {
  std::vector<float> depths;
  for (const Image<float>& frame : frames)
    if (frame[cell] > 0) depths.push_back(frame[cell]);
  const auto all = static_cast<double>(frames.size()), count = static_cast<double>(depths.size());
  if (depths.empty() || count < kMinMoving * all) return CellMotion::kUnknown;
  const float median = MedianOf(depths);
  const auto same = static_cast<double>(std::count_if(depths.begin(), depths.end(), [&](float d) {
    return std::abs(d - median) < kSameDepth * median;
  }));
  if (count >= kWithDepth * all && same >= kMostImages * count) return CellMotion::kStatic;
  return same < kMinMoving * count ? CellMotion::kMoving : CellMotion::kUnknown;
}

constexpr std::array<std::pair<int, int>, 4> kNeighbors = {std::pair(1, 0), std::pair(-1, 0),
                                                           std::pair(0, 1), std::pair(0, -1)};

// Connected static cells.
struct Region {
  std::vector<std::pair<int, int>> cells;
  bool is_at_rim = false;
  int outline = 0, steps = 0;  // pairs of a cell and an outside neighbour, over all frames
};

Region RegionAt(int u0, int v0, const Image<CellMotion>& motions,
                const std::vector<Image<float>>& frames, Image<std::uint8_t>* seen) {
  Region region;
  region.cells.emplace_back(u0, v0);
  (*seen)(u0, v0) = 1;
  for (std::size_t i = 0; i < region.cells.size(); ++i) {
    const auto [u, v] = region.cells[i];
    for (const auto& [du, dv] : kNeighbors) {
      const int x = u + du, y = v + dv;
      if (x < 0 || y < 0 || x >= motions.width() || y >= motions.height()) {
        region.is_at_rim = true;
      } else if (motions(x, y) != CellMotion::kStatic) {
        for (const Image<float>& frame : frames) {
          if (!(frame(u, v) > 0 && frame(x, y) > 0)) continue;
          ++region.outline;
          region.steps += IsOutlineStep(frame(u, v), frame(x, y));
        }
      } else if ((*seen)(x, y) == 0) {
        (*seen)(x, y) = 1;
        region.cells.emplace_back(x, y);
      }
    }
  }
  return region;
}

// Masks the cells and one cell around them, because pixels at the outline mix both depths.
void AddToMask(const Region& region, int cell, Image<std::uint8_t>* mask) {
  for (const auto& [u, v] : region.cells) {
    for (int y = std::max(0, (v - 1) * cell); y < std::min(mask->height(), (v + 2) * cell); ++y) {
      for (int x = std::max(0, (u - 1) * cell); x < std::min(mask->width(), (u + 2) * cell); ++x)
        (*mask)(x, y) = 1;
    }
  }
}

}  // namespace

std::optional<StaticParts> FindStaticParts(const std::vector<FrameImages>& images) {
  if (images.size() < kMinPartImages) return std::nullopt;
  const int width = DepthWidth(images[0].depth), height = DepthHeight(images[0].depth);
  const int cell = std::max(1, width / kPartCellsAcross);
  std::vector<Image<float>> frames;
  for (const FrameImages& image : images) {
    if (DepthWidth(image.depth) != width || DepthHeight(image.depth) != height) return std::nullopt;
    frames.push_back(CellDepths(image.depth, cell));
  }
  Image<CellMotion> motions(frames[0].width(), frames[0].height());
  std::size_t moving = 0, still = 0, known = 0;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    motions[i] = CellMotionOf(frames, i);
    moving += motions[i] == CellMotion::kMoving;
    still += motions[i] == CellMotion::kStatic;
    known += std::any_of(frames.begin(), frames.end(), [&](const auto& f) { return f[i] > 0; });
  }
  const auto all = static_cast<double>(known);
  if (static_cast<double>(moving) < kMinMoving * all) return std::nullopt;
  if (static_cast<double>(still) > kMaxStatic * all) return std::nullopt;
  StaticParts parts = {Image<std::uint8_t>(width, height, 0), 0};
  Image<std::uint8_t> seen(motions.width(), motions.height(), 0);
  for (int v = 0; v < motions.height(); ++v) {
    for (int u = 0; u < motions.width(); ++u) {
      if (motions(u, v) != CellMotion::kStatic || seen(u, v) != 0) continue;
      const Region region = RegionAt(u, v, motions, frames, &seen);
      const auto size = static_cast<double>(region.cells.size());
      if (!region.is_at_rim || size < kMinRegion * static_cast<double>(motions.size())) continue;
      if (region.steps < kMinSteps * region.outline) continue;
      AddToMask(region, cell, &parts.mask);
      parts.ratio += size / all;
    }
  }
  if (parts.ratio == 0) return std::nullopt;
  return parts;
}

void RemoveStaticParts(const Image<std::uint8_t>& mask, RawDepth* depth) {
  std::visit(
      [&](auto& image) {
        if (image.width() != mask.width() || image.height() != mask.height()) return;
        for (std::size_t i = 0; i < mask.size(); ++i)
          if (mask[i] != 0) image[i] = 0;
      },
      *depth);
}

}  // namespace surfit
