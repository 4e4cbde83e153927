#include "surfit/io/point_cloud.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "core/files.h"
#include "io/clouds/ply.h"
#include "io/files/text.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

// Columns of the colour; std::nullopt unless all three exist with type uchar.
std::optional<PlyColumns> FindColorColumns(const PlyElement& element) {
  const auto columns = FindPlyColumns(element, {"red", "green", "blue"});
  const auto is_byte = [&](std::size_t c) { return element.properties[c].type == PlyType::kUint8; };
  if (columns && std::all_of(columns->begin(), columns->end(), is_byte)) return columns;
  return std::nullopt;
}

Rgb8 Color(const double* row, const PlyColumns& c) {
  const auto byte = [&](int k) {
    return static_cast<std::uint8_t>(std::clamp(row[c[k]], 0., 255.));
  };
  return {byte(0), byte(1), byte(2)};
}

template <typename Cloud, typename F>
void ForEachOptional(Cloud& cloud, const F& f) {
  f(cloud.normals);
  f(cloud.colors);
  f(cloud.radii_m);
  f(cloud.confidences);
}

void RequireWhole(const PointCloud& cloud) {
  ForEachOptional(cloud, [&](const auto& values) {
    ThrowIf(!values.empty() && values.size() != cloud.points.size(), "the cloud has ",
            cloud.points.size(), " points and ", values.size(),
            " values of an attribute, must have one per point or none");
  });
}

bool IsPly(std::string_view file) {
  return SplitWords(file.substr(0, file.find('\n'))) == Words{"ply"};
}

PointCloud ParsePly(std::string_view file, const std::string& path,
                    std::optional<Eigen::Vector3d>* origin) {
  const PlyHeader header = ParsePlyHeader(file, path);
  const PlyElement& vertices = FindPlyElement(header, "vertex", path);
  const auto points = FindPlyColumns(vertices, {"x", "y", "z"});
  if (!points) throw InputError(path, ": element 'vertex' must have x, y and z");
  const auto normals = FindPlyColumns(vertices, {"nx", "ny", "nz"});
  const auto colors = FindColorColumns(vertices);
  const auto radius = FindPlyColumn(vertices, "radius");
  const auto confidence = FindPlyColumn(vertices, "confidence");
  PointCloud cloud;
  PointReader read_point(origin, *points);
  const auto begin = [&] {
    cloud.points.reserve(vertices.count);
    if (normals) cloud.normals.reserve(vertices.count);
    if (colors) cloud.colors.reserve(vertices.count);
    if (radius) cloud.radii_m.reserve(vertices.count);
    if (confidence) cloud.confidences.reserve(vertices.count);
  };
  ReadPlyElement(file, header, vertices.name, path, begin, [&](const double* row) {
    cloud.points.push_back(read_point(row));
    if (normals) cloud.normals.push_back(VectorAt(row, *normals));
    if (colors) cloud.colors.push_back(Color(row, *colors));
    if (radius) cloud.radii_m.push_back(static_cast<float>(row[*radius]));
    if (confidence) cloud.confidences.push_back(static_cast<float>(row[*confidence]));
  });
  return cloud;
}

}  // namespace

Eigen::Vector3f PointReader::operator()(const double* row) {
  constexpr double kFar_m = 100;
  const Eigen::Vector3d point(row[columns_[0]], row[columns_[1]], row[columns_[2]]);
  if (origin_ == nullptr) return point.cast<float>();
  if (!*origin_ && point.allFinite()) {
    *origin_ = Eigen::Vector3d::Zero();
    if (point.norm() > kFar_m) *origin_ = point.array().round().matrix();
  }
  const Eigen::Vector3d offset = origin_->value_or(Eigen::Vector3d::Zero());
  return (point - offset).cast<float>();
}

PointCloud ReadPly(const std::string& path) {
  const std::string file = ReadFileOrPipe(path);
  return ParsePly(WithoutByteOrderMark(file), path, nullptr);
}

PointCloud ReadPointCloud(const std::string& path) { return ReadPointCloud(path, nullptr); }

PointCloud ReadPointCloud(const std::string& path, std::optional<Eigen::Vector3d>* origin) {
  const std::string bytes = ReadFileOrPipe(path);
  const std::string_view file = WithoutByteOrderMark(bytes);
  PointCloud cloud = IsPly(file) ? ParsePly(file, path, origin) : ParsePcd(file, path, origin);
  if (origin != nullptr && !*origin) *origin = Eigen::Vector3d::Zero();  // no finite point
  return cloud;
}

PointCloud ReadPointCloudAboutOrigin(const std::string& path) {
  std::optional<Eigen::Vector3d> origin;
  PointCloud cloud = ReadPointCloud(path, &origin);
  cloud.origin = *origin;
  return cloud;
}

std::vector<Eigen::Vector3i> ReadTriangles(const std::string& path) {
  const std::string bytes = ReadFileOrPipe(path);
  const std::string_view file = WithoutByteOrderMark(bytes);
  if (!IsPly(file)) return {};
  const PlyHeader header = ParsePlyHeader(file, path);
  const auto vertices = static_cast<double>(FindPlyElement(header, "vertex", path).count);
  std::vector<Eigen::Vector3i> triangles;
  std::size_t face = 0;
  const auto add = [&](const std::vector<double>& corners) {
    for (const double c : corners) {
      ThrowIf(!(c >= 0 && c < vertices && c == std::floor(c)), path, ": face ", face,
              " has the vertex ", c, ", must be 0 to ", vertices - 1);
    }
    ++face;
    const auto corner = [&](std::size_t k) { return static_cast<int>(corners[k]); };
    for (std::size_t k = 2; k < corners.size(); ++k)
      triangles.emplace_back(corner(0), corner(k - 1), corner(k));
  };
  ReadPlyLists(file, header, "face", {"vertex_indices", "vertex_index"}, path, add);
  return triangles;
}

std::size_t RemoveNonFinite(PointCloud* cloud) {
  RequireWhole(*cloud);
  const std::size_t count = cloud->points.size();
  const auto keep_finite = [&](auto& values) {
    if (values.empty()) return;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (cloud->points[i].allFinite()) values[kept++] = values[i];
    }
    values.resize(kept);
  };
  ForEachOptional(*cloud, keep_finite);
  keep_finite(cloud->points);
  return count - cloud->points.size();
}

void WritePly(const PointCloud& cloud, const std::string& path) {
  RequireWhole(cloud);
  std::vector<PlyProperty> properties;
  const auto add = [&](const PlyNames& names, PlyType type) {
    for (const char* name : names) properties.push_back({name, type});
  };
  const bool is_far = !cloud.origin.isZero(0);
  add({"x", "y", "z"}, is_far ? PlyType::kFloat64 : PlyType::kFloat32);
  if (!cloud.normals.empty()) add({"nx", "ny", "nz"}, PlyType::kFloat32);
  if (!cloud.colors.empty()) add({"red", "green", "blue"}, PlyType::kUint8);
  if (!cloud.radii_m.empty()) properties.push_back({"radius", PlyType::kFloat32});
  if (!cloud.confidences.empty()) properties.push_back({"confidence", PlyType::kFloat32});
  WritePlyVertices(path, cloud.points.size(), properties, [&](std::size_t i, PlyRow* row) {
    if (is_far) {
      const Eigen::Vector3d point = cloud.origin + cloud.points[i].cast<double>();
      for (const double value : point) row->Put(value);
    } else {
      for (const float value : cloud.points[i]) row->Put(value);
    }
    if (!cloud.normals.empty()) {
      for (const float value : cloud.normals[i]) row->Put(value);
    }
    if (!cloud.colors.empty()) {
      const Rgb8 c = cloud.colors[i];
      for (const std::uint8_t value : {c.r, c.g, c.b}) row->Put(value);
    }
    if (!cloud.radii_m.empty()) row->Put(cloud.radii_m[i]);
    if (!cloud.confidences.empty()) row->Put(cloud.confidences[i]);
  });
}

}  // namespace surfit
