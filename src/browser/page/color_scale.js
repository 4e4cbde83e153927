'use strict';
// Viridis (S. van der Walt and N. Smith, CC0): a perceptually uniform colour scale, linear between nine colours.
// 256 colours as bytes r g b.
surfit.viridis = (() => {
  const stops = [[68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141],
    [39, 173, 129], [92, 200, 99], [170, 220, 50], [253, 231, 37]];
  return Uint8Array.from({ length: 3 * 256 }, (_, byte) => {
    const at = Math.floor(byte / 3) / 255 * (stops.length - 1), c = byte % 3;
    const k = Math.min(Math.floor(at), stops.length - 2);
    return Math.round(stops[k][c] + (at - k) * (stops[k + 1][c] - stops[k][c]));
  });
})();

// Index of the colour of a value in surfit.viridis.
surfit.scaleIndex = (value, low, high) => {
  const share = high > low ? (value - low) / (high - low) : 0;
  return 3 * Math.round(255 * Math.min(Math.max(share, 0), 1));
};

surfit.scaleColor = (value, low, high) => {
  const i = surfit.scaleIndex(value, low, high);
  return [...surfit.viridis.slice(i, i + 3)];
};

surfit.cssColor = (rgb) => `rgb(${rgb.join(',')})`;

surfit.scaleGradient = () => `linear-gradient(to right, ${
  Array.from({ length: 9 }, (_, k) => surfit.cssColor(surfit.scaleColor(k, 0, 8))).join(',')})`;
