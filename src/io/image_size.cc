#include "io/image_size.h"

#include "surfit/core/error.h"

namespace surfit {

void RequireUsualSize(ImageSize size, const std::string& path) {
  constexpr int kMax = 16384;  // px
  if (size.width >= 1 && size.height >= 1 && size.width <= kMax && size.height <= kMax) return;
  throw InputError(Concat(path, " is ", size.width, " x ", size.height,
                          " pixels, must be from 1 x 1 to ", kMax, " x ", kMax));
}

}  // namespace surfit
