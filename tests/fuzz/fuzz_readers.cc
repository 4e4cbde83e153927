// Fuzzes a file reader with libFuzzer: fuzz_readers --target=NAME [libFuzzer flags] CORPUS...
#include <cstdint>
#include <iostream>
#include <memory>

#include "fuzz/targets.h"

namespace surfit::testing {
namespace {

std::unique_ptr<FuzzedReader> reader;  // NOLINT: libFuzzer passes no context

std::unique_ptr<FuzzedReader> MakeReader(const std::string& name) {
  for (const FuzzTarget& target : FuzzTargets()) {
    if (target.name == name) return std::make_unique<FuzzedReader>(target);
  }
  return nullptr;
}

}  // namespace
}  // namespace surfit::testing

// libFuzzer ignores flags that begin with two dashes.
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  using namespace surfit::testing;
  const std::string kFlag = "--target=";
  for (int i = 1; i < *argc; ++i) {
    const std::string argument = (*argv)[i];
    if (argument.rfind(kFlag, 0) == 0) reader = MakeReader(argument.substr(kFlag.size()));
  }
  if (reader) return 0;
  std::cerr << "error: --target= must be one of";
  for (const FuzzTarget& target : FuzzTargets()) std::cerr << " " << target.name;
  std::cerr << "\n";
  std::exit(1);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t count) {
  surfit::testing::reader->Takes({reinterpret_cast<const char*>(bytes), count});
  return 0;
}
