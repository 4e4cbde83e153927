'use strict';
// Where a run's camera was. A pose is [frame, stamp_s, tx, ty, tz, qx, qy, qz, qw].
surfit.positionOf = (pose) => new THREE.Vector3(pose[2], pose[3], pose[4]);
surfit.rotationOf = (pose) => new THREE.Quaternion(pose[5], pose[6], pose[7], pose[8]);

// Unit mean over the poses of a direction in the camera; `otherwise` where there is none.
surfit.meanDirection = (poses, inCamera, otherwise) => {
  const sum = new THREE.Vector3();
  for (const pose of poses) {
    sum.add(new THREE.Vector3(...inCamera).applyQuaternion(surfit.rotationOf(pose)));
  }
  return sum.length() > 1e-6 ? sum.normalize() : new THREE.Vector3(...otherwise);
};
surfit.upOf = (run) => surfit.meanDirection(run.poses.poses, [0, -1, 0], [0, -1, 0]);
surfit.forwardOf = (run) => surfit.meanDirection(run.poses.poses, [0, 0, 1], [0, 0, 1]);

surfit.makeLine = (positions, colors, color) => {
  const geometry = new THREE.BufferGeometry().setFromPoints(positions);
  if (colors) {
    geometry.setAttribute('color', new THREE.BufferAttribute(new Uint8Array(colors.flat()), 3, true));
  }
  const line = new THREE.Line(geometry, new THREE.LineBasicMaterial(
    colors ? { vertexColors: THREE.VertexColors } : { color }));
  line.frustumCulled = false;
  return line;
};

// The estimated path, coloured by its error where that is known.
surfit.makeEstimate = (run, errorRange) => {
  const poses = run.poses.poses;
  const colors = run.errors.size > 0
    ? poses.map((pose) => surfit.scaleColor(run.errors.get(pose[0]) || 0, ...errorRange)) : null;
  return surfit.makeLine(poses.map(surfit.positionOf), colors, 0xd1495b);
};

surfit.makeTruth = (run) => surfit.makeLine(
  (run.poses.truth || []).map((row) => new THREE.Vector3(row[1], row[2], row[3])), null, 0xff8c1a);

// The edges of a pyramid that opens at `depth` metres before a pose's camera: pairs of points.
surfit.frustum = (run, pose, depth) => {
  const { camera } = run.poses;
  const corner = (u, v) => new THREE.Vector3((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1)
    .multiplyScalar(depth);
  const corners = [corner(0, 0), corner(camera.width, 0), corner(camera.width, camera.height),
    corner(0, camera.height)];
  const centre = surfit.positionOf(pose);
  const moved = corners.map((c) => c.clone().applyQuaternion(surfit.rotationOf(pose)).add(centre));
  return moved.flatMap((c, k) => [centre, c, c, moved[(k + 1) % 4]]);
};

// Lines whose points are set later.
surfit.makeSegments = (color) => {
  const lines = new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints([]),
    new THREE.LineBasicMaterial({ color }));
  lines.frustumCulled = false;
  return lines;
};

// Of about 30 poses.
surfit.makeFrusta = (run, depth) => {
  const { poses } = run.poses;
  const step = Math.max(1, Math.ceil(poses.length / 30));
  const lines = surfit.makeSegments(0x2f81d6);
  lines.geometry.setFromPoints(poses.filter((_, i) => i % step === 0).flatMap(
    (pose) => surfit.frustum(run, pose, depth)));
  return lines;
};
