#pragma once

#include <string>
#include <vector>

namespace surfit {

// A value of a YAML file (YAML 1.2, of which this is a part): maps and lists, line by line or in
// brackets, of numbers and words. No tags, anchors, or texts of several lines.
struct YamlNode {
  enum class Kind { kNothing, kScalar, kList, kMap };

  Kind kind = Kind::kNothing;
  std::string scalar;             // as it stands there, without quotation marks
  std::vector<std::string> keys;  // of a map: one of each of the values
  std::vector<YamlNode> values;   // of a list or map

  // Of a map; null without such a key.
  const YamlNode* Find(const std::string& key) const;
};

// The only document of a text. The depth of recursion is that of the text's nesting, which is for
// the caller to bound. Throws InputError naming `path`, the line, and what is wrong with it.
YamlNode ParseYaml(const std::string& text, const std::string& path);

}  // namespace surfit
