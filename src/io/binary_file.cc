#include "io/binary_file.h"

#include <cerrno>
#include <system_error>

#include "surfit/core/error.h"

namespace surfit {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "values are copied from memory");

BinaryFile::BinaryFile(const std::string& path) : path_(path), file_(path, std::ios::binary) {
  if (file_.seekg(0, std::ios::end)) size_ = file_.tellg();
  if (!file_) {
    const std::error_code reason(errno, std::generic_category());
    throw InputError(Concat("cannot read '", path, "': ", reason.message()));
  }
}

std::string BinaryFile::Read(std::uint64_t at, std::uint64_t count) const {
  if (!Has(at, count)) {
    throw InputError(Concat(path_, " is ", size_, " bytes long and ends before ", count,
                            " bytes from byte ", at));
  }
  std::string bytes(count, '\0');
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(at));
  if (!file_.read(bytes.data(), static_cast<std::streamsize>(count)))
    throw InputError(Concat("cannot read '", path_, "' at byte ", at));
  return bytes;
}

}  // namespace surfit
