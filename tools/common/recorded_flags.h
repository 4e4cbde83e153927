#pragma once

#include <string>
#include <vector>

namespace surfit::tools {

// Gives each of these flags the value that a run's summary.json has recorded for it, unless the
// command line has set it. Throws InputError naming the file if it cannot be read or tells no such
// options, and the flag whose value does not fit.
void TakeRecordedFlags(const std::string& summary_json, const std::vector<std::string>& names);

}  // namespace surfit::tools
