#pragma once

#include <string>
#include <vector>

namespace surfit::tools {

// What help says of one flag.
struct FlagHelp {
  std::string name, default_value, help, group;
  bool everyday = false;
};

// Everyday flags and how to see the others, or all flags where these are few.
std::string EverydayHelp(const std::vector<FlagHelp>& flags);
// All flags, group by group.
std::string FullHelp(const std::vector<FlagHelp>& flags);
// Throws InputError that lists the groups if there is no such one.
std::string GroupHelp(const std::vector<FlagHelp>& flags, const std::string& group);

}  // namespace surfit::tools
