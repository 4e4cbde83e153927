#include "io/files/yaml.h"

#include <algorithm>

#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr std::size_t kMaxKeys = 100;  // maximum per map

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

class YamlParser {
 public:
  YamlParser(const std::string& text, const std::string& path) : text_(text), path_(path) {}

  YamlNode Parse() {
    SkipHeader();
    YamlNode root;
    if (NextLine()) root = ParseBlock(Column());
    if (NextLine()) Fail("has a different indentation than the lines above");
    return root;
  }

 private:
  [[noreturn]] void Fail(const std::string& what) const {
    const auto line = 1 + std::count(text_.begin(), text_.begin() + std::ptrdiff_t(at_), '\n');
    throw InputError(path_, ":", line, " is invalid or unsupported YAML: the text ", what);
  }

  bool AtEnd() const { return at_ >= text_.size(); }
  char Now() const { return AtEnd() ? '\n' : text_[at_]; }
  bool StartsWith(const char* word) const { return text_.compare(at_, 3, word) == 0; }
  int Column() const {
    const std::size_t end = at_ == 0 ? std::string::npos : text_.rfind('\n', at_ - 1);
    return static_cast<int>(end == std::string::npos ? at_ : at_ - end - 1);
  }
  void SkipLine() { at_ = std::min(text_.find('\n', at_), text_.size() - 1) + 1; }
  void SkipBlanks() {
    while (!AtEnd() && IsBlank(Now())) ++at_;
  }

  // Skips the lines "%YAML:1.0" and "---".
  void SkipHeader() {
    while (Now() == '%') SkipLine();
    if (StartsWith("---")) at_ += 3;
  }

  // Skips blanks, line ends and comments. Returns false at the end of the document.
  bool NextLine() {
    for (;;) {
      SkipBlanks();
      if (AtEnd() || (StartsWith("...") && Column() == 0)) return false;
      if (Now() == '#') {
        SkipLine();
      } else if (Now() == '\n') {
        ++at_;
      } else {
        return true;
      }
    }
  }

  // Parses the items of a list or map, which begin at `column`.
  YamlNode ParseBlock(int column) {
    YamlNode node;
    node.kind = IsItem() ? YamlNode::Kind::kList : YamlNode::Kind::kMap;
    while (NextLine() && Column() == column && IsItem() == (node.kind == YamlNode::Kind::kList)) {
      if (node.kind == YamlNode::Kind::kMap) {
        AddKey(&node);
      } else {
        ++at_;
      }
      node.values.push_back(ParseBlockValue(column, node.kind == YamlNode::Kind::kMap));
    }
    if (!AtEnd() && Column() > column) Fail("has a different indentation than the lines above");
    return node;
  }

  bool IsItem() const {
    return Now() == '-' &&
           (at_ + 1 >= text_.size() || IsBlank(text_[at_ + 1]) || text_[at_ + 1] == '\n');
  }

  // Parses a value on the same line, or an indented block below. A list in a map may have the
  // indentation of its key.
  YamlNode ParseBlockValue(int column, bool is_in_map) {
    SkipBlanks();
    if (Now() != '\n' && Now() != '#') {
      YamlNode node = ParseFlow();
      SkipBlanks();
      if (Now() != '\n' && Now() != '#') Fail("has more than one value");
      if (Now() == '#') SkipLine();
      return node;
    }
    const bool has_more = NextLine();
    if (has_more && (Column() > column || (is_in_map && Column() == column && IsItem())))
      return ParseBlock(Column());
    return {};
  }

  void AddKey(YamlNode* map) {
    const std::string key = ParseScalar(":,{}[]\n");
    if (key.empty() || Now() != ':') Fail("has no key with a colon");
    if (map->keys.size() == kMaxKeys) Fail("has too many keys");
    if (map->Find(key) != nullptr) Fail(Concat("has the key '", key, "' twice"));
    ++at_;
    map->keys.push_back(key);
  }

  // Parses a list or map in brackets, also across lines, or a scalar.
  YamlNode ParseFlow() {
    YamlNode node;
    if (Now() == '{' || Now() == '[') {
      node.kind = Now() == '{' ? YamlNode::Kind::kMap : YamlNode::Kind::kList;
      ParseItems(&node, Now() == '{' ? '}' : ']');
    } else {
      node.kind = YamlNode::Kind::kScalar;
      node.scalar = ParseScalar(",{}[]#\n");
    }
    return node;
  }

  void ParseItems(YamlNode* node, char closing) {
    ++at_;
    for (;;) {
      if (!NextLine()) Fail("ends within brackets");
      if (Now() == closing) break;
      if (node->kind == YamlNode::Kind::kMap) AddKey(node);
      if (!NextLine()) Fail("ends within brackets");
      node->values.push_back(ParseFlow());
      if (!NextLine() || (Now() != ',' && Now() != closing)) Fail("has no comma between values");
      if (Now() == ',') ++at_;
    }
    ++at_;
  }

  // Parses a scalar in quotation marks, or a scalar that ends before any character of `ends`.
  std::string ParseScalar(const char* ends) {
    const char quote = Now();
    const bool is_quoted = quote == '"' || quote == '\'';
    const std::size_t begin = is_quoted ? at_ + 1 : at_;
    const std::size_t end = is_quoted ? text_.find(quote, begin) : text_.find_first_of(ends, begin);
    if (is_quoted && end == std::string::npos) Fail("ends within quotation marks");
    std::string scalar = text_.substr(begin, end - begin);
    at_ = std::min(end, text_.size());
    if (is_quoted) {
      ++at_;
      SkipBlanks();
      return scalar;
    }
    while (!scalar.empty() && IsBlank(scalar.back())) scalar.pop_back();
    return scalar;
  }

  const std::string& text_;
  const std::string& path_;
  std::size_t at_ = 0;
};

}  // namespace

const YamlNode* YamlNode::Find(const std::string& key) const {
  const auto at = std::find(keys.begin(), keys.end(), key);
  const auto i = static_cast<std::size_t>(at - keys.begin());
  return at == keys.end() || i >= values.size() ? nullptr : &values[i];
}

YamlNode ParseYaml(const std::string& text, const std::string& path) {
  return YamlParser(text, path).Parse();
}

}  // namespace surfit
