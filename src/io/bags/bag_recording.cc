#include <algorithm>
#include <cstdio>
#include <map>
#include <optional>
#include <utility>

#include "io/bags/bag_imu.h"
#include "io/bags/bag_topics.h"
#include "io/bags/message_images.h"
#include "io/bags/messages.h"
#include "io/files/text.h"
#include "io/lenses/lens_fit.h"
#include "io/sequences/recording.h"
#include "io/sequences/sequence_camera.h"
#include "io/stamps/time_words.h"
#include "surfit/core/error.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/io/camera_files.h"
#include "surfit/io/sequence.h"

namespace surfit {
namespace {

// Tree of the tf frames of a bag. Keeps the first transform of each frame: transforms between the
// cameras of one device are constant.
class FrameTree {
 public:
  void Add(const std::vector<FrameTransform>& transforms) {
    for (const FrameTransform& transform : transforms)
      by_child_.emplace(transform.child, transform);
  }

  // target_from_source; std::nullopt if the frames are not connected. Any common ancestor gives the
  // same transform.
  std::optional<Rigid3d> Transform(const std::string& target, const std::string& source) const {
    const auto targets = Ancestors(target), sources = Ancestors(source);
    for (const auto& [frame, frame_from_target] : targets) {
      const auto shared = sources.find(frame);
      if (shared != sources.end()) return frame_from_target.Inverse() * shared->second;
    }
    return std::nullopt;
  }

 private:
  // Transforms ancestor_from_frame, including the frame itself.
  std::map<std::string, Rigid3d> Ancestors(const std::string& frame) const {
    std::map<std::string, Rigid3d> found{{frame, Rigid3d()}};
    Rigid3d pose;
    for (auto link = by_child_.find(frame); link != by_child_.end();
         link = by_child_.find(link->second.parent)) {
      pose = link->second.parent_from_child * pose;
      if (!found.emplace(link->second.parent, pose).second) break;  // cycle in a damaged tree
    }
    return found;
  }

  std::map<std::string, FrameTransform> by_child_;
};

// Timestamp in s, bitwise identical to the same timestamp in a text file.
double Seconds(std::int64_t stamp_ns) {
  constexpr std::int64_t kPerSecond = 1000000000;
  char text[40];
  std::snprintf(text, sizeof(text), "%lld.%09lld", static_cast<long long>(stamp_ns / kPerSecond),
                static_cast<long long>(stamp_ns % kPerSecond));
  return FiniteNumber(text);
}

// Coefficients k1 k2 p1 p2 k3. std::nullopt: CameraInfo has another lens model.
std::optional<std::array<double, 5>> FiveCoefficients(const CameraInfo& info) {
  std::array<double, 5> distortion{};
  const std::string& model = info.distortion_model;
  std::size_t used = info.distortion.size();
  while (used > 0 && info.distortion[used - 1] == 0) --used;
  const bool is_brown = model == "plumb_bob" || model == "Brown Conrady" ||
                        (model == "rational_polynomial" && used <= distortion.size());
  if (used > 0 && (!is_brown || used > distortion.size())) return std::nullopt;
  std::copy_n(info.distortion.begin(), used, distortion.begin());
  return distortion;
}

// Converts intrinsics of the full image to the image of a topic, for one axis.
struct ImageAxis {
  std::uint32_t full = 0, offset = 0, part = 0, binning = 0;  // CameraInfo; part 0: full

  int SizePx() const { return static_cast<int>((part == 0 ? full : part) / std::max(1U, binning)); }
  // Pixel centres have integer coordinates in both images.
  double Center(double full_px) const {
    if (binning <= 1) return full_px - offset;
    return (full_px - offset + 0.5) / binning - 0.5;
  }
  double Focal(double full_px) const { return full_px / std::max(1U, binning); }
};

bool HasIntrinsics(const CameraInfo& info) {
  return info.intrinsics[0] != 0 || info.projection[0] != 0;
}

// Uses P for rectified images ("rect" in the topic name) and without K, otherwise K and D. Applies
// binning and region of interest, unless the images have the full size. A message without a size
// has the size of the images. Approximates other lens models if `fit_lens`. std::nullopt if neither
// K nor P is set.
std::optional<PinholeCamera> PinholeOf(CameraInfo info, const ImageTopic& image, bool fit_lens,
                                       const std::string& name) {
  if (!HasIntrinsics(info)) return std::nullopt;
  const bool has_k = info.intrinsics[0] != 0, has_p = info.projection[0] != 0;
  if (info.width == 0 && info.height == 0) {
    info.width = image.width;
    info.height = image.height;
  }
  const bool is_rectified =
      has_p && (!has_k || image.topic->name.find("rect") != std::string::npos);
  const double* const m = is_rectified ? info.projection.data() : info.intrinsics.data();
  const int row = is_rectified ? 4 : 3;
  ImageAxis x{info.width, 0, 0, 1}, y{info.height, 0, 0, 1};
  if (image.width != info.width || image.height != info.height) {
    x = {info.width, info.roi_x, info.roi_width, info.binning_x};
    y = {info.height, info.roi_y, info.roi_height, info.binning_y};
  }
  PinholeCamera camera;
  camera.width = x.SizePx();
  camera.height = y.SizePx();
  camera.fx = x.Focal(m[0]);
  camera.cx = x.Center(m[2]);
  camera.fy = y.Focal(m[row + 1]);
  camera.cy = y.Center(m[row + 2]);
  camera.Validate(name);
  if (is_rectified) return camera;
  if (const auto distortion = FiveCoefficients(info))
    camera.distortion = *distortion;
  else if (fit_lens)
    camera.distortion = FitDistortion(info.distortion_model, info.distortion, camera, name);
  return camera;
}

// Frames of a ROS bag: depth and colour messages paired by timestamp, as in TUM folders.
class BagRecording : public Recording {
 public:
  // Throws InputError with the path, and the topic or option at fault.
  BagRecording(const SequenceOptions& options, const std::string& format, bool is_folder)
      : log_(OpenLog(options.path, format, is_folder)),
        topics_(FindTopics(*log_, options.depth_topic, options.color_topic)),
        warnings_(log_->warnings()) {
    Pair();
  }

  int frame_count() const override { return static_cast<int>(frames_.size()); }
  FrameStamps stamps(int index) const override { return frames_[index].stamps; }
  FrameImages Read(int index) const override {
    const Frame& frame = frames_[index];
    const auto name_of = [&](const Topic& topic) {
      return Concat(log_->path(), ": ", topic.name, " of frame ", index);
    };
    FrameImages images;
    const Topic& depth = *topics_.depth.topic;
    images.depth_name = name_of(depth);
    images.depth = DepthOf(ReadImage(depth, frame.depth, images.depth_name), images.depth_name);
    if (topics_.color.topic == nullptr) return images;
    const Topic& color = *topics_.color.topic;
    images.color_name = name_of(color);
    images.color = ColorOf(ReadImage(color, frame.color, images.color_name), images.color_name);
    return images;
  }

  const std::vector<std::string>& warnings() const { return warnings_; }
  int unpaired_images() const { return unpaired_images_; }  // see OpenedRecording
  bool has_depth_unit() const { return FindDepthUnit(*log_, topics_.depth) != nullptr; }

  // Camera parameters that the options set. The bag can lack these parameters.
  struct Known {
    bool depth = false, color = false, color_from_depth = false;
  };
  // Camera from CameraInfo and tf, with latency 0. The depth unit is DepthUnitsPerMetre(). Throws
  // InputError with the missing parameter and the options that set it. Appends ignored values to
  // `from`, SourceCamera::from.
  RgbdCamera Camera(const Known& known, std::string* from) const {
    RgbdCamera camera = CameraPreset("redwood");
    camera.depth_units_per_metre = DepthUnitsPerMetre();
    const auto depth = Pinhole(topics_.depth, known.depth, from);
    if (depth) camera.depth = *depth;
    if (!depth && !known.depth) {
      throw InputError(log_->path(), " has no CameraInfo for ", topics_.depth.topic->name,
                       ": set intrinsics, a camera.yaml, or a preset as camera");
    }
    if (topics_.color.topic == nullptr) return camera;
    // In one tf frame, the intrinsics of the options are those of both images.
    const bool one_frame = topics_.color.frame == topics_.depth.frame;
    const auto color = Pinhole(topics_.color, known.color || (one_frame && known.depth), from);
    if (one_frame && (!depth || !color || HaveEqualIntrinsics(*depth, *color))) return camera;
    if (!color && !known.color) {
      throw InputError(log_->path(), " has no CameraInfo for ", topics_.color.topic->name,
                       ": set color_intrinsics, or a camera.yaml");
    }
    camera.color_is_registered = false;
    camera.color = color ? *color : camera.depth;
    camera.color_from_depth = ColorFromDepth(known.color_from_depth);
    return camera;
  }

 private:
  struct Stamped {
    std::int64_t stamp_ns = 0;
    MessageLocation place;
  };
  struct Frame {
    FrameStamps stamps;
    MessageLocation depth, color;
  };

  std::vector<std::vector<Stamped>> InOrder(const Topic& topic) {
    const std::string name = Concat(log_->path(), ": a message of ", topic.name);
    std::vector<Stamped> messages;
    messages.reserve(topic.messages.size());
    for (const MessageLocation& place : topic.messages)
      messages.push_back({StampOf(place, topic, name), place});
    UseValidStamps(topic, &messages);
    return SortedByClock(std::move(messages));
  }
  // True if only the first message has the timestamp 0, and the next message follows within 1 s.
  static bool ClockStartsAtZero(const std::vector<Stamped>& messages, std::ptrdiff_t unset) {
    constexpr std::int64_t kSecond_ns = 1000000000;
    return unset == 1 && messages.size() > 1 && messages[0].stamp_ns == 0 &&
           messages[1].stamp_ns < kSecond_ns;
  }
  // Without timestamps, recording times are used. If only some messages have timestamps, messages
  // without a timestamp are left out.
  void UseValidStamps(const Topic& topic, std::vector<Stamped>* messages) {
    const auto is_unset = [](const Stamped& message) { return message.stamp_ns == 0; };
    const auto unset = std::count_if(messages->begin(), messages->end(), is_unset);
    if (unset == static_cast<std::ptrdiff_t>(messages->size())) {
      warnings_.push_back(Concat(log_->path(), ": the messages of ", topic.name,
                                 " have no timestamps, their recording times are used"));
      for (Stamped& message : *messages)
        message.stamp_ns = std::max<std::int64_t>(message.place.recorded_ns, 0);
    } else if (unset > 0 && !ClockStartsAtZero(*messages, unset)) {
      warnings_.push_back(Concat(log_->path(), ": ", unset, " of ", messages->size(),
                                 " messages of ", topic.name,
                                 " have no timestamp (0) and are left out"));
      messages->erase(std::remove_if(messages->begin(), messages->end(), is_unset),
                      messages->end());
    }
  }
  // Parts of the messages of a topic, see FindClockStarts(). Each part is sorted by timestamp.
  using Parts = std::vector<std::vector<Stamped>>;
  static Parts SortedByClock(std::vector<Stamped> messages) {
    std::vector<double> stamps_s = SecondsOf(messages);
    std::vector<std::size_t> starts = FindClockStarts(stamps_s);
    Parts parts;
    for (std::size_t k = 0; k < starts.size(); ++k) {
      const auto at = [&](std::size_t i) {
        return messages.begin() + static_cast<std::ptrdiff_t>(i);
      };
      parts.emplace_back(at(starts[k]), k + 1 < starts.size() ? at(starts[k + 1]) : messages.end());
      std::stable_sort(parts.back().begin(), parts.back().end(),
                       [](const Stamped& a, const Stamped& b) { return a.stamp_ns < b.stamp_ns; });
    }
    return parts;
  }
  static std::vector<double> SecondsOf(const std::vector<Stamped>& messages) {
    std::vector<double> stamps_s;
    stamps_s.reserve(messages.size());
    for (const Stamped& message : messages) stamps_s.push_back(Seconds(message.stamp_ns));
    return stamps_s;
  }
  void Pair() {
    const Parts depth = InOrder(*topics_.depth.topic);
    if (topics_.color.topic == nullptr) {
      for (const std::vector<Stamped>& part : depth) AddDepth(part);
      return;
    }
    const Parts color = InOrder(*topics_.color.topic);
    ThrowIf(depth.size() != color.size(), log_->path(), ": the clock of ",
            topics_.depth.topic->name, " starts ", depth.size(), " times and that of ",
            topics_.color.topic->name, " ", color.size(),
            " times, must be equal: make one bag per recording");
    for (std::size_t k = 0; k < depth.size(); ++k) AddPairs(depth[k], color[k]);
    if (frames_.empty()) {
      throw InputError(log_->path(), ": no timestamp of ", topics_.color.topic->name, " is within ",
                       kMaxBetweenImages_s, " s of a timestamp of ", topics_.depth.topic->name);
    }
  }
  void AddDepth(const std::vector<Stamped>& depth) {
    const std::vector<double> depth_s = SecondsOf(depth);
    for (std::size_t i = 0; i < depth.size(); ++i)
      frames_.push_back({{depth_s[i], depth_s[i]}, depth[i].place, {}});
  }
  void AddPairs(const std::vector<Stamped>& depth, const std::vector<Stamped>& color) {
    const std::vector<double> depth_s = SecondsOf(depth), color_s = SecondsOf(color);
    const auto matches = MatchStamps(color_s, depth_s, kMaxBetweenImages_s);
    for (const auto [c, d] : matches)
      frames_.push_back({{depth_s[d], color_s[c]}, depth[d].place, color[c].place});
    unpaired_images_ += static_cast<int>(color.size() + depth.size() - 2 * matches.size());
  }
  ImageMessage ReadImage(const Topic& topic, const MessageLocation& place,
                         const std::string& name) const {
    return ReadImageMessage(log_->Read(place), topic, name);
  }
  // Depth counts per metre: the inverse of the unit in the bag, otherwise 1000 (REP 118).
  double DepthUnitsPerMetre() const {
    const Topic* const topic = FindDepthUnit(*log_, topics_.depth);
    if (topic == nullptr) return 1000;
    const std::string name = Concat(log_->path(), ": ", topic->name);
    // Prints six digits to undo the rounding of a decimal unit to float.
    const double unit_m =
        FiniteNumber(Concat(ReadFloat(log_->Read(topic->messages[0]), *topic, name)));
    ThrowIf(!(unit_m > 0), name, ": Depth_Units is ", unit_m, ", must be positive");
    return 1 / unit_m;
  }
  // Drivers can send empty messages until the camera has started. Without intrinsics in any
  // message: the last message.
  CameraInfo FirstWithIntrinsics(const Topic& topic, const std::string& name) const {
    CameraInfo info;
    for (const MessageLocation& place : topic.messages) {
      info = ReadCameraInfo(log_->Read(place), topic, name);
      if (HasIntrinsics(info)) break;
    }
    return info;
  }
  // Intrinsics of an image topic; std::nullopt if no CameraInfo has them. `is_known`: the options
  // replace the intrinsics. Then a lens of another model is not used, because intrinsics without
  // this lens belong to rectified images.
  std::optional<PinholeCamera> Pinhole(const ImageTopic& image, bool is_known,
                                       std::string* from) const {
    const Topic* const topic = FindCameraInfo(*log_, image);
    if (topic == nullptr) return std::nullopt;
    const std::string name = Concat(log_->path(), ": ", topic->name);
    const CameraInfo info = FirstWithIntrinsics(*topic, name);
    const bool is_color = image.topic == topics_.color.topic;
    try {
      const auto camera = PinholeOf(info, image, /*fit_lens=*/!is_known, name);
      const std::string note =
          Concat(", without the distortion model '", info.distortion_model, "' of ", name);
      if (camera && is_known && !FiveCoefficients(info) && from->find(note) == from->npos)
        *from += note;
      return camera;
    } catch (const InputError& error) {
      if (is_known) {
        *from += Concat(", without a bad CameraInfo (", error.what(), ")");
        return std::nullopt;
      }
      if (!is_color) throw;
      throw InputError(error.what(), " (the option for this camera is color_intrinsics)");
    }
  }
  Rigid3d ColorFromDepth(bool is_known) const {
    const std::string &target = topics_.color.frame, &source = topics_.depth.frame;
    if (is_known || target == source) return Rigid3d();
    FrameTree tree;
    for (const Topic& topic : log_->topics()) {
      if (topic.type != "tf2_msgs/TFMessage" && topic.type != "tf/tfMessage") continue;
      const std::string name = Concat(log_->path(), ": a message of ", topic.name);
      for (const MessageLocation& place : topic.messages)
        tree.Add(ReadTransforms(log_->Read(place), topic, name));
    }
    if (const auto transform = tree.Transform(target, source)) return *transform;
    throw InputError(log_->path(), ": tf has no transform to ", topics_.color.topic->name, " (",
                     target, ") from ", topics_.depth.topic->name, " (", source,
                     "): set color_from_depth, or a camera.yaml");
  }

  std::unique_ptr<MessageLog> log_;
  BagTopics topics_;
  std::vector<Frame> frames_;
  std::vector<std::string> warnings_;
  int unpaired_images_ = 0;
};

}  // namespace

std::unique_ptr<MessageLog> OpenLog(const std::string& path, const std::string& format,
                                    bool is_folder) {
  if (is_folder) return OpenBagFolder(path, "." + format);
  if (format == "bag") return OpenRosBag(path);
  return format == "mcap" ? OpenMcap(path) : OpenDb3(path);
}

OpenedRecording OpenBag(const SequenceOptions& options, const std::string& format, bool is_folder) {
  auto bag = std::make_unique<BagRecording>(options, format, is_folder);
  BagRecording::Known known;
  known.depth = options.intrinsics.has_value();
  known.color = options.color_intrinsics.has_value();
  known.color_from_depth = options.color_from_depth.has_value();
  OpenedRecording opened;
  opened.has_clock = true;
  opened.warnings = bag->warnings();
  opened.unpaired_images = bag->unpaired_images();
  opened.read_camera = [known, recording = bag.get()] {
    SourceCamera source{{}, "CameraInfo of the bag"};
    source.camera = recording->Camera(known, &source.from);
    source.scale_is_given = recording->has_depth_unit();
    return source;
  };
  opened.frames = std::move(bag);
  return opened;
}

}  // namespace surfit
