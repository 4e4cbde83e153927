#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <vector>

#include "io/checks/recording_warnings.h"
#include "surfit/core/error.h"
#include "surfit/frame/frame_pyramid.h"

namespace surfit {
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
    edges.push_back({std::move(jumps), GradientCells(frame.color, cell)});
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

}  // namespace surfit
