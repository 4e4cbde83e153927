'use strict';
// Pose graph of a run: keyframes [frame, parent frame or -1, submap], and loop candidates (rows of loops.csv) of three
// kinds.
surfit.loopKinds = {
  accepted: { color: '#2e9e5b', name: 'accepted' },
  overruled: { color: '#e08a00', name: 'accepted, but inconsistent with others' },
  refused: { color: '#d1495b', name: 'rejected' },
};

surfit.parseLoops = (csv) => (csv ? surfit.parseCsv(csv) : []).map((loop) => Object.assign(loop, {
  kind: { accepted: 'accepted', contradicts_others: 'overruled' }[loop.reason] || 'refused' }));

surfit.reasonText = (reason) => reason.replaceAll('_', ' ');

// Lines between the cameras of frame pairs.
surfit.makeEdges = (run, pairs, color) => surfit.makeLines(color, pairs.map(
  ([a, b]) => [run.poseOfFrame.get(a), run.poseOfFrame.get(b)]).filter(([a, b]) => a && b).flat()
  .map(surfit.positionOf));

surfit.makeGraph = (run) => {
  const { keyframes } = run.poses;
  const group = new THREE.Group();
  group.add(surfit.makeEdges(run, keyframes.filter(([, parent]) => parent >= 0), 0x4f8ad0));
  const nodes = keyframes.map(([frame]) => run.poseOfFrame.get(frame)).filter(Boolean).map(surfit.positionOf);
  const points = new THREE.Points(new THREE.BufferGeometry().setFromPoints(nodes),
    new THREE.PointsMaterial({ color: 0x4f8ad0, size: 6, sizeAttenuation: false }));
  points.frustumCulled = false;
  group.add(points, surfit.makeLoopEdges(run, 'accepted'), surfit.makeLoopEdges(run, 'overruled'));
  return group;
};

surfit.makeLoopEdges = (run, kind) => surfit.makeEdges(run,
  run.loops.filter((loop) => loop.kind === kind).map((loop) => [loop.source, loop.target]),
  surfit.loopKinds[kind].color);
