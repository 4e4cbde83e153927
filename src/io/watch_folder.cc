#include "surfit/io/watch_folder.h"

#include <deque>
#include <utility>

#include "io/corrected_source.h"
#include "io/folder.h"
#include "io/image_sequence.h"
#include "io/sequence_camera.h"
#include "io/sequence_info.h"
#include "io/watched_folder.h"
#include "surfit/core/error.h"
#include "surfit/core/trace.h"
#include "surfit/io/depth_field.h"

namespace surfit {
namespace {

class WatchSource : public FrameSource {
 public:
  WatchSource(const SequenceOptions& options, SequenceInfo info, WatchedFolder folder)
      : options_(options),
        info_(std::move(info)),
        folder_(std::move(folder)),
        preparer_(CompleteInfo(WaitForImages(), options.prepare, &info_)) {}

  const SequenceInfo& info() const override { return info_; }

  std::optional<ReadResult> Next() override {
    while (options_.last == -1 || count_ <= options_.last) {
      std::optional<Arrival> arrival = NextArrival();
      if (!arrival) break;
      const int index = count_++;
      if (index < options_.first || (index - options_.first) % options_.stride != 0) continue;
      return Prepare(std::move(*arrival), index);
    }
    return std::nullopt;
  }

 private:
  // The first frame's that can be read; it and those before it are still to be given out.
  const FrameImages& WaitForImages() {
    while (std::optional<Arrival> arrival = folder_.Next()) {
      ahead_.push_back(std::move(*arrival));
      if (ahead_.back().images) return *ahead_.back().images;
    }
    throw InputError(Concat("no frame of ", options_.path,
                            " can be read: ", ahead_.empty() ? "none came" : ahead_.front().error));
  }

  std::optional<Arrival> NextArrival() {
    if (ahead_.empty()) return folder_.Next();
    std::optional<Arrival> arrival = std::move(ahead_.front());
    ahead_.pop_front();
    return arrival;
  }

  ReadResult Prepare(Arrival arrival, int index) const {
    ReadResult result;
    result.index = index;
    result.stamp_s = arrival.stamp_s;
    result.error = arrival.error;
    result.decode_ms = arrival.decode_ms;
    if (!arrival.images) return result;
    try {
      const StageTimer timer("decode", index, &result.decode_ms);
      result.frame =
          MakeFrame(info_.camera, preparer_, std::move(*arrival.images), index, arrival.stamp_s);
    } catch (const InputError& error) {
      result.error = error.what();
    }
    return result;
  }

  SequenceOptions options_;
  SequenceInfo info_;
  WatchedFolder folder_;
  std::deque<Arrival> ahead_;  // taken, but not given out yet
  FramePreparer preparer_;
  int count_ = 0;  // of frames so far, whether chosen or not
};

}  // namespace

std::unique_ptr<FrameSource> WatchFolder(const SequenceOptions& options,
                                         const std::atomic<bool>& stop) {
  options.Validate();
  if (!IsFolder(options.path)) throw InputError(options.path + " is no folder");
  SequenceInfo info;
  info.format = "watch";
  info.frame_count = -1;
  info.camera = ResolveCamera(options, info.format, &info.warnings);
  WatchedFolder folder(options.path, info.camera.frames_per_second, stop);
  return CorrectedSource(std::make_unique<WatchSource>(options, std::move(info), std::move(folder)),
                         ReadDepthField(options, "watch"));
}

}  // namespace surfit
