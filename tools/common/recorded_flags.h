#pragma once

#include <set>
#include <string>

#include "surfit/core/options.h"
#include "surfit/io/sequence.h"

namespace surfit::tools {

// Camera for reading the frames: the camera that the run calibrated, or the input camera of the
// run. Programs that read the calibration from another file use kGiven.
enum class RecordedCamera { kFound, kGiven };

// Sets the flags of a sequence to the options in summary.json of a surfit_slam run. Call it in
// Mode::prepare, because Flags::Apply() then copies the flags to the options. With kFound, the
// camera.yaml of the run, if it exists, replaces the flags of the camera. Flags on the command
// line, flags in `left_out` and flags that the program does not have are not set. With --camera,
// the camera.yaml of the run is not used. Throws InputError with the name of the file if it cannot
// be read or has no options. Throws InputError with the name of a flag that has an invalid value.
void ApplyRecordedFlags(const std::string& run, const OptionTable& sequence,
                        const std::set<std::string>& left_out = {},
                        RecordedCamera camera = RecordedCamera::kFound);

}  // namespace surfit::tools
