#pragma once

#include <optional>

#include "surfit/frame/preprocess.h"
#include "surfit/io/sequence.h"
#include "surfit/registration/initialize.h"

namespace surfit {

// One frame of a sequence, ready to be registered.
struct PosedView {
  ColoredView view;
  std::optional<Rigid3d> world_from_camera;  // true pose
};

// The frame with this index; the options' first, last and stride are not used. Throws InputError
// where there is none or it cannot be read.
PosedView ReadPosedView(const SequenceOptions& options, int index,
                        const PreprocessOptions& preprocess);

}  // namespace surfit
