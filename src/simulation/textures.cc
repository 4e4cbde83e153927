#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "simulation/item.h"
#include "simulation/random.h"

namespace surfit {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

float LatticeValue(std::int64_t x, std::int64_t y, std::int64_t z, std::uint64_t seed) {
  const std::uint64_t key = static_cast<std::uint64_t>(x) * 0x8da6b343u +
                            static_cast<std::uint64_t>(y) * 0xd8163841u +
                            static_cast<std::uint64_t>(z) * 0xcb1ab31fu + seed;
  return static_cast<float>(Random::Mix(key) >> 40) * 0x1p-24f;
}

// Smooth value noise in [0, 1) on a lattice of spacing 1.
float ValueNoise(const Vector3d& point, std::uint64_t seed) {
  const Eigen::Array3d base = point.array().floor();
  const Eigen::Array3f f = (point.array() - base).cast<float>();
  const Eigen::Array3f s = f * f * (3 - 2 * f);
  const auto x = static_cast<std::int64_t>(base.x()), y = static_cast<std::int64_t>(base.y()),
             z = static_cast<std::int64_t>(base.z());
  const auto mix = [](float a, float b, float t) { return a + t * (b - a); };
  const auto along_x = [&](int j, int k) {
    return mix(LatticeValue(x, y + j, z + k, seed), LatticeValue(x + 1, y + j, z + k, seed), s.x());
  };
  return mix(mix(along_x(0, 0), along_x(1, 0), s.y()), mix(along_x(0, 1), along_x(1, 1), s.y()),
             s.z());
}

// Three octaves of value noise in [0, 1).
float FractalNoise(const Vector3d& point, std::uint64_t seed) {
  return (4 * ValueNoise(point, seed) + 2 * ValueNoise(2.03 * point, seed + 1) +
          ValueNoise(4.07 * point, seed + 2)) /
         7;
}

Color Mix(const Color& a, const Color& b, float share) { return a + share * (b - a); }

int Cell(double x, double size) { return static_cast<int>(std::floor(x / size)); }

Color RandomColor(Random* random) {
  const auto channel = [&] { return static_cast<float>(random->Uniform(0.04, 0.85)); };
  const float r = channel(), g = channel(), b = channel();
  return {r, g, b};
}

struct Figure {
  Vector2d center, half;
  bool round;
  Color color;

  bool Covers(const Vector2d& point) const {
    const Vector2d relative = (point - center).cwiseQuotient(half);
    return round ? relative.squaredNorm() < 1 : relative.cwiseAbs().maxCoeff() < 1;
  }
};

std::vector<Figure> RandomFigures(const Vector2d& half_size, Random* random) {
  std::vector<Figure> figures(9 + random->Index(6));
  for (Figure& figure : figures) {
    figure.center = {random->Uniform(-0.8, 0.8), random->Uniform(-0.8, 0.8)};
    figure.center = figure.center.cwiseProduct(half_size);
    figure.round = random->Index(2) == 0;
    figure.half = {random->Uniform(0.05, 0.3), random->Uniform(0.05, 0.3)};
    if (figure.round) figure.half.y() = figure.half.x();
    figure.half *= half_size.minCoeff();
    figure.color = RandomColor(random);
  }
  return figures;
}

}  // namespace

Texture Plain(const Color& color) {
  return [color](const Vector3d&) { return color; };
}

Texture Mottled(const Color& color, double scale_m, float contrast, std::uint64_t seed) {
  return [=](const Vector3d& p) -> Color {
    return color * (1 + contrast * (FractalNoise(p / scale_m, seed) - 0.5f));
  };
}

Texture Checks(const Color& a, const Color& b, double size_m) {
  return [=](const Vector3d& p) {
    // Without the offset, faces of centred solids lie on borders of checker cubes.
    const int sum =
        Cell(p.x() + 1e-3, size_m) + Cell(p.y() + 1e-3, size_m) + Cell(p.z() + 1e-3, size_m);
    return (sum & 1) != 0 ? a : b;
  };
}

Texture Stripes(const Color& a, const Color& b, double width_m, int axis) {
  return [=](const Vector3d& p) { return (Cell(p[axis], width_m) & 1) != 0 ? a : b; };
}

Texture Wood(const Color& light, const Color& dark, int grain_axis, std::uint64_t seed) {
  return [=](const Vector3d& p) {
    Vector3d stretched = p / 0.03;
    stretched[grain_axis] = p[grain_axis] / 0.5;
    const float rings = FractalNoise(stretched, seed);
    return Mix(light, dark, rings * rings);
  };
}

Texture Boards(const Color& light, const Color& dark, double width_m, double length_m,
               std::uint64_t seed) {
  return [=](const Vector3d& p) {
    const int row = Cell(p.y(), width_m);
    const double along = p.x() + length_m * LatticeValue(row, 0, 0, seed);
    const int board = Cell(along, length_m);
    constexpr double kHalfJoint_m = 0.003;
    const double across = p.y() - row * width_m, end = along - board * length_m;
    const bool joint = std::min(across, width_m - across) < kHalfJoint_m ||
                       std::min(end, length_m - end) < kHalfJoint_m;
    const float shade = LatticeValue(row, board, 1, seed);
    const float grain = FractalNoise({p.x() / 0.6, p.y() / 0.025, 7.0 * row}, seed + board);
    const Color wood = Mix(light, dark, 0.65f * shade + 0.35f * grain);
    return joint ? Color(0.3f * wood) : wood;
  };
}

Texture Poster(double width_m, double height_m, std::uint64_t seed) {
  Random random(seed);
  const Vector2d half(width_m / 2, height_m / 2);
  const Color background = RandomColor(&random), frame = Color::Constant(0.03f);
  const std::vector<Figure> figures = RandomFigures(half, &random);
  return [=](const Vector3d& p) {
    const Vector2d point(p.x(), p.z());
    constexpr double kFrame_m = 0.02;
    if ((half - point.cwiseAbs()).minCoeff() < kFrame_m) return Color(frame);
    Color color = background;
    for (const Figure& figure : figures) {
      if (figure.Covers(point)) color = figure.color;
    }
    return color;
  };
}

Texture Rug(double width_m, double depth_m, std::uint64_t seed) {
  Random random(seed);
  const Vector2d half(width_m / 2, depth_m / 2);
  const Color wool(0.45f, 0.38f, 0.3f);
  const auto dyed = [&] { return Mix(wool, RandomColor(&random), 0.35f); };
  const Color border = 0.5f * dyed(), field = dyed(), figure = 0.7f * dyed();
  return [=](const Vector3d& p) {
    const double to_edge = (half - p.head<2>().cwiseAbs()).minCoeff();
    const float weave = 0.85f + 0.3f * FractalNoise(p / 0.02, seed);
    constexpr double kBorder_m = 0.12, kPattern_m = 0.3;
    if (to_edge < kBorder_m) return Color(weave * (to_edge < kBorder_m / 2 ? border : figure));
    // Diamond pattern: |x| + |y| < 0.28 in each cell.
    const Vector2d cell = p.head<2>() / kPattern_m;
    const Vector2d in_cell = (cell.array() - cell.array().floor() - 0.5).abs();
    return Color(weave * (in_cell.sum() < 0.28 ? figure : field));
  };
}

}  // namespace surfit
