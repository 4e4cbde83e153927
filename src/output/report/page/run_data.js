'use strict';
// What WriteReport() put into the page: an array of runs, as src/report/report_data.h tells, with the
// texts of frames.csv and loops.csv as columns and rows, and the map's base64 as typed arrays.
surfit.decode = (base64, Type) => {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return new Type(bytes.buffer);
};

// Triples with a fourth, unused: vertex data that begin at multiples of four bytes need no copies.
surfit.padTriples = (triples) => {
  const padded = new triples.constructor(triples.length / 3 * 4);
  for (let from = 0, to = 0; from < triples.length; from += 3, to += 4) {
    padded[to] = triples[from];
    padded[to + 1] = triples[from + 1];
    padded[to + 2] = triples[from + 2];
  }
  return padded;
};

// Columns by name; numbers but for the two that hold words. Nothing where a run has no such table.
surfit.parseFrames = (csv) => {
  if (!csv) return null;
  const [names, ...rows] = csv.trim().split('\n').map((line) => line.split(','));
  const columns = {};
  names.forEach((name, k) => {
    const isText = name === 'state' || name === 'termination';
    columns[name] = rows.map((row) => (isText ? row[k] : Number(row[k])));
  });
  return columns;
};

surfit.decodeMap = (map) => Object.assign(map, {
  position: surfit.decode(map.position, Uint16Array),
  normal: surfit.decode(map.normal, Int8Array),
  color: surfit.decode(map.color, Uint8Array),
  radius: surfit.decode(map.radius, Uint16Array),
  confidence: surfit.decode(map.confidence, Float32Array),
  first_seen: surfit.decode(map.first_seen, Int32Array),
  last_seen: surfit.decode(map.last_seen, Int32Array),
}, map.distance === undefined ? {} : { distance: surfit.decode(map.distance, Uint16Array) });

surfit.readRuns = () => [...document.querySelectorAll('script.run')].map((element) => {
  const run = JSON.parse(element.textContent);
  element.remove();
  run.frames = surfit.parseFrames(run.frames);
  run.loops = surfit.parseLoops(run.loops);
  run.errors = new Map(run.poses.errors_m || []);  // frame's index to metres
  run.poseOfFrame = new Map(run.poses.poses.map((pose) => [pose[0], pose]));
  run.poses.thumbnails = run.poses.thumbnails || [];
  surfit.decodeMap(run.map);
  return run;
});
