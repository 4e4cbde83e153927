#pragma once

#include <cstddef>
#include <cstdint>

#include "surfit/core/image.h"

namespace surfit {

// Nonzero: the pixel is compared.
using PixelMask = Image<std::uint8_t>;

// Upper limit of the PSNR, which is infinite for equal images.
inline constexpr double kMaxPsnr_db = 100;

// Peak signal-to-noise ratio in dB: 10 log10(255^2 / MSE), with the MSE over all channels of the
// compared pixels. At most kMaxPsnr_db; 0 without compared pixels. All images must have the same
// width and height. Aborts if the numbers of pixels differ.
double Psnr(const Image<Rgb8>& image, const Image<Rgb8>& reference, const PixelMask& compared);

// PSNR after multiplication of each image channel with its optimal gain
//   g = sum x y / sum x^2,   x: image, y: reference.
// The gain removes differences of exposure and white balance. Limits and aborts as Psnr().
double PsnrByGain(const Image<Rgb8>& image, const Image<Rgb8>& reference,
                  const PixelMask& compared);

// Structural similarity (SSIM) per pixel, mean of three channels (Wang, Bovik, Sheikh and
// Simoncelli, IEEE Transactions on Image Processing 2004):
//   (2 m_x m_y + C1) (2 s_xy + C2) / ((m_x^2 + m_y^2 + C1) (s_x^2 + s_y^2 + C2)).
// Moments have Gaussian weights (sigma 1.5 px, 11 x 11 pixels, mirrored at the border). C1 =
// (0.01 * 255)^2, C2 = (0.03 * 255)^2. 1 for equal images. Aborts if the sizes differ.
Image<float> StructuralSimilarity(const Image<Rgb8>& image, const Image<Rgb8>& reference);

// Mean over compared pixels; 0 if there are none. Aborts if the numbers of pixels differ.
double MeanOf(const Image<float>& values, const PixelMask& compared);

std::size_t CountOf(const PixelMask& mask);

}  // namespace surfit
