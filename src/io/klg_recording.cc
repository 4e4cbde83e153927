#include "io/klg_recording.h"

#include <optional>
#include <utility>

#include "io/binary_file.h"
#include "io/frame_bytes.h"
#include "io/jpeg.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

struct KlgFrame {
  std::int64_t stamp_us = 0;
  std::uint64_t depth_at = 0;  // byte in the file; colour follows depth
  std::uint64_t depth_bytes = 0;
  std::uint64_t color_bytes = 0;
};

class KlgRecording : public Recording {
 public:
  KlgRecording(const std::string& path, ImageSize size) : file_(path), size_(size) {
    Index();
    if (const auto claimed = SizeOfFirstJpeg()) size_ = *claimed;
    if (size_ == ImageSize())
      throw InputError(path + " does not tell the size of its images: name a camera");
  }

  int promised_count() const { return promised_count_; }
  int frame_count() const override { return static_cast<int>(frames_.size()); }
  double stamp_s(int index) const override {
    return 1e-6 * static_cast<double>(frames_[index].stamp_us);
  }

  FrameImages Read(int index) const override {
    const KlgFrame& frame = frames_[index];
    FrameImages images;
    images.depth_name = Concat(file_.path(), ": depth of frame ", index);
    images.color_name = Concat(file_.path(), ": colour of frame ", index);
    const std::string depth = file_.Read(frame.depth_at, frame.depth_bytes);
    images.depth = depth.size() == 2 * size_.pixels()
                       ? CopyDepth(depth, size_, images.depth_name)
                       : InflateDepth(depth, size_, images.depth_name);
    const std::string color = ReadColor(frame);
    if (color.empty()) return images;
    images.color = color.size() == 3 * size_.pixels()
                       ? CopyColor(color, size_, images.color_name)
                       : DecodeColor(color, size_, images.color_name);
    return images;
  }

 private:
  std::string ReadColor(const KlgFrame& frame) const {
    return file_.Read(frame.depth_at + frame.depth_bytes, frame.color_bytes);
  }

  // Walks over the frames' headers, as far as the file goes.
  void Index() {
    constexpr std::uint64_t kHeader = 16;  // bytes before the images of a frame
    const std::string count = file_.Read(0, sizeof(promised_count_));
    promised_count_ = ByteReader(count).Take<std::int32_t>();
    std::uint64_t at = count.size();
    while (frame_count() < promised_count_ && file_.Has(at, kHeader)) {
      const std::string bytes = file_.Read(at, kHeader);
      ByteReader header(bytes);
      KlgFrame frame;
      frame.stamp_us = header.Take<std::int64_t>();
      const auto depth_bytes = header.Take<std::int32_t>(),
                 color_bytes = header.Take<std::int32_t>();
      if (depth_bytes < 0 || color_bytes < 0) return;
      frame.depth_at = at + kHeader;
      frame.depth_bytes = depth_bytes;
      frame.color_bytes = color_bytes;
      if (!file_.Has(frame.depth_at, frame.depth_bytes + frame.color_bytes)) return;
      frames_.push_back(frame);
      at = frame.depth_at + frame.depth_bytes + frame.color_bytes;
    }
  }

  std::optional<ImageSize> SizeOfFirstJpeg() const {
    for (const KlgFrame& frame : frames_) {
      const std::string color = ReadColor(frame);
      if (IsJpeg(color)) return JpegSize(color, file_.path() + ": the first JPEG");
    }
    return std::nullopt;
  }

  BinaryFile file_;
  ImageSize size_;
  std::int32_t promised_count_ = 0;
  std::vector<KlgFrame> frames_;
};

}  // namespace

OpenedRecording OpenKlg(const std::string& path, ImageSize size) {
  auto frames = std::make_unique<KlgRecording>(path, size);
  OpenedRecording opened;
  if (frames->frame_count() != frames->promised_count()) {
    opened.warnings.push_back(Concat(path, " promises ", frames->promised_count(),
                                     " frames, and is damaged or ends after ",
                                     frames->frame_count()));
  }
  opened.frames = std::move(frames);
  return opened;
}

}  // namespace surfit
