'use strict';
// Viridis (S. van der Walt and N. Smith, CC0) at nine places, straight between them: colours for
// numbers, even to the eye. 256 colours as bytes r g b.
surfit.viridis = (() => {
  const stops = [[68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141],
    [39, 173, 129], [92, 200, 99], [170, 220, 50], [253, 231, 37]];
  const colors = new Uint8Array(3 * 256);
  for (let i = 0; i < 256; ++i) {
    const at = i / 255 * (stops.length - 1);
    const k = Math.min(Math.floor(at), stops.length - 2);
    for (let c = 0; c < 3; ++c) {
      colors[3 * i + c] = Math.round(stops[k][c] + (at - k) * (stops[k + 1][c] - stops[k][c]));
    }
  }
  return colors;
})();

// The place of a value among the 256 colours.
surfit.scaleIndex = (value, low, high) => {
  const share = high > low ? (value - low) / (high - low) : 0;
  return Math.round(255 * Math.min(Math.max(share, 0), 1));
};

surfit.scaleColor = (value, low, high) => {
  const i = 3 * surfit.scaleIndex(value, low, high);
  return [...surfit.viridis.slice(i, i + 3)];
};

surfit.cssColor = (rgb) => `rgb(${rgb.join(',')})`;

surfit.scaleGradient = () => {
  const stops = [0, 32, 64, 96, 128, 160, 192, 224, 255].map(
    (i) => surfit.cssColor(surfit.viridis.slice(3 * i, 3 * i + 3)));
  return `linear-gradient(to right, ${stops.join(',')})`;
};

// The least and the greatest of many numbers.
surfit.range = (values) => {
  let low = Infinity, high = -Infinity;
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low <= high ? [low, high] : [0, 0];
};
