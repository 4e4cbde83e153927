#include <array>
#include <cstdint>
#include <string_view>

#include "core/read_file.h"
#include "io/ply_body.h"
#include "io/ply_header.h"
#include "surfit/core/error.h"
#include "surfit/io/surfel_ply.h"

namespace surfit {
namespace {

constexpr std::array<std::string_view, 13> kNames = {
    "x",     "y",    "z",      "nx",         "ny",         "nz",       "red",
    "green", "blue", "radius", "confidence", "first_seen", "last_seen"};
using Columns = std::array<std::size_t, kNames.size()>;

std::size_t Column(const PlyElement& element, std::string_view name, const std::string& path) {
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    if (element.properties[i].name == name && !element.properties[i].count_type) return i;
  }
  throw InputError(Concat(path, ": is no map of surfels: 'vertex' has no property ", name));
}

Surfel FromRow(const double* row, const Columns& c) {
  const auto vector = [&](int k) -> Eigen::Vector3f {
    return Eigen::Vector3d(row[c[k]], row[c[k + 1]], row[c[k + 2]]).cast<float>();
  };
  const auto byte = [&](int k) { return static_cast<std::uint8_t>(row[c[k]]); };
  Surfel s;
  s.position_in_world = vector(0);
  s.normal_in_world = vector(3);
  s.color = {byte(6), byte(7), byte(8)};
  s.radius_m = static_cast<float>(row[c[9]]);
  s.confidence = static_cast<float>(row[c[10]]);
  s.first_seen = static_cast<std::int32_t>(row[c[11]]);
  s.last_seen = static_cast<std::int32_t>(row[c[12]]);
  return s;
}

}  // namespace

std::vector<Surfel> ReadSurfelPly(const std::string& path) {
  const std::string file = ReadFile(path);
  const PlyHeader header = ParsePlyHeader(file, path);
  const PlyElement& vertices = FindPlyElement(header, "vertex", path);
  Columns columns;
  for (std::size_t i = 0; i < kNames.size(); ++i) columns[i] = Column(vertices, kNames[i], path);
  std::vector<Surfel> surfels;
  ReadPlyElement(
      file, header, "vertex", path, [&] { surfels.reserve(vertices.count); },
      [&](const double* row) { surfels.push_back(FromRow(row, columns)); });
  return surfels;
}

}  // namespace surfit
