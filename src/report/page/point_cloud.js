'use strict';
// A run's surfels as points of three.js. Positions stay the 16-bit shares of the map's extent.
surfit.pointVertexShader = `
attribute vec3 shade;
attribute float confidence;
uniform vec3 origin, extent;
uniform float radius, pixelsAtOneMetre, leastConfidence;
uniform bool cull;
varying vec3 color;
void main() {
  vec4 inView = viewMatrix * vec4(origin + extent * position, 1.);
  bool away = dot(mat3(viewMatrix) * normal, inView.xyz) > 0.;
  color = shade;
  gl_PointSize = max(2. * radius * pixelsAtOneMetre / -inView.z, 1.);
  gl_Position = projectionMatrix * inView;
  if (confidence < leastConfidence || (cull && away)) gl_Position = vec4(2., 2., 2., 1.);
}`;
surfit.pointFragmentShader = `
varying vec3 color;
void main() { gl_FragColor = vec4(color, 1.); }`;

surfit.makePointCloud = (map) => {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(surfit.padTriples(map.position), 4, true));
  geometry.setAttribute('normal', new THREE.BufferAttribute(surfit.padTriples(map.normal), 4, true));
  geometry.setAttribute('confidence', new THREE.BufferAttribute(map.confidence, 1));
  geometry.setAttribute('shade', new THREE.BufferAttribute(new Uint8Array(4 * map.shown), 4, true));
  const material = new THREE.ShaderMaterial({
    vertexShader: surfit.pointVertexShader,
    fragmentShader: surfit.pointFragmentShader,
    uniforms: {
      origin: { value: new THREE.Vector3(...map.origin) },
      extent: { value: new THREE.Vector3(...map.extent) },
      radius: { value: 0 },  // as chooseFirst() has it
      pixelsAtOneMetre: { value: 1 }, leastConfidence: { value: 0 }, cull: { value: true },
    },
  });
  const points = new THREE.Points(geometry, material);
  points.frustumCulled = false;  // the geometry's own bounds are those of shares
  return points;
};

// Draws the first `count` surfels, an even share of the map, or all that there are. Where surfels
// are left out the others grow to close the surface.
surfit.chooseFirst = (points, map, count, size) => {
  const drawn = Math.min(count, map.shown);
  points.geometry.setDrawRange(0, drawn);
  points.material.uniforms.radius.value = 0.7 * size * map.radius * Math.sqrt(map.points / Math.max(drawn, 1));
};

// How each mode tells a number, and how it is named. Confidence is logarithmic.
surfit.scalarModes = {
  confidence: { legend: 'confidence (logarithmic)', of: (map, i) => Math.log10(map.confidence[i]),
    show: (value) => (10 ** value).toPrecision(3) },
  last_seen: { legend: 'last seen in frame', of: (map, i) => map.last_seen[i], show: String },
  first_seen: { legend: 'first seen in frame', of: (map, i) => map.first_seen[i], show: String },
};

// The range of a mode over all maps, so that colours compare; of confidence at most four decades.
surfit.modeRange = (runs, mode) => {
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
      const from = 3 * surfit.scaleIndex(of(map, i), low, high);
      for (let c = 0; c < 3; ++c) out[4 * i + c] = surfit.viridis[from + c];
    }
  }
  shade.needsUpdate = true;
};
