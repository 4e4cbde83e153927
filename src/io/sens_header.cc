#include "io/sens_header.h"

#include "io/image_size.h"
#include "io/matrix_text.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

Eigen::Matrix4d TakeMatrix(ByteReader* reader) {
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i) matrix(i / 4, i % 4) = reader->Take<float>();
  return matrix;
}

PinholeCamera Pinhole(const Eigen::Matrix4d& intrinsics) {
  PinholeCamera camera;
  camera.fx = intrinsics(0, 0);
  camera.fy = intrinsics(1, 1);
  camera.cx = intrinsics(0, 2);
  camera.cy = intrinsics(1, 2);
  return camera;
}

void TakeSize(ByteReader* reader, const std::string& name, PinholeCamera* camera) {
  camera->width = reader->Take<std::int32_t>();
  camera->height = reader->Take<std::int32_t>();
  RequireUsualSize({camera->width, camera->height}, name);
}

bool HaveSamePixels(const PinholeCamera& a, const PinholeCamera& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy &&
         a.cx == b.cx && a.cy == b.cy;
}

SensHeader::DepthCoding ToDepthCoding(std::int32_t coding, const std::string& path) {
  if (coding == 0 || coding == 1) return static_cast<SensHeader::DepthCoding>(coding);
  throw InputError(Concat(path, ": compression of depth is ", coding, coding == 2 ? " (occi)" : "",
                          ", must be 0 (raw) or 1 (zlib)"));
}

void RequireColorCoding(std::int32_t coding, const std::string& path) {
  if (coding >= 0 && coding <= 2) return;
  throw InputError(Concat(path, ": compression of colour is ", coding,
                          ", must be 0 (raw), 1 (PNG) or 2 (JPEG)"));
}

// How long the part before the sensor's name is, with the name.
std::uint64_t SizeWithName(const BinaryFile& file) {
  constexpr std::uint64_t kBeforeName = 12;
  const std::string bytes = file.Read(0, kBeforeName);
  ByteReader reader(bytes);
  const auto version = reader.Take<std::uint32_t>();
  if (version != 4) throw InputError(Concat(file.path(), " has version ", version, ", must be 4"));
  const auto length = reader.Take<std::uint64_t>();
  if (!file.Has(kBeforeName, length))
    throw InputError(
        Concat(file.path(), ": the sensor's name has ", length, " bytes, beyond the end"));
  return kBeforeName + length;
}

}  // namespace

SensHeader ReadSensHeader(const BinaryFile& file) {
  constexpr std::uint64_t kAfterName = 4 * 64 + 2 * 4 + 4 * 4 + 4 + 8;
  const std::uint64_t begin = SizeWithName(file);
  const std::string bytes = file.Read(begin, kAfterName);
  ByteReader reader(bytes);
  SensHeader header;
  RgbdCamera& camera = header.camera;
  camera.color = Pinhole(TakeMatrix(&reader));
  const Eigen::Matrix4d color_extrinsics = TakeMatrix(&reader);
  camera.depth = Pinhole(TakeMatrix(&reader));
  const Eigen::Matrix4d depth_extrinsics = TakeMatrix(&reader);
  const auto color_coding = reader.Take<std::int32_t>();
  RequireColorCoding(color_coding, file.path());
  header.raw_color = color_coding == 0;
  header.depth_coding = ToDepthCoding(reader.Take<std::int32_t>(), file.path());
  TakeSize(&reader, file.path() + ": colour", &camera.color);
  TakeSize(&reader, file.path() + ": depth", &camera.depth);
  camera.depth_units_per_metre = reader.Take<float>();
  header.frame_count = reader.Take<std::uint64_t>();
  header.size = begin + kAfterName;

  camera.color_is_registered =
      HaveSamePixels(camera.color, camera.depth) && color_extrinsics == depth_extrinsics;
  camera.color_from_depth =
      RigidFromMatrix(color_extrinsics, file.path() + ": extrinsics of colour") *
      RigidFromMatrix(depth_extrinsics, file.path() + ": extrinsics of depth").Inverse();
  camera.Validate(file.path());
  return header;
}

}  // namespace surfit
