#pragma once

#include "common/modes.h"

namespace surfit::tools {

// The evaluations of surfit_evaluate.
Mode TrajectoryEvaluationMode();
Mode MapEvaluationMode();
Mode ViewEvaluationMode();
Mode RevisitEvaluationMode();

}  // namespace surfit::tools
