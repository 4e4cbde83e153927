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

// Best alignment of colour edges to depth edges: a depth pixel is scaled about the image centre and
// shifted to its colour pixel.
struct RegistrationFit {
  double scale = 1;  // size of colour relative to depth, about the image centre
  // Shift after scaling, in steps of 1/160 of the image width. Positive: colour is to the right, or
  // below.
  int right_px = 0, down_px = 0;
  bool is_doubtful = false;  // all frames, and both halves of them, contradict the registration
};

// Estimates the alignment from raw or rectified images. Frames are ignored without colour, with
// colour of another size, or with few depth edges. Returns std::nullopt without usable frames, and
// without an alignment above the mean gradient.
std::optional<RegistrationFit> FitRegistration(const std::vector<FrameImages>& frames,
                                               const PinholeCamera& depth_camera);

// Checks the registration of colour to depth. Returns a warning with approximate intrinsics of the
// colour camera if the registration is probably wrong, otherwise std::nullopt.
//
// Most depth edges are object boundaries, where colour changes as well. So the mean colour gradient
// at depth edges is largest with correct registration. Tests scales of 0.8 to 1.25 and shifts of up
// to 5 % of the image width. Frames with few depth edges are not used.
std::optional<std::string> RegistrationWarning(const std::vector<FrameImages>& frames,
                                               const PinholeCamera& depth_camera);

}  // namespace surfit
