#include "report/base64.h"

#include <gtest/gtest.h>

namespace surfit {
namespace {

// RFC 4648, section 10.
TEST(EncodeBase64, EncodesTheVectorsOfTheStandard) {
  EXPECT_EQ(EncodeBase64(std::string()), "");
  EXPECT_EQ(EncodeBase64(std::string("f")), "Zg==");
  EXPECT_EQ(EncodeBase64(std::string("fo")), "Zm8=");
  EXPECT_EQ(EncodeBase64(std::string("foo")), "Zm9v");
  EXPECT_EQ(EncodeBase64(std::string("foobar")), "Zm9vYmFy");
}

TEST(EncodeBase64, EncodesAllDigits) {
  // 111110 111111 111110 111111 in bits.
  EXPECT_EQ(EncodeBase64(std::string("\xfb\xff\xbf")), "+/+/");
}

TEST(EncodeBase64, WritesNumbersLittleEndian) {
  EXPECT_EQ(EncodeBase64(std::vector<std::uint16_t>{0x6f66, 0x666f}),
            EncodeBase64(std::string("foof")));
}

}  // namespace
}  // namespace surfit
