#pragma once

#include <string>
#include <vector>

namespace surfit {

// Value of a YAML file. Supports a subset of YAML 1.2: maps, lists and scalars, in block style or
// in brackets. Tags, anchors, escape sequences and texts of several lines are not supported.
// kNothing: a key or list item without a value, or an empty document.
struct YamlNode {
  enum class Kind { kNothing, kScalar, kList, kMap };

  Kind kind = Kind::kNothing;
  std::string scalar;             // text without quotation marks
  std::vector<std::string> keys;  // keys of a map, in the order of `values`
  std::vector<YamlNode> values;   // values of a list or map

  // Value of a key of a map; null if the key does not exist. Valid as long as this node is
  // unchanged. Null also if this node is no map.
  const YamlNode* Find(const std::string& key) const;
};

// Parses a text with a single document. Recursion is as deep as the nesting of the text, so the
// caller must limit the length of the text. Throws InputError with `path`, line and reason. Also
// throws for a key that occurs twice, and for more than 100 keys of a map.
YamlNode ParseYaml(const std::string& text, const std::string& path);

}  // namespace surfit
