'use strict';
// Camera poses in the 3D view. A pose is [frame, stamp_s, tx, ty, tz, qx, qy, qz, qw].
surfit.positionOf = (pose) => new THREE.Vector3(pose[2], pose[3], pose[4]);
surfit.rotationOf = (pose) => new THREE.Quaternion(pose[5], pose[6], pose[7], pose[8]);

// Unit vector of the mean world direction of a direction in the camera frame; `inCamera` if the mean vanishes.
surfit.meanDirection = (poses, ...inCamera) => {
  const sum = new THREE.Vector3();
  for (const pose of poses) sum.add(new THREE.Vector3(...inCamera).applyQuaternion(surfit.rotationOf(pose)));
  return sum.length() > 1e-6 ? sum.normalize() : new THREE.Vector3(...inCamera);
};
surfit.upOf = (poses) => surfit.meanDirection(poses, 0, -1, 0);
surfit.upOfRun = ({ up, poses }) => (up ? new THREE.Vector3(...up) : surfit.upOf(poses));
surfit.forwardOf = (poses) => surfit.meanDirection(poses, 0, 0, 1);

// Horizontal unit vector nearest to a direction; any horizontal unit vector for a vertical direction.
surfit.level = (direction, up) => {
  const level = direction.clone().addScaledVector(up, -direction.dot(up));
  if (level.length() < 1e-3) level.set(up.y, up.z, up.x).cross(up);
  return level.normalize();
};

// Lines between pairs of points, or along all points with THREE.Line.
surfit.makeLines = (color, points = [], Lines = THREE.LineSegments) => {
  const lines = new Lines(new THREE.BufferGeometry().setFromPoints(points), new THREE.LineBasicMaterial({ color }));
  lines.frustumCulled = false;
  return lines;
};

// Replaces the geometry, because the buffers of a geometry have a fixed size.
surfit.setPoints = (lines, points) => {
  lines.geometry.dispose();
  lines.geometry = new THREE.BufferGeometry().setFromPoints(points);
};

// Edges of a camera frustum as pairs of points. depth: height of the frustum, m.
surfit.frustum = (camera, pose, depth) => {
  const corners = [[0, 0], [camera.width, 0], [camera.width, camera.height], [0, camera.height]].map(
    ([u, v]) => new THREE.Vector3((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1)
      .multiplyScalar(depth).applyQuaternion(surfit.rotationOf(pose)).add(surfit.positionOf(pose)));
  return corners.flatMap((corner, k) => [surfit.positionOf(pose), corner, corner, corners[(k + 1) % 4]]);
};
