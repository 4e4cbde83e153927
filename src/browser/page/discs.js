'use strict';
// Surfels as discs. A disc is a three.js point, whose fragment shader discards pixels with rays that miss the disc.
surfit.discVertexShader = `
attribute vec3 shade;
attribute float confidence, radius;
uniform vec3 origin, extent, boxLow, boxHigh;
uniform mat3 boxFromWorld;
uniform float metresPerRadius, pixelsAtOneMetre, leastConfidence;
uniform bool cull;
varying vec3 color, centre, facing;
varying float metres, pixels;
void main() {
  vec4 inMap = vec4(origin + extent * position, 1.);
  centre = (modelViewMatrix * inMap).xyz;
  facing = normalize(mat3(modelViewMatrix) * normal);
  color = shade;
  metres = metresPerRadius * radius;
  float nearest = max(-centre.z - metres, 0.2 * -centre.z);
  pixels = max(2. * metres * pixelsAtOneMetre / nearest, 1.);
  gl_PointSize = pixels;
  gl_Position = projectionMatrix * vec4(centre, 1.);
  vec3 inBox = boxFromWorld * (modelMatrix * inMap).xyz;
  bool cropped = any(lessThan(inBox, boxLow)) || any(greaterThan(inBox, boxHigh));
  bool away = dot(facing, centre) > 0.;
  if (confidence < leastConfidence || cropped || (cull && away)) gl_Position = vec4(2., 2., 2., 1.);
}`;
// The ray r of the pixel intersects the plane of the disc at t r with t = n.c / n.r. Discs of up to two pixels are
// drawn as squares, because small discs could miss all pixel centres.
surfit.discFragmentShader = `
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

// Sets the vertex data of a geometry. Positions are three floats, or four integers that are normalised to [0, 1].
surfit.setDiscs = (geometry, { position, normal, confidence, radius, shade }) => {
  const set = (name, array, items, normalised) => geometry.setAttribute(name,
    new THREE.BufferAttribute(array, items, normalised));
  const isFloat = position instanceof Float32Array;
  set('position', position, isFloat ? 3 : 4, !isFloat);
  set('normal', normal, 4, true);
  set('confidence', confidence, 1, false);
  set('radius', radius, 1, true);
  set('shade', shade, 4, true);
};

// Discs at origin + extent * position of the geometry.
surfit.makeDiscs = (geometry, origin = [0, 0, 0], extent = [1, 1, 1]) => {
  const material = new THREE.ShaderMaterial({
    vertexShader: surfit.discVertexShader,
    fragmentShader: surfit.discFragmentShader,
    uniforms: {
      origin: { value: new THREE.Vector3(...origin) },
      extent: { value: new THREE.Vector3(...extent) },
      metresPerRadius: { value: 0 },  // metres of the largest value of `radius`
      pixelsAtOneMetre: { value: 1 }, leastConfidence: { value: 0 }, cull: { value: true },
      boxFromWorld: { value: new THREE.Matrix3() },
      boxLow: { value: new THREE.Vector3(-1e9, -1e9, -1e9) },
      boxHigh: { value: new THREE.Vector3(1e9, 1e9, 1e9) },
    },
  });
  const discs = new THREE.Points(geometry, material);
  discs.frustumCulled = false;  // the bounds of the geometry are not in world units
  return discs;
};

// Factor of the radii that closes gaps if only `drawn` surfels of the map are drawn. The factor 1.4 accounts for
// irregular spacing.
surfit.growth = (map, drawn) => 1.4 * Math.sqrt(map.points / Math.max(drawn, 1));

// Functions of (map, i, k): component k of the colour of surfel i. `color` and `normal` have four bytes per surfel.
surfit.colorings = {
  color: (map, i, k) => map.color[4 * i + k],
  normal: (map, i, k) => 127.5 + map.normal[4 * i + k],
};

// Colouring of the values valueOf(map, i) by the colour scale. NaN is grey.
surfit.scaledColoring = (valueOf, [low, high]) => (map, i, k) => {
  const value = valueOf(map, i);
  return Number.isNaN(value) ? 128 : surfit.viridis[surfit.scaleIndex(value, low, high) + k];
};

surfit.shadeSurfel = (map, i, coloring) => {
  for (let k = 0; k < 3; ++k) map.shade[4 * i + k] = coloring(map, i, k);
};
