#include <gmock/gmock.h>
#include <sys/resource.h>

#include <cerrno>
#include <csignal>
#include <cstring>

#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "testing/matchers.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

namespace fs = std::filesystem;

// Limits the size of new files to a number of bytes during its lifetime.
class LargestFile {
 public:
  explicit LargestFile(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit now = {bytes, before_.rlim_max};
    former_ = std::signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &now);
  }
  ~LargestFile() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, former_);
  }

 private:
  rlimit before_{};
  void (*former_)(int);
};

TEST(AppendedFile, ContainsEachPieceAfterAppend) {
  const TempFolder dir;
  AppendedFile file(dir.Write("a.txt", "an older file"));
  EXPECT_EQ(ReadBytes(dir / "a.txt"), "");
  file.Append("one\n");
  EXPECT_EQ(ReadBytes(dir / "a.txt"), "one\n");
  file.Append("two\n");
  EXPECT_EQ(ReadBytes(dir / "a.txt"), "one\ntwo\n");
}

TEST(AppendedFile, ContainsOnlyWholePiecesAfterWriteError) {
  const TempFolder dir;
  AppendedFile file(dir / "a.txt");
  {
    const LargestFile limit(10);
    file.Append("first\n");
    ExpectInputError([&] { file.Append("second\n"); },
                     AllOf(Names("a.txt"), HasSubstr(std::strerror(EFBIG))));
    EXPECT_EQ(ReadBytes(dir / "a.txt"), "first\n");
  }
  file.Append("third\n");
  EXPECT_EQ(ReadBytes(dir / "a.txt"), "first\nthird\n");
}

TEST(AppendedFile, ReplacesSymbolicLink) {
  const TempFolder dir;
  const std::string target = dir.Write("target.txt", "old");
  fs::create_symlink(target, dir / "a.txt");
  AppendedFile(dir / "a.txt").Append("new");
  EXPECT_EQ(ReadBytes(target), "old");
  EXPECT_FALSE(fs::is_symlink(dir / "a.txt"));
}

TEST(AppendedFile, RejectsMissingFolder) {
  ExpectInputError([] { AppendedFile("/no/such/folder/a.txt"); }, Names("/no/such/folder/a.txt"));
}

}  // namespace
}  // namespace surfit::testing
