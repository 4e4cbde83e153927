#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/repeated_warning.h"
#include "io/cursor.h"
#include "io/images/deflate.h"
#include "io/images/image_files.h"
#include "io/sequences/frame_bytes.h"
#include "io/sequences/klg_writer.h"
#include "io/sequences/recording.h"
#include "io/stamps/time_words.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "surfit/io/camera_files.h"

namespace surfit {
namespace {

struct KlgFrame {
  std::int64_t stamp = 0;
  std::uint64_t depth_at = 0;  // byte in the file; colour follows depth
  std::uint64_t depth_bytes = 0;
  std::uint64_t color_bytes = 0;
};

class KlgRecording : public Recording {
 public:
  KlgRecording(const std::string& path, ImageSize size) : file_(path), size_(size) {
    Index();
    SetUnit();
    if (const auto claimed = SizeOfFirstJpeg()) size_ = *claimed;
    ThrowIf(size_ == ImageSize(), path, " does not store the image size: set camera");
  }

  int claimed_count() const { return claimed_count_; }
  // True if bytes after the last complete frame were not read.
  bool has_rest() const { return file_.Has(end_, 1); }
  // Empty if timestamps are in us.
  const std::string& unit_warning() const { return unit_warning_; }
  int frame_count() const override { return static_cast<int>(frames_.size()); }
  FrameStamps stamps(int index) const override {
    const double stamp_s = second_ * static_cast<double>(frames_[index].stamp);
    return {stamp_s, stamp_s};
  }

  FrameImages Read(int index) const override {
    const KlgFrame& frame = frames_[index];
    const std::uint64_t color_at = frame.depth_at + frame.depth_bytes;
    return ReadImages(
        file_, index,
        {frame.depth_at, frame.depth_bytes, size_, frame.depth_bytes == 2 * size_.pixels()},
        {color_at, frame.color_bytes, size_, frame.color_bytes == 3 * size_.pixels()});
  }

 private:
  // Stops at the first invalid or truncated frame. After a crash of the logger, the count in the
  // file is too small, usually 0 or -1. Therefore frames after the count are read too, if they have
  // depth. Zero padding has no depth.
  void Index() {
    constexpr std::uint64_t kHeader = 16;  // bytes before the images of a frame
    const std::string count = file_.Read(0, sizeof(claimed_count_));
    claimed_count_ = Cursor(count, file_.path()).Take<std::int32_t>();
    end_ = count.size();
    while (file_.Has(end_, kHeader)) {
      const std::string bytes = file_.Read(end_, kHeader);
      Cursor header(bytes, file_.path());
      KlgFrame frame;
      frame.stamp = header.Take<std::int64_t>();
      const auto depth_bytes = header.Take<std::int32_t>(),
                 color_bytes = header.Take<std::int32_t>();
      if (depth_bytes < 0 || color_bytes < 0) return;
      if (depth_bytes == 0 && frame_count() >= claimed_count_) return;
      frame.depth_at = end_ + kHeader;
      frame.depth_bytes = depth_bytes;
      frame.color_bytes = color_bytes;
      if (!file_.Has(frame.depth_at, frame.depth_bytes + frame.color_bytes)) return;
      frames_.push_back(frame);
      end_ = frame.depth_at + frame.depth_bytes + frame.color_bytes;
    }
  }

  // Some loggers write ms or ns instead of us.
  void SetUnit() {
    std::vector<double> stamps;
    for (const KlgFrame& frame : frames_) stamps.push_back(static_cast<double>(frame.stamp));
    const int decimals = DetectTimeUnit(stamps).value_or(0);
    if (decimals != 3 && decimals != 9) return;
    second_ = decimals == 3 ? 1e-3 : 1e-9;
    unit_warning_ = Concat(file_.path(), ": timestamps are in ", TimeUnitName(decimals),
                           " instead of us by their intervals, they are converted to s");
  }

  std::optional<ImageSize> SizeOfFirstJpeg() const {
    for (const KlgFrame& frame : frames_) {
      const std::string color = file_.Read(frame.depth_at + frame.depth_bytes, frame.color_bytes);
      if (IsJpeg(color)) return JpegSize(color, file_.path() + ": the first JPEG");
    }
    return std::nullopt;
  }

  BinaryFile file_;
  ImageSize size_;
  std::int32_t claimed_count_ = 0;
  std::vector<KlgFrame> frames_;
  std::uint64_t end_ = 0;  // byte after the last complete frame
  double second_ = 1e-6;   // unit of the timestamps, s
  std::string unit_warning_;
};

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "values are copied from memory");

template <typename T>
void Put(T value, std::ostream& out) {
  out.write(reinterpret_cast<const char*>(&value), sizeof(T));
}

// Converts depth to mm. Values above 65534 mm become 0 and are counted in *beyond.
Image<std::uint16_t> Millimetres(const Image<float>& depth_m, std::int64_t* beyond) {
  constexpr long kMost = 65534;  // 65535 is missing depth in other formats
  Image<std::uint16_t> depth(depth_m.width(), depth_m.height());
  for (std::size_t i = 0; i < depth.size(); ++i) {
    const long value = std::lround(1000. * depth_m[i]);
    if (value > kMost) ++*beyond;
    depth[i] = value > kMost ? 0 : static_cast<std::uint16_t>(value);
  }
  return depth;
}

template <typename T>
std::string RawBytes(const Image<T>& image) {
  return {reinterpret_cast<const char*>(image.data()), image.size() * sizeof(T)};
}

// Readers recognise uncompressed images by their size.
std::string DepthBytes(const Image<std::uint16_t>& depth) {
  constexpr int kLevel = 6;
  std::string raw = RawBytes(depth);
  std::string deflated = Deflate(raw.data(), raw.size(), kLevel);
  return deflated.size() < raw.size() ? deflated : raw;
}

std::string ColorBytes(const Image<Rgb8>& color) {
  constexpr int kQuality = 95;
  std::string raw = RawBytes(color);
  if (color.empty()) return raw;
  std::string jpeg = EncodeJpeg(color, kQuality);
  return jpeg.size() == raw.size() ? raw : jpeg;
}

void WriteFrame(const RgbdFrame& frame, std::ostream& out, KlgSummary* summary) {
  const std::string depth = DepthBytes(Millimetres(frame.depth_m, &summary->depths_out_of_range));
  const std::string color = ColorBytes(frame.color);
  Put(static_cast<std::int64_t>(std::llround(1e6 * frame.stamp_s)), out);
  Put(static_cast<std::int32_t>(depth.size()), out);
  Put(static_cast<std::int32_t>(color.size()), out);
  out << depth << color;
}

// Camera of the written frames. For mirrored sources, fy is negative as in the source. The latency
// is 0, because it is already subtracted from the written timestamps.
RgbdCamera FrameCamera(const SequenceInfo& info) {
  RgbdCamera camera;
  camera.depth = info.pinhole;
  camera.noise = info.camera.noise;
  if (info.mirrored) camera.depth.fy = -camera.depth.fy;
  camera.depth_units_per_metre = 1000;
  camera.frames_per_second = info.camera.frames_per_second;
  return camera;
}

}  // namespace

OpenedRecording OpenKlg(const std::string& path, ImageSize size) {
  auto frames = std::make_unique<KlgRecording>(path, size);
  OpenedRecording opened;
  opened.has_clock = true;
  const int claimed = frames->claimed_count(), found = frames->frame_count();
  if (claimed < found) {
    opened.warnings.push_back(
        Concat(path, " declares ", claimed, " frames, but has ", found,
               ": the recorder did not end normally, all are read",
               frames->has_rest() ? ", except the last, incomplete one" : ""));
  } else {
    WarnIfShort(path, claimed, found, &opened);
  }
  if (!frames->unit_warning().empty()) opened.warnings.push_back(frames->unit_warning());
  opened.frames = std::move(frames);
  return opened;
}

KlgSummary WriteKlg(FrameSource* source, const std::string& path) {
  KlgSummary summary;
  RepeatedWarning skipped("frames skipped");
  WriteFileAtomically(path, [&](std::ostream& out) {
    Put(std::int32_t{0}, out);  // number of frames, written at the end
    while (const auto result = source->Next()) {
      if (result->frame) {
        WriteFrame(*result->frame, out, &summary);
        ++summary.frames_written;
      } else {
        skipped.Tell(Concat("frame ", result->index, " skipped: ", result->error));
        ++summary.frames_skipped;
      }
    }
    ThrowIf(summary.frames_written == 0, "no frame could be read for ", path);
    out.seekp(0);
    Put(static_cast<std::int32_t>(summary.frames_written), out);
  });
  WriteCameraYaml(FrameCamera(source->info()), path + ".yaml");
  return summary;
}

}  // namespace surfit
