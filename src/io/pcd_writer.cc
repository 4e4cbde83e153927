#include <glog/logging.h>

#include <cstdint>

#include "io/ply_writer.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "surfit/io/point_cloud.h"

namespace surfit {
namespace {

std::string FormatHeader(const PointCloud& cloud) {
  std::string names = "x y z";
  int count = 3;
  if (!cloud.normals.empty()) {
    names += " normal_x normal_y normal_z";
    count += 3;
  }
  if (!cloud.colors.empty()) {
    names += " rgb";
    ++count;
  }
  const auto repeated = [count](const char* word) {
    std::string line;
    for (int i = 0; i < count; ++i) line += word;
    return line;
  };
  return Concat("# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS ", names, "\nSIZE",
                repeated(" 4"), "\nTYPE", repeated(" F"), "\nCOUNT", repeated(" 1"), "\nWIDTH ",
                cloud.points.size(), "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS ",
                cloud.points.size(), "\nDATA binary\n");
}

}  // namespace

void WritePcd(const PointCloud& cloud, const std::string& path) {
  CHECK(cloud.normals.empty() || cloud.normals.size() == cloud.points.size());
  CHECK(cloud.colors.empty() || cloud.colors.size() == cloud.points.size());
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << FormatHeader(cloud);
    PlyRow row;
    for (std::size_t i = 0; i < cloud.points.size(); ++i) {
      row.Clear();
      for (const float value : cloud.points[i]) row.Put(value);
      if (!cloud.normals.empty()) {
        for (const float value : cloud.normals[i]) row.Put(value);
      }
      if (!cloud.colors.empty()) {
        const Rgb8 c = cloud.colors[i];
        row.Put(std::uint32_t{c.r} << 16 | std::uint32_t{c.g} << 8 | std::uint32_t{c.b});
      }
      out.write(row.bytes().data(), static_cast<std::streamsize>(row.bytes().size()));
    }
  });
}

}  // namespace surfit
