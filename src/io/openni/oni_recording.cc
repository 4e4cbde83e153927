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

constexpr int kPatience_ms = 5000;  // images come at once
// OpenNI2's player now and then goes on by two images, and then the first is lost for this round.
constexpr int kRounds = 5;

struct UsedNames {
  std::mutex mutex;
  std::set<int> numbers;
};

UsedNames& Used() {
  static auto* const used = new UsedNames;
  return *used;
}

// A name for a file that nothing in this process has while this lives: devices of one name share a
// position in the file.
class PlayerName {
 public:
  // Throws InputError where OpenNI2 holds no name of that length.
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

// A recording of OpenNI2 (.oni), played image by image. Depth and colour are paired by their
// stamps, as images of TUM folders are.
class OniRecording : public Recording {
 public:
  // Plays all of it once, for its stamps. Throws InputError naming the file.
  explicit OniRecording(const SequenceOptions& options)
      : options_(options),
        name_(options.path),
        device_(std::make_shared<const OpenNiLibrary>(options.openni2_library), name_.text()) {
    device_.PlayOnRequest(options_);
    device_.Start();
    ThrowIf(device_.depth_count() < 1, options_.path,
            " tells of no image of depth, as where its recording was not ended");
    Pair(ListImages());
  }

  int frame_count() const override { return static_cast<int>(frames_.size()); }
  FrameStamps stamps(int index) const override { return frames_[index].stamps; }
  // Quick for one frame after the other; for an earlier one the rest of the file is played first.
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
      // The other image of the frame may come first by some.
      const bool is_kept = last && last->number == (image->is_depth() ? frame.depth : frame.color);
      if (is_sought || !is_kept) last = std::move(image);
    }
    ThrowIf(!has_come(), images.depth_name, " or its colour cannot be played");
    images.depth = depth_->depth;
    if (frame.color > 0) images.color = color_->color;
    return images;
  }

  RgbdCamera Camera() const { return device_.Camera(options_); }
  const std::vector<std::string>& warnings() const { return warnings_; }
  int unpaired_images() const { return unpaired_images_; }  // OpenedRecording

 private:
  // Numbers of images in the file; color is 0 without one.
  struct Frame {
    FrameStamps stamps;
    int depth = 0, color = 0;
  };
  struct StampedNumber {
    double stamp_s = 0;
    int number = 0;
  };
  struct Images {
    std::vector<StampedNumber> depth, color;  // in order of their stamps
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
      warnings_.push_back(Concat(options_.path, ": ", depth_seen.size(), " of ", depth_count,
                                 " images of depth and ", color_seen.size(), " of ", color_count,
                                 " of colour can be played"));
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
    ThrowIf(frames_.empty(), options_.path, ": no stamp of colour is within ", kMaxBetweenImages_s,
            " s of one of depth");
  }
  // How many images are played in some rounds of the file.
  int ImagesInRounds() const { return kRounds * (device_.depth_count() + device_.color_count()); }

  SequenceOptions options_;
  PlayerName name_;
  mutable OpenNiDevice device_;
  mutable std::optional<DeviceImage> depth_, color_;  // the last ones that were played
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
  opened.tell_camera = [played = recording.get()] {
    return ToldCamera{played->Camera(), "the file's field of view"};
  };
  opened.frames = std::move(recording);
  return opened;
}

}  // namespace surfit
