'use strict';
// The pose graph of a run: keyframes [frame, parent's frame or -1, submap], and the loops that were
// tried, rows of loops.csv. A loop is of one of three kinds.
surfit.loopKinds = {
  accepted: { color: '#2e9e5b', name: 'accepted' },
  overruled: { color: '#e08a00', name: 'accepted, but it contradicts others' },
  refused: { color: '#d1495b', name: 'refused' },
};

surfit.parseLoops = (csv) => {
  if (!csv) return [];
  const [names, ...rows] = csv.trim().split('\n').map((line) => line.split(','));
  return rows.map((row) => {
    const loop = Object.fromEntries(names.map((name, k) => [name, name === 'reason' ? row[k] : Number(row[k])]));
    loop.kind = loop.reason === 'accepted' ? 'accepted'
      : loop.reason === 'contradicts_others' ? 'overruled' : 'refused';
    return loop;
  });
};

surfit.reasonText = (reason) => reason.replaceAll('_', ' ');

// How many loops have each reason, the most frequent first.
surfit.countReasons = (loops) => {
  const counts = new Map();
  for (const { reason } of loops) counts.set(reason, (counts.get(reason) || 0) + 1);
  return [...counts].sort((a, b) => b[1] - a[1]);
};

// Lines between the cameras of pairs of frames.
surfit.makeEdges = (run, pairs, color) => {
  const at = (frame) => run.poseOfFrame.get(frame);
  const known = pairs.filter(([a, b]) => at(a) && at(b));
  const points = known.flatMap(([a, b]) => [surfit.positionOf(at(a)), surfit.positionOf(at(b))]);
  const lines = new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(points),
    new THREE.LineBasicMaterial({ color }));
  lines.frustumCulled = false;
  return lines;
};

surfit.makeGraph = (run) => {
  const keyframes = run.poses.keyframes || [];
  const group = new THREE.Group();
  group.add(surfit.makeEdges(run, keyframes.filter(([, parent]) => parent >= 0), 0x4f8ad0));
  const nodes = keyframes.map(([frame]) => run.poseOfFrame.get(frame)).filter(Boolean).map(surfit.positionOf);
  const points = new THREE.Points(new THREE.BufferGeometry().setFromPoints(nodes),
    new THREE.PointsMaterial({ color: 0x4f8ad0, size: 6, sizeAttenuation: false }));
  points.frustumCulled = false;
  group.add(points);
  for (const kind of ['accepted', 'overruled']) group.add(surfit.makeLoopEdges(run, kind));
  return group;
};

surfit.makeLoopEdges = (run, kind) => surfit.makeEdges(run,
  run.loops.filter((loop) => loop.kind === kind).map((loop) => [loop.source, loop.target]),
  surfit.loopKinds[kind].color);
