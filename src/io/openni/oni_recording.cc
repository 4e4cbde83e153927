#include <algorithm>
#include <filesystem>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "io/openni/openni_device.h"
#include "io/sequences/raw_frames.h"
#include "surfit/core/error.h"
#include "surfit/geometry/trajectory.h"

namespace surfit {
namespace {

constexpr int kPatience_ms = 5000;  // timeout per image
// Number of playback loops. The player of OpenNI2 occasionally skips an image, which the next loop
// delivers.
constexpr int kRounds = 5;

struct UsedNames {
  std::mutex mutex;
  std::set<int> numbers;
};

UsedNames& Used() {
  static auto* const used = new UsedNames;
  return *used;
}

// Unique path of a file in this process. OpenNI2 shares the playback position among devices with
// the same path. "./" is repeated in the path until it is unique.
class PlayerName {
 public:
  // Throws InputError if the path is too long for OpenNI2.
  explicit PlayerName(const std::string& path) {
    UsedNames& used = Used();
    const std::lock_guard<std::mutex> lock(used.mutex);
    number_ = 0;
    while (used.numbers.count(number_) > 0) ++number_;
    const std::filesystem::path file(path);
    const std::string folder = file.parent_path().string();
    text_ = folder.empty() ? "./" : folder + "/";
    for (int i = 0; i < number_; ++i) text_ += "./";
    text_ += file.filename().string();
    ThrowIf(text_.size() >= ONI_MAX_STR, path, ": OpenNI2 opens paths of at most ", ONI_MAX_STR - 1,
            " bytes");
    used.numbers.insert(number_);
  }
  ~PlayerName() {
    UsedNames& used = Used();
    const std::lock_guard<std::mutex> lock(used.mutex);
    used.numbers.erase(number_);
  }
  PlayerName& operator=(PlayerName&&) = delete;

  const std::string& text() const { return text_; }

 private:
  int number_;
  std::string text_;
};

// OpenNI2 recording (.oni). Depth and colour are paired by timestamp, as in TUM folders.
class OniRecording : public Recording {
 public:
  // Plays the file once to read its timestamps. Throws InputError with the path.
  explicit OniRecording(const SequenceOptions& options)
      : options_(options),
        name_(options.path),
        device_(std::make_shared<const OpenNiLibrary>(options.openni2_library), name_.text()) {
    device_.PlayOnRequest(options_);
    device_.Start();
    ThrowIf(device_.depth_count() < 1, options_.path,
            " has no depth images: the recording may not have been finished");
    Pair(ListImages());
  }

  int frame_count() const override { return static_cast<int>(frames_.size()); }
  FrameStamps stamps(int index) const override { return frames_[index].stamps; }
  // Fast for ascending frames. For an earlier frame, the file must play to its end first.
  FrameImages Read(int index) const override {
    const Frame& frame = frames_[index];
    FrameImages images;
    images.depth_name = Concat(options_.path, ": depth of frame ", index);
    images.color_name = Concat(options_.path, ": colour of frame ", index);
    const auto has_come = [&] {
      return depth_ && depth_->number == frame.depth &&
             (frame.color == 0 || (color_ && color_->number == frame.color));
    };
    for (int i = 0; i < ImagesInRounds() && !has_come(); ++i) {
      std::optional<DeviceImage> image = device_.Next(kPatience_ms);
      if (!image) break;
      const bool is_sought = image->number == (image->is_depth() ? frame.depth : frame.color);
      std::optional<DeviceImage>& last = image->is_depth() ? depth_ : color_;
      // An image of the frame is kept until the other image of the frame arrives.
      const bool is_kept = last && last->number == (image->is_depth() ? frame.depth : frame.color);
      if (is_sought || !is_kept) last = std::move(image);
    }
    ThrowIf(!has_come(), images.depth_name, " or its colour image cannot be played");
    images.depth = depth_->depth;
    if (frame.color > 0) images.color = color_->color;
    return images;
  }

  RgbdCamera Camera() const { return device_.Camera(options_); }
  const std::vector<std::string>& warnings() const { return warnings_; }
  int unpaired_images() const { return unpaired_images_; }  // see OpenedRecording

 private:
  // Image numbers in the file. `color` 0: none.
  struct Frame {
    FrameStamps stamps;
    int depth = 0, color = 0;
  };
  struct StampedNumber {
    double stamp_s = 0;
    int number = 0;
  };
  struct Images {
    std::vector<StampedNumber> depth, color;  // sorted by timestamp
  };

  Images ListImages() {
    const auto depth_count = static_cast<std::size_t>(device_.depth_count());
    const auto color_count = static_cast<std::size_t>(device_.color_count());
    Images images;
    std::set<int> depth_seen, color_seen;
    for (int i = 0; i < ImagesInRounds() &&
                    (depth_seen.size() < depth_count || color_seen.size() < color_count);
         ++i) {
      const std::optional<DeviceImage> image = device_.Next(kPatience_ms);
      if (!image) break;
      std::set<int>& seen = image->is_depth() ? depth_seen : color_seen;
      if (!seen.insert(image->number).second) continue;
      (image->is_depth() ? images.depth : images.color)
          .push_back({SecondsOf(image->stamp_us), image->number});
    }
    if (depth_seen.size() != depth_count || color_seen.size() != color_count) {
      warnings_.push_back(Concat(options_.path, ": only ", depth_seen.size(), " of ", depth_count,
                                 " depth images and ", color_seen.size(), " of ", color_count,
                                 " colour images can be played"));
    }
    for (std::vector<StampedNumber>* list : {&images.depth, &images.color}) {
      std::sort(list->begin(), list->end(), [](const StampedNumber& a, const StampedNumber& b) {
        return std::pair(a.stamp_s, a.number) < std::pair(b.stamp_s, b.number);
      });
    }
    return images;
  }
  void Pair(const Images& images) {
    if (!device_.has_color()) {
      for (const StampedNumber& depth : images.depth)
        frames_.push_back({{depth.stamp_s, depth.stamp_s}, depth.number, 0});
      return;
    }
    const auto stamps_s = [](const std::vector<StampedNumber>& list) {
      std::vector<double> stamps;
      stamps.reserve(list.size());
      for (const StampedNumber& image : list) stamps.push_back(image.stamp_s);
      return stamps;
    };
    for (const auto [c, d] :
         MatchStamps(stamps_s(images.color), stamps_s(images.depth), kMaxBetweenImages_s)) {
      frames_.push_back({{images.depth[d].stamp_s, images.color[c].stamp_s},
                         images.depth[d].number,
                         images.color[c].number});
    }
    unpaired_images_ =
        static_cast<int>(images.color.size() + images.depth.size() - 2 * frames_.size());
    ThrowIf(frames_.empty(), options_.path, ": no colour timestamp is within ", kMaxBetweenImages_s,
            " s of a depth timestamp");
  }
  int ImagesInRounds() const { return kRounds * (device_.depth_count() + device_.color_count()); }

  SequenceOptions options_;
  PlayerName name_;
  mutable OpenNiDevice device_;
  mutable std::optional<DeviceImage> depth_, color_;  // last played images
  std::vector<Frame> frames_;
  std::vector<std::string> warnings_;
  int unpaired_images_ = 0;
};

}  // namespace

OpenedRecording OpenOni(const SequenceOptions& options) {
  auto recording = std::make_unique<OniRecording>(options);
  OpenedRecording opened;
  opened.has_clock = true;
  opened.warnings = recording->warnings();
  opened.unpaired_images = recording->unpaired_images();
  opened.read_camera = [played = recording.get()] {
    return SourceCamera{played->Camera(), "the field of view in the file"};
  };
  opened.frames = std::move(recording);
  return opened;
}

}  // namespace surfit
