#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>

#include "core/files.h"
#include "io/clouds/ply.h"
#include "surfit/core/error.h"
#include "surfit/io/point_cloud.h"

namespace surfit {
namespace {

constexpr std::array<std::string_view, 13> kNames = {
    "x",     "y",    "z",      "nx",         "ny",         "nz",       "red",
    "green", "blue", "radius", "confidence", "first_seen", "last_seen"};
constexpr std::string_view kFromStereo = "from_stereo";  // since version 0.2
using Columns = std::array<std::size_t, kNames.size()>;

// NaN becomes 0.
template <typename T>
T WithinRange(double value) {
  const double low = std::numeric_limits<T>::min(), high = std::numeric_limits<T>::max();
  return std::isnan(value) ? T{0} : static_cast<T>(std::clamp(value, low, high));
}

Surfel FromRow(const double* row, const Columns& c) {
  const auto vector = [&](int k) -> Eigen::Vector3f {
    return Eigen::Vector3d(row[c[k]], row[c[k + 1]], row[c[k + 2]]).cast<float>();
  };
  const auto byte = [&](int k) { return WithinRange<std::uint8_t>(row[c[k]]); };
  Surfel s;
  s.position_in_world = vector(0);
  s.normal_in_world = vector(3);
  s.color = {byte(6), byte(7), byte(8)};
  s.radius_m = static_cast<float>(row[c[9]]);
  s.confidence = static_cast<float>(row[c[10]]);
  s.first_seen = WithinRange<std::int32_t>(row[c[11]]);
  s.last_seen = WithinRange<std::int32_t>(row[c[12]]);
  return s;
}

}  // namespace

void WriteSurfelPly(const SurfelMap& map, const std::string& path) {
  constexpr PlyType kFloat = PlyType::kFloat32, kByte = PlyType::kUint8, kInt = PlyType::kInt32;
  const std::vector<PlyProperty> properties = {
      {"x", kFloat},          {"y", kFloat},
      {"z", kFloat},          {"nx", kFloat},
      {"ny", kFloat},         {"nz", kFloat},
      {"red", kByte},         {"green", kByte},
      {"blue", kByte},        {"radius", kFloat},
      {"confidence", kFloat}, {"first_seen", kInt},
      {"last_seen", kInt},    {std::string(kFromStereo), kByte}};
  const std::vector<std::int32_t> ids = map.Ids();
  WritePlyVertices(path, ids.size(), properties, [&](std::size_t i, PlyRow* row) {
    const Surfel s = map[ids[i]];
    for (const float value : s.position_in_world) row->Put(value);
    for (const float value : s.normal_in_world) row->Put(value);
    for (const std::uint8_t value : {s.color.r, s.color.g, s.color.b}) row->Put(value);
    for (const float value : {s.radius_m, s.confidence}) row->Put(value);
    for (const std::int32_t value : {s.first_seen, s.last_seen}) row->Put(value);
    row->Put(static_cast<std::uint8_t>(s.from_stereo));
  });
}

std::vector<Surfel> ReadSurfelPly(const std::string& path) {
  const std::string file = ReadFileOrPipe(path);
  const PlyHeader header = ParsePlyHeader(file, path);
  const PlyElement& vertices = FindPlyElement(header, "vertex", path);
  Columns columns;
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    const auto column = FindPlyColumn(vertices, kNames[i]);
    if (!column)
      throw InputError(path, ": not a surfel map: element 'vertex' has no property ", kNames[i]);
    columns[i] = *column;
  }
  const auto from_stereo = FindPlyColumn(vertices, kFromStereo);
  std::vector<Surfel> surfels;
  ReadPlyElement(
      file, header, "vertex", path, [&] { surfels.reserve(vertices.count); },
      [&](const double* row) {
        surfels.push_back(FromRow(row, columns));
        surfels.back().from_stereo = from_stereo && row[*from_stereo] > 0;
      });
  return surfels;
}

}  // namespace surfit
