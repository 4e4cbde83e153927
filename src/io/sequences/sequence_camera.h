#pragma once

#include <string>

#include "io/sequences/recording.h"
#include "surfit/geometry/sensor.h"
#include "surfit/io/sequence.h"

namespace surfit {

// Sets the camera of `info`, its origin and warnings. info->format must be set. Precedence: values
// in the options, options.camera, camera.yaml of the sequence, `tell`, the format. Keeps fy < 0. If
// width and height are 0, they are set later from the images. Returns true if the options, a
// camera file or the recording set the depth scale, and false for the default of a format or
// preset. Throws InputError with the option or file at fault.
bool ResolveCamera(const SequenceOptions& options, const CameraReader& tell, SequenceInfo* info);

// "525 525 319.5 239.5 px, 1000 depth units per metre", with distortion coefficients if not 0, and
// with disparity parameters instead of depth units.
std::string FormatDepthCamera(const RgbdCamera& camera);

// Compares image size, intrinsics and distortion.
bool HaveEqualIntrinsics(const PinholeCamera& a, const PinholeCamera& b);

// Comma-separated names of the presets with this image size. Empty if there are none.
std::string PresetsOfSize(int width, int height);

// Sets the latency of depth to 0. Call it for sequences whose timestamps are not from a clock.
// Throws InputError if the options set a latency other than 0.
void DropLatency(const SequenceOptions& options, RgbdCamera* camera);

// Path of the camera.yaml that ResolveCamera() reads; empty: none.
std::string CameraFile(const SequenceOptions& options, const std::string& format);

}  // namespace surfit
