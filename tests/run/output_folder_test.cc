#include "io/files/output_folder.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include "surfit/core/error.h"
#include "testing/matchers.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

namespace fs = std::filesystem;

TEST(OutputFolder, IsCreatedAndHasNoLockAfterwards) {
  const TempFolder dir;
  const std::string folder = dir.path() + "/a/b";
  { const OutputFolder owned(folder, {"map.ply"}); }
  EXPECT_TRUE(fs::is_empty(folder));
}

TEST(OutputFolder, RejectsASecondOwner) {
  const TempFolder dir;
  {
    const OutputFolder owned(dir.path(), {});
    dir.Write("map.ply", "of the owner");
    ExpectInputError([&] { OutputFolder(dir.path(), {"map.ply"}); }, Names(dir.path(), getpid()));
    EXPECT_EQ(ReadBytes(dir / "map.ply"), "of the owner");
  }
  EXPECT_NO_THROW(OutputFolder(dir.path(), {}));
}

TEST(OutputFolder, IsReusedAfterItsOwnerHasEnded) {
  const TempFolder dir;
  dir.Write(".surfit.lock", "12345\n");
  ::testing::internal::CaptureStderr();
  { const OutputFolder owned(dir.path(), {}); }
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), Names(dir.path(), 12345));
  EXPECT_TRUE(fs::is_empty(dir.path()));
}

TEST(OutputFolder, RemovesOnlyFilesOfAFormerRun) {
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

TEST(OutputFolder, RejectsLinksToOtherFolders) {
  const TempFolder dir, elsewhere;
  elsewhere.Write("1.jpg", "x");
  fs::create_directory_symlink(elsewhere.path(), dir.path() + "/views");
  ExpectInputError(
      [&] {
        OutputFolder(dir.path(), {"map.ply", "views/1.jpg"});
      },
      Names(dir.path() + "/views"));
  EXPECT_EQ(ReadBytes(elsewhere / "1.jpg"), "x");
}

TEST(OutputFolder, RejectsRemovalOfInputFiles) {
  const TempFolder dir;
  dir.Write("camera.yaml", "x");
  ExpectInputError(
      [&] {
        OutputFolder(dir.path(), {"camera.yaml"}, {"", dir / "camera.yaml"});
      },
      Names("camera.yaml"));
  EXPECT_EQ(ReadBytes(dir / "camera.yaml"), "x");
}

}  // namespace
}  // namespace surfit::testing
