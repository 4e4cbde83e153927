#pragma once

#include <cstddef>
#include <cstdint>

#include "surfit/core/image.h"

namespace surfit {

// Which pixels are compared: those that are not 0.
using PixelMask = Image<std::uint8_t>;

// Of equal images the ratio is infinite; what is more than this is told as this.
inline constexpr double kMostPsnr_db = 100;

// The peak signal-to-noise ratio of an image in dB, 10 log10(255^2 / MSE), with the mean of squared
// differences over all channels of the pixels that are compared. At most kMostPsnr_db; 0 where no
// pixel is. The images and the mask have one size.
double Psnr(const Image<Rgb8>& image, const Image<Rgb8>& reference, const PixelMask& compared);

// The same with each channel of the image multiplied by the gain that makes it greatest,
//   g = sum x y / sum x^2,   x of the image, y of the reference,
// so that exposure and white balance count for nothing. Products are neither rounded nor cut off.
double PsnrByGain(const Image<Rgb8>& image, const Image<Rgb8>& reference,
                  const PixelMask& compared);

// The structural similarity of an image at each pixel (Wang, Bovik, Sheikh and Simoncelli, IEEE
// Transactions on Image Processing 2004), the mean of the three channels':
//   (2 m_x m_y + C1) (2 s_xy + C2) / ((m_x^2 + m_y^2 + C1) (s_x^2 + s_y^2 + C2)),
// means, variances and covariance weighted by a Gaussian of 1.5 px over 11 x 11 pixels, which are
// mirrored at the border; C1 = (0.01 * 255)^2, C2 = (0.03 * 255)^2. 1 where the images are equal.
Image<float> StructuralSimilarity(const Image<Rgb8>& image, const Image<Rgb8>& reference);

// The mean of those values that are compared; 0 where none is.
double MeanOf(const Image<float>& values, const PixelMask& compared);

// How many pixels the mask has.
std::size_t CountOf(const PixelMask& mask);

}  // namespace surfit
