#include "apps/live/http_rules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace surfit {
namespace {

TEST(HttpRules, TokensHave128BitsAndDiffer) {
  std::set<std::string> tokens;
  for (int i = 0; i < 100; ++i) {
    const std::string token = RandomToken();
    EXPECT_THAT(token, testing::MatchesRegex("[0-9a-f]+"));
    EXPECT_EQ(token.size(), 32u);
    tokens.insert(token);
  }
  EXPECT_EQ(tokens.size(), 100u);
}

TEST(HttpRules, SecretsAreComparedCompletely) {
  EXPECT_TRUE(IsSameSecret("abc", "abc"));
  for (const char* other : {"", "a", "ab", "abcd", "abcabc", "ABC", "abd"}) {
    EXPECT_FALSE(IsSameSecret(other, "abc")) << other;
  }
}

TEST(HttpRules, ReadsTargets) {
  const auto target = ParseTarget("/f00/map?epoch=1&since=4294967295");
  ASSERT_TRUE(target);
  EXPECT_EQ(target->token, "f00");
  EXPECT_EQ(target->page, "map");
  EXPECT_EQ(target->Number("epoch"), 1u);
  EXPECT_EQ(target->Number("since"), 4294967295u);
  EXPECT_EQ(target->Number("slot"), 0u);
  EXPECT_EQ(ParseTarget("/f00/")->page, "");
}

TEST(HttpRules, RejectsOtherTargets) {
  for (const char* other : {"", "/", "f00/", "/f00", "http://host/f00/", "*", "/f00?a=1/",
                            "/f00/map?epoch", "/f00/map?epoch=", "/f00/map?epoch=-1",
                            "/f00/map?epoch=1e3", "/f00/map?epoch=4294967296"}) {
    const auto target = ParseTarget(other);
    EXPECT_TRUE(!target || target->token != "f00") << other;
  }
}

TEST(HttpRules, AcceptsOnlyItsOwnHosts) {
  for (const char* host : {"127.0.0.1:8080", "127.0.0.1", "localhost:1", "LOCALHOST", "[::1]:8080",
                           "[fe80::1]", "192.168.1.7:80"}) {
    EXPECT_TRUE(IsOwnHost(host)) << host;
  }
  for (const char* host : {"", "evil.example", "evil.example:8080", "127.0.0.1.evil.example",
                           "localhost.evil.example", "evil.example:127.0.0.1", "[evil]", "[]",
                           ":80", "127.0.0.1@evil.example", "2130706433", "127.1"}) {
    EXPECT_FALSE(IsOwnHost(host)) << host;
  }
}

TEST(HttpRules, AcceptsOnlyItsOwnOrigin) {
  EXPECT_TRUE(IsOwnOrigin("http://127.0.0.1:8080", "127.0.0.1:8080"));
  for (const char* origin : {"null", "", "https://127.0.0.1:8080", "http://127.0.0.1:8081",
                             "http://127.0.0.1", "http://evil.example:8080"}) {
    EXPECT_FALSE(IsOwnOrigin(origin, "127.0.0.1:8080")) << origin;
  }
}

}  // namespace
}  // namespace surfit
