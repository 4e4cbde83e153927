#include "surfit/calibration/calibration.h"

#include "core/shared_options.h"
#include "surfit/core/options.h"

namespace surfit {

void CalibrationOptions::Visit(OptionVisitor& v) {
  v.Group("calibration");
  v.Add(enabled, SharedOption("calibrate", InField("enabled"), Everyday()));
  v.Add(first_keyframes, "first_keyframes",
        "number of keyframes of the first calibration; repeated for every 25 % more keyframes",
        AtLeast(2));
  v.Add(max_keyframes, "max_keyframes",
        "number of keyframes after which the calibration does not change", AtLeast(2));
  v.AddPart(refinement, "refinement", "refinement of poses and calibration", NoFlags());
}

}  // namespace surfit
