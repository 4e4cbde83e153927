#pragma once

#include <string>
#include <vector>

#include "testing/temp_folder.h"

namespace surfit::testing {

// A reader of files, which may be given any bytes.
struct FuzzTarget {
  std::string name;                           // and that of its folder in tests/fuzz/corpus
  std::string file;                           // the bytes' name in the folder that is read
  void (*prepare)(const TempFolder& folder);  // writes what else stands there
  void (*read)(const std::string& folder);    // throws InputError for what it refuses
};

const std::vector<FuzzTarget>& FuzzTargets();

// Reads bytes as one of the targets, in a folder of its own.
class FuzzedReader {
 public:
  explicit FuzzedReader(const FuzzTarget& target);

  // Whether they were taken, or else refused. Throws what no reader should.
  bool Takes(const std::string& bytes) const;

 private:
  const FuzzTarget& target_;
  TempFolder folder_;
};

}  // namespace surfit::testing
