#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "output/pictures/axes.h"
#include "output/pictures/picture_view.h"
#include "output/pictures/pictures.h"
#include "surfit/evaluation/error_statistics.h"
#include "surfit/evaluation/trajectory_evaluation.h"

namespace surfit {
namespace {

constexpr int kWidth = 1600, kHeight = 900, kHeightWithErrors = 1320;
constexpr PixelBox kBoxes[] = {{90, 110, 790, 820}, {880, 110, 1580, 820}};
constexpr PixelBox kErrorBox = {90, 950, 1580, 1250};
constexpr Rgb8 kPaper = {255, 255, 255}, kInk = {20, 20, 20};
constexpr const char* kAxisLabels[] = {"x [m]", "y [m]", "z [m]"};

struct PathStyle {
  Rgb8 color;
  double width_px, mark_px;
};
// The ground truth is wider and drawn first, so both paths are visible if they coincide.
constexpr PathStyle kEstimateStyle = {{230, 90, 0}, 3, 6}, kTruthStyle = {{145, 190, 250}, 9, 11};
constexpr PathStyle kLegendStyle = {kInk, 3, 6};

void DrawStart(Image<Rgb8>* image, PixelPoint at, const PathStyle& style) {
  DrawDisc(image, at, style.mark_px, style.color);
}
void DrawEnd(Image<Rgb8>* image, PixelPoint at, const PathStyle& style) {
  const double half = style.mark_px - 1;
  FillBox(image, {at.u - half, at.v - half, at.u + half, at.v + half}, style.color);
}

using Path = std::array<std::vector<double>, 3>;

Path PositionsOf(const Trajectory& trajectory) {
  Path path;
  for (const StampedPose& pose : trajectory) {
    for (int axis = 0; axis < 3; ++axis) {
      path[axis].push_back(pose.world_from_camera.translation[axis]);
    }
  }
  return path;
}

std::array<AxisRange, 3> FindRanges(const Path& a, const Path& b) {
  std::array<AxisRange, 3> ranges;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values = a[axis];
    values.insert(values.end(), b[axis].begin(), b[axis].end());
    if (values.empty()) values = {0, 1};
    const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
    ranges[axis] = {*least, *greatest};
  }
  return ranges;
}

void DrawView(const ShownAxes& shown, const std::array<AxisRange, 3>& ranges, const PixelBox& box,
              const Path& truth, const Path& estimate, Image<Rgb8>* image) {
  AxisRange vertical = ranges[shown.vertical];
  if (shown.vertical_downward) std::swap(vertical.begin, vertical.end);
  const AxisRanges shown_ranges =
      EqualAspect({ranges[shown.horizontal], vertical}, box.right - box.left, box.bottom - box.top);
  const Axes axes{box, shown_ranges, shown.title, kAxisLabels[shown.horizontal],
                  kAxisLabels[shown.vertical]};
  DrawAxes(image, axes);
  for (const auto& [path, style] : {std::pair(&truth, kTruthStyle), {&estimate, kEstimateStyle}}) {
    std::vector<PixelPoint> points;
    for (std::size_t i = 0; i < path->front().size(); ++i) {
      points.push_back(axes.At((*path)[shown.horizontal][i], (*path)[shown.vertical][i]));
    }
    if (points.empty()) continue;
    DrawLine(image, points, style.color, style.width_px);
    DrawStart(image, points.front(), style);
    DrawEnd(image, points.back(), style);
  }
}

void DrawLegend(bool has_ground_truth, Image<Rgb8>* image) {
  constexpr double kMiddle = 32, kLine = 50, kSpace = 14, kBetween = 40;
  double u = kBoxes[0].left;
  const auto text = [&](const std::string& words) {
    DrawText(image, {u + kSpace, kMiddle}, words);
    u += kSpace + TextWidth(words, {}) + kBetween;
  };
  const auto line = [&](const PathStyle& style, const std::string& words) {
    DrawLine(image, {{u, kMiddle}, {u + kLine, kMiddle}}, style.color, style.width_px);
    u += kLine;
    text(words);
  };
  line(kEstimateStyle, "estimate");
  if (has_ground_truth) line(kTruthStyle, "ground truth");
  DrawStart(image, {u, kMiddle}, kLegendStyle);
  text("start");
  DrawEnd(image, {u, kMiddle}, kLegendStyle);
  text("end");
}

void DrawErrors(const std::vector<MatchedPose>& poses, double begin_s, Image<Rgb8>* image) {
  std::vector<double> times_s, errors_m;
  for (const MatchedPose& pose : poses) {
    times_s.push_back(pose.stamp_s - begin_s);
    errors_m.push_back((pose.estimate.translation - pose.ground_truth.translation).norm());
  }
  const ErrorStatistics statistics = Summarize(errors_m);
  char title[64];
  std::snprintf(title, sizeof(title), "position error, RMSE %.3g mm", 1e3 * statistics.rmse);
  constexpr double kShortest_s = 1e-3, kLeast_mm = 1e-3, kRoom = 1.1;
  const Axes axes{kErrorBox,
                  {{0, std::max(times_s.back(), kShortest_s)},
                   {0, kRoom * std::max(1e3 * statistics.max, kLeast_mm)}},
                  title,
                  "time since the first pose [s]",
                  "error [mm]"};
  DrawAxes(image, axes);
  std::vector<PixelPoint> points;
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    points.push_back(axes.At(times_s[i], 1e3 * errors_m[i]));
  }
  DrawLine(image, points, kEstimateStyle.color, kEstimateStyle.width_px);
}

}  // namespace

void WriteTrajectoryPicture(const Trajectory& estimate, const Trajectory& ground_truth,
                            const std::string& path) {
  const Path estimated = PositionsOf(estimate), truth = PositionsOf(ground_truth);
  const std::array<AxisRange, 3> ranges = FindRanges(estimated, truth);
  const Eigen::Vector3d extent_m(ranges[0].end - ranges[0].begin, ranges[1].end - ranges[1].begin,
                                 ranges[2].end - ranges[2].begin);
  const Eigen::Vector3d up = UpDirection(estimate.empty() ? ground_truth : estimate);
  const std::array<ShownAxes, 2> views = ChooseTrajectoryAxes(up, extent_m);
  const std::vector<MatchedPose> matched = MatchPoses(ground_truth, estimate, MatchOptions());
  Image<Rgb8> image(kWidth, matched.empty() ? kHeight : kHeightWithErrors, kPaper);
  for (int i = 0; i < 2; ++i) DrawView(views[i], ranges, kBoxes[i], truth, estimated, &image);
  DrawLegend(!ground_truth.empty(), &image);
  if (!matched.empty()) DrawErrors(matched, estimate.front().stamp_s, &image);
  WritePng(image, path);
}

}  // namespace surfit
