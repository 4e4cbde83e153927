#pragma once

#include <optional>
#include <vector>

#include "io/sequences/recording.h"
#include "io/sequences/recording_warnings.h"
#include "surfit/frame/frame_source.h"
#include "surfit/frame/rectify_frame.h"

namespace surfit {

// Completes `info` from the first images of a sequence: unknown image sizes, and warnings about the
// depth scale and the registration of colour. Mirrors the ground truth if the camera is mirrored.
// Logs the assumptions and warnings. Returns the rectifier of the frames. `first` must not be
// empty. Throws InputError naming the image if its size differs from the size of the camera. Call
// after ResolveCamera(), once per sequence.
FrameRectifier CompleteInfo(const std::vector<FrameImages>& first, const RectifyOptions& options,
                            bool scale_is_given, SequenceInfo* info,
                            std::optional<RegistrationFit>* registration);

}  // namespace surfit
