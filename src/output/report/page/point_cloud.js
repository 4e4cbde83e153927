'use strict';
// A run's surfels as discs: a point of three.js that holds the disc, of which pixels are left out whose
// rays miss it. Positions stay the 16-bit shares of the map's extent.
surfit.pointVertexShader = `
attribute vec3 shade;
attribute float confidence, radius;
uniform vec3 origin, extent, boxLow, boxHigh;
uniform mat3 boxFromWorld;
uniform float metresPerRadius, pixelsAtOneMetre, leastConfidence;
uniform bool cull;
varying vec3 color, centre, facing;
varying float metres, pixels;
void main() {
  vec4 inRun = vec4(origin + extent * position, 1.);
  centre = (modelViewMatrix * inRun).xyz;
  facing = normalize(mat3(modelViewMatrix) * normal);
  color = shade;
  metres = metresPerRadius * radius;
  float nearest = max(-centre.z - metres, 0.2 * -centre.z);
  pixels = max(2. * metres * pixelsAtOneMetre / nearest, 1.);
  gl_PointSize = pixels;
  gl_Position = projectionMatrix * vec4(centre, 1.);
  vec3 inBox = boxFromWorld * (modelMatrix * inRun).xyz;
  bool cropped = any(lessThan(inBox, boxLow)) || any(greaterThan(inBox, boxHigh));
  bool away = dot(facing, centre) > 0.;
  if (confidence < leastConfidence || cropped || (cull && away)) gl_Position = vec4(2., 2., 2., 1.);
}`;
// The ray r of the pixel meets the disc's plane at t r, t = n.c / n.r. Discs of no more than two pixels
// are drawn as they are, so that none is lost between pixels.
surfit.pointFragmentShader = `
uniform float pixelsAtOneMetre;
varying vec3 color, centre, facing;
varying float metres, pixels;
void main() {
  if (pixels > 2.) {
    vec2 aside = (gl_PointCoord - 0.5) * vec2(1., -1.) * pixels / pixelsAtOneMetre;
    vec3 ray = vec3(centre.xy / -centre.z + aside, -1.);
    vec3 offset = dot(facing, centre) / dot(facing, ray) * ray - centre;
    if (dot(offset, offset) > metres * metres) discard;
  }
  gl_FragColor = vec4(color, 1.);
}`;

surfit.makePointCloud = (map) => {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(surfit.padTriples(map.position), 4, true));
  geometry.setAttribute('normal', new THREE.BufferAttribute(surfit.padTriples(map.normal), 4, true));
  geometry.setAttribute('confidence', new THREE.BufferAttribute(map.confidence, 1));
  geometry.setAttribute('radius', new THREE.BufferAttribute(map.radius, 1, true));
  geometry.setAttribute('shade', new THREE.BufferAttribute(new Uint8Array(4 * map.shown), 4, true));
  return surfit.makePoints(geometry, map.origin, map.extent);
};

// Discs of a geometry that has all that the shader above takes.
surfit.makePoints = (geometry, origin, extent) => {
  const material = new THREE.ShaderMaterial({
    vertexShader: surfit.pointVertexShader,
    fragmentShader: surfit.pointFragmentShader,
    uniforms: {
      origin: { value: new THREE.Vector3(...origin) },
      extent: { value: new THREE.Vector3(...extent) },
      metresPerRadius: { value: 0 },  // as chooseFirst() has it
      pixelsAtOneMetre: { value: 1 }, leastConfidence: { value: 0 }, cull: { value: true },
      boxFromWorld: { value: new THREE.Matrix3() },
      boxLow: { value: new THREE.Vector3(-1e9, -1e9, -1e9) },
      boxHigh: { value: new THREE.Vector3(1e9, 1e9, 1e9) },
    },
  });
  const points = new THREE.Points(geometry, material);
  points.frustumCulled = false;  // the geometry's own bounds are those of shares
  return points;
};

// By how much discs grow to close the surface: where only `drawn` of the map's surfels are, and because
// they lie as chance has it.
surfit.growth = (map, drawn) => 1.4 * Math.sqrt(map.points / Math.max(drawn, 1));

// Less confident surfels are dust: DustConfidence() of surfit/pictures/pictures.h.
surfit.dustConfidence = (map) => {
  const sorted = map.confidence.slice().sort();
  return sorted.length === 0 ? 0 : Math.min(3, 0.1 * sorted[Math.round(0.9 * (sorted.length - 1))]);
};

// Draws the first `count` surfels, an even share of the map, or all that there are.
surfit.chooseFirst = (points, map, count, size) => {
  const drawn = Math.min(count, map.shown);
  points.geometry.setDrawRange(0, drawn);
  points.material.uniforms.metresPerRadius.value = map.max_radius * size * surfit.growth(map, drawn);
};

surfit.positionOfSurfel = (map, i) => new THREE.Vector3(...[0, 1, 2].map(
  (k) => map.origin[k] + map.extent[k] * map.position[3 * i + k] / 65535));

// How each mode tells a number, and how it is named. Confidence is logarithmic.
surfit.scalarModes = {
  confidence: { legend: 'confidence (logarithmic)', of: (map, i) => Math.log10(map.confidence[i]),
    show: (value) => (10 ** value).toPrecision(3) },
  last_seen: { legend: 'last seen in frame', of: (map, i) => map.last_seen[i], show: String },
  first_seen: { legend: 'first seen in frame', of: (map, i) => map.first_seen[i], show: String },
  distance: { legend: 'distance to the other run (grey: nothing within 50 cm)',
    of: (map, i) => (map.distance[i] === surfit.farFromMap ? NaN : map.distance[i] / 10),
    show: (value) => `${value.toPrecision(3)} mm` },
};

// The range of a mode over all maps, so that colours compare; of confidence at most four decades, of
// distances up to those that a twentieth exceed.
surfit.modeRange = (runs, mode) => {
  if (mode === 'distance') {
    const shares = runs.map(({ map }) => surfit.distanceQuantile(map, 0.95)).filter(Number.isFinite);
    return [0, Math.max(...shares, 1)];
  }
  let [low, high] = [Infinity, -Infinity];
  for (const { map } of runs) {
    for (let i = 0; i < map.shown; ++i) {
      const value = surfit.scalarModes[mode].of(map, i);
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  if (!(low <= high)) return [0, 0];
  return mode === 'confidence' ? [Math.max(low, high - 4), high] : [low, high];
};

surfit.colorPoints = (points, map, mode, [low, high]) => {
  const shade = points.geometry.getAttribute('shade');
  const out = shade.array;
  if (mode === 'color') {
    out.set(surfit.padTriples(map.color));
  } else if (mode === 'normal') {
    out.set(surfit.padTriples(Uint8Array.from(map.normal, (n) => 127.5 + n)));
  } else {
    const of = surfit.scalarModes[mode].of;
    for (let i = 0; i < map.shown; ++i) {
      const value = mode === 'distance' && !map.distance ? NaN : of(map, i);
      const from = 3 * surfit.scaleIndex(value, low, high);
      for (let c = 0; c < 3; ++c) out[4 * i + c] = Number.isNaN(value) ? 128 : surfit.viridis[from + c];
    }
  }
  shade.needsUpdate = true;
};
