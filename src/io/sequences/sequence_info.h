#pragma once

#include <optional>
#include <vector>

#include "io/checks/recording_warnings.h"
#include "io/sequences/recording.h"
#include "surfit/frame/frame_source.h"
#include "surfit/frame/rectify_frame.h"

namespace surfit {

// Completes all members of `info` from the first images of a sequence. Adds warnings about depth
// scale, depth range and registration of colour. Mirrors the ground truth if the camera is
// mirrored. Logs the assumptions and warnings. Returns the rectifier of the frames. `first` must
// not be empty. Throws InputError naming the first image if its size differs from the size of the
// camera, and for intrinsics that are not in px. Without a colour image, a separate colour camera
// becomes registered. Call after ResolveCamera(), once per sequence.
FrameRectifier CompleteInfo(const std::vector<FrameImages>& first, const RectifyOptions& options,
                            bool scale_is_given, SequenceInfo* info,
                            std::optional<RegistrationFit>* registration);

}  // namespace surfit
