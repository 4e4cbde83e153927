// Programs with the example library of a custom residual.
#include <dlfcn.h>
#include <link.h>

#include "tools/slam_tool.h"

namespace surfit::testing {
namespace {

const std::string kLibrary = SURFIT_TOOLS_DIR "/../tests/examples/residual_in_slam.so";

class ResidualLibrary : public SlamTool {};

TEST_F(ResidualLibrary, IsUsedForTrackingAndReported) {
  const ProgramResult result = Succeeded(Slam(
      Room(), Output(), {"--residual_library=" + kLibrary, "--residual=soft_plane", "--report"}));
  const nlohmann::json summary = Summary(Output());
  EXPECT_EQ(summary["frames_lost"], 0);
  EXPECT_LT(summary["ate_rmse_m"], 0.015);
  EXPECT_EQ(summary["options"]["residual"], "soft_plane");
  EXPECT_THAT(ReadBytes(Output() + "/report.html"), Names("soft_plane"));
  // The result differs from the default residual.
  Succeeded(Slam(Room(), Output("ours")));
  EXPECT_NE(summary["digest"], Summary(Output("ours"))["digest"]);
}

TEST_F(ResidualLibrary, IsComparedWithTheBuiltInResiduals) {
  Succeeded(RunProgram("surfit_compare_solvers", {"--synthetic_points=2000", "--output=" + Output(),
                                                  "--residual_library=" + kLibrary,
                                                  "--rotations_deg=1", "--translations_m=0.01"}));
  int own = 0;
  const auto comparison = nlohmann::json::parse(ReadBytes(Output() + "/comparison.json"));
  for (const auto& row : comparison["rows"]) {
    if (row["residual"] != "soft_plane") continue;
    SCOPED_TRACE(row.dump());
    ++own;
    EXPECT_EQ(row["converged_ratio"], 1);
    EXPECT_LT(row["translation_error_m"], 1e-6);
  }
  EXPECT_EQ(own, 8);  // every solver except svd, and ceres_per_point with each linear solver
}

// Path of a library without residuals.
std::string AnotherLibrary() {
  void* const library = dlopen("libm.so.6", RTLD_NOW);
  const link_map* at = nullptr;
  if (library == nullptr || dlinfo(library, RTLD_DI_LINKMAP, &at) != 0) return "";
  return at->l_name;
}

TEST_F(ResidualLibrary, RejectsOtherLibraries) {
  const auto refused = [&](const std::string& library, const auto&... names) {
    ExpectRefused(Slam(Room(), Output(), {"--residual_library=" + library}), library, names...);
  };
  refused("/nowhere.so");
  refused(AnotherLibrary(), "SurfitRegisterResiduals");
  ExpectRefused(Slam(Room(), Output(), {"--residual=soft_plane"}), "--residual", "soft_plane",
                "point_to_point");
}

}  // namespace
}  // namespace surfit::testing
