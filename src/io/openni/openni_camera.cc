#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "core/repeated_warning.h"
#include "io/openni/camera_connection.h"
#include "io/openni/image_pairs.h"
#include "io/sequences/raw_frames.h"
#include "io/sequences/sequence_camera.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

using Clock = std::chrono::steady_clock;

struct CameraFrame {
  int index = 0;
  ImagePair images;
  double paused_before_s = 0;
  int dropped_before = 0;
  Clock::time_point came;  // arrival time
};

// Reads images in a background thread and keeps the newest `capacity` frames.
class FrameQueue {
 public:
  FrameQueue(const SequenceOptions& options, int capacity)
      : link_(options),
        pairs_(link_.device().has_color()),
        capacity_(static_cast<std::size_t>(capacity)) {}
  ~FrameQueue() { Stop(); }

  // Call before Start() only: afterwards, the thread uses the link.
  const CameraConnection& link() const { return link_; }

  void Start() {
    thread_ = std::thread([this] {
      try {
        while (!ends_) TakeImage();
      } catch (...) {
        const std::lock_guard<std::mutex> lock(mutex_);
        failure_ = std::current_exception();
      }
    });
  }

  // Waits for the next frame. Returns std::nullopt if `stop` is true. Rethrows an exception of the
  // reading thread.
  std::optional<CameraFrame> Next(const std::atomic<bool>& stop) {
    constexpr std::chrono::milliseconds kWakeUp(20);  // polling interval of `stop`
    std::unique_lock<std::mutex> lock(mutex_);
    while (queue_.empty() && !stop) {
      if (failure_) std::rethrow_exception(failure_);
      came_.wait_for(lock, kWakeUp);
    }
    if (stop) return std::nullopt;
    CameraFrame arrival = std::move(queue_.front());
    queue_.pop_front();
    return arrival;
  }

 private:
  void Stop() {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
  }

  void TakeImage() {
    std::optional<DeviceImage> image = link_.Next();
    if (!image) return;
    if (link_.paused_before_s() > 0) {
      pairs_.Clear();
      paused_before_s_ = link_.paused_before_s();
      last_depth_ = 0;  // a reopened device restarts its image numbers
    }
    pairs_.Add(std::move(*image));
    while (std::optional<ImagePair> pair = pairs_.Take()) Add(std::move(*pair));
  }

  // Number of depth images that OpenNI2 replaced by newer images before they were read.
  int DroppedBefore(int number) {
    const int missing = last_depth_ > 0 ? std::max(number - last_depth_ - 1, 0) : 0;
    last_depth_ = number;
    return missing;
  }

  void Add(ImagePair pair) {
    const int dropped = DroppedBefore(pair.depth.number);
    const std::lock_guard<std::mutex> lock(mutex_);
    dropped_ += dropped;
    index_ += dropped;
    queue_.push_back({index_++, std::move(pair), std::exchange(paused_before_s_, 0),
                      std::exchange(dropped_, 0), Clock::now()});
    if (queue_.size() > capacity_) DropOldest();
    came_.notify_one();
  }

  // Adds the counts of dropped frames and pauses to the next frame.
  void DropOldest() {
    CameraFrame& oldest = queue_.front();
    late_.Tell(Concat("frame ", oldest.index, " was dropped: processing is too slow"));
    const int dropped = oldest.dropped_before + 1;
    const double paused_s = oldest.paused_before_s;
    queue_.pop_front();
    if (queue_.empty()) {
      dropped_ += dropped;
      return;
    }
    queue_.front().dropped_before += dropped;
    queue_.front().paused_before_s += paused_s;
  }

  CameraConnection link_;
  ImagePairs pairs_;
  const std::size_t capacity_;
  double paused_before_s_ = 0;
  int last_depth_ = 0;  // number of the last depth image; 0: none
  int index_ = 0;
  RepeatedWarning late_{"frames dropped"};

  std::mutex mutex_;  // protects the members up to failure_
  std::condition_variable came_;
  std::deque<CameraFrame> queue_;
  int dropped_ = 0;  // dropped frames before the next frame
  std::exception_ptr failure_;

  std::atomic<bool> ends_{false};
  std::thread thread_;
};

class OpenNiCamera : public RawFrames {
 public:
  OpenNiCamera(const SequenceOptions& options, std::unique_ptr<FrameQueue> queue,
               const std::atomic<bool>& stop)
      : options_(options),
        stop_(stop),
        name_(queue->link().name()),
        has_color_(queue->link().device().has_color()),
        queue_(std::move(queue)) {}

  // Images of the first complete frame, which is also the first frame of the sequence.
  std::vector<FrameImages> FirstImages() override {
    queue_->Start();
    int dropped = 0;
    while (std::optional<CameraFrame> arrival = queue_->Next(stop_)) {
      last_ = std::move(*arrival);
      last_.dropped_before += dropped;
      dropped = last_.dropped_before + 1;
      if (has_color_ && last_.images.color.color.empty()) continue;
      is_first_ = true;
      return {ImagesOf(last_)};
    }
    throw InputError(name_, ": stopped before the first frame");
  }

  std::optional<RawFrame> Next() override {
    const Clock::time_point asked = Clock::now();
    RawFrame frame;
    while (TakeArrival()) {
      if (options_.last >= 0 && last_.index > options_.last) break;
      frame.head.dropped_before += last_.dropped_before;
      frame.head.paused_before_s += last_.paused_before_s;
      const int after_first = last_.index - options_.first;
      if (after_first < 0 || after_first % options_.stride != 0) continue;
      Describe(asked, &frame);
      return frame;
    }
    return std::nullopt;
  }

  FrameImages Read() override { return ImagesOf(std::exchange(last_, {})); }

 private:
  // Moves the next frame to last_. Returns false if there is no further frame.
  bool TakeArrival() {
    if (std::exchange(is_first_, false)) return true;
    std::optional<CameraFrame> arrival = queue_->Next(stop_);
    if (arrival) last_ = std::move(*arrival);
    return arrival.has_value();
  }

  FrameImages ImagesOf(CameraFrame arrival) const {
    FrameImages images;
    images.depth = std::move(arrival.images.depth.depth);
    images.color = std::move(arrival.images.color.color);
    images.depth_name = Concat(name_, ": depth of frame ", arrival.index);
    images.color_name = Concat(name_, ": colour of frame ", arrival.index);
    return images;
  }

  void Describe(Clock::time_point asked, RawFrame* frame) const {
    const auto ms = [](Clock::duration time) {
      return std::chrono::duration<double, std::milli>(time).count();
    };
    frame->head.index = last_.index;
    frame->head.waited_ms = last_.came > asked ? ms(last_.came - asked) : 0;
    frame->head.queued_ms = ms(Clock::now() - last_.came);
    const double depth_s = SecondsOf(last_.images.depth.stamp_us);
    frame->stamps = {depth_s, depth_s};
    if (!has_color_) return;
    if (last_.images.color.color.empty()) {
      frame->head.error =
          Concat(name_, ": no colour image within ", kMaxBetweenImages_s, " s of the depth image");
    } else {
      frame->stamps.color_s = SecondsOf(last_.images.color.stamp_us);
    }
  }

  const SequenceOptions options_;
  const std::atomic<bool>& stop_;
  const std::string name_;
  const bool has_color_;
  std::unique_ptr<FrameQueue> queue_;
  CameraFrame last_;
  bool is_first_ = false;  // last_ is the first frame and was not returned by Next() yet
};

}  // namespace

RawSequence OpenOpenNiCamera(const SequenceOptions& options, int capacity,
                             const std::atomic<bool>& stop) {
  auto queue = std::make_unique<FrameQueue>(options, capacity);
  SequenceInfo info;
  info.format = "openni2";
  info.frame_count = -1;
  info.has_clock = true;
  const bool scale_is_given = ResolveCamera(
      options,
      [&]() -> SourceCamera {
        return {queue->link().device().Camera(options), queue->link().name() + " (field of view)"};
      },
      &info);
  return MakeRawSequence(std::move(info),
                         std::make_unique<OpenNiCamera>(options, std::move(queue), stop), options,
                         scale_is_given);
}

}  // namespace surfit
