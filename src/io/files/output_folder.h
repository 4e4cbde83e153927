#pragma once

#include <string>
#include <vector>

namespace surfit {

// Makes a folder, with those that it is in, unless it is there. Throws InputError naming it.
void MakeFolder(const std::string& folder);

// A folder that results are written into, owned by one process while it does so: a lock file in it
// holds that process's number, and goes with the object. Of a process that has ended without that,
// a killed one, the lock does not hold, and is taken over with a word in the log.
class OutputFolder {
 public:
  // Makes the folder if it is missing, and removes a former run's files from it, and what a killed
  // one has left half written. Throws InputError naming the folder if it cannot be made or somebody
  // else owns it, a folder in it that is a link (what that leads to is not touched), or a file to
  // be removed that is one of the inputs.
  OutputFolder(const std::string& folder, const std::vector<std::string>& former_files,
               const std::vector<std::string>& inputs = {});
  ~OutputFolder();
  OutputFolder& operator=(OutputFolder&&) = delete;

 private:
  std::string lock_path_;
  int lock_ = -1;
};

}  // namespace surfit
