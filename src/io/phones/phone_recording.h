#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "io/files/text.h"
#include "io/images/image_files.h"
#include "io/phones/video_file.h"
#include "io/sequences/recording.h"
#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// Recordings by phones and similar programs. Each frame has intrinsics and a pose of its own. The
// poses come from the tracking of the phone, so they are no ground truth.

// Poses by the recording device.
class DevicePoses {
 public:
  // Adds a pose world_from_camera with the camera axes x right, y down, z forward. Counts a pose
  // that is not finite or not rigid.
  void Add(double stamp_s, const ParsedRigid& parsed);
  // Adds a pose with the camera axes of OpenGL and ARKit: x right, y up, z backward.
  void AddOpenGl(double stamp_s, const ParsedRigid& parsed);

  // Sorted by time.
  Trajectory Sorted() const;
  // Warning with the number of invalid poses. Empty: none.
  std::string warning() const;

 private:
  Trajectory poses_;
  int invalid_ = 0;
  std::string first_error_;
};

struct PhoneFrame {
  FrameFiles files;            // without colour if it is in a video
  int video_frame = -1;        // in the order of the file, with hidden frames; -1: no video
  PinholeCamera color_camera;  // camera of the colour image of this frame
  std::string camera_place;    // file of this camera, for messages
};

// Frames of a recording, in the order of their numbers. Images are not opened.
struct PhoneFiles {
  std::vector<PhoneFrame> frames;
  std::shared_ptr<VideoFile> video = nullptr;  // null: colour images are files
  std::string camera_from;                     // source of the intrinsics
  double depth_units_per_metre = 1000;
  bool scale_is_given = true;  // the format or a file has the depth scale
  bool has_clock = true;
  int unpaired_images = 0;  // images that belong to no frame
  DevicePoses poses = {};
  std::vector<std::string> warnings = {};
};

// Opens the frames. The depth camera has the lens and the position of the colour camera, and the
// size of the depth images. If intrinsics change between frames, images are resampled to the median
// intrinsics. Throws InputError without a frame, and if the aspect ratios of depth and colour
// differ.
OpenedRecording OpenPhoneFiles(PhoneFiles files);

// True for stray_scanner, arkit_scenes, polycam, record3d and nerfstudio.
bool IsPhone(const std::string& format);

// Opens a folder of this format. Throws InputError that names the file, the field and the rule.
OpenedRecording OpenPhone(const SequenceOptions& options, const std::string& format);

PhoneFiles ListStrayScanner(const std::string& folder, bool confidence);
PhoneFiles ListArkitScenes(const std::string& folder, bool confidence);
PhoneFiles ListPolycam(const std::string& folder, bool confidence);
PhoneFiles ListRecord3d(const std::string& folder, bool confidence);
// Frames of transforms.json that have a depth image, in the order of the numbers in their names.
// Timestamps are (number - first number) / frames_per_second. If no frame names a depth image, the
// folder is listed as a Redwood folder. `has_camera`: another camera is used, so the lens of the
// recording may be invalid.
PhoneFiles ListNerfstudio(const std::string& folder, double frames_per_second, bool has_camera,
                          bool confidence);

// Sets the confidence images of `folder` by the names of the depth images, see
// AddNamedConfidence(). Adds a warning for frames without one. Does nothing without the folder.
void AddPhoneConfidence(const std::string& folder, PhoneFiles* files);

// Camera of the same lens for images of another size. Throws InputError with both names if the
// aspect ratios differ by more than 2 %.
PinholeCamera ResizedCamera(const PinholeCamera& camera, ImageSize size,
                            const std::string& image_path, const std::string& camera_from);

// Camera of the numbers fx, fy, cx, cy, px. Requires positive focal lengths, and a principal point
// near the centre of the image: 0.3 to 0.7 of its size. Throws InputError with the place, the field
// and the rule.
PinholeCamera LensOf(ImageSize size, const std::array<double, 4>& numbers,
                     const std::string& place);

// Adds a warning with the number of these items, if it is positive: "PLACE: COUNT TEXT".
void WarnOfCount(std::size_t count, const std::string& place, const std::string& text,
                 std::vector<std::string>* warnings);

}  // namespace surfit
