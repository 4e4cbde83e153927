#include "run/output_folder.h"

#include <filesystem>

#include "surfit/core/error.h"

namespace surfit {

void PrepareOutputFolder(const std::string& folder, const std::vector<std::string>& former_files) {
  namespace fs = std::filesystem;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder)) {
    throw InputError(Concat(folder, ": cannot make the output folder: ", error.message()));
  }
  for (const std::string& name : former_files) {
    fs::remove(fs::path(folder) / name, error);
    if (error) {
      throw InputError(Concat(folder, "/", name, ": cannot be replaced: ", error.message()));
    }
  }
}

}  // namespace surfit
