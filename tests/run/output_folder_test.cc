#include "io/files/output_folder.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include "surfit/core/error.h"
#include "testing/matchers.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

namespace fs = std::filesystem;

TEST(OutputFolder, IsMadeAndLeftWithoutALock) {
  const TempFolder dir;
  const std::string folder = dir.path() + "/a/b";
  { const OutputFolder owned(folder, {"map.ply"}); }
  EXPECT_TRUE(fs::is_empty(folder));
}

TEST(OutputFolder, HasOneOwnerAtATime) {
  const TempFolder dir;
  {
    const OutputFolder owned(dir.path(), {});
    dir.Write("map.ply", "of the owner");
    ExpectInputError([&] { OutputFolder(dir.path(), {"map.ply"}); },
                     AllOf(HasSubstr(dir.path()), HasSubstr(Concat("by process ", getpid()))));
    EXPECT_EQ(ReadBytes(dir / "map.ply"), "of the owner");
  }
  EXPECT_NO_THROW(OutputFolder(dir.path(), {}));
}

TEST(OutputFolder, IsTakenOverFromAProcessThatHasEnded) {
  const TempFolder dir;
  dir.Write(".surfit.lock", "12345\n");
  ::testing::internal::CaptureStderr();
  { const OutputFolder owned(dir.path(), {}); }
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), HasSubstr("process 12345 has ended"));
  EXPECT_TRUE(fs::is_empty(dir.path()));
}

TEST(OutputFolder, LosesAFormerRunsFilesAndNothingElse) {
  const TempFolder dir;
  for (const char* name :
       {"map.ply", "views/1.jpg", "map.ply.partial-77-0", "other.txt", "other.txt.partial-77-0"}) {
    dir.Write(name, "x");
  }
  const OutputFolder owned(dir.path(), {"map.ply", "views/1.jpg", "absent.txt"});
  EXPECT_FALSE(fs::exists(dir / "map.ply"));
  EXPECT_FALSE(fs::exists(dir / "views/1.jpg"));
  EXPECT_FALSE(fs::exists(dir / "map.ply.partial-77-0"));
  EXPECT_TRUE(fs::exists(dir / "other.txt"));
  EXPECT_TRUE(fs::exists(dir / "other.txt.partial-77-0"));
}

TEST(OutputFolder, TouchesNothingThatAFolderInItIsALinkTo) {
  const TempFolder dir, elsewhere;
  elsewhere.Write("1.jpg", "x");
  fs::create_directory_symlink(elsewhere.path(), dir.path() + "/views");
  ExpectInputError(
      [&] {
        OutputFolder(dir.path(), {"map.ply", "views/1.jpg"});
      },
      HasSubstr("views is a link"));
  EXPECT_EQ(ReadBytes(elsewhere / "1.jpg"), "x");
}

TEST(OutputFolder, KeepsWhatIsStillToBeRead) {
  const TempFolder dir;
  dir.Write("camera.yaml", "x");
  ExpectInputError(
      [&] {
        OutputFolder(dir.path(), {"camera.yaml"}, {"", dir / "camera.yaml"});
      },
      HasSubstr("camera.yaml is read"));
  EXPECT_EQ(ReadBytes(dir / "camera.yaml"), "x");
}

}  // namespace
}  // namespace surfit::testing
