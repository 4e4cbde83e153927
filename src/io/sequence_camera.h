#pragma once

#include <string>
#include <vector>

#include "surfit/geometry/sensor.h"
#include "surfit/io/sequence.h"

namespace surfit {

// The camera that the options, the folder and the format give, in this order; fy < 0 is kept. A
// camera of width 0 and height 0 takes its size from the images. Appends what the user should know.
// Throws InputError naming the option or file at fault.
RgbdCamera ResolveCamera(const SequenceOptions& options, const std::string& format,
                         std::vector<std::string>* warnings);

// Makes the latency zero, for a recording whose stamps are no clock's. Throws InputError if the
// options ask for one.
void DropLatency(const SequenceOptions& options, RgbdCamera* camera);

// The camera.yaml that ResolveCamera() reads, or an empty name where it reads none.
std::string CameraFile(const SequenceOptions& options, const std::string& format);

}  // namespace surfit
