#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "io/phones/phone_recording.h"
#include "io/sequences/confidence.h"
#include "io/sequences/folder.h"
#include "io/sequences/folder_recording.h"
#include "io/sequences/raw_frames.h"
#include "io/sequences/recording.h"
#include "io/sequences/sequence_camera.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/io/sequence.h"

namespace surfit {
namespace {

SequenceFiles ListSequence(const std::string& format, const std::string& folder,
                           double frames_per_second) {
  if (format == "seven_scenes") return ListSevenScenesSequence(folder, frames_per_second);
  if (format == "redwood") return ListRedwoodSequence(folder, frames_per_second);
  if (format == "replica") return ListReplicaSequence(folder, frames_per_second);
  if (format == "icl_nuim") return ListIclNuimSequence(folder);
  return ListTumSequence(folder);
}

OpenedRecording OpenRecording(const std::string& format, const std::string& path,
                              const RgbdCamera& camera, bool confidence) {
  if (format == "klg") return OpenKlg(path, {camera.depth.width, camera.depth.height});
  if (format == "sens") return OpenSens(path, camera.frames_per_second);
  SequenceFiles files = ListSequence(format, path, camera.frames_per_second);
  if (confidence) AddConfidence(path, files.has_clock, &files.frames, &files.warnings);
  return {MakeFolderRecording(std::move(files.frames)), std::move(files.ground_truth),
          files.has_clock, std::move(files.warnings), files.unpaired_images};
}

// Warning if timestamps go back: the clock was set, or the recording has several takes.
std::optional<std::string> ClockWarning(const Recording& frames, const std::string& path) {
  int count = 0, first = 0;
  for (int i = 1; i < frames.frame_count(); ++i) {
    if (frames.stamps(i).depth_s >= frames.stamps(i - 1).depth_s) continue;
    if (count++ == 0) first = i;
  }
  if (count == 0) return std::nullopt;
  return Concat(
      path, ": timestamps go back ", count, " times, first at frame ", first, " from ",
      std::to_string(frames.stamps(first - 1).depth_s), " to ",
      std::to_string(frames.stamps(first).depth_s),
      " s: the clock starts again, or the recording has several takes; frames stay in the "
      "order of the recording");
}

// Warning if the ground truth has no pose at the time of a frame.
std::optional<std::string> TruthWarning(const Recording& frames, const Trajectory& truth,
                                        const std::string& path) {
  if (truth.empty() || frames.frame_count() == 0) return std::nullopt;
  double first_s = HUGE_VAL, last_s = -HUGE_VAL;
  for (int i = 0; i < frames.frame_count(); ++i) {
    const double stamp_s = frames.stamps(i).depth_s;
    if (InterpolatePose(truth, stamp_s)) return std::nullopt;
    first_s = std::min(first_s, stamp_s);
    last_s = std::max(last_s, stamp_s);
  }
  return Concat(path, ": no frame has ground truth, because the timestamps of the frames are from ",
                std::to_string(first_s), " to ", std::to_string(last_s),
                " s and those of the ground truth from ", std::to_string(truth.front().stamp_s),
                " to ", std::to_string(truth.back().stamp_s),
                " s: both must be in s of the same clock");
}

std::vector<int> SelectFrames(int count, const SequenceOptions& options) {
  ThrowIf(count == 0, options.path, " lists no frames");
  ThrowIf(options.first == count, options.path, " is complete: it has ", count,
          " frames, and first is ", count,
          ". If a session is continued, it already contains all frames");
  ThrowIf(options.first > count, "first is ", options.first, ", must be below ", count,
          ", the number of frames of ", options.path);
  const int last = options.last == -1 ? count - 1 : std::min(options.last, count - 1);
  std::vector<int> indices;
  for (int i = options.first; i <= last; i += options.stride) indices.push_back(i);
  return indices;
}

class RecordedFrames : public RawFrames {
 public:
  RecordedFrames(std::unique_ptr<Recording> recording, std::vector<int> indices)
      : recording_(std::move(recording)), indices_(std::move(indices)) {}

  std::vector<FrameImages> FirstImages() override {
    constexpr std::size_t kImages = 8, kApart = 15;
    std::vector<FrameImages> images;
    std::string first_error;
    for (std::size_t i = 0; i < indices_.size() && images.size() < kImages;
         i += images.empty() ? 1 : kApart) {
      try {
        images.push_back(recording_->Read(indices_[i]));
      } catch (const InputError& error) {
        if (first_error.empty()) first_error = error.what();
      }
    }
    ThrowIf(images.empty(), "no frame can be read: ", first_error);
    return images;
  }

  std::optional<RawFrame> Next() override {
    if (next_ == indices_.size()) return std::nullopt;
    RawFrame frame;
    frame.head.index = indices_[next_++];
    frame.stamps = recording_->stamps(frame.head.index);
    return frame;
  }

  FrameImages Read() override { return recording_->Read(indices_[next_ - 1]); }

 private:
  std::unique_ptr<Recording> recording_;
  std::vector<int> indices_;
  std::size_t next_ = 0;
};

}  // namespace

bool IsLive(const SequenceOptions& options) {
  return options.format == "watch" || options.format == "openni2";
}

RawSequence OpenRawLive(const SequenceOptions& options, int capacity,
                        const std::atomic<bool>& stop) {
  Validate(options);
  ThrowIf(capacity < 1, "capacity is ", capacity, ", must be at least 1");
  if (options.format == "watch") return OpenWatchedFolder(options, stop);
  if (options.format == "openni2") return OpenOpenNiCamera(options, capacity, stop);
  throw InputError("format is '", options.format,
                   "', must be watch or openni2 for a live sequence");
}

std::unique_ptr<FrameSource> OpenLive(const SequenceOptions& options, int capacity,
                                      const std::atomic<bool>& stop) {
  return MakeFrameSource(OpenRawLive(options, capacity, stop));
}

RawSequence OpenRawSequence(const SequenceOptions& options) {
  Validate(options);
  ThrowIf(IsLive(options), "format is '", options.format,
          "': live sequences are only read by surfit_slam and surfit_record");
  ThrowIf(!IsFolder(options.path) && !IsFile(options.path), options.path,
          " is neither a folder nor a file");
  SequenceInfo info;
  info.format = options.format == "auto" ? DetectFormat(options.path) : options.format;
  const bool is_file = IsFile(options.path);
  ThrowIf(is_file ? !MayBeFile(info.format) : !MayBeFolder(info.format), options.path, " is a ",
          is_file ? "file" : "folder", ", which format ", info.format, " does not support");
  OpenedRecording opened;
  if (IsBag(info.format)) opened = OpenBag(options, info.format, /*is_folder=*/!is_file);
  if (info.format == "oni") opened = OpenOni(options);
  if (info.format == "mkv") opened = OpenAzureKinect(options);
  if (IsPhone(info.format)) opened = OpenPhone(options, info.format);
  const bool scale_is_given = ResolveCamera(options, opened.read_camera, &info);

  if (!opened.frames)
    opened = OpenRecording(info.format, options.path, info.camera, options.confidence);
  if (!opened.has_clock) DropLatency(options, &info.camera);
  info.warnings.insert(info.warnings.end(), opened.warnings.begin(), opened.warnings.end());
  if (auto warning = ClockWarning(*opened.frames, options.path)) info.warnings.push_back(*warning);
  if (auto warning = TruthWarning(*opened.frames, opened.ground_truth, options.path))
    info.warnings.push_back(*warning);
  info.ground_truth = std::move(opened.ground_truth);
  info.has_clock = opened.has_clock;
  if (opened.unpaired_images > 0) {
    info.unpaired_ratio = static_cast<double>(opened.unpaired_images) /
                          (opened.unpaired_images + 2 * opened.frames->frame_count());
  }
  std::vector<int> indices = SelectFrames(opened.frames->frame_count(), options);
  info.frame_count = static_cast<int>(indices.size());
  return MakeRawSequence(
      std::move(info),
      std::make_unique<RecordedFrames>(std::move(opened.frames), std::move(indices)), options,
      scale_is_given);
}

Trajectory ReadDevicePoses(const SequenceOptions& options) {
  const std::string format = options.format == "auto" ? DetectFormat(options.path) : options.format;
  ThrowIf(!IsPhone(format), options.path, ": format ", format, " has no poses of a device");
  const OpenedRecording opened = OpenPhone(options, format);
  ThrowIf(opened.device_poses.empty(), options.path, " has no valid poses of the device");
  if (!opened.device_pose_warning.empty())
    LOG(WARNING) << options.path << ": " << opened.device_pose_warning;
  return opened.device_poses;
}

std::unique_ptr<FrameSource> OpenSequence(const SequenceOptions& options) {
  return MakeFrameSource(OpenRawSequence(options));
}

}  // namespace surfit
