#pragma once

#include <set>
#include <string>

#include "surfit/core/options.h"
#include "surfit/io/sequence.h"

namespace surfit::tools {

// By which camera frames are read: the one that a run found, or the one that it was given, for who
// has what was found from elsewhere.
enum class RecordedCamera { kFound, kGiven };

// Gives the flags of a sequence what a run of surfit_slam has recorded: those of its summary.json,
// and where the camera that it found is wanted and it wrote a camera.yaml, this in place of the
// camera that it was given. Flags that the command line has set stay as they are; with --camera
// none of the run's camera.yaml counts. Those left out, and those that the program has not, do as
// well. Throws InputError naming the file if it cannot be read or tells no such options, and the
// flag whose value does not fit.
void TakeRecordedFlags(const std::string& run, const OptionTable& sequence,
                       const std::set<std::string>& left_out = {},
                       RecordedCamera camera = RecordedCamera::kFound);

// A sequence as such a run read it, with the camera that the run found, if it found one.
SequenceOptions WithFoundCamera(const SequenceOptions& sequence, const std::string& run);

}  // namespace surfit::tools
