#include <algorithm>
#include <array>
#include <utility>

#include "output/pictures/axes.h"
#include "output/pictures/picture_view.h"
#include "output/pictures/pictures.h"

namespace surfit {
namespace {

constexpr int kWidth = 1600, kHeight = 900;
constexpr PixelBox kBoxes[] = {{90, 110, 790, 820}, {880, 110, 1580, 820}};
constexpr Rgb8 kPaper = {255, 255, 255}, kInk = {20, 20, 20};
constexpr Rgb8 kEstimateColor = {230, 90, 0}, kGroundTruthColor = {20, 90, 210};
constexpr const char* kAxisLabels[] = {"x [m]", "y [m]", "z [m]"};

void DrawStart(Image<Rgb8>* image, PixelPoint at, Rgb8 color) { DrawDisc(image, at, 6, color); }
void DrawEnd(Image<Rgb8>* image, PixelPoint at, Rgb8 color) {
  FillBox(image, {at.u - 5, at.v - 5, at.u + 5, at.v + 5}, color);
}

// The x, y and z coordinates of a path in the world.
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

// Of both paths together; 0 to 1 where both are empty.
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

// A view of both paths, the estimate on top.
void DrawView(const ShownAxes& shown, const std::array<AxisRange, 3>& ranges, const PixelBox& box,
              const Path& truth, const Path& estimate, Image<Rgb8>* image) {
  AxisRange vertical = ranges[shown.vertical];
  if (shown.vertical_downward) std::swap(vertical.begin, vertical.end);
  const AxisRanges shown_ranges =
      EqualAspect({ranges[shown.horizontal], vertical}, box.right - box.left, box.bottom - box.top);
  const Axes axes{box, shown_ranges, shown.title, kAxisLabels[shown.horizontal],
                  kAxisLabels[shown.vertical]};
  DrawAxes(image, axes);
  for (const auto& [path, color] :
       {std::pair(&truth, kGroundTruthColor), {&estimate, kEstimateColor}}) {
    std::vector<PixelPoint> points;
    for (std::size_t i = 0; i < path->front().size(); ++i) {
      points.push_back(axes.At((*path)[shown.horizontal][i], (*path)[shown.vertical][i]));
    }
    if (points.empty()) continue;
    DrawLine(image, points, color, 3);
    DrawStart(image, points.front(), color);
    DrawEnd(image, points.back(), color);
  }
}

// Entries from left to right: the lines' colours, then what the marks mean.
void DrawLegend(bool has_ground_truth, Image<Rgb8>* image) {
  constexpr double kMiddle = 32, kLine = 50, kSpace = 14, kBetween = 40;
  double u = kBoxes[0].left;
  const auto text = [&](const std::string& words) {
    DrawText(image, {u + kSpace, kMiddle}, words);
    u += kSpace + TextWidth(words, {}) + kBetween;
  };
  const auto line = [&](Rgb8 color, const std::string& words) {
    DrawLine(image, {{u, kMiddle}, {u + kLine, kMiddle}}, color, 4);
    u += kLine;
    text(words);
  };
  line(kEstimateColor, "estimate");
  if (has_ground_truth) line(kGroundTruthColor, "ground truth");
  DrawStart(image, {u, kMiddle}, kInk);
  text("start");
  DrawEnd(image, {u, kMiddle}, kInk);
  text("end");
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
  Image<Rgb8> image(kWidth, kHeight, kPaper);
  for (int i = 0; i < 2; ++i) DrawView(views[i], ranges, kBoxes[i], truth, estimated, &image);
  DrawLegend(!ground_truth.empty(), &image);
  WritePng(image, path);
}

}  // namespace surfit
