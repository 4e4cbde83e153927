// The example of a residual of one's own, in the programs that load it.
#include <dlfcn.h>
#include <link.h>

#include "tools/slam_tool.h"

namespace surfit::testing {
namespace {

const std::string kLibrary = SURFIT_TOOLS_DIR "/../tests/examples/residual_in_slam.so";

class ResidualLibrary : public SlamTool {};

TEST_F(ResidualLibrary, TracksByItAndReportsIt) {
  const ProgramResult result = Succeeded(Slam(
      Room(), Output(), {"--residual_library=" + kLibrary, "--residual=soft_plane", "--report"}));
  const nlohmann::json summary = Summary(Output());
  EXPECT_EQ(summary["frames_lost"], 0);
  EXPECT_LT(summary["ate_rmse_m"], 0.015);
  EXPECT_EQ(summary["options"]["residual"], "soft_plane");
  EXPECT_THAT(ReadBytes(Output() + "/report.html"), HasSubstr("soft_plane"));
  // And not by what would be chosen without.
  Succeeded(Slam(Room(), Output("ours")));
  EXPECT_NE(summary["digest"], Summary(Output("ours"))["digest"]);
}

TEST_F(ResidualLibrary, IsComparedWithOurOwn) {
  Succeeded(RunProgram("surfit_compare_solvers", {"--synthetic_points=2000", "--output=" + Output(),
                                                  "--residual_library=" + kLibrary,
                                                  "--rotations_deg=1", "--translations_m=0.01"}));
  int own = 0;
  const auto comparison = nlohmann::json::parse(ReadBytes(Output() + "/comparison.json"));
  for (const auto& row : comparison["rows"]) {
    if (row["residual"] != "soft_plane") continue;
    SCOPED_TRACE(row.dump());
    ++own;
    EXPECT_EQ(row["converged_share"], 1);
    EXPECT_LT(row["translation_error_m"], 1e-6);
  }
  EXPECT_EQ(own, 8);  // every solver but svd, and ceres_per_point with each linear solver
}

// The path of one that has nothing to do with residuals.
std::string AnotherLibrary() {
  void* const library = dlopen("libm.so.6", RTLD_NOW);
  const link_map* at = nullptr;
  if (library == nullptr || dlinfo(library, RTLD_DI_LINKMAP, &at) != 0) return "";
  return at->l_name;
}

TEST_F(ResidualLibrary, IsRefusedWhereItIsNone) {
  const auto refused = [&](const std::string& library, const std::string& message) {
    ExpectRefused(Slam(Room(), Output(), {"--residual_library=" + library}), message);
  };
  refused("/nowhere.so", "which cannot be loaded: /nowhere.so");
  refused(AnotherLibrary(), "which has no function SurfitRegisterResiduals");
  ExpectRefused(Slam(Room(), Output(), {"--residual=soft_plane"}),
                "--residual is 'soft_plane', must be one of: point_to_point, ");
}

}  // namespace
}  // namespace surfit::testing
