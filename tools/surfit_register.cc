// Registers two point clouds and shows how well they fit.

#include <gflags/gflags.h>

#include <cstdio>

#include "common/icp_flags.h"
#include "common/icp_report.h"
#include "common/recorded_flags.h"
#include "common/solver_flags.h"
#include "common/tool_main.h"
#include "surfit/run/register_run.h"

namespace {

const surfit::RegisterRunOptions kRun;

}  // namespace

DEFINE_string(source, kRun.source, "file of the cloud to be moved: PLY or PCD, metres");
DEFINE_string(target, kRun.target, "file of the cloud to be met");
DEFINE_string(output, kRun.output, "folder for pose, aligned cloud and pictures; made if missing");
DEFINE_bool(reciprocal, kRun.registration.reciprocal,
            "on the finest level, pairs must be each other's nearest points");
DEFINE_int32(levels, kRun.registration.levels,
             "levels of coarse to fine, each of a quarter of the source points of the next");
DEFINE_double(normal_radius_m, kRun.normals.radius_m,
              "normals come from neighbours at least this far; 0 = from the cloud's spacing");
DEFINE_int32(threads, kRun.threads, "threads that compute at the same time");

namespace surfit::tools {
namespace {

void PrintCloud(const char* name, const RegisteredCloud& cloud) {
  std::printf("%s: %zu points", name, cloud.points);
  if (cloud.not_finite > 0) std::printf(", %zu more not finite", cloud.not_finite);
  if (cloud.normal_radius_m > 0) {
    std::printf(", normals from %.4f m around", cloud.normal_radius_m);
  }
  std::printf(", %zu without normal\n", cloud.without_normal);
}

int Run() {
  RequireFlag("source", FLAGS_source);
  RequireFlag("target", FLAGS_target);
  RequireFlag("output", FLAGS_output);
  RegisterRunOptions options;
  options.source = FLAGS_source;
  options.target = FLAGS_target;
  options.output = FLAGS_output;
  options.registration.icp = IcpOptionsFromFlags(RegisterCloudsOptions::DefaultIcp());
  SetSolverFromFlags(&options.registration.icp);
  options.normals.radius_m = FLAGS_normal_radius_m;
  options.normals.noise = options.registration.icp.error_model.noise;
  options.registration.reciprocal = FLAGS_reciprocal;
  options.registration.levels = FLAGS_levels;
  options.threads = FLAGS_threads;
  options.record = RecordedFlags();
  const RegisterRunResult result = RunRegister(options);
  PrintCloud("source", result.source);
  PrintCloud("target", result.target);
  PrintIterations(result.icp);
  std::printf("%s: rmse %.4f m, inlier share %.3f, smallest eigenvalue %.2e\n",
              ToString(result.icp.termination).c_str(), result.icp.rmse_m, result.icp.inlier_share,
              result.icp.eigenvalues[0]);
  PrintPose(result.icp);
  std::printf("pictures: %s/before.png, %s/after.png\n", FLAGS_output.c_str(),
              FLAGS_output.c_str());
  return PrintFailure(result.icp, options.registration.icp);
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  surfit::tools::SetIcpFlagDefaults(surfit::RegisterCloudsOptions::DefaultIcp());
  return surfit::tools::ToolMain(
      argc, argv, "registers two point clouds by ICP with nearest neighbours, from the identity",
      surfit::tools::Run);
}
