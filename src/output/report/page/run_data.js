'use strict';
// Runs of the page, in the format of src/output/report/report_data.h. Parses frames.csv to columns and loops.csv to
// rows, and decodes the base64 of the map to typed arrays.
surfit.decode = (base64, Type) => {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return new Type(bytes.buffer);
};

// Pads triples to four numbers, because vertex data must be aligned to four bytes.
surfit.padTriples = (triples) => {
  const padded = new triples.constructor(triples.length / 3 * 4);
  for (let from = 0, to = 0; from < triples.length; from += 3, to += 4) {
    for (let k = 0; k < 3; ++k) padded[to + k] = triples[from + k];
  }
  return padded;
};

surfit.textColumns = ['state', 'termination', 'reason'];

// Rows as objects. Values are numbers, except texts in surfit.textColumns.
surfit.parseCsv = (csv) => {
  const [names, ...rows] = csv.trim().split('\n').map((line) => line.split(','));
  return rows.map((row) => Object.fromEntries(
    names.map((name, k) => [name, surfit.textColumns.includes(name) ? row[k] : Number(row[k])])));
};

// Columns by name; null for a run without frames.csv.
surfit.parseFrames = (csv) => {
  if (!csv) return null;
  const rows = surfit.parseCsv(csv);
  return Object.fromEntries(csv.split('\n', 1)[0].trim().split(',').map((name) => [name, rows.map((row) => row[name])]));
};

surfit.mapColumns = { position: Uint16Array, normal: Int8Array, color: Uint8Array, radius: Uint16Array,
  confidence: Float32Array, first_seen: Int32Array, last_seen: Int32Array, distance: Uint16Array };

surfit.decodeMap = (map) => {
  for (const [name, Type] of Object.entries(surfit.mapColumns)) {
    if (map[name] !== undefined) map[name] = surfit.decode(map[name], Type);
  }
  for (const name of ['position', 'normal', 'color']) map[name] = surfit.padTriples(map[name]);
  map.shade = new Uint8Array(4 * map.shown);
};

surfit.readRuns = () => surfit.takeData('run').map((run) => {
  run.frames = surfit.parseFrames(run.frames);
  run.loops = surfit.parseLoops(run.loops);
  run.errors = new Map(run.poses.errors_m || []);  // position error in m by frame index
  run.poseOfFrame = new Map(run.poses.poses.map((pose) => [pose[0], pose]));
  run.poses.thumbnails = run.poses.thumbnails || [];
  run.poses.keyframes = run.poses.keyframes || [];
  run.poses.truth = run.poses.truth || [];
  surfit.decodeMap(run.map);
  return run;
});
