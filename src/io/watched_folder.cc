#include "io/watched_folder.h"

#include <thread>

#include "io/folder.h"
#include "io/folder_recording.h"
#include "io/numbered_frames.h"
#include "surfit/core/error.h"
#include "surfit/core/trace.h"

namespace surfit {
namespace {

constexpr std::chrono::milliseconds kPause(10);
constexpr std::chrono::seconds kPatience(2);

}  // namespace

void WatchedFolder::List() {
  const std::string color_folder = color_folder_ ? *color_folder_ : FindColorFolder(path_);
  for (FrameFiles& files : ListNumberedFrames(path_ + "/depth", color_folder)) {
    const long number = static_cast<long>(files.stamp_s);
    if (taken_.count(number) > 0) continue;
    files.stamp_s /= frames_per_second_;
    waiting_[number] = files;
  }
}

std::optional<Arrival> WatchedFolder::TakeFirst(bool ended) {
  if (waiting_.empty()) return std::nullopt;
  const auto [number, files] = *waiting_.begin();
  Arrival arrival;
  arrival.stamp_s = files.stamp_s;
  if (!taken_.empty() && number < *taken_.rbegin()) {
    arrival.error = Concat(files.depth_path, " came after frame ", *taken_.rbegin(), " was taken");
  } else {
    try {
      const StageTimer timer("decode", static_cast<int>(taken_.size()), &arrival.decode_ms);
      arrival.images = ReadFrameFiles(files);
      if (!color_folder_) color_folder_ = FindColorFolder(path_);
    } catch (const InputError& error) {
      if (!first_try_) first_try_ = Clock::now();
      if (!ended && Clock::now() - *first_try_ < kPatience) return std::nullopt;
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
    // Looked for before the frames, so that none that came before it is missed.
    const bool ended = IsFile(path_ + "/done");
    List();
    if (auto arrival = TakeFirst(ended)) return arrival;
    if (ended) return std::nullopt;
    std::this_thread::sleep_for(kPause);
  }
  return std::nullopt;
}

}  // namespace surfit
