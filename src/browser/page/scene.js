'use strict';
// 3D view on a canvas. Mouse and keys rotate, move and zoom the view about a target.
surfit.Scene = class {
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({ canvas, alpha: true });
    this.camera = new THREE.PerspectiveCamera(50, 1, 0.02, 500);
    new ResizeObserver(() => this.draw()).observe(canvas.parentElement);
  }

  // Called when the user rotates the view.
  isTurned() {}

  look(from, at) {
    this.camera.position.copy(from);
    // The controls read the up vector of the camera in their constructor.
    if (this.controls) this.controls.dispose();
    this.controls = new THREE.OrbitControls(this.camera, this.canvas);
    this.controls.enableKeys = false;  // listens to keys of the whole window
    this.controls.target.copy(at);
    this.controls.addEventListener('change', () => this.draw());
    this.controls.addEventListener('start', () => this.isTurned());
    this.controls.update();
    this.draw();
  }

  // Shows the whole path and 90 % of the points from behind and above.
  lookAtAll({ centre, size }, ahead, up) {
    const back = surfit.level(ahead, up).negate();
    const narrow = Math.max(1, 1.35 / this.aspect());
    this.camera.up.copy(up);
    this.camera.fov = 50;
    this.look(centre.clone().addScaledVector(back.add(up).normalize(), 2.12 * narrow * size), centre);
  }

  canvasSize() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    return { width: clientWidth, height: Math.max(clientHeight, 1) };
  }

  aspect() { return this.canvasSize().width / this.canvasSize().height; }

  // Resizes the canvas only if its size has changed, because resizing clears it.
  fitCanvas(pixelRatio) {
    const { width, height } = this.canvasSize();
    const size = this.renderer.getSize(new THREE.Vector2());
    if (size.x === width && size.y === height && this.renderer.getPixelRatio() === pixelRatio) return;
    this.renderer.setPixelRatio(pixelRatio);
    this.renderer.setSize(width, height, false);
  }

  setAspect({ width, height }) {
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
  }

  // Pixels per metre at a distance of 1 m. height: height of the view in CSS pixels.
  pixelsAtOneMetre(height) {
    return height * this.renderer.getPixelRatio() / (2 * Math.tan(this.camera.fov * Math.PI / 360));
  }

  // Rotates the camera about the target by angles in rad. Rotations over the top are blocked.
  turn(right, upwards) {
    const { camera, controls: { target } } = this;
    const offset = camera.position.clone().sub(target).applyAxisAngle(camera.up, right);
    const side = new THREE.Vector3().crossVectors(camera.up, offset).normalize();
    const raised = offset.clone().applyAxisAngle(side, -upwards);
    const fromTop = raised.angleTo(camera.up);
    this.look(target.clone().add(fromTop > 0.05 && fromTop < Math.PI - 0.05 ? raised : offset), target.clone());
  }

  // Moves camera and target. Unit: distance to the target.
  move(right, upwards) {
    const { camera, controls: { target } } = this;
    const ahead = target.clone().sub(camera.position), step = ahead.length();
    const move = new THREE.Vector3().crossVectors(ahead, camera.up).normalize().multiplyScalar(right * step)
      .addScaledVector(camera.up, upwards * step);
    this.look(camera.position.clone().add(move), target.clone().add(move));
  }

  zoom(factor) {
    const { camera, controls: { target } } = this;
    this.look(camera.position.clone().sub(target).multiplyScalar(factor).add(target), target.clone());
  }
};

// Median of all points, and the radius about it that contains 90 % of the points and the whole path, m.
surfit.boundsOf = (points, path) => {
  const all = [...points, ...path];
  const middle = (values) => values.sort((a, b) => a - b)[Math.floor(values.length / 2)] || 0;
  const centre = new THREE.Vector3(...['x', 'y', 'z'].map((k) => middle(all.map((p) => p[k]))));
  const distances = all.map((p) => p.distanceTo(centre)).sort((a, b) => a - b);
  const farthest = surfit.range(path.map((p) => p.distanceTo(centre)))[1];
  return { centre, size: Math.max(distances[Math.floor(0.9 * distances.length)] || 1, 1.1 * farthest, 0.1) };
};

surfit.sceneKeys = {
  ArrowLeft: (scene, shift) => (shift ? scene.move(-0.08, 0) : scene.turn(-0.12, 0)),
  ArrowRight: (scene, shift) => (shift ? scene.move(0.08, 0) : scene.turn(0.12, 0)),
  ArrowUp: (scene, shift) => (shift ? scene.move(0, 0.08) : scene.turn(0, 0.12)),
  ArrowDown: (scene, shift) => (shift ? scene.move(0, -0.08) : scene.turn(0, -0.12)),
  '+': (scene) => scene.zoom(0.85),
  '=': (scene) => scene.zoom(0.85),
  '-': (scene) => scene.zoom(1 / 0.85),
};

// Connects the keys of the scene (may be null) and otherKeys (functions by key). Buttons, selects and inputs keep
// their own keys.
surfit.connectKeys = (target, scene, otherKeys) => target.addEventListener('keydown', (event) => {
  const turn = scene && surfit.sceneKeys[event.key];
  const isElsewhere = /^(BUTTON|SELECT|INPUT)$/.test(event.target.tagName);
  if (isElsewhere || event.ctrlKey || event.altKey || event.metaKey || !(turn || event.key in otherKeys)) return;
  event.preventDefault();
  if (!turn) return otherKeys[event.key]();
  scene.isTurned();
  turn(scene, event.shiftKey);
});
