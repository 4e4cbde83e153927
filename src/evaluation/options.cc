#include "surfit/core/options.h"

#include <cmath>

#include "surfit/core/error.h"
#include "surfit/evaluation/map_error.h"
#include "surfit/evaluation/trajectory_evaluation.h"

namespace surfit {

using Unit = RelativePoseErrorOptions::Unit;

static std::string OptionToText(const Unit& unit) {
  return unit == Unit::kFrames ? "frames" : "seconds";
}

static void OptionFromText(const std::string& text, Unit* unit) {
  ThrowIf(text != "frames" && text != "seconds", "'frames' or 'seconds'");
  *unit = text == "frames" ? Unit::kFrames : Unit::kSeconds;
}

void MatchOptions::Visit(OptionVisitor& v) {
  v.Add(max_difference_s, "max_difference_s",
        "maximum time difference to the nearest ground-truth pose without interpolation, s "
        "(evo: 0.01, TUM scripts: 0.02)",
        Between(0, 1));
  v.Add(max_gap_s, "max_gap_s", "maximum gap between ground-truth poses for interpolation, s",
        Between(0, 1), ZeroIs("nearest pose without interpolation, as in evo and the TUM scripts"));
}

void RelativePoseErrorOptions::Visit(OptionVisitor& v) {
  v.Add(delta, "delta", "distance between the two poses of a relative pose error", Positive());
  v.Add(delta_unit, "delta_unit", "unit of delta: frames or seconds");
  v.Check([this] {
    if (delta_unit != Unit::kFrames || (delta == std::floor(delta) && delta < 1e9)) return;
    throw InputError("delta is ", delta, " frames, must be an integer below 1e9");
  });
}

void TrajectoryEvaluationOptions::Visit(OptionVisitor& v) {
  v.AddPart(match, "match", "association of poses by timestamp");
  v.AddPart(rpe, "rpe", "relative pose error");
}

void MapErrorOptions::Visit(OptionVisitor& v) {
  v.Add(completeness_distance_m, "completeness_distance_m",
        "maximum distance to the nearest map point of a mapped reference point, m", Positive());
}

}  // namespace surfit
