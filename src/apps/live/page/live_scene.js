'use strict';
surfit.slowMs = 150;  // that drawing may take before it is done more coarsely

// Another geometry for another number of points: the graphics card forgets the old one.
surfit.setPoints = (line, points) => {
  line.geometry.dispose();
  line.geometry = new THREE.BufferGeometry().setFromPoints(points);
};

// The map in 3D with the path, the camera and the loops; drawn when something has changed. Until somebody turns
// it all of it is kept in view.
surfit.LiveScene = class {
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({ canvas, alpha: true, antialias: false });
    this.pixelRatio = Math.min(window.devicePixelRatio, 2);
    this.nextAt = 0;  // when to draw again at the earliest
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(50, 1, 0.02, 500);
    this.map = new surfit.ShownMap();
    this.coloring = surfit.colorings.color;
    this.points = surfit.makePoints(this.map.geometry, [0, 0, 0], [1, 1, 1]);
    this.path = surfit.makeLine([], null, 0xff961e);
    this.frustum = surfit.makeSegments(0xff3b3b);
    this.loops = surfit.makeSegments(0x3cdc78);
    for (const line of [this.path, this.frustum, this.loops]) {
      line.material.depthTest = false;
      line.renderOrder = 1;
    }
    this.scene.add(this.points, this.path, this.frustum, this.loops);
    this.up = new THREE.Vector3(0, -1, 0);
    this.ups = new THREE.Vector3();  // summed over the poses
    this.places = [];
    this.follows = false;
    this.isTouched = false;
    this.look(new THREE.Vector3(0, -1, -3), new THREE.Vector3(0, 0, 1));
    new ResizeObserver(() => this.draw()).observe(canvas.parentElement);
  }

  look(from, at) {
    this.camera.up.copy(this.up);
    this.camera.position.copy(from);
    // The controls take what is up from the camera when they are made.
    if (this.controls) this.controls.dispose();
    this.controls = new THREE.OrbitControls(this.camera, this.canvas);
    this.controls.enableKeys = false;
    this.controls.target.copy(at);
    this.controls.addEventListener('change', () => this.draw());
    this.controls.addEventListener('start', () => { this.isTouched = true; });
    this.controls.update();
    this.draw();
  }

  // All but the farthest surfels, from behind and above the first camera.
  lookAtAll() {
    const places = [...this.map.places(3000), ...this.places];
    if (places.length === 0) return;
    const middle = (values) => values.sort((a, b) => a - b)[Math.floor(values.length / 2)];
    const centre = new THREE.Vector3(...['x', 'y', 'z'].map((k) => middle(places.map((p) => p[k]))));
    const distances = places.map((p) => p.distanceTo(centre)).sort((a, b) => a - b);
    const path = Math.max(0, ...this.places.map((p) => p.distanceTo(centre)));
    const size = Math.max(distances[Math.floor(0.9 * (distances.length - 1))], 1.1 * path, 0.5);
    if (this.ups.length() > 1e-6) this.up.copy(this.ups).normalize();
    const back = (this.ahead || new THREE.Vector3(0, 0, 1)).clone().negate();
    back.addScaledVector(this.up, -back.dot(this.up));
    if (back.length() < 1e-3) back.set(this.up.y, this.up.z, this.up.x).cross(this.up);
    const narrow = Math.max(1, 1.2 / this.aspect());
    const away = back.normalize().add(this.up.clone().multiplyScalar(0.9)).normalize();
    this.look(centre.clone().addScaledVector(away, 1.75 * narrow * size), centre);
  }

  showWhole() {
    this.follows = false;
    this.isTouched = false;
    this.lookAtAll();
  }

  // Behind the camera and above it, looking where it looks; turned by hand it keeps its place to it.
  follow(on) {
    this.follows = on;
    if (on && this.pose) {
      const at = (x, y, z) => new THREE.Vector3(x, y, z).applyQuaternion(this.rotation).add(this.place);
      if (this.ups.length() > 1e-6) this.up.copy(this.ups).normalize();
      this.isTouched = true;
      this.look(at(0, -0.5, -1.4), at(0, 0, 1.2));
    }
  }

  takeMap(buffer) {
    const goesOn = this.map.take(buffer, this.coloring);
    if (!goesOn && !this.isTouched && !this.follows) this.lookAtAll();
    this.draw();
    return goesOn;
  }

  setColors(name) {
    this.coloring = surfit.colorings[name];
    this.map.recolor(this.coloring);
    this.draw();
  }

  setPath({ places, loops }) {
    const points = (numbers) => Array.from({ length: numbers.length / 3 }, (_, i) => new THREE.Vector3(
      ...numbers.slice(3 * i, 3 * i + 3)).multiplyScalar(0.001));
    this.places = points(places);
    this.showPath();
    surfit.setPoints(this.loops, points(loops));
    this.draw();
  }

  // Up to the camera: it goes on between two answers.
  showPath() {
    surfit.setPoints(this.path, this.place ? [...this.places, this.place] : this.places);
  }

  setState(state) {
    this.mapPoints = state.map_points;
    this.dust = state.dust;
    this.shownCount = state.shown;
    if (state.pose) this.setPose(state.pose, state.camera);
    this.draw();
  }

  setPose(pose, camera) {
    const [tx, ty, tz, ...rotation] = pose;
    const before = this.place;
    this.place = new THREE.Vector3(tx, ty, tz);
    this.rotation = new THREE.Quaternion(...rotation);
    this.ups.add(new THREE.Vector3(0, -1, 0).applyQuaternion(this.rotation));
    if (!this.pose) this.ahead = new THREE.Vector3(0, 0, 1).applyQuaternion(this.rotation);
    this.pose = pose;
    surfit.setPoints(this.frustum, surfit.frustum({ poses: { camera } }, [0, 0, ...pose], 0.3));
    this.showPath();
    if (this.follows && before) {
      const move = this.place.clone().sub(before);
      this.camera.position.add(move);
      this.controls.target.add(move);
      this.controls.update();
    }
  }

  aspect() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    return clientWidth / Math.max(clientHeight, 1);
  }

  // Not so often that the page does nothing else: a browser may draw by the processor.
  draw() {
    if (this.waits) return;
    this.waits = true;
    setTimeout(() => requestAnimationFrame(() => {
      this.waits = false;
      const begin = performance.now();
      this.drawNow();
      const context = this.renderer.getContext();
      context.readPixels(0, 0, 1, 1, context.RGBA, context.UNSIGNED_BYTE, new Uint8Array(4));  // waits for it
      const end = performance.now();
      this.nextAt = end + (end - begin);
      if (end - begin > surfit.slowMs) this.pixelRatio = Math.max(0.7 * this.pixelRatio, 0.5);
    }), Math.max(0, this.nextAt - performance.now()));
  }

  drawNow() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    const size = this.renderer.getSize(new THREE.Vector2());
    if (size.x !== clientWidth || size.y !== clientHeight || this.renderer.getPixelRatio() !== this.pixelRatio) {
      this.renderer.setPixelRatio(this.pixelRatio);
      this.renderer.setSize(clientWidth, clientHeight, false);
    }
    this.camera.aspect = this.aspect();
    this.camera.updateProjectionMatrix();
    const { uniforms } = this.points.material;
    const tangent = Math.tan(this.camera.fov * Math.PI / 360);
    uniforms.pixelsAtOneMetre.value = clientHeight * this.renderer.getPixelRatio() / (2 * tangent);
    uniforms.metresPerRadius.value = 255 * surfit.metresPerRadius
      * surfit.growth({ points: this.mapPoints || 1 }, this.shownCount || 1);
    uniforms.leastConfidence.value = Math.max(this.dust || 0, 1) - 0.5;  // 0: there is no surfel
    this.renderer.render(this.scene, this.camera);
  }
};
