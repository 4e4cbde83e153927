#include "registration/global/corners.h"

#include <Eigen/Cholesky>
#include <array>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "registration/icp/view_level.h"
#include "surfit/core/parallel.h"
#include "surfit/frame/frame_pyramid.h"

namespace surfit {
namespace {

constexpr int kLevels = 3;
constexpr double kQuality = 0.01;  // of the strongest corner
constexpr double kApart_px = 6;

constexpr int kRadius_px = 4, kSide_px = 2 * kRadius_px + 1;
constexpr int kSteps = 15;
constexpr float kSmallStep_px = 0.02f, kFarthest_px = 12;
// Correlations with the image before, and with the first.
constexpr float kAlikeNext = 0.6f, kAlikeFirst = 0.5f;
constexpr float kLeastContrast = 0.008f;
constexpr int kTracksPerBlock = 16;

using Patch = Eigen::Array<float, kSide_px, kSide_px, Eigen::RowMajor>;

bool IsWithin(const Image<float>& image, const Eigen::Vector2f& at) {
  constexpr float kMargin = kRadius_px + 2;
  return at.x() >= kMargin && at.y() >= kMargin &&
         at.x() < static_cast<float>(image.width()) - kMargin &&
         at.y() < static_cast<float>(image.height()) - kMargin;
}

// The patch around a pixel that IsWithin() the image, bilinear, from so many pixels beside it.
Patch PatchAt(const Image<float>& image, const Eigen::Vector2f& at, int beside_u = 0,
              int beside_v = 0) {
  const int left = static_cast<int>(at.x()), top = static_cast<int>(at.y());
  const float a = at.x() - static_cast<float>(left), b = at.y() - static_cast<float>(top);
  const auto from = [&](int u, int v) {
    const float* begin =
        image.row(top - kRadius_px + beside_v + v) + left - kRadius_px + beside_u + u;
    return Eigen::Map<const Patch, 0, Eigen::OuterStride<>>(begin,
                                                            Eigen::OuterStride<>(image.width()));
  };
  return (1 - b) * ((1 - a) * from(0, 0) + a * from(1, 0)) +
         b * ((1 - a) * from(0, 1) + a * from(1, 1));
}

float LengthOf(const Patch& patch) { return patch.matrix().norm(); }

// Less its mean, and of unit length: what gain and offset do not change. Nothing beyond the image
// and where it is even.
std::optional<Patch> LookAt(const Image<float>& image, const Eigen::Vector2f& at) {
  if (!IsWithin(image, at)) return std::nullopt;
  Patch patch = PatchAt(image, at);
  patch -= patch.mean();
  const float length = LengthOf(patch);
  if (!(length > kLeastContrast * kSide_px)) return std::nullopt;
  return patch / length;
}

struct Found {
  Eigen::Vector2f at;
  float alike;  // correlation
};

// From `at` on, where the patch around `from` is.
std::optional<Found> FindPatch(const Image<float>& source, const Eigen::Vector2f& from,
                               const Image<float>& target, Eigen::Vector2f at) {
  const std::optional<Patch> wanted = LookAt(source, from);
  if (!wanted) return std::nullopt;
  const Patch values = PatchAt(source, from);
  const float length = 2 * LengthOf(values - values.mean());
  Patch by_u = (PatchAt(source, from, 1, 0) - PatchAt(source, from, -1, 0)) / length;
  Patch by_v = (PatchAt(source, from, 0, 1) - PatchAt(source, from, 0, -1)) / length;
  by_u -= by_u.mean();
  by_v -= by_v.mean();
  Eigen::Matrix2f hessian;
  hessian << (by_u * by_u).sum(), (by_u * by_v).sum(), (by_u * by_v).sum(), (by_v * by_v).sum();
  const Eigen::LDLT<Eigen::Matrix2f> factors(hessian);
  const Eigen::Vector2f begin = at;
  float step_px = kFarthest_px;
  for (int i = 0; i <= kSteps && step_px >= kSmallStep_px; ++i) {
    const std::optional<Patch> here = LookAt(target, at);
    if (!here) return std::nullopt;
    const Patch difference = *here - *wanted;
    const Eigen::Vector2f step =
        factors.solve(Eigen::Vector2f((by_u * difference).sum(), (by_v * difference).sum()));
    at -= step;
    step_px = step.norm();
    if (!((at - begin).norm() < kFarthest_px)) return std::nullopt;
  }
  const std::optional<Patch> here = LookAt(target, at);
  if (!here) return std::nullopt;
  return Found{at, (*here * *wanted).sum()};
}

// The pixel's place in an image of half the size.
Eigen::Vector2f Coarser(const Eigen::Vector2f& at) { return (at.array() - 0.5f) / 2; }
Eigen::Vector2f Finer(const Eigen::Vector2f& at) { return at.array() * 2 + 0.5f; }

// Coarse to fine, from the expected place on.
std::optional<Eigen::Vector2f> FindCorner(const GreyPyramid& source, const Eigen::Vector2f& from,
                                          const GreyPyramid& target,
                                          const Eigen::Vector2f& expected) {
  std::array<Eigen::Vector2f, kLevels> from_at;
  from_at[0] = from;
  Eigen::Vector2f at = expected;
  for (int level = 1; level < kLevels; ++level) {
    from_at[level] = Coarser(from_at[level - 1]);
    at = Coarser(at);
  }
  for (int level = kLevels - 1; level > 0; --level) {
    const auto found = FindPatch(source[level], from_at[level], target[level], at);
    at = Finer(found && found->alike > kAlikeNext ? found->at : at);
  }
  const auto found = FindPatch(source[0], from, target[0], at);
  if (!found || !(found->alike > kAlikeNext)) return std::nullopt;
  return found->at;
}

}  // namespace

GreyPyramid MakeGreyPyramid(const Image<Rgb8>& color) {
  GreyPyramid pyramid = {CoarseBrightness(color, 0).value};
  while (pyramid.size() < kLevels) pyramid.push_back(HalfResolution(pyramid.back()));
  return pyramid;
}

std::vector<Eigen::Vector2f> FindCorners(const GreyPyramid& grey, const Image<float>& depth_m,
                                         int max_count) {
  const cv::Size size(depth_m.width(), depth_m.height());
  const cv::Mat image(size, CV_32F, const_cast<float*>(grey.front().data()));
  const cv::Mat depth(size, CV_32F, const_cast<float*>(depth_m.data()));
  std::vector<cv::Point2f> found;
  cv::goodFeaturesToTrack(image, found, max_count, kQuality, kApart_px, depth > 0);
  std::vector<Eigen::Vector2f> corners;
  corners.reserve(found.size());
  for (const cv::Point2f& corner : found) corners.emplace_back(corner.x, corner.y);
  return corners;
}

CornerTracks::CornerTracks(GreyPyramid first, std::vector<Eigen::Vector2f> corners)
    : first_(std::move(first)), last_(first_) {
  for (int i = 0; i < static_cast<int>(corners.size()); ++i) {
    tracks_.push_back({i, corners[i], corners[i]});
  }
}

void CornerTracks::Follow(GreyPyramid next, const Expect& expect) {
  std::vector<std::optional<Eigen::Vector2f>> places(tracks_.size());
  ParallelFor(0, static_cast<int>(tracks_.size()), kTracksPerBlock, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      places[i] = FindCorner(last_, tracks_[i].last, next, expect(tracks_[i]));
    }
  });
  std::vector<Track> found;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (places[i]) found.push_back({tracks_[i].corner, tracks_[i].first, *places[i]});
  }
  tracks_ = std::move(found);
  last_ = std::move(next);
}

std::vector<CornerTracks::Track> CornerTracks::Lasting() const {
  std::vector<Track> lasting;
  for (const Track& track : tracks_) {
    const auto found = FindPatch(first_[0], track.first, last_[0], track.last);
    if (found && found->alike > kAlikeFirst)
      lasting.push_back({track.corner, track.first, found->at});
  }
  return lasting;
}

}  // namespace surfit
