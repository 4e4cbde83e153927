#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "io/sequences/raw_frames.h"
#include "output/recorded_run.h"
#include "surfit/core/image.h"
#include "surfit/frame/camera_motion.h"
#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

// Colour camera of a run. The image size is the size of the recorded images.
struct ColorCamera {
  PinholeCamera lens;        // with distortion; fy > 0
  Rigid3d color_from_depth;  // transform from the depth camera
  double readout_s = 0;      // rolling-shutter readout, s
};

// Colour image of a frame with a pose.
struct ColorImage {
  int index = 0;       // of the frame
  double stamp_s = 0;  // capture time of the middle row
  // Pose of the depth camera at this time in the world of the run, and its motion at the depth
  // frame.
  Rigid3d world_from_depth;
  CameraMotion motion;
  double sharpness = 0;  // mean squared gradient of the brightness

  std::string Name() const;  // file name of the exported image
};

// Number of frames of a run that are not used, by reason.
struct UnusedFrames {
  int without_color = 0, unreadable = 0, repeated = 0, without_pose_at_time = 0, not_chosen = 0;
};

// Colour camera before estimation: that of the sequence, or the estimated depth camera of the run
// for registered colour.
ColorCamera GivenColorCamera(const SequenceInfo& info, const RecordedRun& run);

// Reads all frames of the run, and returns their colour images with poses. An image that repeats
// the previous image has another capture time than its timestamp, and is not used. `progress` must
// not be empty. It receives the number of images so far. Adds the numbers of other frames to
// `unused`, which must not be null. Throws InputError if the sequence cannot be opened. The poses
// of the run must be in the order of the frame indices.
std::vector<ColorImage> ListColorImages(const SequenceOptions& sequence, const RecordedRun& run,
                                        const std::function<void(int)>& progress,
                                        UnusedFrames* unused);

// Returns at most `most` images; 0: all. Divides the path of the camera into parts of about equal
// image motion, and takes the sharpest image of each part.
std::vector<ColorImage> ChooseImages(const std::vector<ColorImage>& images, int most);

// Calls `call` with the position in `images` and the recorded colour image, in ascending order.
// `images` must be ascending in their index. Throws InputError if an image cannot be read again.
void ReadColorImages(const SequenceOptions& sequence, const std::vector<ColorImage>& images,
                     const std::function<void(std::size_t, const Image<Rgb8>&)>& call);
// As ReadColorImages(), with the rectified depth images (m) of the frames.
void ReadDepthImages(const SequenceOptions& sequence, const std::vector<ColorImage>& images,
                     const std::function<void(std::size_t, const Image<float>&)>& call);

// Log brightness of an image at several resolutions, after a high-pass filter, which removes the
// exposure. An image of `halvings` n has 2^n times fewer columns and rows.
std::vector<Image<float>> FilteredBrightness(const Image<Rgb8>& color,
                                             const std::vector<int>& halvings);

struct BrightnessSample {
  double value;
  Eigen::Vector2d slope;  // derivative by the pixel, 1/px of the full image
};

// Bilinear sample of an image of FilteredBrightness(). `pixel`: in the full image. Returns
// std::nullopt within 2 px of the border of the reduced image.
std::optional<BrightnessSample> BrightnessAt(const Image<float>& brightness, int halvings,
                                             const Eigen::Vector2d& pixel);

}  // namespace surfit
