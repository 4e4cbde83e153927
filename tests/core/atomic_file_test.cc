#include "surfit/core/atomic_file.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "surfit/core/error.h"
#include "testing/matchers.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

namespace fs = std::filesystem;

std::size_t FileCount(const std::string& folder) {
  return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
}

TEST(WriteFileAtomically, ReplacesFileAndLeavesNoOtherFile) {
  const TempFolder dir;
  const std::string path = dir.Write("a.txt", "an older and longer file");
  WriteFileAtomically(path, [](std::ostream& out) { out << "new\n"; });
  EXPECT_EQ(ReadBytes(path), "new\n");
  EXPECT_EQ(FileCount(dir.path()), 1u);
}

TEST(WriteFileAtomically, KeepsOldFileUntilNewFileIsComplete) {
  const TempFolder dir;
  const std::string path = dir.Write("a.txt", "old");
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << "new" << std::flush;
    EXPECT_EQ(ReadBytes(path), "old");
  });
}

TEST(WriteFileAtomically, KeepsOldFileIfWriterThrows) {
  const TempFolder dir;
  const std::string path = dir.Write("a.txt", "old");
  const auto write = [&] {
    WriteFileAtomically(path, [](std::ostream& out) {
      out << "half";
      throw std::out_of_range("the writer's own");
    });
  };
  EXPECT_THROW(write(), std::out_of_range);
  EXPECT_EQ(ReadBytes(path), "old");
  EXPECT_EQ(FileCount(dir.path()), 1u);
}

TEST(WriteFileAtomically, NamesFileAndSystemError) {
  const TempFolder dir;
  EXPECT_THAT(
      [&] { WriteFileAtomically(dir.path() + "/no/such/folder/a.txt", [](std::ostream&) {}); },
      ThrowsMessage<InputError>(
          AllOf(Names("no/such/folder/a.txt"), HasSubstr(std::strerror(ENOENT)))));
  EXPECT_THAT(
      [&] { WriteFileAtomically(dir.path(), [](std::ostream&) {}); },
      ThrowsMessage<InputError>(AllOf(Names(dir.path()), HasSubstr(std::strerror(EISDIR)))));
}

TEST(WriteFileAtomically, RejectsFullDisk) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  EXPECT_THAT(
      [] { WriteFileAtomically("/dev/full", [](std::ostream& out) { out << "x"; }); },
      ThrowsMessage<InputError>(AllOf(Names("/dev/full"), HasSubstr(std::strerror(ENOSPC)))));
  EXPECT_TRUE(fs::is_character_file("/dev/full"));  // written to, not replaced
}

TEST(WriteFileAtomically, RejectsSymbolicLink) {
  const TempFolder dir;
  const std::string target = dir.Write("target.txt", "old");
  fs::create_symlink(target, dir / "link.txt");
  ExpectInputError(
      [&] { WriteFileAtomically(dir / "link.txt", [](std::ostream& out) { out << "new"; }); },
      Names("link.txt"));
  EXPECT_EQ(ReadBytes(target), "old");
  EXPECT_TRUE(fs::is_symlink(dir / "link.txt"));
}

TEST(WriteFileAtomically, IgnoresLinksWithNamesOfPartialFiles) {
  const TempFolder dir;
  const std::string target = dir.Write("target.txt", "old");
  for (int i = 0; i < 1000; ++i) {
    fs::create_symlink(target, dir / Concat("a.txt.partial-", getpid(), "-", i));
  }
  fs::create_symlink(target, dir / "a.txt.partial");
  WriteFileAtomically(dir / "a.txt", [](std::ostream& out) { out << "new"; });
  EXPECT_EQ(ReadBytes(target), "old");
  EXPECT_EQ(ReadBytes(dir / "a.txt"), "new");
}

TEST(WriteFileAtomically, SupportsSeekInStream) {
  const TempFolder dir;
  WriteFileAtomically(dir / "a.txt", [](std::ostream& out) {
    out << "0 of " << std::string(100000, 'x');
    out.seekp(0);
    out << '7';
  });
  EXPECT_EQ(ReadBytes(dir / "a.txt"), "7 of " + std::string(100000, 'x'));
}

}  // namespace
}  // namespace surfit::testing
