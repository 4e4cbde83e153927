#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/sequences/recording.h"
#include "surfit/frame/rectify_frame.h"
#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// Returns a warning if the depth scale is implausible and another common scale fits better, or if
// the median depth is below 0.2 m or above 20 m. Implausible: the median depth is outside of 0.4 to
// 5 m, or almost all depth is too close. Returns std::nullopt for depth in metres (float images)
// and for images without valid depth. `path`: name of the image in the warning. `is_given`: the
// scale is set by options or a file, so the warning only asks to check it.
std::optional<std::string> DepthScaleWarning(const RawDepth& depth, double depth_units_per_metre,
                                             const std::string& path, bool is_given = false);

// Orientation of the pixels of a colour image, relative to depth.
enum class ImageTurn { kNone, kRotated, kMirrored, kUpsideDown };

// Best alignment of colour edges to depth edges: a depth pixel is scaled about the image centre and
// shifted to its colour pixel.
struct RegistrationFit {
  double scale = 1;  // size of colour relative to depth, about the image centre
  // Shift after scaling, px, in steps of 1/160 of the image width. Positive: colour is to the
  // right, or below.
  int right_px = 0, down_px = 0;
  bool is_doubtful = false;  // all frames, and both halves of them, contradict the registration
  // If not kNone, only colour of this orientation matches. Scale and shift are then 1 and 0.
  ImageTurn turn = ImageTurn::kNone;
  // Mean colour gradient at depth edges with the given registration, in standard deviations of the
  // gradient. About 0 for colour of another place, and 0.5 to 4 for registered colour.
  double given_score = 0;
};

// Estimates the alignment from raw or rectified images. Frames are ignored without colour, with
// colour of another size, or with few depth edges. Returns std::nullopt without usable frames, and
// without an alignment above the mean gradient.
std::optional<RegistrationFit> FitRegistration(const std::vector<FrameImages>& frames,
                                               const PinholeCamera& depth_camera);

// Returns a warning if the registration of FitRegistration() is doubtful. It has approximate
// intrinsics of the colour camera, if colour is shifted or scaled.
std::optional<std::string> RegistrationWarning(const RegistrationFit& fit,
                                               const PinholeCamera& depth_camera);
std::optional<std::string> RegistrationWarning(const std::vector<FrameImages>& frames,
                                               const PinholeCamera& depth_camera);

// Checks the place of a separate colour camera. Uses its distance from the depth camera, the ratio
// of depth in its view, and colour edges at depth edges. Compares them with the inverse of
// color_from_depth. Returns a warning, or std::nullopt. `images`: raw images. `camera.depth.fy`
// must be positive. `registration`: alignment of the registered colour.
std::optional<std::string> ColorCameraWarning(const std::vector<FrameImages>& images,
                                              const RgbdCamera& camera,
                                              const RectifyOptions& options,
                                              std::optional<RegistrationFit>* registration);

}  // namespace surfit
