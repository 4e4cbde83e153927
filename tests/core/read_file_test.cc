#include <gmock/gmock.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <thread>

#include "core/files.h"
#include "surfit/core/error.h"
#include "testing/matchers.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

std::string MakePipe(const TempFolder& dir) {
  const std::string path = dir / "pipe";
  EXPECT_EQ(mkfifo(path.c_str(), 0600), 0);
  return path;
}

std::string Brackets(int depth) { return std::string(depth, '[') + std::string(depth, ']'); }

TEST(ReadFile, ReadsAllBytes) {
  const TempFolder dir;
  for (const std::size_t size : {0, 1, 65536, 200000}) {
    const std::string bytes(size, 'x');
    EXPECT_EQ(ReadFile(dir.Write("a", bytes)), bytes);
    EXPECT_EQ(ReadFileOrPipe(dir / "a"), bytes);
  }
}

TEST(ReadFile, RejectsPipeDeviceAndFolder) {
  const TempFolder dir;
  const std::string pipe = MakePipe(dir);  // without a writer
  for (const std::string& path : {pipe, std::string("/dev/zero"), dir.path()}) {
    ExpectInputError([&] { ReadFile(path); }, Names(path));
  }
}

TEST(ReadFile, RejectsFileAboveSizeLimit) {
  const TempFolder dir;
  EXPECT_EQ(ReadFile(dir.Write("a", "12345"), 5), "12345");
  ExpectInputError([&] { ReadFile(dir / "a", 4); }, Names(dir / "a", 4));
}

TEST(ReadFile, NamesFileAndSystemError) {
  ExpectInputError([] { ReadFile("/nowhere/a"); },
                   AllOf(Names("/nowhere/a"), HasSubstr(std::strerror(ENOENT))));
}

TEST(ReadFileOrPipe, ReadsPipeToEnd) {
  const TempFolder dir;
  const std::string pipe = MakePipe(dir), bytes(300000, 'x');
  std::thread writer([&] { std::ofstream(pipe) << bytes; });
  EXPECT_EQ(ReadFileOrPipe(pipe), bytes);
  writer.join();
}

TEST(ReadJsonText, RejectsDeepNesting) {
  const TempFolder dir;
  EXPECT_EQ(ReadJsonText(dir.Write("a.json", Brackets(100))), Brackets(100));
  const std::string in_string = "[\"" + std::string(1000, '[') + "\\\"" + "[\"]";
  EXPECT_EQ(ReadJsonText(dir.Write("a.json", in_string)), in_string);
  for (const std::string& text : {Brackets(101), Brackets(100000), "{\"]]\":" + Brackets(100)}) {
    ExpectInputError([&] { ReadJsonText(dir.Write("a.json", text)); }, Names("a.json"));
  }
}

}  // namespace
}  // namespace surfit::testing
