#pragma once

#include <string>
#include <vector>

namespace surfit {

// Creates a folder and its parents if they do not exist. Throws InputError with the path if this
// fails. Does nothing for an existing folder.
void CreateFolder(const std::string& folder);

// Output folder, locked by one object at a time, also within a process. A lock file in the folder
// stores the process id and is removed by the destructor. The lock of a killed process is taken
// over with a warning.
class OutputFolder {
 public:
  // Creates the folder if it is missing. Removes `former_files` (paths relative to the folder) and
  // their partially written versions.
  //
  // Throws InputError in these cases:
  // - The folder or its lock file cannot be created, or the folder is locked.
  // - A subfolder of a former file is a symbolic link. Its target is not changed.
  // - A former file is one of `inputs` (paths), or cannot be removed.
  OutputFolder(const std::string& folder, const std::vector<std::string>& former_files,
               const std::vector<std::string>& inputs = {});
  ~OutputFolder();
  OutputFolder& operator=(OutputFolder&&) = delete;

 private:
  std::string lock_path_;
  int lock_ = -1;
};

}  // namespace surfit
