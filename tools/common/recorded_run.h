#pragma once

#include <set>
#include <string>

#include "surfit/core/options.h"
#include "surfit/io/sequence.h"

namespace surfit::tools {

// Gives the flags of a sequence what a run of surfit_slam has recorded: those of its summary.json,
// and the camera that it found, where it wrote a camera.yaml, in place of the camera that it was
// given. Flags that the command line has set stay as they are; with --camera none of the run's
// camera.yaml counts. Those left out, and those that the program has not, do as well. Throws
// InputError naming the file if it cannot be read or tells no such options, and the flag whose
// value does not fit.
void TakeRecordedFlags(const std::string& run, const OptionTable& sequence,
                       const std::set<std::string>& left_out = {});

// A sequence as such a run read it, with the camera that the run found, if it found one.
SequenceOptions WithFoundCamera(const SequenceOptions& sequence, const std::string& run);

}  // namespace surfit::tools
