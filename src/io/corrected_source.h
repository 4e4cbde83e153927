#pragma once

#include <memory>

#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/io/frame_source.h"

namespace surfit {

// The frames of a source with their depth corrected; the source itself if there is nothing to do.
std::unique_ptr<FrameSource> CorrectedSource(std::unique_ptr<FrameSource> source,
                                             const InverseDepthField& field);

}  // namespace surfit
