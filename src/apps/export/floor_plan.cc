#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ostream>
#include <utility>

#include "apps/export/occupancy.h"
#include "surfit/core/atomic_file.h"

namespace surfit {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kMinLength_m = 0.4;
constexpr double kHalfThickness_m = 0.04;
constexpr double kMaxGap_m = 0.15;
constexpr double kMinHeight_m = 0.4;  // vertical extent of a wall in the band
constexpr double kAngleGate_rad = 10 * kPi / 180;
// Points within these distances of a line are removed before the next line is searched: surface
// noise, and flat objects on the wall.
constexpr double kUsedDistance_m = 0.12;
constexpr double kUsedAngle_rad = 35 * kPi / 180;

// Vertical surface in plan view.
struct WallPoint {
  Eigen::Vector2d position, normal;
  double height_m = 0;
};

// One point per cube, so that the density of surfels does not matter.
std::vector<WallPoint> WallPoints(const UprightMap& map, const OccupancyGrid& grid) {
  constexpr double kEdge_m = 0.02;
  constexpr float kMaxVertical = 0.2f;  // vertical component of the normal
  std::vector<std::pair<std::array<std::int64_t, 3>, std::size_t>> cubes;
  for (std::size_t i = 0; i < map.surfels.size(); ++i) {
    const Surfel& surfel = map.surfels[i];
    const float height = surfel.position_in_world.z();
    if (height < grid.low_m || height > grid.high_m) continue;
    if (std::abs(surfel.normal_in_world.z()) > kMaxVertical) continue;
    std::array<std::int64_t, 3> cube;
    for (int k = 0; k < 3; ++k) {
      cube[k] = static_cast<std::int64_t>(std::floor(surfel.position_in_world[k] / kEdge_m));
    }
    cubes.emplace_back(cube, i);
  }
  std::sort(cubes.begin(), cubes.end());
  std::vector<WallPoint> points;
  for (std::size_t k = 0; k < cubes.size(); ++k) {
    if (k > 0 && cubes[k].first == cubes[k - 1].first) continue;
    const Surfel& surfel = map.surfels[cubes[k].second];
    points.push_back({surfel.position_in_world.head<2>().cast<double>(),
                      surfel.normal_in_world.head<2>().cast<double>().normalized(),
                      surfel.position_in_world.z()});
  }
  return points;
}

// Line n . x = offset.
struct Line {
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();
  double offset = 0;

  bool Has(const WallPoint& p) const { return IsNear(p, kHalfThickness_m, kAngleGate_rad); }
  bool IsNear(const WallPoint& p, double distance_m, double angle_rad) const {
    return std::abs(p.normal.dot(normal)) > std::cos(angle_rad) &&
           std::abs(p.position.dot(normal) - offset) < distance_m;
  }
};

// Line with the most points among directions in steps of 2 degrees.
std::pair<Line, int> BestLine(const std::vector<WallPoint>& points) {
  constexpr int kDirections = 90;
  constexpr double kBin_m = 0.02;
  std::pair<Line, int> best = {{}, 0};
  double radius_m = 0;
  for (const WallPoint& p : points) radius_m = std::max(radius_m, p.position.norm());
  const int half = static_cast<int>(radius_m / kBin_m) + 3;
  std::vector<int> bins;
  for (int k = 0; k < kDirections; ++k) {
    const double azimuth = kPi * k / kDirections;
    const Eigen::Vector2d normal(std::cos(azimuth), std::sin(azimuth));
    bins.assign(2 * half + 1, 0);
    for (const WallPoint& p : points) {
      if (std::abs(p.normal.dot(normal)) < std::cos(kAngleGate_rad)) continue;
      ++bins[static_cast<int>(std::lround(p.position.dot(normal) / kBin_m)) + half];
    }
    for (int i = 1; i + 1 < 2 * half + 1; ++i) {
      const int count = bins[i - 1] + bins[i] + bins[i + 1];
      if (count > best.second) best = {{normal, (i - half) * kBin_m}, count};
    }
  }
  return best;
}

// Refines a line to the principal axis of its points.
Line FitLine(const std::vector<WallPoint>& points, Line line) {
  for (int pass = 0; pass < 3; ++pass) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
    int count = 0;
    for (const WallPoint& p : points) {
      if (!line.Has(p)) continue;
      sum += p.position;
      second += p.position * p.position.transpose();
      ++count;
    }
    if (count < 2) return line;
    const Eigen::Vector2d center = sum / count;
    const Eigen::Matrix2d covariance = second / count - center * center.transpose();
    const double along =
        0.5 * std::atan2(2 * covariance(0, 1), covariance(0, 0) - covariance(1, 1));
    Eigen::Vector2d normal(-std::sin(along), std::cos(along));
    if (normal.dot(line.normal) < 0) normal = -normal;
    if (normal.dot(line.normal) < std::cos(kAngleGate_rad)) return line;
    line = {normal, normal.dot(center)};
  }
  return line;
}

// Parts of the line without gaps, with sufficient length and vertical extent.
std::vector<WallLine> PartsOf(const Line& line, const std::vector<WallPoint>& points) {
  const Eigen::Vector2d along(line.normal.y(), -line.normal.x());
  std::vector<std::pair<double, double>> places;  // along the line, height
  for (const WallPoint& p : points) {
    if (line.Has(p)) places.emplace_back(p.position.dot(along), p.height_m);
  }
  std::sort(places.begin(), places.end());
  std::vector<WallLine> parts;
  for (std::size_t begin = 0; begin < places.size();) {
    std::size_t end = begin;
    double low = places[begin].second, high = low;
    while (end + 1 < places.size() && places[end + 1].first - places[end].first < kMaxGap_m) {
      ++end;
      low = std::min(low, places[end].second);
      high = std::max(high, places[end].second);
    }
    const double length = places[end].first - places[begin].first;
    if (length >= kMinLength_m && high - low >= kMinHeight_m) {
      const Eigen::Vector2d foot = line.offset * line.normal;
      parts.push_back({foot + places[begin].first * along, foot + places[end].first * along});
    }
    begin = end + 1;
  }
  return parts;
}

class Svg {
 public:
  Svg(std::ostream& out, const OccupancyGrid& grid)
      : out_(out),
        grid_(grid),
        cell_(kUnits_per_m * grid.cell_m),
        height_(cell_ * grid.cells.height()) {
    out_.precision(6);
    page_.extend(Eigen::Vector2d::Zero());
    page_.extend(Eigen::Vector2d(cell_ * grid.cells.width(), height_));
  }

  // Extends the page to a point, before Begin().
  void Include(const Eigen::Vector2d& point) { page_.extend(PageOf(point)); }

  // The scale bar is below everything else.
  void Begin() {
    const Eigen::Vector2d at = page_.min(), size = page_.sizes() + Eigen::Vector2d(0, kFooter);
    out_ << "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"" << at.x() << ' ' << at.y() << ' '
         << size.x() << ' ' << size.y() << "\" width=\"" << size.x() << "\" height=\"" << size.y()
         << "\" font-family=\"sans-serif\" font-size=\"14\">\n"
         << "<rect x=\"" << at.x() << "\" y=\"" << at.y()
         << "\" width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
  }
  void End() { out_ << "</svg>\n"; }

  // Cells of one state, as one rectangle per run in a row.
  void Cells(CellState state, const char* color) {
    out_ << "<g fill=\"" << color << "\" shape-rendering=\"crispEdges\">\n";
    for (int v = 0; v < grid_.cells.height(); ++v) {
      for (int u = 0; u < grid_.cells.width(); ++u) {
        if (grid_.cells(u, v) != state) continue;
        const int begin = u;
        while (u + 1 < grid_.cells.width() && grid_.cells(u + 1, v) == state) ++u;
        out_ << "<rect x=\"" << begin * cell_ << "\" y=\"" << height_ - (v + 1) * cell_
             << "\" width=\"" << (u + 1 - begin) * cell_ << "\" height=\"" << cell_ << "\"/>\n";
      }
    }
    out_ << "</g>\n";
  }
  void Walls(const std::vector<WallLine>& walls) {
    out_ << "<g stroke=\"#000000\" stroke-width=\"4\" stroke-linecap=\"square\">\n";
    for (const WallLine& wall : walls) {
      const Eigen::Vector2d a = PageOf(wall.begin), b = PageOf(wall.end);
      out_ << "<line x1=\"" << a.x() << "\" y1=\"" << a.y() << "\" x2=\"" << b.x() << "\" y2=\""
           << b.y() << "\"/>\n";
    }
    out_ << "</g>\n";
  }
  void Path(const std::vector<Eigen::Vector3d>& path) {
    out_ << "<polyline fill=\"none\" stroke=\"#3070c0\" stroke-width=\"1.5\" points=\"";
    for (const Eigen::Vector3d& point : path) {
      const Eigen::Vector2d at = PageOf(point.head<2>());
      out_ << at.x() << ',' << at.y() << ' ';
    }
    out_ << "\"/>\n";
  }
  void ScaleBar() {
    const double x = page_.min().x() + 20, y = page_.max().y() + 15;
    out_ << "<path fill=\"none\" stroke=\"#000000\" stroke-width=\"2\" d=\"M" << x << ' ' << y - 6
         << "v12m0-6h" << kUnits_per_m << "m0-6v12\"/>\n<text x=\"" << x + 10 + kUnits_per_m
         << "\" y=\"" << y + 5 << "\">1 m</text>\n<text x=\"" << x << "\" y=\"" << y + 30
         << "\">heights " << grid_.low_m << " to " << grid_.high_m << " m</text>\n";
  }

 private:
  static constexpr double kUnits_per_m = 100;
  static constexpr double kFooter = 60;

  Eigen::Vector2d PageOf(const Eigen::Vector2d& point) const {
    const Eigen::Vector2d at = kUnits_per_m * (point - grid_.origin_m);
    return {at.x(), height_ - at.y()};
  }

  std::ostream& out_;
  const OccupancyGrid& grid_;
  const double cell_, height_;
  Eigen::AlignedBox2d page_;  // without the footer
};

}  // namespace

std::vector<WallLine> FindWallLines(const UprightMap& map, const OccupancyGrid& grid) {
  constexpr int kMaxLines = 200;
  constexpr int kMinPoints = 100;
  std::vector<WallPoint> points = WallPoints(map, grid);
  std::vector<WallLine> walls;
  for (int i = 0; i < kMaxLines; ++i) {
    const std::pair<Line, int> best = BestLine(points);
    if (best.second < kMinPoints) break;
    const Line line = FitLine(points, best.first);
    for (const WallLine& part : PartsOf(line, points)) walls.push_back(part);
    points.erase(std::remove_if(points.begin(), points.end(),
                                [&](const WallPoint& p) {
                                  return best.first.Has(p) ||
                                         line.IsNear(p, kUsedDistance_m, kUsedAngle_rad);
                                }),
                 points.end());
  }
  std::stable_sort(walls.begin(), walls.end(), [](const WallLine& a, const WallLine& b) {
    return (a.end - a.begin).norm() > (b.end - b.begin).norm();
  });
  return walls;
}

void WriteFloorPlan(const OccupancyGrid& grid, const std::vector<WallLine>& walls,
                    const std::vector<Eigen::Vector3d>& path, const std::string& file) {
  WriteFileAtomically(file, [&](std::ostream& out) {
    Svg svg(out, grid);
    for (const WallLine& wall : walls) {
      svg.Include(wall.begin);
      svg.Include(wall.end);
    }
    for (const Eigen::Vector3d& point : path) svg.Include(point.head<2>());
    svg.Begin();
    svg.Cells(CellState::kFree, "#eef2f6");
    svg.Cells(CellState::kOccupied, "#b8b8b8");
    svg.Walls(walls);
    svg.Path(path);
    svg.ScaleBar();
    svg.End();
  });
}

}  // namespace surfit
