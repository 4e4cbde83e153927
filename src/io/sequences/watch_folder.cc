#include <glog/logging.h>

#include <chrono>
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include "core/repeated_warning.h"
#include "core/trace.h"
#include "io/sequences/confidence.h"
#include "io/sequences/folder.h"
#include "io/sequences/folder_recording.h"
#include "io/sequences/raw_frames.h"
#include "io/sequences/sequence_camera.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

constexpr std::chrono::milliseconds kPause(10);  // polling interval
constexpr std::chrono::seconds kPatience(2);     // timeout for an incomplete frame

// Frame that was read, or an error.
struct Arrival {
  FrameStamps stamps;
  std::optional<FrameImages> images;
  std::string error;   // reason for missing images
  double read_ms = 0;  // reading time
};

// Reads numbered images as they appear, see WatchFolder().
class WatchedFolder {
 public:
  WatchedFolder(std::string path, double frames_per_second, bool confidence,
                const std::atomic<bool>& stop)
      : path_(std::move(path)),
        frames_per_second_(frames_per_second),
        stop_(stop),
        confidence_(confidence) {}

  // Waits for the next frame. Returns std::nullopt after the last frame or after a stop.
  std::optional<Arrival> Next();

 private:
  using Clock = std::chrono::steady_clock;

  // Adds new frames to waiting_.
  void List();
  // A missing confidence image is an error, except in the last try. Throws InputError that names
  // the file.
  FrameImages Read(FrameFiles files, bool is_last_try);
  // Removes and returns the first waiting frame if it is complete. After the timeout, or if a later
  // frame was already read, returns an error instead. Otherwise, returns std::nullopt. `ended`: no
  // further images will appear.
  std::optional<Arrival> TakeFirst(bool ended);

  std::string path_;
  double frames_per_second_;
  const std::atomic<bool>& stop_;
  const bool confidence_;     // use the images in confidence/, if this folder exists
  int confidence_range_ = 0;  // ConfidenceRange() of the first image; 0: no image yet
  // A pointer, because RepeatedWarning cannot be moved.
  std::unique_ptr<RepeatedWarning> without_confidence_ =
      std::make_unique<RepeatedWarning>("frames without a confidence image");
  std::optional<std::string> color_folder_;  // set by the first frame; "": frames without colour
  std::map<long, FrameFiles> waiting_;       // by frame number
  std::set<long> taken_;
  std::set<std::string> told_;                  // logged warnings about duplicate numbers
  std::optional<Clock::time_point> first_try_;  // first attempt to read the first waiting frame
};

void WatchedFolder::List() {
  const std::string color_folder = color_folder_ ? *color_folder_ : FindColorFolder(path_);
  const auto tell = [this](const std::string& twice) {
    if (told_.insert(twice).second) LOG(WARNING) << twice;
  };
  std::vector<FrameFiles> frames = ListNumberedFrames(path_ + "/depth", color_folder, tell);
  if (confidence_) AddNamedConfidence(ConfidenceFolder(path_), /*has_clock=*/false, tell, &frames);
  for (FrameFiles& files : frames) {
    const long number = static_cast<long>(files.stamps.depth_s);
    if (taken_.count(number) > 0) continue;
    files.stamps.depth_s = files.stamps.color_s = static_cast<double>(number) / frames_per_second_;
    waiting_[number] = files;
  }
}

FrameImages WatchedFolder::Read(FrameFiles files, bool is_last_try) {
  const bool is_missing =
      confidence_ && files.confidence_path.empty() && IsFolder(ConfidenceFolder(path_));
  const std::string missing = files.depth_path + " has no confidence image";
  if (is_missing && !is_last_try) throw InputError(missing);
  if (!files.confidence_path.empty() && confidence_range_ == 0)
    confidence_range_ = ConfidenceRange(ReadConfidenceImage(files.confidence_path));
  files.confidence_range = confidence_range_;
  FrameImages images = ReadFrameFiles(files);
  if (is_missing) without_confidence_->Tell(missing + ": all of its depth is used");
  return images;
}

std::optional<Arrival> WatchedFolder::TakeFirst(bool ended) {
  if (waiting_.empty()) return std::nullopt;
  const auto [number, files] = *waiting_.begin();
  Arrival arrival;
  arrival.stamps = files.stamps;
  if (!taken_.empty() && number < *taken_.rbegin()) {
    arrival.error =
        Concat(files.depth_path, " arrived after frame ", *taken_.rbegin(), " was read");
  } else {
    const bool is_last_try = ended || (first_try_ && Clock::now() - *first_try_ >= kPatience);
    try {
      const StageTimer timer("read", static_cast<int>(taken_.size()), &arrival.read_ms);
      arrival.images = Read(files, is_last_try);
      if (!color_folder_) color_folder_ = FindColorFolder(path_);
    } catch (const InputError& error) {
      if (!first_try_) first_try_ = Clock::now();
      if (!is_last_try) return std::nullopt;
      arrival.error = error.what();
    }
  }
  first_try_.reset();
  taken_.insert(number);
  waiting_.erase(number);
  return arrival;
}

std::optional<Arrival> WatchedFolder::Next() {
  while (!stop_) {
    // Must precede List(), so that no frame before `done` is missed.
    const bool ended = IsFile(path_ + "/done");
    List();
    if (auto arrival = TakeFirst(ended)) return arrival;
    if (ended) return std::nullopt;
    std::this_thread::sleep_for(kPause);
  }
  return std::nullopt;
}

class WatchedFrames : public RawFrames {
 public:
  WatchedFrames(const SequenceOptions& options, WatchedFolder folder)
      : options_(options), folder_(std::move(folder)) {}

  // Images of the first readable frame. This frame and all frames before it are stored in ahead_.
  std::vector<FrameImages> FirstImages() override {
    while (std::optional<Arrival> arrival = folder_.Next()) {
      ahead_.push_back(std::move(*arrival));
      if (ahead_.back().images) return {*ahead_.back().images};
    }
    throw InputError("no frame of ", options_.path,
                     " can be read: ", ahead_.empty() ? "no frame arrived" : ahead_.front().error);
  }

  std::optional<RawFrame> Next() override {
    while (options_.last == -1 || count_ <= options_.last) {
      std::optional<Arrival> arrival = NextArrival();
      if (!arrival) break;
      const int index = count_++;
      if (index < options_.first || (index - options_.first) % options_.stride != 0) continue;
      RawFrame frame;
      frame.head.index = index;
      frame.head.error = arrival->error;
      frame.head.read_ms = arrival->read_ms;
      frame.stamps = arrival->stamps;
      images_ = std::move(arrival->images);
      return frame;
    }
    return std::nullopt;
  }

  FrameImages Read() override { return std::move(*images_); }

 private:
  std::optional<Arrival> NextArrival() {
    if (ahead_.empty()) return folder_.Next();
    std::optional<Arrival> arrival = std::move(ahead_.front());
    ahead_.pop_front();
    return arrival;
  }

  const SequenceOptions options_;
  WatchedFolder folder_;
  std::deque<Arrival> ahead_;          // frames that FirstImages() read ahead
  std::optional<FrameImages> images_;  // images of the last frame of Next()
  int count_ = 0;                      // number of frames so far, including skipped frames
};

}  // namespace

RawSequence OpenWatchedFolder(const SequenceOptions& options, const std::atomic<bool>& stop) {
  ThrowIf(!IsFolder(options.path), options.path, " is not a folder");
  SequenceInfo info;
  info.format = "watch";
  info.frame_count = -1;
  const bool scale_is_given = ResolveCamera(options, /*tell=*/{}, &info);
  DropLatency(options, &info.camera);
  WatchedFolder folder(options.path, info.camera.frames_per_second, options.confidence, stop);
  return MakeRawSequence(std::move(info),
                         std::make_unique<WatchedFrames>(options, std::move(folder)), options,
                         scale_is_given);
}

std::unique_ptr<FrameSource> WatchFolder(const SequenceOptions& options,
                                         const std::atomic<bool>& stop) {
  Validate(options);
  return MakeFrameSource(OpenWatchedFolder(options, stop));
}

}  // namespace surfit
