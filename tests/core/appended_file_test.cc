#include <gmock/gmock.h>
#include <sys/resource.h>

#include <csignal>

#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "testing/matchers.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

namespace fs = std::filesystem;

// While it lives, files have no place for more bytes.
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

TEST(AppendedFile, HasEachPieceAtOnce) {
  const TempFolder dir;
  AppendedFile file(dir.Write("a.txt", "an older file"));
  EXPECT_EQ(ReadBytes(dir / "a.txt"), "");
  file.Append("one\n");
  EXPECT_EQ(ReadBytes(dir / "a.txt"), "one\n");
  file.Append("two\n");
  EXPECT_EQ(ReadBytes(dir / "a.txt"), "one\ntwo\n");
}

TEST(AppendedFile, HoldsWholePiecesWhereThereIsNoPlaceForMore) {
  const TempFolder dir;
  AppendedFile file(dir / "a.txt");
  {
    const LargestFile limit(10);
    file.Append("first\n");
    ExpectInputError([&] { file.Append("second\n"); },
                     AllOf(HasSubstr("a.txt"), HasSubstr("File too large")));
    EXPECT_EQ(ReadBytes(dir / "a.txt"), "first\n");
  }
  file.Append("third\n");
  EXPECT_EQ(ReadBytes(dir / "a.txt"), "first\nthird\n");
}

TEST(AppendedFile, TakesThePlaceOfALink) {
  const TempFolder dir;
  const std::string target = dir.Write("target.txt", "old");
  fs::create_symlink(target, dir / "a.txt");
  AppendedFile(dir / "a.txt").Append("new");
  EXPECT_EQ(ReadBytes(target), "old");
  EXPECT_FALSE(fs::is_symlink(dir / "a.txt"));
}

TEST(AppendedFile, NamesAFileThatCannotBeWritten) {
  ExpectInputError([] { AppendedFile("/no/such/folder/a.txt"); },
                   HasSubstr("/no/such/folder/a.txt"));
}

}  // namespace
}  // namespace surfit::testing
