#pragma once

#include <string>

#include "io/sequences/recording.h"
#include "surfit/geometry/sensor.h"
#include "surfit/io/sequence.h"

namespace surfit {

// Gives a sequence whose format is known the camera that the options, the folder and the format
// tell, in this order, before the format what `tell` tells; fy < 0 is kept. A camera of
// width 0 and height 0 takes its size from the images. Tells where it is from, and appends what the
// user should know. Throws InputError naming the option or file at fault.
void ResolveCamera(const SequenceOptions& options, const TellCamera& tell, SequenceInfo* info);

// "525 525 319.5 239.5 px, 1000 units of depth a metre", and distortion if there is any.
std::string DepthFigures(const RgbdCamera& camera);

// Whether a pixel of the one sees the ray that it sees in the other.
bool HaveSamePixels(const PinholeCamera& a, const PinholeCamera& b);

// The presets whose images have this size, for a sentence.
std::string PresetsOfSize(int width, int height);

// Makes the latency zero, for a recording whose stamps are no clock's. Throws InputError if the
// options ask for one.
void DropLatency(const SequenceOptions& options, RgbdCamera* camera);

// The camera.yaml that ResolveCamera() reads, or an empty name where it reads none.
std::string CameraFile(const SequenceOptions& options, const std::string& format);

}  // namespace surfit
