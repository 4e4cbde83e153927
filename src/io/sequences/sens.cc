#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include "io/cursor.h"
#include "io/files/text.h"
#include "io/images/image_files.h"
#include "io/sequences/frame_bytes.h"
#include "io/sequences/recording.h"
#include "io/sequences/sequence_camera.h"
#include "io/stamps/ground_truth.h"
#include "io/stamps/time_words.h"
#include "surfit/core/error.h"
#include "surfit/geometry/sensor.h"

namespace surfit {
namespace {

// Header of a .sens file (SensorData of ScanNet, version 4), little endian:
// - uint32 version
// - uint64 length of the sensor name, sensor name
// - row-major 4 x 4 floats: intrinsics and extrinsics of colour, then of depth
// - int32 compression of colour (0 raw, 1 PNG, 2 JPEG)
// - int32 compression of depth (0 raw, 1 zlib, 2 occi)
// - uint32 width and height of colour, then of depth
// - float depth counts per metre
// - uint64 number of frames
struct SensHeader {
  enum class DepthCoding { kRaw = 0, kZlib = 1 };

  // Extrinsics are camera_from_sensor. In ScanNet they are identity transforms: the intrinsics
  // alone register colour to depth.
  RgbdCamera camera;
  bool raw_color = false;  // false: PNG or JPEG, detected per image
  DepthCoding depth_coding = DepthCoding::kZlib;
  std::uint64_t frame_count = 0;
  std::uint64_t size = 0;  // bytes of the header
};

Eigen::Matrix4d TakeMatrix(Cursor* reader) {
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

void TakeSize(Cursor* reader, const std::string& name, PinholeCamera* camera) {
  camera->width = reader->Take<std::int32_t>();
  camera->height = reader->Take<std::int32_t>();
  RequireValidSize({camera->width, camera->height}, name);
}

SensHeader::DepthCoding ToDepthCoding(std::int32_t coding, const std::string& path) {
  if (coding == 0 || coding == 1) return static_cast<SensHeader::DepthCoding>(coding);
  throw InputError(path, ": compression of depth is ", coding, coding == 2 ? " (occi)" : "",
                   ", must be 0 (raw) or 1 (zlib)");
}

void RequireColorCoding(std::int32_t coding, const std::string& path) {
  if (coding >= 0 && coding <= 2) return;
  throw InputError(path, ": compression of colour is ", coding,
                   ", must be 0 (raw), 1 (PNG) or 2 (JPEG)");
}

// Number of bytes up to the end of the sensor name.
std::uint64_t SizeWithName(const BinaryFile& file) {
  constexpr std::uint64_t kBeforeName = 12;
  const std::string bytes = file.Read(0, kBeforeName);
  Cursor reader(bytes, file.path());
  const auto version = reader.Take<std::uint32_t>();
  ThrowIf(version != 4, file.path(), " has version ", version, ", must be 4");
  const auto length = reader.Take<std::uint64_t>();
  ThrowIf(!file.Has(kBeforeName, length), file.path(), ": the sensor name has ", length,
          " bytes, more than the file");
  return kBeforeName + length;
}

// Throws InputError with the path and the reason. Depth in the occi format is rejected, because its
// decoder is not public.
SensHeader ReadSensHeader(const BinaryFile& file) {
  constexpr std::uint64_t kAfterName = 4 * 64 + 2 * 4 + 4 * 4 + 4 + 8;
  const std::uint64_t begin = SizeWithName(file);
  const std::string bytes = file.Read(begin, kAfterName);
  Cursor reader(bytes, file.path());
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
      HaveEqualIntrinsics(camera.color, camera.depth) && color_extrinsics == depth_extrinsics;
  camera.color_from_depth =
      RigidFromMatrix(color_extrinsics, file.path() + ": extrinsics of colour") *
      RigidFromMatrix(depth_extrinsics, file.path() + ": extrinsics of depth").Inverse();
  camera.Validate(file.path());
  return header;
}

struct SensFrame {
  Eigen::Matrix4d world_from_camera;
  std::uint64_t depth_stamp_us = 0, color_stamp_us = 0;
  FrameStamps stamps;
  std::uint64_t color_at = 0;  // byte offset in the file; depth follows colour
  std::uint64_t color_bytes = 0;
  std::uint64_t depth_bytes = 0;
};

ImageSize SizeOf(const PinholeCamera& camera) { return {camera.width, camera.height}; }

class SensRecording : public Recording {
 public:
  SensRecording(const std::string& path, double frames_per_second)
      : file_(path), header_(ReadSensHeader(file_)) {
    Index();
    SetStamps(frames_per_second);
  }

  std::uint64_t claimed_count() const { return header_.frame_count; }
  int frame_count() const override { return static_cast<int>(frames_.size()); }
  FrameStamps stamps(int index) const override { return frames_[index].stamps; }

  FrameImages Read(int index) const override {
    const SensFrame& frame = frames_[index];
    const RgbdCamera& camera = header_.camera;
    return ReadImages(file_, index,
                      {frame.color_at + frame.color_bytes, frame.depth_bytes, SizeOf(camera.depth),
                       header_.depth_coding == SensHeader::DepthCoding::kRaw},
                      {frame.color_at, frame.color_bytes, SizeOf(camera.color), header_.raw_color});
  }

  // Valid poses. Frames without a pose are counted in a warning.
  Trajectory Poses(std::vector<std::string>* warnings) const {
    GroundTruthPoses truth(file_.path());
    for (int i = 0; i < frame_count(); ++i) truth.Add(frames_[i].stamps.depth_s, PoseOf(i));
    return truth.Take(warnings);
  }

 private:
  ParsedRigid PoseOf(int index) const {
    const Eigen::Matrix4d& matrix = frames_[index].world_from_camera;
    if (!matrix.allFinite()) return {std::nullopt, Concat("frame ", index, " is not finite")};
    try {
      return {RigidFromMatrix(matrix, Concat("frame ", index)), ""};
    } catch (const InputError& error) {
      return {std::nullopt, error.what()};
    }
  }

  // Stops at the first truncated frame.
  void Index() {
    constexpr std::uint64_t kHeader = 64 + 4 * 8;  // bytes before the images of a frame
    std::uint64_t at = header_.size;
    while (frames_.size() < header_.frame_count && file_.Has(at, kHeader)) {
      const std::string bytes = file_.Read(at, kHeader);
      Cursor reader(bytes, file_.path());
      SensFrame frame;
      for (int i = 0; i < 16; ++i) frame.world_from_camera(i / 4, i % 4) = reader.Take<float>();
      frame.color_stamp_us = reader.Take<std::uint64_t>();
      frame.depth_stamp_us = reader.Take<std::uint64_t>();
      frame.color_bytes = reader.Take<std::uint64_t>();
      frame.depth_bytes = reader.Take<std::uint64_t>();
      frame.color_at = at + kHeader;
      if (!file_.Has(frame.color_at, frame.color_bytes)) return;
      if (!file_.Has(frame.color_at + frame.color_bytes, frame.depth_bytes)) return;
      at = frame.color_at + frame.color_bytes + frame.depth_bytes;
      frames_.push_back(frame);
    }
  }

  // True if timestamps ascend, or ascend again after the clock was set.
  bool IsClock(std::uint64_t SensFrame::*stamp_us) const {
    std::vector<double> stamps_s;
    bool ascends = true;
    for (const SensFrame& frame : frames_) {
      const double stamp_s = 1e-6 * static_cast<double>(frame.*stamp_us);
      ascends = ascends && (stamps_s.empty() || stamp_s > stamps_s.back());
      stamps_s.push_back(stamp_s);
    }
    return ascends || FindClockStarts(stamps_s).size() > 1;
  }

  void SetStamps(double frames_per_second) {
    const bool depth_is_clock = IsClock(&SensFrame::depth_stamp_us);
    const bool color_is_clock = IsClock(&SensFrame::color_stamp_us);
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      SensFrame& frame = frames_[i];
      const double depth_s = 1e-6 * static_cast<double>(frame.depth_stamp_us);
      const double color_s = 1e-6 * static_cast<double>(frame.color_stamp_us);
      const double counted_s = static_cast<double>(i) / frames_per_second;
      frame.stamps.depth_s = depth_is_clock ? depth_s : (color_is_clock ? color_s : counted_s);
      frame.stamps.color_s = color_is_clock ? color_s : frame.stamps.depth_s;
    }
  }

  BinaryFile file_;
  SensHeader header_;
  std::vector<SensFrame> frames_;
};

}  // namespace

RgbdCamera ReadSensCamera(const std::string& path) {
  return ReadSensHeader(BinaryFile(path)).camera;
}

OpenedRecording OpenSens(const std::string& path, double frames_per_second) {
  auto frames = std::make_unique<SensRecording>(path, frames_per_second);
  OpenedRecording opened;
  opened.ground_truth = frames->Poses(&opened.warnings);
  WarnIfShort(path, frames->claimed_count(), frames->frame_count(), &opened);
  opened.frames = std::move(frames);
  return opened;
}

}  // namespace surfit
