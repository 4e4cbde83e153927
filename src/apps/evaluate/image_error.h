#pragma once

#include <cstddef>
#include <cstdint>

#include "surfit/core/image.h"

namespace surfit {

// Pixels with a value other than 0 are compared.
using PixelMask = Image<std::uint8_t>;

// Upper limit of the PSNR, which is infinite for equal images.
inline constexpr double kMaxPsnr_db = 100;

// Peak signal-to-noise ratio in dB: 10 log10(255^2 / MSE). The MSE is the mean over all channels of
// the compared pixels. At most kMaxPsnr_db; 0 without compared pixels. Aborts if the sizes of the
// images and the mask differ.
double Psnr(const Image<Rgb8>& image, const Image<Rgb8>& reference, const PixelMask& compared);

// PSNR after multiplication of each image channel with its optimal gain
//   g = sum x y / sum x^2,   x: image, y: reference.
// The gain removes differences of exposure and white balance. Products are neither rounded nor
// clipped. Aborts if the sizes differ.
double PsnrByGain(const Image<Rgb8>& image, const Image<Rgb8>& reference,
                  const PixelMask& compared);

// Structural similarity (SSIM) per pixel, averaged over three channels (Wang, Bovik, Sheikh and
// Simoncelli, IEEE Transactions on Image Processing 2004):
//   (2 m_x m_y + C1) (2 s_xy + C2) / ((m_x^2 + m_y^2 + C1) (s_x^2 + s_y^2 + C2)).
// Means, variances and covariance are weighted by a Gaussian of 1.5 px over 11 x 11 pixels,
// mirrored at the border. C1 = (0.01 * 255)^2, C2 = (0.03 * 255)^2. The similarity is 1 for equal
// images. Aborts if the sizes differ.
Image<float> StructuralSimilarity(const Image<Rgb8>& image, const Image<Rgb8>& reference);

// Mean of the compared values; 0 without compared pixels.
double MeanOf(const Image<float>& values, const PixelMask& compared);

// Number of pixels other than 0.
std::size_t CountOf(const PixelMask& mask);

}  // namespace surfit
