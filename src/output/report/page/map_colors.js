'use strict';
// Colours of the surfels. Confidence is logarithmic.
surfit.scalarModes = {
  confidence: { legend: 'confidence (logarithmic)', of: (map, i) => Math.log10(map.confidence[i]),
    show: (value) => (10 ** value).toPrecision(3) },
  last_seen: { legend: 'last seen in frame', of: (map, i) => map.last_seen[i], show: String },
  first_seen: { legend: 'first seen in frame', of: (map, i) => map.first_seen[i], show: String },
  distance: { legend: 'distance to the other run (grey: more than 50 cm)',
    of: (map, i) => (!map.distance || map.distance[i] === surfit.farFromMap ? NaN : map.distance[i] / 10),
    show: (value) => `${value.toPrecision(3)} mm` },
};

// Range of a mode over all maps, so that colours are comparable. Confidence: at most four decades; distance: up to
// the 95 % quantile.
surfit.modeRange = (runs, mode) => {
  if (mode === 'distance') {
    const shares = runs.map(({ map }) => surfit.distanceQuantile(map, 0.95)).filter(Number.isFinite);
    return [0, Math.max(...shares, 1)];
  }
  const ranges = runs.filter(({ map }) => map.shown > 0).map(({ map }) => surfit.range(
    Float64Array.from(map.radius, (_, i) => surfit.scalarModes[mode].of(map, i))));
  const [low, high] = surfit.range(ranges.flat());
  return mode === 'confidence' ? [Math.max(low, high - 4), high] : [low, high];
};

surfit.colorDiscs = (discs, map, mode, range) => {
  const coloring = surfit.colorings[mode] || surfit.scaledColoring(surfit.scalarModes[mode].of, range);
  for (let i = 0; i < map.shown; ++i) surfit.shadeSurfel(map, i, coloring);
  discs.geometry.getAttribute('shade').needsUpdate = true;
};

surfit.showLegend = (mode, range) => {
  const legend = surfit.byId('map-legend');
  legend.textContent = '';
  const say = (textContent) => surfit.element('span', legend, { textContent });
  if (mode === 'color') return say('surfel colours');
  if (mode === 'normal') return say('(1 + n) / 2 with the normal n in the world frame: x red, y green, z blue');
  const { legend: name, show } = surfit.scalarModes[mode];
  say(name);
  say(show(range[0]));
  surfit.element('div', legend, { className: 'bar' }).style.background = surfit.scaleGradient();
  return say(show(range[1]));
};

// Surfels below this confidence are noise. Same as NoiseConfidence() of output/pictures/pictures.h.
surfit.dustConfidence = (map) => {
  const sorted = map.confidence.slice().sort();
  return sorted.length === 0 ? 0 : Math.min(3, 0.1 * sorted[Math.round(0.9 * (sorted.length - 1))]);
};

surfit.positionOfSurfel = (map, i) => new THREE.Vector3(...[0, 1, 2].map(
  (k) => map.origin[k] + map.extent[k] * map.position[4 * i + k] / 65535));
