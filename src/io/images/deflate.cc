#include "io/images/deflate.h"

#include <glog/logging.h>
#include <libdeflate.h>

#include <memory>
#include <new>

namespace surfit {
namespace {

struct DeflateCloser {
  void operator()(libdeflate_decompressor* inflater) const {
    libdeflate_free_decompressor(inflater);
  }
  void operator()(libdeflate_compressor* deflater) const { libdeflate_free_compressor(deflater); }
};

}  // namespace

bool Inflate(const void* data, std::size_t size, void* bytes, std::size_t count) {
  const std::unique_ptr<libdeflate_decompressor, DeflateCloser> inflater(
      libdeflate_alloc_decompressor());
  if (!inflater) throw std::bad_alloc();
  return libdeflate_zlib_decompress(inflater.get(), data, size, bytes, count, nullptr) ==
         LIBDEFLATE_SUCCESS;
}

std::string Deflate(const void* bytes, std::size_t count, int level) {
  const std::unique_ptr<libdeflate_compressor, DeflateCloser> deflater(
      libdeflate_alloc_compressor(level));
  if (!deflater) throw std::bad_alloc();
  std::string data(libdeflate_zlib_compress_bound(deflater.get(), count), '\0');
  const std::size_t size =
      libdeflate_zlib_compress(deflater.get(), bytes, count, data.data(), data.size());
  CHECK_GT(size, 0u);
  data.resize(size);
  return data;
}

}  // namespace surfit
