#pragma once

#include <gmock/gmock.h>

#include <optional>

#include "testing/matchers.h"
#include "tools/slam_tool.h"

namespace surfit::testing {

// Runs programs with one failing system call: see fault_library.cc.
class FaultTest : public SlamTool {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kLibrary)) GTEST_SKIP() << "this build has no fault library";
  }

  // Runs a program whose n-th call of this kind fails. Returns std::nullopt if it makes fewer
  // calls.
  std::optional<ProgramResult> RunWithFault(const std::string& kind, int n,
                                            const std::string& folder,
                                            const std::string& command) const {
    const std::string mark = own_.path() + "/mark";
    std::filesystem::remove(mark);
    std::filesystem::remove_all(Output());
    const ProgramResult result =
        RunShell("export SURFIT_FAULT=" + kind + ":" + std::to_string(n) + " SURFIT_FAULT_FOLDER=" +
                 std::filesystem::weakly_canonical(folder).string() + " SURFIT_FAULT_MARK=" + mark +
                 "\nLD_PRELOAD=" + kLibrary + " exec $tools/" + command);
    if (!std::filesystem::exists(mark)) return std::nullopt;
    EXPECT_LT(result.exit_code, 128) << kind << " " << n << ": " << result.err;
    if (result.exit_code == 1) {
      EXPECT_THAT(result.err, HasError()) << kind << " " << n;
    }
    return result;
  }
  static std::string WholePath(const std::string& path) {
    return std::filesystem::weakly_canonical(path).string();
  }

 private:
  static inline const std::string kLibrary = std::string(SURFIT_TOOLS_DIR) + "/libsurfit_fault.so";
};

}  // namespace surfit::testing
