#include <algorithm>
#include <cctype>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "io/files/text.h"
#include "io/matroska/azure_camera.h"
#include "io/matroska/matroska_file.h"
#include "io/sequences/frame_bytes.h"
#include "io/sequences/recording.h"
#include "surfit/core/error.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/io/camera_files.h"

namespace surfit {
namespace {

constexpr std::uint64_t kVideoTrack = 1;

// Frame of a track.
struct MkvImage {
  double stamp_s = 0;
  std::uint64_t at = 0, count = 0;  // position in the file
};

// Recording of an Azure Kinect. Depth and colour are paired by timestamp, as in TUM folders. Images
// are undistorted if the file has the calibration.
class AzureKinectRecording : public Recording {
 public:
  // Throws InputError with the path.
  explicit AzureKinectRecording(const std::string& path)
      : file_(path), content_(ReadMatroska(file_)) {
    depth_ = FindTrack("DEPTH");
    color_ = FindTrack("COLOR");
    ThrowIf(depth_ == nullptr, path, " has no video track DEPTH: the recorder must store depth");
    RequireFormat(*depth_, depth_->pixel_format == "b16g", "b16g (16-bit grey)");
    if (color_ != nullptr) {
      RequireFormat(*color_,
                    color_->codec == "V_MJPEG" || color_->pixel_format == "MJPG" ||
                        color_->pixel_format == "BGRA",
                    "MJPG or BGRA");
    }
    Pair();
    SetCalibration();
  }

  int frame_count() const override { return static_cast<int>(frames_.size()); }
  FrameStamps stamps(int index) const override {
    return {frames_[index].depth.stamp_s, frames_[index].color.stamp_s};
  }
  FrameImages Read(int index) const override {
    const Frame& frame = frames_[index];
    FrameImages images;
    images.depth_name = Concat(file_.path(), ": depth of frame ", index);
    Image<std::uint16_t> depth = ReadDepth(frame.depth, images.depth_name);
    if (depth_lens_) depth = depth_lens_->Undistorted(depth);
    images.depth = std::move(depth);
    if (color_ == nullptr) return images;
    images.color_name = Concat(file_.path(), ": colour of frame ", index);
    images.color = ReadColor(frame.color, images.color_name);
    if (color_lens_) images.color = color_lens_->Undistorted(images.color);
    return images;
  }

  bool has_calibration() const { return calibration_.has_value(); }
  // Without calibration, the options must set the cameras. Throws InputError otherwise.
  RgbdCamera Camera(const SequenceOptions& options) const {
    RgbdCamera camera = CameraPreset("redwood");
    camera.depth_units_per_metre = 1000;
    camera.color_is_registered = color_ == nullptr;
    if (calibration_) {
      camera.depth = depth_lens_->pinhole();
      if (color_lens_) camera.color = color_lens_->pinhole();
      camera.color_from_depth = calibration_->color_from_depth;
      return camera;
    }
    ThrowIf(!options.intrinsics, file_.path(),
            " has no attachment calibration.json: set intrinsics, or a camera.yaml");
    ThrowIf(color_ != nullptr && (!options.color_intrinsics || !options.color_from_depth),
            file_.path(),
            " has no attachment calibration.json: set color_intrinsics and color_from_depth, or a "
            "camera.yaml");
    const auto sized = [](ImageSize size) {
      return PinholeCamera{size.width, size.height, 1, 1, 0, 0, {}};
    };
    camera.depth = sized(depth_->size);
    if (color_ != nullptr) camera.color = sized(color_->size);
    return camera;
  }
  const std::vector<std::string>& warnings() const { return warnings_; }
  int unpaired_images() const { return unpaired_images_; }  // see OpenedRecording

 private:
  struct Frame {
    MkvImage depth, color;
  };

  const MatroskaTrack* FindTrack(const char* name) const {
    for (const MatroskaTrack& track : content_.tracks) {
      if (track.type == kVideoTrack && track.name == name) return &track;
    }
    return nullptr;
  }

  void RequireFormat(const MatroskaTrack& track, bool is_known, const char* known) const {
    const std::string name = Concat(file_.path(), ": track ", track.name);
    const bool is_named = std::all_of(track.pixel_format.begin(), track.pixel_format.end(),
                                      [](unsigned char c) { return std::isprint(c) != 0; });
    ThrowIf(!is_known, name, " has the format ",
            is_named && !track.pixel_format.empty() ? track.pixel_format : track.codec,
            ", must be ", known);
    ThrowIf(track.is_encoded, name,
            " is compressed or encrypted by Matroska, which is not supported");
    ThrowIf(track.size.width == 0 || track.size.height == 0, name, " has no image size");
  }

  // Timestamps of the device: the times in the file begin at the first frame of the recording.
  std::vector<MkvImage> ImagesOf(const MatroskaTrack& track) const {
    const auto start = content_.tags.find("K4A_START_OFFSET_NS");
    const double start_ns =
        start == content_.tags.end()
            ? 0
            : ParseNumber(start->second, file_.path() + ": K4A_START_OFFSET_NS");
    std::vector<MkvImage> images;
    for (const MatroskaBlock& block : content_.blocks) {
      if (block.track != track.number) continue;
      ThrowIf(block.is_laced, file_.path(), ": track ", track.name,
              " stores several frames per block, which is not supported");
      images.push_back(
          {1e-9 * (static_cast<double>(block.stamp_ns) + start_ns), block.at, block.count});
    }
    std::stable_sort(images.begin(), images.end(),
                     [](const MkvImage& a, const MkvImage& b) { return a.stamp_s < b.stamp_s; });
    return images;
  }

  void Pair() {
    const std::vector<MkvImage> depth = ImagesOf(*depth_);
    if (color_ == nullptr) {
      for (const MkvImage& image : depth) frames_.push_back({image, image});
    } else {
      const std::vector<MkvImage> color = ImagesOf(*color_);
      const auto stamps = [](const std::vector<MkvImage>& images) {
        std::vector<double> stamps_s;
        stamps_s.reserve(images.size());
        for (const MkvImage& image : images) stamps_s.push_back(image.stamp_s);
        return stamps_s;
      };
      for (const auto [c, d] : MatchStamps(stamps(color), stamps(depth), kMaxBetweenImages_s))
        frames_.push_back({depth[d], color[c]});
      ThrowIf(frames_.empty() && !depth.empty(), file_.path(), ": no colour image is within ",
              kMaxBetweenImages_s, " s of a depth image");
      unpaired_images_ = static_cast<int>(color.size() + depth.size() - 2 * frames_.size());
    }
    if (content_.is_truncated) {
      warnings_.push_back(
          Concat(file_.path(), " is truncated, its ", frames_.size(), " complete frames are read"));
    }
  }

  void SetCalibration() {
    const auto file = std::find_if(
        content_.attachments.begin(), content_.attachments.end(),
        [](const MatroskaAttachment& attachment) { return attachment.name == "calibration.json"; });
    if (file == content_.attachments.end()) return;
    std::string json = file_.Read(file->at, file->count);
    json.resize(json.find_last_not_of('\0') + 1);
    calibration_ =
        ParseAzureCalibration(json, depth_->size, color_ == nullptr ? ImageSize() : color_->size,
                              file_.path() + ": calibration.json");
    depth_lens_.emplace(calibration_->depth);
    if (calibration_->color) color_lens_.emplace(*calibration_->color);
  }

  Image<std::uint16_t> ReadDepth(const MkvImage& image, const std::string& name) const {
    const std::string bytes = file_.Read(image.at, image.count);
    ThrowIf(bytes.size() != 2 * depth_->size.pixels(), name, " has ", bytes.size(),
            " bytes, must have ", 2 * depth_->size.pixels());
    Image<std::uint16_t> depth(depth_->size.width, depth_->size.height);
    for (std::size_t i = 0; i < depth.size(); ++i) {  // big endian
      const auto high = static_cast<unsigned char>(bytes[2 * i]);
      const auto low = static_cast<unsigned char>(bytes[2 * i + 1]);
      depth[i] = static_cast<std::uint16_t>(high << 8 | low);
    }
    return depth;
  }

  Image<Rgb8> ReadColor(const MkvImage& image, const std::string& name) const {
    const std::string bytes = file_.Read(image.at, image.count);
    if (color_->pixel_format == "BGRA") {
      ThrowIf(bytes.size() != 4 * color_->size.pixels(), name, " has ", bytes.size(),
              " bytes, must have ", 4 * color_->size.pixels());
      Image<Rgb8> color(color_->size.width, color_->size.height);
      for (std::size_t i = 0; i < color.size(); ++i) {
        const auto channel = [&](int k) { return static_cast<std::uint8_t>(bytes[4 * i + k]); };
        color[i] = {channel(2), channel(1), channel(0)};
      }
      return color;
    }
    const ImageSize size = JpegSize(bytes, name);
    ThrowIf(size != color_->size, name, " is ", size.width, " x ", size.height, " pixels, must be ",
            color_->size.width, " x ", color_->size.height);
    return DecodeJpeg(bytes, name);
  }

  BinaryFile file_;
  MatroskaContent content_;
  const MatroskaTrack* depth_ = nullptr;
  const MatroskaTrack* color_ = nullptr;  // null: the file has no colour
  std::vector<Frame> frames_;
  std::optional<AzureCalibration> calibration_;
  mutable std::optional<AzureUndistorter> depth_lens_, color_lens_;
  std::vector<std::string> warnings_;
  int unpaired_images_ = 0;
};

}  // namespace

OpenedRecording OpenAzureKinect(const SequenceOptions& options) {
  auto recording = std::make_unique<AzureKinectRecording>(options.path);
  OpenedRecording opened;
  opened.has_clock = true;
  opened.warnings = recording->warnings();
  opened.unpaired_images = recording->unpaired_images();
  opened.read_camera = [options, frames = recording.get()] {
    const char* const from = frames->has_calibration() ? "calibration.json in the file" : "options";
    return SourceCamera{frames->Camera(options), from, false, true};
  };
  opened.frames = std::move(recording);
  return opened;
}

}  // namespace surfit
