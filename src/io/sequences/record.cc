#include "io/sequences/record.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <optional>
#include <variant>

#include "core/repeated_warning.h"
#include "core/shared_options.h"
#include "io/images/image_files.h"
#include "io/sequences/raw_frames.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/io/camera_files.h"
#include "surfit/io/trajectory_files.h"

namespace surfit {
namespace {

namespace fs = std::filesystem;

constexpr double kUnitsOfMetres = 5000;  // depth counts per metre, as in TUM data sets

// Shortest decimal text that is read back as the same value.
std::string ToText(double stamp_s) {
  std::array<char, 400> text;
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), stamp_s, std::chars_format::fixed);
  return {text.data(), end.ptr};
}

// Converts depth from m to counts. Values that do not fit in 16 bits become 0.
Image<std::uint16_t> ToCounts(const Image<float>& depth_m, RecordSummary* summary) {
  summary->depth_is_rounded = true;
  Image<std::uint16_t> counts(depth_m.width(), depth_m.height());
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double count = std::round(depth_m[i] * kUnitsOfMetres);
    if (!(count > 0)) continue;
    const bool fits = count < std::numeric_limits<std::uint16_t>::max();
    summary->depths_out_of_range += !fits;
    if (fits) counts[i] = static_cast<std::uint16_t>(count);
  }
  return counts;
}

// Writes frames to a TUM folder. Either all frames have colour, or no frame has colour.
class RecordedFolder {
 public:
  RecordedFolder(const RecordOptions& options, const RawSequence& sequence)
      : folder_(options.output), info_(sequence.info), field_(sequence.field) {
    const std::string list = folder_ + "/depth.txt";
    ThrowIf(fs::exists(list), list, " exists: choose a folder without a recording");
    std::error_code error;
    for (const char* name : {"/depth", "/rgb"}) fs::create_directories(folder_ + name, error);
    ThrowIf(!fs::is_directory(folder_ + "/depth") || !fs::is_directory(folder_ + "/rgb"), folder_,
            ": cannot create the folders depth/ and rgb/");
  }

  // Appends a frame. Throws InputError with the path of a file that cannot be written.
  void Write(const FrameImages& images, const FrameStamps& stamps, RecordSummary* summary) {
    if (!depth_list_) Begin(images);
    if (images.color.empty() != (color_list_ == nullptr)) {
      throw InputError(images.depth_name + (color_list_ ? " has no colour" : " has colour") +
                       ", must be like the first frame");
    }
    char name[32];
    std::snprintf(name, sizeof(name), "%06d.png", summary->frames_written);
    const std::string depth_row = ToText(stamps.depth_s) + " depth/" + name;
    WriteImage(std::string("/depth/") + name, EncodeDepth(images.depth, summary), summary);
    if (!color_list_) return depth_list_->Append(depth_row + "\n");
    const std::string color_row = ToText(stamps.color_s) + " rgb/" + name;
    WriteImage(std::string("/rgb/") + name, EncodePng(images.color), summary);
    // The pair is written first, because associations.txt takes precedence over rgb.txt and
    // depth.txt.
    pair_list_->Append(color_row + " " + depth_row + "\n");
    color_list_->Append(color_row + "\n");
    depth_list_->Append(depth_row + "\n");
  }

 private:
  // Writes camera, ground truth and list headers. The first frame determines the depth unit and
  // whether there is colour.
  void Begin(const FrameImages& first) {
    RgbdCamera camera = info_.camera;
    if (std::holds_alternative<Image<float>>(first.depth)) {
      camera.depth_units_per_metre = kUnitsOfMetres;
      camera.disparity = {};
    }
    WriteCameraYaml(camera, folder_ + "/camera.yaml", field_);
    if (!info_.ground_truth.empty()) {
      Trajectory poses = info_.ground_truth;
      for (StampedPose& pose : poses)
        if (info_.mirrored) pose.world_from_camera = Mirrored(pose.world_from_camera);
      WriteTumTrajectory(poses, folder_ + "/groundtruth.txt");
    }
    depth_list_ = MakeList("/depth.txt");
    if (first.color.empty()) return;
    color_list_ = MakeList("/rgb.txt");
    pair_list_ = std::make_unique<AppendedFile>(folder_ + "/associations.txt");
  }

  std::unique_ptr<AppendedFile> MakeList(const char* name) const {
    auto list = std::make_unique<AppendedFile>(folder_ + name);
    list->Append("# timestamp filename\n");
    return list;
  }

  static std::string EncodeDepth(const RawDepth& depth, RecordSummary* summary) {
    if (const auto* metres = std::get_if<Image<float>>(&depth))
      return EncodePng(ToCounts(*metres, summary));
    return EncodePng(std::get<Image<std::uint16_t>>(depth));
  }

  void WriteImage(const std::string& name, const std::string& bytes, RecordSummary* summary) const {
    std::ofstream file(folder_ + name, std::ios::binary);
    file << bytes;
    ThrowIf(!file.flush(), folder_, name, " cannot be written");
    summary->bytes += static_cast<std::int64_t>(bytes.size());
  }

  const std::string folder_;
  const SequenceInfo& info_;
  const InverseDepthField& field_;
  std::unique_ptr<AppendedFile> depth_list_, color_list_, pair_list_;
};

// Returns std::nullopt, with a warning, for an unreadable frame.
std::optional<FrameImages> ReadImages(const RawFrame& frame, RawFrames* frames,
                                      RepeatedWarning* skipped, RecordSummary* summary) {
  summary->frames_dropped += frame.head.dropped_before;
  summary->pauses += frame.head.paused_before_s > 0;
  std::string error = frame.head.error;
  try {
    if (error.empty()) return frames->Read();
  } catch (const InputError& unreadable) {
    error = unreadable.what();
  }
  skipped->Tell(Concat("frame ", frame.head.index, " is skipped: ", error));
  ++summary->frames_skipped;
  return std::nullopt;
}

}  // namespace

void RecordOptions::Visit(OptionVisitor& v) {
  v.AddPart(sequence, "sequence", "sequence to record");
  v.Group("recording");
  v.Add(output, SharedOption("output", Required(), Everyday()));
  v.Add(max_frames, "max_frames", "maximum number of frames", AtLeast(0), ZeroIs("no limit"));
  v.Add(max_seconds, "max_seconds", "maximum duration by the timestamps", InUnit("s"), AtLeast(0),
        ZeroIs("no limit"), AsFlag("seconds"), Everyday());
  v.Check([this] {
    const RectifyOptions as_they_come;
    if (sequence.rectify.downsample == as_they_come.downsample &&
        sequence.rectify.max_depth_m == as_they_come.max_depth_m)
      return;
    throw InputError(
        "downsample and max_depth_m must have their default values: images are recorded unchanged");
  });
}

RecordSummary RecordSequence(const RecordOptions& options, const std::atomic<bool>& stop,
                             const std::function<void(const RecordSummary&)>& progress) {
  // Frames of a live camera that wait for writing. Above it, the oldest is dropped.
  constexpr int kQueueCapacity = 60;
  Validate(options);
  const RawSequence sequence = IsLive(options.sequence)
                                   ? OpenRawLive(options.sequence, kQueueCapacity, stop)
                                   : OpenRawSequence(options.sequence);
  RecordedFolder folder(options, sequence);
  RecordSummary summary;
  RepeatedWarning skipped("frames skipped");
  double first_s = 0;
  while (!stop && (options.max_frames == 0 || summary.frames_written < options.max_frames)) {
    const std::optional<RawFrame> frame = sequence.frames->Next();
    if (!frame) break;
    const auto images = ReadImages(*frame, sequence.frames.get(), &skipped, &summary);
    if (!images) continue;
    if (summary.frames_written == 0) first_s = frame->stamps.depth_s;
    const double seconds = frame->stamps.depth_s - first_s;
    if (options.max_seconds > 0 && seconds > options.max_seconds) break;
    folder.Write(*images, frame->stamps, &summary);
    summary.depths += images->low_confidence.depths;
    summary.low_confidence += images->low_confidence.removed;
    summary.seconds = seconds;
    ++summary.frames_written;
    progress(summary);
  }
  summary.interrupted = stop;
  ThrowIf(summary.frames_written == 0, options.sequence.path, ": no frame could be recorded");
  return summary;
}

}  // namespace surfit
