#pragma once

#include "common/modes.h"

namespace surfit::tools {

Mode TrajectoryEvaluationMode();
Mode MapEvaluationMode();
Mode ViewEvaluationMode();
Mode RevisitEvaluationMode();

}  // namespace surfit::tools
