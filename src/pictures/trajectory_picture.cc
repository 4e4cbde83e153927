#include "surfit/pictures/trajectory_picture.h"

#include <algorithm>
#include <array>

#include "pictures/picture_view.h"
#include "pictures/plot_canvas.h"
#include "pictures/png_file.h"
#include "pictures/trajectory_axes.h"

namespace surfit {
namespace {

constexpr int kWidth = 1600, kHeight = 900;
constexpr PixelBox kBoxes[] = {{90, 110, 790, 820}, {880, 110, 1580, 820}};
constexpr Rgb8 kPaper = {255, 255, 255}, kInk = {20, 20, 20};
constexpr Rgb8 kEstimateColor = {230, 90, 0}, kGroundTruthColor = {20, 90, 210};
constexpr const char* kAxisLabels[] = {"x [m]", "y [m]", "z [m]"};

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

void BeginView(const ShownAxes& shown, const std::array<AxisRange, 3>& ranges, const PixelBox& box,
               PlotCanvas* canvas) {
  AxisRange vertical = ranges[shown.vertical];
  if (shown.vertical_downward) std::swap(vertical.begin, vertical.end);
  Axes axes;
  axes.box = box;
  axes.ranges =
      EqualAspect({ranges[shown.horizontal], vertical}, box.right - box.left, box.bottom - box.top);
  axes.title = shown.title;
  axes.x_label = kAxisLabels[shown.horizontal];
  axes.y_label = kAxisLabels[shown.vertical];
  canvas->BeginAxes(axes);
}

// The path with a filled circle at its start and a square at its end.
void DrawPath(const Path& path, const ShownAxes& shown, Rgb8 color, PlotCanvas* canvas) {
  const std::vector<double>& x = path[shown.horizontal];
  const std::vector<double>& y = path[shown.vertical];
  if (x.empty()) return;
  canvas->SetColor(color);
  canvas->SetLineWidth(2);
  canvas->Line(x, y);
  canvas->Marker(x.front(), y.front(), PlotCanvas::MarkerShape::kCircle);
  canvas->Marker(x.back(), y.back(), PlotCanvas::MarkerShape::kSquare);
}

// Entries from left to right: the lines' colours, then what the marks mean.
void DrawLegend(bool has_ground_truth, PlotCanvas* canvas) {
  constexpr double kMiddle = 32, kLine = 50, kMark = 10, kSpace = 12;
  double x = kBoxes[0].left;
  const auto text = [&](const std::string& words, double next) {
    canvas->SetColor(kInk);
    canvas->Text(x + kSpace, kMiddle, words);
    x += next;
  };
  const auto line = [&](Rgb8 color, const std::string& words) {
    canvas->SetColor(color);
    canvas->SetLineWidth(3);
    canvas->Line({x, x + kLine}, {kMiddle, kMiddle});
    x += kLine;
    text(words, 170);
  };
  const auto mark = [&](PlotCanvas::MarkerShape shape, const std::string& words) {
    canvas->SetColor(kInk);
    canvas->Marker(x, kMiddle, shape);
    x += kMark;
    text(words, 90);
  };
  canvas->UsePixels();
  line(kEstimateColor, "estimate");
  if (has_ground_truth) line(kGroundTruthColor, "ground truth");
  mark(PlotCanvas::MarkerShape::kCircle, "start");
  mark(PlotCanvas::MarkerShape::kSquare, "end");
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
  {
    PlotCanvas canvas(&image);
    canvas.SetTextHeight(18);
    for (int i = 0; i < 2; ++i) {
      BeginView(views[i], ranges, kBoxes[i], &canvas);
      DrawPath(truth, views[i], kGroundTruthColor, &canvas);
      DrawPath(estimated, views[i], kEstimateColor, &canvas);
    }
    DrawLegend(!ground_truth.empty(), &canvas);
  }
  WritePng(image, path);
}

}  // namespace surfit
