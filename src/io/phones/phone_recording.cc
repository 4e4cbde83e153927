#include "io/phones/phone_recording.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/files.h"
#include "core/median.h"
#include "io/phones/resample.h"
#include "io/sequences/folder_recording.h"
#include "surfit/core/error.h"
#include "surfit/io/sequence.h"

namespace surfit {
namespace {

double MedianField(const std::vector<PhoneFrame>& frames, double PinholeCamera::*field) {
  std::vector<double> values;
  values.reserve(frames.size());
  for (const PhoneFrame& frame : frames) values.push_back(frame.color_camera.*field);
  return MedianOf(std::move(values));
}

PinholeCamera MedianCamera(const std::vector<PhoneFrame>& frames) {
  PinholeCamera camera = frames.front().color_camera;
  for (double PinholeCamera::*field :
       {&PinholeCamera::fx, &PinholeCamera::fy, &PinholeCamera::cx, &PinholeCamera::cy})
    camera.*field = MedianField(frames, field);
  return camera;
}

// Size of the first depth image that can be read. Throws the error of the first image.
ImageSize FirstDepthSize(const std::vector<PhoneFrame>& frames) {
  constexpr std::size_t kTrials = 100;
  std::string first_error;
  for (std::size_t i = 0; i < std::min(frames.size(), kTrials); ++i) {
    const std::string& path = frames[i].files.depth_path;
    try {
      return SizeInHeader(ReadFile(path), path);
    } catch (const InputError& error) {
      if (first_error.empty()) first_error = error.what();
    }
  }
  throw InputError("no frame can be read: ", first_error);
}

struct CommonCameras {
  PinholeCamera depth, color;
};

// Frames of files and of a video, resampled to common cameras.
class PhoneFrames : public Recording {
 public:
  PhoneFrames(std::vector<PhoneFrame> frames, const CommonCameras& common,
              std::shared_ptr<VideoFile> video)
      : frames_(std::move(frames)), common_(common), video_(std::move(video)) {}

  int frame_count() const override { return static_cast<int>(frames_.size()); }
  FrameStamps stamps(int index) const override { return frames_[index].files.stamps; }

  FrameImages Read(int index) const override {
    const PhoneFrame& frame = frames_[index];
    FrameImages images = ReadFrameFiles(frame.files);
    if (video_ && frame.video_frame >= 0) ReadVideo(frame.video_frame, &images);
    Resample(frame.color_camera, &images);
    return images;
  }

 private:
  // Depth alone is used if the video ends early.
  void ReadVideo(int video_frame, FrameImages* images) const {
    images->color_name = Concat(video_->path(), ": frame ", video_frame);
    try {
      images->color = video_->Read(video_frame);
    } catch (const InputError& error) {
      if (!std::exchange(warned_, true))
        LOG(WARNING) << error.what() << ": this frame and later frames of the video have no colour";
    }
  }

  void Resample(const PinholeCamera& own_color, FrameImages* images) const {
    constexpr double kNegligible_px = 0.02;
    if (LargestShift(own_color, common_.color) >= kNegligible_px && !images->color.empty())
      ResampleColor(own_color, common_.color, &images->color);
    const PinholeCamera own_depth =
        ResizedCamera(own_color, {common_.depth.width, common_.depth.height}, "", "");
    if (LargestShift(own_depth, common_.depth) >= kNegligible_px)
      ResampleDepth(own_depth, common_.depth, &images->depth);
  }

  std::vector<PhoneFrame> frames_;
  CommonCameras common_;
  std::shared_ptr<VideoFile> video_;
  mutable bool warned_ = false;
};

// Throws InputError with the place of a camera whose size is not that of the first camera.
void RequireOneSize(const std::vector<PhoneFrame>& frames) {
  const PinholeCamera& first = frames.front().color_camera;
  for (const PhoneFrame& frame : frames) {
    const PinholeCamera& camera = frame.color_camera;
    ThrowIf(camera.width != first.width || camera.height != first.height, frame.camera_place,
            ": the camera of ", frame.files.depth_path, " has ", camera.width, " x ", camera.height,
            " pixels, must have ", first.width, " x ", first.height, " as that of the first frame");
  }
}

// Text about the intrinsics of frames that change. Empty if they are constant.
std::string DescribeLens(const std::vector<PhoneFrame>& frames, const PinholeCamera& median) {
  double largest = 0;
  for (const PhoneFrame& frame : frames)
    largest = std::max(largest, std::abs(frame.color_camera.fx / median.fx - 1));
  constexpr double kNegligible = 1e-5;
  if (largest < kNegligible) return "";
  return Concat(", median of ", frames.size(), " frames (fx changes by up to ",
                0.01 * std::round(1e4 * largest), " %, images are resampled)");
}

// Removes hidden frames and frames after the end from PhoneFrame::video_frame. Warns of frames
// without colour, and of frames of the video that are not used.
void AssignVideo(const VideoFile& video, PhoneFiles* files) {
  const int first = video.hidden_frames(), end = first + video.frame_count();
  const int count = static_cast<int>(files->frames.size());
  std::size_t without = 0;
  for (int i = 0; i < count; ++i) {
    int& frame = files->frames[i].video_frame;
    frame = frame >= first && frame < end ? frame - first : -1;
    without += frame < 0;
  }
  const int unused = end - first - count + static_cast<int>(without);
  WarnOfCount(
      without, video.path(),
      Concat("of ", count, " frames have no image in the video (", video.frame_count(), " frames",
             first > 0 ? Concat(" after ", first, " hidden") : "", "), their colour is missing"),
      &files->warnings);
  if (unused > 0)
    WarnOfCount(static_cast<std::size_t>(unused), video.path(),
                "frames of the video belong to no depth image", &files->warnings);
}

}  // namespace

void DevicePoses::Add(double stamp_s, const ParsedRigid& parsed) {
  if (parsed.transform) {
    poses_.push_back({stamp_s, *parsed.transform});
  } else if (invalid_++ == 0) {
    first_error_ = parsed.error;
  }
}

void DevicePoses::AddOpenGl(double stamp_s, const ParsedRigid& parsed) {
  ParsedRigid turned = parsed;
  if (turned.transform)
    turned.transform = *turned.transform * Rigid3d(Eigen::Quaterniond(0, 1, 0, 0), {0, 0, 0});
  Add(stamp_s, turned);
}

Trajectory DevicePoses::Sorted() const {
  Trajectory sorted = poses_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const StampedPose& a, const StampedPose& b) {
    return a.stamp_s < b.stamp_s;
  });
  return sorted;
}

std::string DevicePoses::warning() const {
  if (invalid_ == 0) return "";
  return Concat(invalid_, " of ", poses_.size() + invalid_, " poses are invalid and left out (",
                first_error_, ")");
}

PinholeCamera ResizedCamera(const PinholeCamera& camera, ImageSize size,
                            const std::string& image_path, const std::string& camera_from) {
  if (size.width == camera.width && size.height == camera.height) return camera;
  const double x = static_cast<double>(size.width) / camera.width;
  const double y = static_cast<double>(size.height) / camera.height;
  ThrowIf(std::abs(x / y - 1) > 0.02, image_path, " is ", size.width, " x ", size.height,
          " pixels, must have the aspect ratio of the ", camera.width, " x ", camera.height,
          " camera of ", camera_from);
  PinholeCamera resized = camera;
  resized.width = size.width;
  resized.height = size.height;
  resized.fx *= x;
  resized.fy *= y;
  resized.cx = (camera.cx + 0.5) * x - 0.5;
  resized.cy = (camera.cy + 0.5) * y - 0.5;
  return resized;
}

PinholeCamera LensOf(ImageSize size, const std::array<double, 4>& numbers,
                     const std::string& place) {
  PinholeCamera camera;
  camera.width = size.width;
  camera.height = size.height;
  camera.fx = numbers[0];
  camera.fy = numbers[1];
  camera.cx = numbers[2];
  camera.cy = numbers[3];
  camera.Validate(place);
  ThrowIf(camera.fy < 0, place, ": fy is ", camera.fy, ", must be positive");
  const auto require = [&](double center, int length, const char* field, const char* side) {
    ThrowIf(center < 0.3 * length || center > 0.7 * length, place, ": ", field, " is ", center,
            ", must be near the centre of the image: ", 0.3 * length, " to ", 0.7 * length,
            " for the ", side, " ", length);
  };
  require(camera.cx, camera.width, "cx", "width");
  require(camera.cy, camera.height, "cy", "height");
  return camera;
}

void WarnOfCount(std::size_t count, const std::string& place, const std::string& text,
                 std::vector<std::string>* warnings) {
  if (count > 0) warnings->push_back(Concat(place, ": ", count, " ", text));
}

namespace {

// Recording of the frames, without a camera.
OpenedRecording Opened(std::unique_ptr<Recording> frames, PhoneFiles files) {
  OpenedRecording opened;
  opened.frames = std::move(frames);
  opened.device_poses = files.poses.Sorted();
  opened.device_pose_warning = files.poses.warning();
  opened.has_clock = files.has_clock;
  opened.warnings = std::move(files.warnings);
  opened.unpaired_images = files.unpaired_images;
  return opened;
}

// Recording for a camera of the options: images are not resampled.
OpenedRecording OpenWithoutLens(PhoneFiles files) {
  std::vector<FrameFiles> frames;
  for (PhoneFrame& frame : files.frames) frames.push_back(std::move(frame.files));
  return Opened(MakeFolderRecording(std::move(frames)), std::move(files));
}

}  // namespace

OpenedRecording OpenPhoneFiles(PhoneFiles files) {
  ThrowIf(files.frames.empty(), files.camera_from, " has no frame with a depth image");
  if (files.video) AssignVideo(*files.video, &files);
  if (files.frames.front().color_camera.width == 0) return OpenWithoutLens(std::move(files));
  RequireOneSize(files.frames);
  RgbdCamera camera;
  camera.color = MedianCamera(files.frames);
  camera.depth = ResizedCamera(camera.color, FirstDepthSize(files.frames),
                               files.frames.front().files.depth_path, files.camera_from);
  camera.color_is_registered =
      camera.depth.width == camera.color.width && camera.depth.height == camera.color.height;
  camera.depth_units_per_metre = files.depth_units_per_metre;
  camera.Validate(files.camera_from);
  SourceCamera source = {camera, files.camera_from + DescribeLens(files.frames, camera.color),
                         false, files.scale_is_given};
  auto frames = std::make_unique<PhoneFrames>(
      std::move(files.frames), CommonCameras{camera.depth, camera.color}, files.video);
  OpenedRecording opened = Opened(std::move(frames), std::move(files));
  opened.read_camera = [source = std::move(source)] { return source; };
  return opened;
}

}  // namespace surfit
