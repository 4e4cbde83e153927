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
constexpr int kReach = 8;   // maximum shift of colour, cells
constexpr int kCoarse = 4;  // size of the coarse cells that search large shifts, cells
constexpr std::array kScales = {.8,    .83,  .86,  .89,  .92,  .95, .975, 1.,
                                1.025, 1.05, 1.08, 1.12, 1.16, 1.2, 1.25};
constexpr int kGiven = 7;       // index of scale 1
constexpr float kJump = 0.08F;  // minimum relative depth difference at a depth edge
constexpr std::size_t kFewestJumps = 200, kEnoughJumps = 2000;  // depth edge pixels per frame
// Minimum score margin of an alignment over the given registration. The unit is the standard
// deviation of all scores. kMarginOfHalf is the minimum for each half of the frames. Different
// capture times of colour and depth shift colour in changing directions. Then the halves disagree.
constexpr double kMargin = 1, kMarginOfHalf = 0.5;
// Minimum score per frame of turned colour, and its margin over the given orientation. Measured:
// scores of registered colour are 0.5 to 4, and scores of turned colour are below 0.7 of them.
constexpr double kMinTurnedScore = 0.5, kTurnedRatio = 2, kTurnedMargin = 0.3;

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
// `right0`, `down0`: shift in cells that is added to each alignment.
void AddScores(const std::vector<Pixel>& pixels, const Image<float>& cells, int cell, int right0,
               int down0, std::vector<double>* scores) {
  const double middle_u = 0.5 * cell * cells.width(), middle_v = 0.5 * cell * cells.height();
  for (int scale = 0; scale < static_cast<int>(kScales.size()); ++scale) {
    for (const Pixel& pixel : pixels) {
      const int x =
          right0 +
          static_cast<int>(std::floor((kScales[scale] * (pixel.u - middle_u) + middle_u) / cell));
      const int y =
          down0 +
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

// Depth edges and colour gradients of a frame.
struct FrameEdges {
  std::vector<Pixel> jumps;
  Image<float> changes;
};

// Edges of the frames that have enough depth edges, and colour of the size of depth.
std::vector<FrameEdges> EdgesOf(const std::vector<FrameImages>& frames, int cell,
                                std::size_t enough) {
  std::vector<FrameEdges> edges;
  for (const FrameImages& frame : frames) {
    std::vector<Pixel> jumps = std::visit(
        [&](const auto& depth) {
          const bool fits =
              frame.color.width() == depth.width() && frame.color.height() == depth.height();
          return fits ? DepthJumps(depth, cell) : std::vector<Pixel>();
        },
        frame.depth);
    if (jumps.size() < kFewestJumps) continue;
    const std::size_t every = std::max<std::size_t>(1, jumps.size() / enough);
    for (std::size_t j = 0; j * every < jumps.size(); ++j) jumps[j] = jumps[j * every];
    jumps.resize((jumps.size() + every - 1) / every);
    edges.push_back({std::move(jumps), ColorChanges(frame.color, cell)});
  }
  return edges;
}

Image<float> Turned(const Image<float>& cells, ImageTurn turn) {
  Image<float> turned(cells.width(), cells.height());
  const bool flips_u = turn == ImageTurn::kRotated || turn == ImageTurn::kMirrored;
  const bool flips_v = turn == ImageTurn::kRotated || turn == ImageTurn::kUpsideDown;
  for (int v = 0; v < cells.height(); ++v) {
    for (int u = 0; u < cells.width(); ++u) {
      turned(u, v) =
          cells(flips_u ? cells.width() - 1 - u : u, flips_v ? cells.height() - 1 - v : v);
    }
  }
  return turned;
}

// Largest mean colour gradient at the depth edges of a frame, without scale, within one cell.
double GivenScore(const FrameEdges& edges, ImageTurn turn, int cell) {
  const Image<float> cells = Turned(edges.changes, turn);
  double most = -std::numeric_limits<double>::infinity();
  for (int down = -1; down <= 1; ++down) {
    for (int right = -1; right <= 1; ++right) {
      double sum = 0;
      for (const Pixel& pixel : edges.jumps) {
        const int x = pixel.u / cell + right, y = pixel.v / cell + down;
        if (x >= 0 && y >= 0 && x < cells.width() && y < cells.height()) sum += cells(x, y);
      }
      most = std::max(most, sum / static_cast<double>(edges.jumps.size()));
    }
  }
  return most;
}

// Mean of GivenScore() over the frames [first, last).
double MeanScore(const std::vector<FrameEdges>& edges, std::size_t first, std::size_t last,
                 ImageTurn turn, int cell) {
  double sum = 0;
  for (std::size_t i = first; i < last; ++i) sum += GivenScore(edges[i], turn, cell);
  return sum / static_cast<double>(last - first);
}

// Orientation that matches much better than the given one, in all frames and both halves of them.
ImageTurn TurnOf(const std::vector<FrameEdges>& edges, double given_score, int cell) {
  const std::size_t all = edges.size(), half = (all + 1) / 2;
  for (const ImageTurn turn : {ImageTurn::kRotated, ImageTurn::kMirrored, ImageTurn::kUpsideDown}) {
    const auto is_better = [&](std::size_t first, std::size_t last) {
      const double score = MeanScore(edges, first, last, turn, cell);
      return score > kMinTurnedScore &&
             score > kTurnedRatio * std::max(given_score, 0.) + kTurnedMargin;
    };
    if (is_better(0, half) && (half == all || is_better(half, all))) return turn;
  }
  return ImageTurn::kNone;
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

// Best alignment of the frames near a shift.
struct AlignmentSearch {
  Place best;                // relative to the shift
  bool has_edges = false;    // the best alignment has a positive score
  bool is_doubtful = false;  // all frames and both halves contradict the given alignment
};

AlignmentSearch SearchAlignment(const std::vector<FrameEdges>& edges, int cell, int right0,
                                int down0) {
  std::vector<double> all(kPlaces);
  std::vector<std::vector<double>> halves;
  const std::size_t half = (edges.size() + 1) / 2;
  for (std::size_t first = 0; first < edges.size(); first += half) {
    std::vector<double> scores(kPlaces);
    for (std::size_t i = first; i < std::min(first + half, edges.size()); ++i)
      AddScores(edges[i].jumps, edges[i].changes, cell, right0, down0, &scores);
    for (std::size_t i = 0; i < kPlaces; ++i) all[i] += scores[i];
    halves.push_back(std::move(scores));
  }
  AlignmentSearch search;
  ForEachPlace([&](const Place& place) {
    if (all[IndexOf(place)] > all[IndexOf(search.best)]) search.best = place;
  });
  search.has_edges = all[IndexOf(search.best)] > 0;
  const bool agree = std::all_of(halves.begin(), halves.end(), [&](const auto& scores) {
    return Advantage(search.best, scores) > kMarginOfHalf;
  });
  search.is_doubtful = agree && Advantage(search.best, all) >= kMargin;
  return search;
}

// Searches shifts beyond the reach of fine cells with coarse cells, and then refines the best one.
// std::nullopt if no such shift is clearly better.
std::optional<RegistrationFit> FitLargeShift(const std::vector<FrameImages>& frames,
                                             const std::vector<FrameEdges>& edges, int cell) {
  const int coarse = kCoarse * cell;
  const AlignmentSearch far =
      SearchAlignment(EdgesOf(frames, coarse, kEnoughJumps / kCoarse), coarse, 0, 0);
  const bool is_far =
      kCoarse * std::max(std::abs(far.best.right), std::abs(far.best.down)) > kReach;
  if (!far.has_edges || !far.is_doubtful || !is_far) return std::nullopt;
  const int right0 = kCoarse * far.best.right, down0 = kCoarse * far.best.down;
  const AlignmentSearch near = SearchAlignment(edges, cell, right0, down0);
  if (!near.has_edges) return std::nullopt;
  RegistrationFit fit;
  fit.scale = kScales[near.best.scale];
  fit.right_px = (right0 + near.best.right) * cell;
  fit.down_px = (down0 + near.best.down) * cell;
  fit.is_doubtful = true;
  return fit;
}

const char* NameOf(ImageTurn turn) {
  if (turn == ImageTurn::kRotated) return "rotated by 180 degrees";
  return turn == ImageTurn::kMirrored ? "mirrored left to right" : "upside down";
}

std::string Sentence(const RegistrationFit& found, const PinholeCamera& c) {
  const std::string doubt =
      "colour may not be registered to depth: edges of colour do not lie on edges of depth. ";
  if (found.turn != ImageTurn::kNone)
    return Concat(doubt, "They do if colour images are ", NameOf(found.turn),
                  ": colour is not used");
  const auto fit = [&](double center, int size, int moved_px) {
    return std::round(found.scale * (center - 0.5 * size) + 0.5 * size + moved_px);
  };
  return Concat(doubt, "The best match has colour at ", std::lround(100 * found.scale),
                " % of the size of depth, ", found.right_px, " px to the right and ", found.down_px,
                " px down. If colour is not registered, set its intrinsics, about ",
                std::round(found.scale * c.fx), ",", std::round(found.scale * c.fy), ",",
                fit(c.cx, c.width, found.right_px), ",", fit(c.cy, c.height, found.down_px),
                ", as color_camera in a camera.yaml or as color_intrinsics");
}

}  // namespace

std::optional<RegistrationFit> FitRegistration(const std::vector<FrameImages>& frames,
                                               const PinholeCamera& depth_camera) {
  const int cell = CellOf(depth_camera);
  const std::vector<FrameEdges> edges = EdgesOf(frames, cell, kEnoughJumps);
  if (edges.empty()) return std::nullopt;
  const AlignmentSearch search = SearchAlignment(edges, cell, 0, 0);
  if (!search.has_edges) return std::nullopt;
  RegistrationFit fit = {kScales[search.best.scale], search.best.right * cell,
                         search.best.down * cell, search.is_doubtful};
  fit.given_score = MeanScore(edges, 0, edges.size(), ImageTurn::kNone, cell);
  if (search.best.IsGiven()) return fit;
  fit.turn = TurnOf(edges, fit.given_score, cell);
  if (fit.turn != ImageTurn::kNone) {
    fit.scale = 1;
    fit.right_px = fit.down_px = 0;
    fit.is_doubtful = true;
    return fit;
  }
  // The score of a larger shift increases up to the limit of the search.
  const bool is_at_limit =
      std::max(std::abs(search.best.right), std::abs(search.best.down)) == kReach;
  if (fit.is_doubtful && !is_at_limit) return fit;
  if (auto large = FitLargeShift(frames, edges, cell)) {
    large->given_score = fit.given_score;
    return large;
  }
  return fit;
}

std::optional<std::string> RegistrationWarning(const RegistrationFit& fit,
                                               const PinholeCamera& depth_camera) {
  if (!fit.is_doubtful) return std::nullopt;
  return Sentence(fit, depth_camera);
}

std::optional<std::string> RegistrationWarning(const std::vector<FrameImages>& frames,
                                               const PinholeCamera& depth_camera) {
  const auto fit = FitRegistration(frames, depth_camera);
  return fit ? RegistrationWarning(*fit, depth_camera) : std::nullopt;
}

namespace {

// A separate colour camera is in the same device.
constexpr double kFarthestCamera_m = 0.5;
constexpr double kMinVisible = 0.3;      // of depth that the colour camera sees
constexpr double kMinInverseGain = 0.3;  // of RegistrationFit::given_score

// Colour of the first images as seen by a colour camera.
struct ColorView {
  double visible = 0;  // ratio of depth with colour
  std::optional<RegistrationFit> fit;
};

ColorView ViewOf(const std::vector<FrameImages>& images, const RgbdCamera& camera,
                 const RectifyOptions& options) {
  const FrameRectifier rectifier(camera, options);
  std::vector<FrameImages> frames;
  std::size_t depths = 0, visible = 0;
  for (const FrameImages& image : images) {
    if (image.color.empty()) continue;
    RgbdFrame frame = rectifier.Rectify(image.depth, image.color);
    for (std::size_t i = 0; i < frame.depth_m.size(); ++i) {
      if (!(frame.depth_m[i] > 0)) continue;
      const Rgb8 c = frame.color[i];
      ++depths;
      visible += c.r != 0 || c.g != 0 || c.b != 0;
    }
    frames.push_back({std::move(frame.depth_m), std::move(frame.color), "", ""});
  }
  ColorView view;
  if (depths == 0) return {1, std::nullopt};
  view.visible = static_cast<double>(visible) / static_cast<double>(depths);
  view.fit = FitRegistration(frames, rectifier.pinhole());
  return view;
}

}  // namespace

std::optional<std::string> ColorCameraWarning(const std::vector<FrameImages>& images,
                                              const RgbdCamera& camera,
                                              const RectifyOptions& options,
                                              std::optional<RegistrationFit>* registration) {
  const ColorView given = ViewOf(images, camera, options);
  *registration = given.fit;
  const double distance_m = camera.color_from_depth.translation.norm();
  if (distance_m > kFarthestCamera_m) {
    return Concat("the colour camera is ", distance_m,
                  " m from the depth camera, must be in the same device: color_from_depth has "
                  "its translation in m",
                  distance_m > 1 ? Concat(", and these may be mm (", distance_m, " mm)") : "");
  }
  RgbdCamera inverse = camera;
  inverse.color_from_depth = camera.color_from_depth.Inverse();
  const bool is_unseen = given.visible < kMinVisible;
  const double given_score = given.fit ? given.fit->given_score : 0;
  if (!is_unseen && (!given.fit || given.fit->scale == 1)) {
    const bool is_matched = !given.fit || (!given.fit->is_doubtful && given.fit->right_px == 0 &&
                                           given.fit->down_px == 0);
    if (is_matched) return std::nullopt;
  }
  const ColorView other = ViewOf(images, inverse, options);
  const double other_score = other.fit ? other.fit->given_score : 0;
  const bool inverse_is_seen = is_unseen && other.visible > 2 * kMinVisible;
  if (inverse_is_seen || (!is_unseen && other_score > given_score + kMinInverseGain)) {
    return Concat(
        "the colour camera is probably at the inverse place: edges of colour match "
        "edges of depth better with the inverse of color_from_depth (score ",
        other_score, " for ", given_score,
        "), which maps points of the depth camera to the colour camera");
  }
  if (is_unseen) {
    return Concat("the colour camera sees only ", std::lround(100 * given.visible),
                  " % of the depth: check color_camera and color_from_depth, which maps points of "
                  "the depth camera to the colour camera, in m");
  }
  if (!given.fit || !given.fit->is_doubtful) return std::nullopt;
  return Concat(
      "edges of registered colour do not lie on edges of depth: the best match has "
      "colour at ",
      std::lround(100 * given.fit->scale), " % of the size of depth, ", given.fit->right_px,
      " px to the right and ", given.fit->down_px,
      " px down. Check color_camera and color_from_depth");
}

}  // namespace surfit
