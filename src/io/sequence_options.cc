#include <algorithm>

#include "io/folder.h"
#include "surfit/core/error.h"
#include "surfit/io/sequence.h"

namespace surfit {
namespace {

void RequireKnownFormat(const std::string& format) {
  if (format == "auto") return;
  std::string known = "auto";
  for (const std::string& name : SequenceFormats()) {
    if (format == name) return;
    known += ", " + name;
  }
  throw InputError(Concat("format is '", format, "', must be one of ", known));
}

}  // namespace

void SequenceOptions::Validate() const {
  if (path.empty()) throw InputError("sequence is empty, must name a folder or file");
  RequireKnownFormat(format);
  if (first < 0) throw InputError(Concat("first is ", first, ", must be at least 0"));
  if (last < -1) throw InputError(Concat("last is ", last, ", must be at least -1"));
  if (last != -1 && last < first)
    throw InputError(Concat("last is ", last, ", must be at least first, ", first, ", or -1"));
  if (stride < 1) throw InputError(Concat("stride is ", stride, ", must be at least 1"));
  prepare.Validate();
}

}  // namespace surfit
