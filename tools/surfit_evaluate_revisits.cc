// Tells whether an estimate or its pseudo ground truth lays the surfaces of two visits to one place
// better over each other.

#include <gflags/gflags.h>

#include <chrono>
#include <cmath>
#include <iostream>

#include "common/json.h"
#include "common/progress_line.h"
#include "common/sequence_flags.h"
#include "common/tool_main.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"
#include "surfit/run/revisits.h"

namespace {

const surfit::RevisitOptions kDefaults;

}  // namespace

DEFINE_string(estimate, "", "the estimated trajectory of the sequence: TUM format");
DEFINE_int32(min_gap, kDefaults.min_gap, "frames between the two visits, at least");
DEFINE_double(max_distance, kDefaults.max_distance_m, "metres between the cameras, at most");
DEFINE_double(max_angle_deg, kDefaults.max_angle_rad * 180 / M_PI,
              "degrees between the cameras, at most");
DEFINE_int32(stride, 5, "look at every stride-th frame");
DEFINE_int32(threads, 2, "threads to compute with");

namespace surfit::tools {
namespace {

RevisitOptions OptionsFromFlags() {
  RequireFlag("estimate", FLAGS_estimate);
  RevisitOptions options;
  options.sequence = SequenceOptionsFromFlags();
  options.sequence.stride = FLAGS_stride;
  options.estimate = FLAGS_estimate;
  options.min_gap = FLAGS_min_gap;
  options.max_distance_m = FLAGS_max_distance;
  options.max_angle_rad = FLAGS_max_angle_deg * M_PI / 180;
  return options;
}

void SetAgreement(const std::string& name, const RevisitAgreement& agreement, Json* json) {
  Json of_trajectory;
  SetStatistics("surface", "m", &agreement.surface_m, &of_trajectory);
  SetStatistics("icp_translation", "m", &agreement.icp_translation_m, &of_trajectory);
  SetStatistics("icp_rotation", "deg", &agreement.icp_rotation_deg, &of_trajectory);
  (*json)[name] = of_trajectory;
}

void PrintSummary(const std::string& name, const RevisitAgreement& agreement) {
  std::cerr << name << ": surfaces " << 1000 * agreement.surface_m.median
            << " mm apart, dense ICP goes " << 1000 * agreement.icp_translation_m.median
            << " mm and " << agreement.icp_rotation_deg.median << " deg (medians)" << std::endl;
}

int Run() {
  const RevisitOptions options = OptionsFromFlags();
  const ThreadLimit threads(FLAGS_threads);
  ProgressLine line;
  const auto start = std::chrono::steady_clock::now();
  const RevisitReport report = CompareAtRevisits(options, [&](int done, int all) {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    line.Show(Concat("pair ", done, "/", all), elapsed.count(), done == all);
  });
  Json json = {{"pairs", report.pairs},
               {"unregistered", report.unregistered},
               {"frames_without_pose", report.without_pose}};
  SetAgreement("groundtruth", report.ground_truth, &json);
  SetAgreement("estimate", report.estimate, &json);
  PrintJson(json);
  std::cerr << report.pairs << " pairs of frames of the same place, " << report.unregistered
            << " of them not registered" << std::endl;
  if (report.unregistered == report.pairs) return kAlgorithmFailed;
  PrintSummary("ground truth", report.ground_truth);
  PrintSummary("estimate", report.estimate);
  return kDone;
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv,
      "compares an estimated trajectory and the sequence's own poses where the camera returns to "
      "where it was: how far apart the surfaces of both visits lie, and how far dense ICP goes "
      "from the relative pose. Prints JSON on stdout and a summary on stderr.",
      surfit::tools::Run);
}
