#include "io/sequences/recording_warnings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <vector>

#include "surfit/core/error.h"

namespace surfit {

namespace {

// Depth cameras measure from 0.4 m to about 5 m. Indoors, the median depth is usually 1 to 3 m. A
// median depth beyond kNearest_m or kFarthest_m causes a warning if another scale fits better. A
// median depth beyond kAbsurdlyNear_m or kAbsurdlyFar_m always causes a warning.
constexpr double kNearest_m = 0.4, kFarthest_m = 5;
constexpr double kAbsurdlyNear_m = 0.2, kAbsurdlyFar_m = 20;
constexpr double kUsual_m = 1.8;
// The scale is also implausible if almost all depth is below kAllNear_m, and some of it is closer
// than sensors measure (kTooNear_m).
constexpr double kAllNear_m = 1.2, kTooNear_m = 0.3;
constexpr double kFew = 0.02;  // ratio of pixels that are ignored as outliers
// Depth counts per metre. Common scales: 1 mm and TUM. Rare scales: Replica and 0.1 mm. Rare scales
// are similar to the scale of TUM. So they are only considered for counts beyond the range of TUM.
constexpr std::array<double, 2> kCommonScales = {1000, 5000};
constexpr std::array<double, 2> kRareScales = {6553.5, 10000};

std::vector<std::uint16_t> ValidCounts(const Image<std::uint16_t>& depth) {
  std::vector<std::uint16_t> valid;
  std::copy_if(depth.begin(), depth.end(), std::back_inserter(valid),
               [](std::uint16_t d) { return d != 0 && d != 65535; });
  return valid;
}

// `counts` must not be empty.
double Quantile(std::vector<std::uint16_t> counts, double share) {
  const auto at =
      counts.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(counts.size()));
  std::nth_element(counts.begin(), at, counts.end());
  return *at;
}

// Scale with the median depth closest to kUsual_m, compared by ratio.
double LikelyScale(double median_count) {
  const auto distance = [&](double scale) {
    return std::abs(std::log(median_count / scale / kUsual_m));
  };
  const auto& scales =
      median_count > kFarthest_m * kCommonScales.back() ? kRareScales : kCommonScales;
  return *std::min_element(scales.begin(), scales.end(),
                           [&](double a, double b) { return distance(a) < distance(b); });
}

}  // namespace

std::optional<std::string> DepthScaleWarning(const RawDepth& depth, double depth_units_per_metre,
                                             const std::string& path, bool is_given) {
  const auto* const counts = std::get_if<Image<std::uint16_t>>(&depth);
  if (counts == nullptr) return std::nullopt;
  const std::vector<std::uint16_t> valid = ValidCounts(*counts);
  if (valid.empty()) return std::nullopt;
  const auto depth_m = [&](double share) { return Quantile(valid, share) / depth_units_per_metre; };
  const double median_count = Quantile(valid, 0.5), median_m = depth_m(0.5);
  const double likely = LikelyScale(median_count);
  const bool all_near = depth_m(1 - kFew) < kAllNear_m && depth_m(kFew) < kTooNear_m;
  const bool plausible = median_m >= kNearest_m && median_m <= kFarthest_m && !all_near;
  const bool absurd = median_m < kAbsurdlyNear_m || median_m > kAbsurdlyFar_m;
  if (plausible || (likely == depth_units_per_metre && !absurd)) return std::nullopt;
  const std::string observed = Concat("the median depth of ", path, " is ", median_m, " m at ",
                                      depth_units_per_metre, " units per metre: ");
  if (is_given && likely == depth_units_per_metre) return observed + "check depth_scale";
  if (is_given) {
    return Concat(observed, "check depth_scale, the median is ", median_count / likely, " m at ",
                  likely);
  }
  return Concat(observed, "depth_scale is more likely ", likely, ", with a median of ",
                median_count / likely, " m");
}

namespace {

// Colour gradients are averaged in square cells of 1/160 of the image width.
constexpr int kCellsAcross = 160;
constexpr int kReach = 8;  // maximum shift of colour, cells
constexpr std::array kScales = {.8,    .83,  .86,  .89,  .92,  .95, .975, 1.,
                                1.025, 1.05, 1.08, 1.12, 1.16, 1.2, 1.25};
constexpr int kGiven = 7;       // index of scale 1
constexpr float kJump = 0.08F;  // minimum relative depth difference at a depth edge
constexpr std::size_t kFewestJumps = 200, kEnoughJumps = 2000;  // depth edge pixels per frame
// Minimum score margin of an alignment over the given registration. The unit is the standard
// deviation of all scores. kMarginOfHalf is the minimum for each half of the frames. Different
// capture times of colour and depth shift colour in changing directions. Then the halves disagree.
constexpr double kMargin = 1, kMarginOfHalf = 0.5;

struct Pixel {
  int u = 0, v = 0;
};

// Pixels at depth edges: the relative depth difference over `gap` pixels exceeds kJump.
template <typename T>
std::vector<Pixel> DepthJumps(const Image<T>& depth, int gap) {
  const auto valid = [](T d) { return d > 0 && static_cast<float>(d) != 65535; };
  const auto jumps = [&](T a, T b) {
    const auto x = static_cast<float>(a), y = static_cast<float>(b);
    return valid(a) && valid(b) && std::abs(x - y) > kJump * std::min(x, y);
  };
  std::vector<Pixel> pixels;
  for (int v = gap; v < depth.height() - gap; ++v) {
    for (int u = gap; u < depth.width() - gap; ++u) {
      const int half = gap / 2;
      const bool across = jumps(depth(u - half, v), depth(u - half + gap, v));
      if (across || jumps(depth(u, v - half), depth(u, v - half + gap))) pixels.push_back({u, v});
    }
  }
  return pixels;
}

// Gradient magnitude per cell, normalised to mean 0 and standard deviation 1.
Image<float> ColorChanges(const Image<Rgb8>& color, int cell) {
  const auto grey = [&](int u, int v) {
    const Rgb8& c = color(u, v);
    return static_cast<float>(c.r + c.g + c.b);
  };
  Image<float> change(color.width(), color.height(), 0.F);
  double sum = 0;
  for (int v = 1; v + 1 < color.height(); ++v) {
    for (int u = 1; u + 1 < color.width(); ++u) {
      change(u, v) =
          std::abs(grey(u + 1, v) - grey(u - 1, v)) + std::abs(grey(u, v + 1) - grey(u, v - 1));
      sum += change(u, v);
    }
  }
  const auto most = static_cast<float>(4 * sum / static_cast<double>(change.size()) + 1e-6);
  Image<float> cells(color.width() / cell, color.height() / cell, 0.F);
  for (int v = 0; v < cells.height() * cell; ++v) {
    for (int u = 0; u < cells.width() * cell; ++u)
      cells(u / cell, v / cell) += std::min(change(u, v), most);
  }
  double mean = 0, variance = 0;
  for (const float c : cells) mean += c / static_cast<double>(cells.size());
  for (const float c : cells) variance += (c - mean) * (c - mean);
  const double sigma = std::sqrt(variance / static_cast<double>(cells.size())) + 1e-6;
  for (float& c : cells) c = static_cast<float>((c - mean) / sigma);
  return cells;
}

// Alignment of colour to depth: scaling by kScales[scale] about the image centre, then a shift in
// cells.
struct Place {
  int scale = kGiven, right = 0, down = 0;

  // True for the given registration, to the resolution of scales and cells.
  bool IsGiven() const {
    return std::abs(scale - kGiven) <= 1 && std::abs(right) <= 1 && std::abs(down) <= 1;
  }
};

constexpr int kSide = 2 * kReach + 1;
constexpr std::size_t kPlaces = kScales.size() * kSide * kSide;

std::size_t IndexOf(const Place& p) {
  const int index = (p.scale * kSide + p.down + kReach) * kSide + p.right + kReach;
  return static_cast<std::size_t>(index);
}

template <typename Function>
void ForEachPlace(const Function& function) {
  for (int scale = 0; scale < static_cast<int>(kScales.size()); ++scale) {
    for (int down = -kReach; down <= kReach; ++down) {
      for (int right = -kReach; right <= kReach; ++right) function(Place{scale, right, down});
    }
  }
}

// Adds the mean colour gradient at the pixels for each alignment. Pixels outside the image add 0.
void AddScores(const std::vector<Pixel>& pixels, const Image<float>& cells, int cell,
               std::vector<double>* scores) {
  const double middle_u = 0.5 * cell * cells.width(), middle_v = 0.5 * cell * cells.height();
  for (int scale = 0; scale < static_cast<int>(kScales.size()); ++scale) {
    for (const Pixel& pixel : pixels) {
      const int x =
          static_cast<int>(std::floor((kScales[scale] * (pixel.u - middle_u) + middle_u) / cell));
      const int y =
          static_cast<int>(std::floor((kScales[scale] * (pixel.v - middle_v) + middle_v) / cell));
      for (int down = -kReach; down <= kReach; ++down) {
        if (y + down < 0 || y + down >= cells.height()) continue;
        for (int right = -kReach; right <= kReach; ++right) {
          if (x + right < 0 || x + right >= cells.width()) continue;
          (*scores)[IndexOf({scale, right, down})] +=
              cells(x + right, y + down) / static_cast<double>(pixels.size());
        }
      }
    }
  }
}

// Sum of the scores of the frames [first, last). Frames with few depth edges, or with different
// sizes of colour and depth, add 0.
std::vector<double> ScoresOf(const std::vector<FrameImages>& frames, std::size_t first,
                             std::size_t last, int cell) {
  std::vector<double> scores(kPlaces);
  for (std::size_t i = first; i < last; ++i) {
    const FrameImages& frame = frames[i];
    std::vector<Pixel> jumps = std::visit(
        [&](const auto& depth) {
          const bool fits =
              frame.color.width() == depth.width() && frame.color.height() == depth.height();
          return fits ? DepthJumps(depth, cell) : std::vector<Pixel>();
        },
        frame.depth);
    if (jumps.size() < kFewestJumps) continue;
    const std::size_t every = std::max<std::size_t>(1, jumps.size() / kEnoughJumps);
    for (std::size_t j = 0; j * every < jumps.size(); ++j) jumps[j] = jumps[j * every];
    jumps.resize((jumps.size() + every - 1) / every);
    AddScores(jumps, ColorChanges(frame.color, cell), cell, &scores);
  }
  return scores;
}

// Score margin of an alignment over the given registration, in standard deviations over all
// alignments.
double Advantage(const Place& place, const std::vector<double>& scores) {
  double mean = 0, variance = 0, given = -std::numeric_limits<double>::infinity();
  for (const double score : scores) mean += score / static_cast<double>(kPlaces);
  for (const double score : scores) variance += (score - mean) * (score - mean);
  ForEachPlace([&](const Place& p) {
    if (p.IsGiven()) given = std::max(given, scores[IndexOf(p)]);
  });
  const double sigma = std::sqrt(variance / static_cast<double>(kPlaces));
  return sigma > 0 ? (scores[IndexOf(place)] - given) / sigma : 0;
}

int CellOf(const PinholeCamera& camera) { return std::max(1, camera.width / kCellsAcross); }

std::string Sentence(const RegistrationFit& found, const PinholeCamera& c) {
  const auto fit = [&](double center, int size, int moved_px) {
    return std::round(found.scale * (center - 0.5 * size) + 0.5 * size + moved_px);
  };
  return Concat(
      "colour may not be registered to depth: colour edges match depth edges best with colour at ",
      std::lround(100 * found.scale), " % of the size of depth, ", found.right_px,
      " px to the right and ", found.down_px,
      " px down. If colour is not registered, set its intrinsics, about ",
      std::round(found.scale * c.fx), ",", std::round(found.scale * c.fy), ",",
      fit(c.cx, c.width, found.right_px), ",", fit(c.cy, c.height, found.down_px),
      ", as color_camera in a camera.yaml or as color_intrinsics");
}

}  // namespace

std::optional<RegistrationFit> FitRegistration(const std::vector<FrameImages>& frames,
                                               const PinholeCamera& depth_camera) {
  const int cell = CellOf(depth_camera);
  if (frames.empty()) return std::nullopt;
  const std::size_t half = (frames.size() + 1) / 2;
  std::vector<double> all(kPlaces);
  std::vector<std::vector<double>> halves;
  for (std::size_t first = 0; first < frames.size(); first += half) {
    halves.push_back(ScoresOf(frames, first, std::min(first + half, frames.size()), cell));
    for (std::size_t i = 0; i < kPlaces; ++i) all[i] += halves.back()[i];
  }
  Place best;
  ForEachPlace([&](const Place& place) {
    if (all[IndexOf(place)] > all[IndexOf(best)]) best = place;
  });
  if (!(all[IndexOf(best)] > 0)) return std::nullopt;
  const bool agree = std::all_of(halves.begin(), halves.end(), [&](const auto& scores) {
    return Advantage(best, scores) > kMarginOfHalf;
  });
  return RegistrationFit{kScales[best.scale], best.right * cell, best.down * cell,
                         agree && Advantage(best, all) >= kMargin};
}

std::optional<std::string> RegistrationWarning(const std::vector<FrameImages>& frames,
                                               const PinholeCamera& depth_camera) {
  const auto fit = FitRegistration(frames, depth_camera);
  if (!fit || !fit->is_doubtful) return std::nullopt;
  return Sentence(*fit, depth_camera);
}

}  // namespace surfit
