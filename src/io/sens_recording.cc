#include "io/sens_recording.h"

#include <utility>

#include "io/binary_file.h"
#include "io/frame_bytes.h"
#include "io/matrix_text.h"
#include "io/sens_header.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

struct SensFrame {
  Eigen::Matrix4d world_from_camera;
  std::uint64_t stamp_us = 0;  // of colour
  double stamp_s = 0;
  std::uint64_t color_at = 0;  // byte in the file; depth follows colour
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

  std::uint64_t promised_count() const { return header_.frame_count; }
  int frame_count() const override { return static_cast<int>(frames_.size()); }
  double stamp_s(int index) const override { return frames_[index].stamp_s; }

  FrameImages Read(int index) const override {
    const SensFrame& frame = frames_[index];
    FrameImages images;
    images.depth_name = Concat(file_.path(), ": depth of frame ", index);
    images.color_name = Concat(file_.path(), ": colour of frame ", index);
    const std::string depth = file_.Read(frame.color_at + frame.color_bytes, frame.depth_bytes);
    const ImageSize depth_size = SizeOf(header_.camera.depth);
    images.depth = header_.depth_coding == SensHeader::DepthCoding::kRaw
                       ? CopyDepth(depth, depth_size, images.depth_name)
                       : InflateDepth(depth, depth_size, images.depth_name);
    const std::string color = file_.Read(frame.color_at, frame.color_bytes);
    if (color.empty()) return images;
    const ImageSize color_size = SizeOf(header_.camera.color);
    images.color = header_.raw_color ? CopyColor(color, color_size, images.color_name)
                                     : DecodeColor(color, color_size, images.color_name);
    return images;
  }

  // The poses that are there.
  Trajectory Poses() const {
    Trajectory poses;
    for (int i = 0; i < frame_count(); ++i) {
      const Eigen::Matrix4d& matrix = frames_[i].world_from_camera;
      if (!matrix.allFinite()) continue;
      poses.push_back({frames_[i].stamp_s,
                       RigidFromMatrix(matrix, Concat(file_.path(), ": pose of frame ", i))});
    }
    return poses;
  }

 private:
  // Walks over the frames' headers, as far as the file goes.
  void Index() {
    constexpr std::uint64_t kHeader = 64 + 4 * 8;  // bytes before the images of a frame
    std::uint64_t at = header_.size;
    while (frames_.size() < header_.frame_count && file_.Has(at, kHeader)) {
      const std::string bytes = file_.Read(at, kHeader);
      ByteReader reader(bytes);
      SensFrame frame;
      for (int i = 0; i < 16; ++i) frame.world_from_camera(i / 4, i % 4) = reader.Take<float>();
      frame.stamp_us = reader.Take<std::uint64_t>();
      reader.Take<std::uint64_t>();  // the stamp of depth
      frame.color_bytes = reader.Take<std::uint64_t>();
      frame.depth_bytes = reader.Take<std::uint64_t>();
      frame.color_at = at + kHeader;
      if (!file_.Has(frame.color_at, frame.color_bytes)) return;
      if (!file_.Has(frame.color_at + frame.color_bytes, frame.depth_bytes)) return;
      at = frame.color_at + frame.color_bytes + frame.depth_bytes;
      frames_.push_back(frame);
    }
  }

  void SetStamps(double frames_per_second) {
    bool ascending = true;
    for (std::size_t i = 1; i < frames_.size(); ++i)
      ascending = ascending && frames_[i - 1].stamp_us < frames_[i].stamp_us;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      frames_[i].stamp_s = ascending ? 1e-6 * static_cast<double>(frames_[i].stamp_us)
                                     : static_cast<double>(i) / frames_per_second;
    }
  }

  BinaryFile file_;
  SensHeader header_;
  std::vector<SensFrame> frames_;
};

}  // namespace

OpenedRecording OpenSens(const std::string& path, double frames_per_second) {
  auto frames = std::make_unique<SensRecording>(path, frames_per_second);
  OpenedRecording opened;
  opened.ground_truth = frames->Poses();
  if (frames->promised_count() != static_cast<std::uint64_t>(frames->frame_count())) {
    opened.warnings.push_back(Concat(path, " promises ", frames->promised_count(),
                                     " frames, and is damaged or ends after ",
                                     frames->frame_count()));
  }
  opened.frames = std::move(frames);
  return opened;
}

}  // namespace surfit
