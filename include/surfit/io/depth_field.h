#pragma once

#include <string>

#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/io/sequence.h"

namespace surfit {

// The correction of depth that a sequence of this format comes with: the inverse_depth_field of its
// camera.yaml (of a file F.klg: F.klg.yaml), zero where that has none or options.camera names a
// preset. OpenSequence() and WatchFolder() apply it to every frame; it holds for frames as they
// give them, mirrored if the file's image y axis points up. Throws InputError naming file and key.
InverseDepthField ReadDepthField(const SequenceOptions& options, const std::string& format);

}  // namespace surfit
