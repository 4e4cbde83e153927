// Registers two point clouds and prints the quality of the result.

#include <cstdio>

#include "apps/solvers/register_run.h"
#include "common/outcomes.h"
#include "common/tool_main.h"

namespace surfit::tools {
namespace {

void PrintCloud(const char* name, const RegisteredCloud& cloud) {
  std::printf("%s: %zu points", name, cloud.points);
  if (cloud.not_finite > 0) std::printf(", %zu non-finite points removed", cloud.not_finite);
  if (cloud.normal_radius_m > 0) {
    std::printf(", normals from a radius of %.4f m", cloud.normal_radius_m);
  }
  std::printf(", %zu without normal\n", cloud.without_normal);
}

int Run(const RegisterRunOptions& options) {
  const RegisterRunResult result = RunRegister(options);
  PrintCloud("source", result.source);
  PrintCloud("target", result.target);
  PrintIterations(result.icp);
  std::printf("%s: rmse %.4f m, inlier share %.3f, smallest eigenvalue %.2e\n",
              ToString(result.icp.termination).c_str(), result.icp.rmse_m, result.icp.inlier_ratio,
              result.icp.eigenvalues[0]);
  PrintPose(result.icp);
  std::printf("pictures: %s/before.png, %s/after.png\n", options.output.c_str(),
              options.output.c_str());
  return PrintFailure(result.icp, options.registration.icp);
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv, "registers two point clouds by ICP with nearest neighbours, from the identity",
      surfit::tools::Run);
}
