'use strict';
surfit.slowMs = 150;  // maximum rendering time; above this time the resolution is reduced

// Map with path, camera and loops, rendered after changes. The whole map is in view until the user turns it.
surfit.LiveScene = class extends surfit.Scene {
  constructor(canvas) {
    super(canvas);
    this.pixelRatio = Math.min(window.devicePixelRatio, 2);
    this.nextAt = 0;  // earliest time of the next rendering
    this.scene = new THREE.Scene();
    this.map = new surfit.ShownMap();
    this.coloring = surfit.colorings.color;
    this.discs = surfit.makeDiscs(this.map.geometry);
    this.path = surfit.makeLines(0xff961e, [], THREE.Line);
    this.frustum = surfit.makeLines(0xff3b3b);
    this.loops = surfit.makeLines(0x3cdc78);
    for (const line of [this.path, this.frustum, this.loops]) {
      line.material.depthTest = false;
      line.renderOrder = 1;
    }
    this.scene.add(this.discs, this.path, this.frustum, this.loops);
    this.ups = new THREE.Vector3();  // sum of the up directions of all poses
    this.positions = [];
    this.state = {};
    this.follows = false;
    this.isTouched = false;
    this.camera.up.set(0, -1, 0);
    this.look(new THREE.Vector3(0, -1, -3), new THREE.Vector3(0, 0, 1));
  }

  isTurned() { this.isTouched = true; }

  up() { return this.ups.length() > 1e-6 ? this.ups.clone().normalize() : this.camera.up.clone(); }

  showWhole() {
    this.follows = this.isTouched = false;
    const points = this.map.positions(3000);
    if (points.length + this.positions.length === 0) return;
    this.lookAtAll(surfit.boundsOf(points, this.positions), this.ahead || new THREE.Vector3(0, 0, 1), this.up());
  }

  // View from behind and above the camera of the run. If the user turns the view, its offset to this camera is kept.
  lookFromCamera() {
    if (!this.place) return;
    const at = (x, y, z) => new THREE.Vector3(x, y, z).applyQuaternion(this.rotation).add(this.place);
    this.camera.up.copy(this.up());
    this.isTouched = true;
    this.look(at(0, -0.5, -1.4), at(0, 0, 1.2));
  }

  takeMap(buffer) {
    const goesOn = this.map.take(buffer, this.coloring);
    if (!goesOn && !this.isTouched && !this.follows) this.showWhole();
    this.draw();
    return goesOn;
  }

  setColors(name) {
    this.coloring = surfit.liveColorings[name];
    this.map.recolor(this.coloring);
    this.draw();
  }

  setPath({ positions, loops }) {
    const points = (numbers) => Array.from({ length: numbers.length / 3 }, (_, i) => new THREE.Vector3(
      ...numbers.slice(3 * i, 3 * i + 3)).multiplyScalar(0.001));
    this.positions = points(positions);
    this.showPath();
    surfit.setPoints(this.loops, points(loops));
    this.draw();
  }

  // Path and newest position, which the server may not have added to the path yet.
  showPath() { surfit.setPoints(this.path, [...this.positions, ...(this.place ? [this.place] : [])]); }

  setState(state) {
    this.state = state;
    if (state.pose) this.setPose([0, 0, ...state.pose], state.camera);
    this.draw();
  }

  setPose(pose, camera) {
    const before = this.place;
    this.place = surfit.positionOf(pose);
    this.rotation = surfit.rotationOf(pose);
    this.ups.add(surfit.upOf([pose]));
    this.ahead = this.ahead || surfit.forwardOf([pose]);
    surfit.setPoints(this.frustum, surfit.frustum(camera, pose, 0.3));
    this.showPath();
    if (!this.follows || !before) return;
    const move = this.place.clone().sub(before);
    this.camera.position.add(move);
    this.controls.target.add(move);
    this.controls.update();
  }

  // Renders for at most half of the time, because a browser may render on the CPU.
  draw() {
    if (this.waits) return;
    this.waits = true;
    setTimeout(() => requestAnimationFrame(() => {
      this.waits = false;
      const begin = performance.now();
      this.drawNow();
      const context = this.renderer.getContext();
      // Waits for the end of rendering.
      context.readPixels(0, 0, 1, 1, context.RGBA, context.UNSIGNED_BYTE, new Uint8Array(4));
      const end = performance.now();
      this.nextAt = end + (end - begin);
      if (end - begin > surfit.slowMs) this.pixelRatio = Math.max(0.7 * this.pixelRatio, 0.5);
    }), Math.max(0, this.nextAt - performance.now()));
  }

  drawNow() {
    this.fitCanvas(this.pixelRatio);
    this.setAspect(this.canvasSize());
    const { uniforms } = this.discs.material, { map_points: points = 1, shown = 1, dust = 0 } = this.state;
    uniforms.pixelsAtOneMetre.value = this.pixelsAtOneMetre(this.canvasSize().height);
    uniforms.metresPerRadius.value = 255 * surfit.metresPerRadius * surfit.growth({ points }, shown);
    uniforms.leastConfidence.value = Math.max(dust, 1) - 0.5;  // 0: empty slot
    this.renderer.render(this.scene, this.camera);
  }
};
