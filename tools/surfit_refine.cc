// Refines a run of surfit_slam: joint optimisation of poses, surfels and the camera calibration.

#include <cmath>
#include <iostream>
#include <vector>

#include "apps/solvers/refine_run.h"
#include "common/console.h"
#include "common/recorded_flags.h"
#include "common/tool_main.h"
#include "core/shared_options.h"
#include "surfit/core/error.h"

namespace surfit::tools {
namespace {

struct Options {
  std::string run;
  RefineRunOptions refine;
  std::vector<std::string> fix;

  void Visit(OptionVisitor& v) {
    v.Group("run");
    v.Add(run, SharedOption("run", Everyday()));
    v.AddPart(refine, "refine", "refinement");
    v.Group("refinement");
    v.Add(fix, "fix",
          "parameters that are not estimated, separated by commas: intrinsics, depth_offset, "
          "depth_field (variation of the inverse depth error over the image), readout",
          AsFlag(), Everyday());
  }
};

void TakeRun(Options* options) {
  RequireFlag("run", options->run);
  ApplyRecordedFlags(options->run, TableOf(&options->refine.sequence));
  options->refine.trajectory = options->run + "/trajectory.txt";
  options->refine.output = options->run + "/refined";
}

using Row = std::vector<std::string>;

Row AteRow(const RefineRunSummary& s) {
  const auto text = [](const std::optional<TrajectoryEvaluation>& e) -> std::string {
    return e && e->ate ? Number(1000 * e->ate->translation_m.rmse, 4) : "unknown";
  };
  return {"ATE RMSE, mm", text(s.before), text(s.after), ""};
}

void AddCalibrationRows(const RefineRunSummary& s, std::vector<Row>* rows) {
  const DepthCalibration &a = s.given, &b = s.calibration;
  const auto add = [&](const std::string& name, double before, double after, int i) {
    const double variance = s.refinement.calibration_covariance(i, i);
    const std::string sigma = variance > 0 ? Number(std::sqrt(variance), 3) : "fixed";
    rows->push_back({name, Number(before), Number(after), sigma});
  };
  add("fx, px", a.camera.fx, b.camera.fx, 0);
  add("fy, px", a.camera.fy, b.camera.fy, 1);
  add("cx, px", a.camera.cx, b.camera.cx, 2);
  add("cy, px", a.camera.cy, b.camera.cy, 3);
  for (std::size_t i = 0; i < InverseDepthField::kSize; ++i) {
    add(Concat("inverse depth c", i, ", 1/m"), a.field.coefficients[i], b.field.coefficients[i],
        static_cast<int>(4 + i));
  }
  add("readout, s", a.readout_s, b.readout_s, static_cast<int>(4 + InverseDepthField::kSize));
}

// Result of the significance test of the calibration; empty without a test.
std::string CalibrationLine(const RefinementSummary& s) {
  if (s.calibration_limit == 0) return "";
  return Concat("the estimated calibration differs ",
                s.calibration_kept
                    ? "only insignificantly from the input calibration, which is kept"
                    : "significantly from the input calibration",
                " (squared distance ", Number(s.calibration_distance, 3), ", limit ",
                Number(s.calibration_limit, 3), ")\n");
}

void PrintOutcome(const RefineRunSummary& s, const std::string& output) {
  std::vector<Row> rows = {{"", "before", "after", "standard deviation"}, AteRow(s)};
  const RefinementFit &first = s.refinement.before, &last = s.refinement.after;
  rows.push_back(
      {"point to plane RMS, mm", Number(1000 * first.rms_m, 4), Number(1000 * last.rms_m, 4), ""});
  AddCalibrationRows(s, &rows);
  std::cout << output << ": " << ToString(s.refinement.termination) << " after "
            << s.refinement.rounds.size() << " rounds, " << s.keyframes << " keyframes of "
            << s.poses << " poses, " << s.map_points << " surfels in the map, "
            << Number(s.total_s, 3) << " s\n"
            << TextTable(rows, 1) << CalibrationLine(s.refinement)
            << "the scale is fixed: it is not observable" << std::endl;
}

RefineRunOptions WithFixedParameters(const Options& given) {
  RefineRunOptions options = given.refine;
  RefinementOptions& r = options.refinement;
  const std::map<std::string, bool*> estimated = {{"intrinsics", &r.estimate_intrinsics},
                                                  {"depth_offset", &r.estimate_depth_offset},
                                                  {"depth_field", &r.estimate_depth_field},
                                                  {"readout", &r.estimate_readout}};
  for (const std::string& name : given.fix) {
    const auto found = estimated.find(name);
    ThrowIf(found == estimated.end(), "--fix contains '", name,
            "', must be intrinsics, depth_offset, depth_field or readout");
    *found->second = false;
  }
  return options;
}

int Run(const Options& given) {
  const RefineRunOptions options = WithFixedParameters(given);
  const RefineRunSummary summary =
      RunRefinement(options, [](const std::string& line) { std::cerr << line << std::endl; });
  if (!summary.refinement.Succeeded()) {
    std::cerr << "refinement failed: " << ToString(summary.refinement.termination) << std::endl;
    return kAlgorithmFailed;
  }
  PrintOutcome(summary, options.output);
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "refines a run of surfit_slam: the poses of keyframes, the surfels that they share and the "
      "camera calibration by joint least squares; corrects the other poses and fuses the map "
      "again. "
      "The sequence is read with the options and the camera of --run, except for flags that are "
      "set.",
      surfit::tools::Run, surfit::tools::TakeRun);
}
