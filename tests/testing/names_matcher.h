#pragma once

#include <gmock/gmock.h>

#include <cctype>
#include <ostream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace surfit::testing {

// Matches a text that contains every name as a whole token, in any order. A name is a file, flag,
// field or value. Create it with Names().
class NamesMatcher {
 public:
  using is_gtest_matcher = void;

  explicit NamesMatcher(std::vector<std::string> names) : names_(std::move(names)) {}

  bool MatchAndExplain(const std::string& text, ::testing::MatchResultListener* listener) const {
    bool matches = true;
    for (const std::string& name : names_) {
      if (name.empty() || IsProse(name)) {
        *listener << "'" << name << "' is not the name of a file, flag, field or value; ";
        matches = false;
      } else if (!HasToken(text, name)) {
        *listener << "'" << name << "' is missing; ";
        matches = false;
      }
    }
    return matches;
  }
  void DescribeTo(std::ostream* out) const { Describe("names", out); }
  void DescribeNegationTo(std::ostream* out) const { Describe("does not name all of", out); }

 private:
  static bool IsAlpha(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }
  static bool IsWord(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
  }

  // True if a blank separates two words.
  static bool IsProse(const std::string& name) {
    for (std::size_t i = 1; i + 1 < name.size(); ++i) {
      if (name[i] == ' ' && IsAlpha(name[i - 1]) && IsAlpha(name[i + 1])) return true;
    }
    return false;
  }

  // True if the name does not begin inside a longer word, number, flag or file name.
  static bool BeginsToken(const std::string& text, std::size_t begin) {
    const auto before = [&](std::size_t n) { return begin < n ? ' ' : text[begin - n]; };
    if (text[begin] == '-') return before(1) != '-' && !IsWord(before(1));
    if (!IsWord(text[begin])) return true;
    if (IsWord(before(1)) || (before(1) == '.' && IsWord(before(2)))) return false;
    // A minus is a sign unless it follows a word (a range, for example 0-3).
    const bool is_number = !IsAlpha(text[begin]);
    return !is_number || before(1) != '-' || IsWord(before(2));
  }

  // True if the name does not end inside a longer word, number or file name.
  static bool EndsToken(const std::string& text, std::size_t end) {
    const auto after = [&](std::size_t n) { return end + n < text.size() ? text[end + n] : ' '; };
    if (!IsWord(text[end - 1])) return true;
    return !IsWord(after(0)) && (after(0) != '.' || !IsWord(after(1)));
  }

  static bool HasToken(const std::string& text, const std::string& name) {
    for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name, at + 1)) {
      if (BeginsToken(text, at) && EndsToken(text, at + name.size())) return true;
    }
    return false;
  }

  void Describe(const std::string& verb, std::ostream* out) const {
    *out << verb;
    for (const std::string& name : names_) *out << " '" << name << "'";
  }

  std::vector<std::string> names_;
};

// EXPECT_THAT(error.what(), Names("camera.yaml", "fx", -3)): the text contains each name as a whole
// token. Numbers are compared as operator<< prints them. A name of two words fails: messages may be
// rewritten, so tests do not compare sentences.
template <typename... Parts>
NamesMatcher Names(const Parts&... names) {
  const auto text = [](const auto& name) {
    std::ostringstream stream;
    stream << name;
    return stream.str();
  };
  return NamesMatcher({text(names)...});
}

// EXPECT_THAT([&] { ReadCamera(path); }, ThrowsNaming<InputError>("camera.yaml", "fx", -3))
template <typename Error, typename... Parts>
auto ThrowsNaming(const Parts&... names) {
  return ::testing::ThrowsMessage<Error>(Names(names...));
}

}  // namespace surfit::testing
