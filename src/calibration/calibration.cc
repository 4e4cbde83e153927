#include "surfit/calibration/calibration.h"

#include "surfit/core/options.h"

namespace surfit {

void CalibrationOptions::Visit(OptionVisitor& v) {
  v.Group("calibration");
  v.Add(enabled, "enabled",
        "calibrate the depth camera by the keyframes while it is tracked: focal lengths, principal "
        "point and the error of depth over the image",
        AsFlag("calibrate"), Everyday());
  v.Add(first_keyframes, "first_keyframes",
        "keyframes for the first time; then whenever there are a quarter more", AtLeast(2));
  v.Add(max_keyframes, "max_keyframes", "with more, the camera stays as it was found", AtLeast(2));
  v.AddPart(refinement, "refinement", "how it is found", NoFlags());
}

}  // namespace surfit
