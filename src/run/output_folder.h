#pragma once

#include <string>
#include <vector>

namespace surfit {

// Makes the output folder if it is missing, and removes a former run's files from it.
// Throws InputError naming the folder or file if that fails.
void PrepareOutputFolder(const std::string& folder, const std::vector<std::string>& former_files);

}  // namespace surfit
