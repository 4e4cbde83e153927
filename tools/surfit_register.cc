// Registers two point clouds and prints the quality of the result.

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "apps/solvers/register_run.h"
#include "common/outcomes.h"
#include "common/tool_main.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit::tools {
namespace {

// Method of the initial pose, or a pose or file for the method "file".
class StartText final : public OptionText {
 public:
  explicit StartText(RegisterRunOptions* options) : options_(options) {}
  std::string Get() const override {
    return options_->start.method == "file" ? options_->start_pose : options_->start.method;
  }
  void Set(const std::string& text) override {
    const bool is_method = text == "identity" || text == "global" || text == "auto";
    ThrowIf(!is_method && text.find(',') == std::string::npos && !std::filesystem::exists(text),
            "identity, global, auto, tx,ty,tz,qx,qy,qz,qw, or a file with a 4 x 4 matrix");
    options_->start.method = is_method ? text : "file";
    options_->start_pose = is_method ? "" : text;
  }
  const std::type_info& type() const override { return typeid(StartText); }
  void* field() override { return options_; }

 private:
  RegisterRunOptions* options_;
};

struct Options {
  RegisterRunOptions run;

  void Visit(OptionVisitor& v) {
    v.AddPart(run, "run", "registration", WithoutFlags({"start"}));
    v.Group("registration");
    StartText start(&run);
    v.AddText(start, Option("start",
                            "initial pose; identity; global: matches of local shapes; auto: "
                            "identity, then global if that result is not accepted; "
                            "tx,ty,tz,qx,qy,qz,qw, or a file with a 4 x 4 matrix: initial "
                            "target_from_source",
                            Everyday()));
  }
};

void PrintCloud(const char* name, const RegisteredCloud& cloud) {
  std::printf("%s: %zu points", name, cloud.points);
  if (cloud.not_finite > 0) std::printf(", %zu non-finite points removed", cloud.not_finite);
  if (cloud.duplicates > 0) std::printf(", %zu equal to other points", cloud.duplicates);
  if (cloud.normal_radius_m > 0) {
    std::printf(", normals from a radius of %.4f m", cloud.normal_radius_m);
  }
  std::printf(", %zu without normal\n", cloud.without_normal);
}

void PrintVerification(const CloudRegistration& result) {
  std::printf("start %s: overlap ratio %.3f, inliers near the surface %.3f, ", result.start.c_str(),
              result.overlap_ratio, result.inlier_ratio);
  if (result.free_space_violation_ratio) {
    std::printf("free-space violations %.3f, ", *result.free_space_violation_ratio);
  }
  std::printf("forward-backward %.4f m, largest sigma %.4f m, point spacing %.4f m, noise %.4f m\n",
              result.disagreement_m, result.sigma_m, result.spacing_m, result.noise_m);
}

// Prints the reason of a rejected registration on stderr.
ExitCode PrintReason(const CloudRegistration& result, const RegisterRunOptions& options) {
  if (result.accepted()) return kDone;
  if (!result.icp.Succeeded()) return PrintFailure(result.icp, options.registration.icp);
  std::fprintf(stderr, "failed: %s: %s\n", ToString(result.reason).c_str(),
               ViolatedCriterion(result, options.start.criteria).c_str());
  return kAlgorithmFailed;
}

int Run(const Options& given) {
  const RegisterRunOptions& options = given.run;
  const RegisterRunResult result = RunRegister(options);
  const CloudRegistration& registration = result.registration;
  PrintCloud("source", result.source);
  PrintCloud("target", result.target);
  PrintIterations(registration.icp);
  std::printf("%s: rmse %.4f m, inlier share %.3f, smallest eigenvalue %.2e\n",
              ToString(registration.icp.termination).c_str(), registration.icp.rmse_m,
              registration.icp.inlier_ratio, registration.icp.eigenvalues[0]);
  PrintVerification(registration);
  constexpr double kUnusualSpacingM = 5;
  if (registration.spacing_m > kUnusualSpacingM) {
    std::printf("note: the point spacing is %.4g m: coordinates should be in metres\n",
                registration.spacing_m);
  }
  PrintPose(registration.icp);
  std::printf("pictures: %s/before.png, %s/after.png\n", options.output.c_str(),
              options.output.c_str());
  return PrintReason(registration, options);
}

}  // namespace
}  // namespace surfit::tools

int main(int argc, char** argv) {
  return surfit::tools::ToolMain(
      argc, argv, "registers two point clouds from any pose, and verifies the result",
      surfit::tools::Run);
}
