#include "io/image_files.h"
#include "testing/expect_input_error.h"
#include "testing/temp_folder.h"
#include "testing/write_images.h"

namespace surfit {
namespace {

using testing::ExpectInputError;
using ::testing::HasSubstr;

std::string SomePng() {
  testing::TempFolder folder;
  testing::WriteDepth(folder / "depth.png", Image<std::uint16_t>(20, 10, 1234));
  return testing::ReadBytes(folder / "depth.png");
}

TEST(RequireWholePng, AcceptsAWholeFileWhateverFollows) {
  EXPECT_TRUE(IsPng(SomePng()));
  EXPECT_NO_THROW(RequireWholePng(SomePng(), "a.png"));
  EXPECT_NO_THROW(RequireWholePng(SomePng() + "padding", "a.png"));
}

TEST(RequireWholePng, RefusesEveryTruncation) {
  const std::string bytes = SomePng();
  for (std::size_t size = 8; size < bytes.size(); ++size) {
    ExpectInputError([&] { RequireWholePng(bytes.substr(0, size), "a.png"); },
                     ::testing::StrEq("a.png is truncated"));
  }
}

TEST(RequireWholePng, RefusesEveryFlippedByte) {
  const std::string bytes = SomePng();
  for (std::size_t i = 8; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] ^= 0x10;
    ExpectInputError([&] { RequireWholePng(damaged, "a.png"); }, HasSubstr("a.png is "));
  }
}

TEST(IsPng, LooksAtTheSignature) {
  EXPECT_FALSE(IsPng(""));
  EXPECT_FALSE(IsPng("\x89PNG"));
  EXPECT_FALSE(IsPng("P5 20 10 65535 and so on"));
}

}  // namespace
}  // namespace surfit
