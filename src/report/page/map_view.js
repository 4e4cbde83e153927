'use strict';
// The maps side by side on one canvas, seen by one camera. Drawn when something changes only: at once
// with a part of the points, so that turning stays smooth without a graphics card, and with all as
// soon as nothing has changed for a moment.
surfit.pointsWhileChanging = 100000;  // of all maps
surfit.restMs = 200;

surfit.MapView = class {
  constructor(runs) {
    this.runs = runs;
    this.canvas = surfit.byId('map-canvas');
    this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, alpha: true });
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.renderer.setScissorTest(true);
    this.pointSize = 1;
    this.isComplete = false;  // whether all points are drawn
    this.camera = new THREE.PerspectiveCamera(50, 1, 0.02, 500);
    this.frameMap();
    this.cells = runs.map((run) => this.makeCell(run));
    this.connect();
    new ResizeObserver(() => this.draw()).observe(this.canvas.parentElement);
    this.resetView();
    this.setMode('color');
  }

  // The middle of the first map, and how far from it are all of its path and its points but for
  // the farthest tenth.
  frameMap() {
    const { map, poses: { poses } } = this.runs[0];
    const points = [];
    for (let i = 0; i < map.shown; i += Math.ceil(map.shown / 5000)) {
      points.push(new THREE.Vector3(...[0, 1, 2].map(
        (k) => map.origin[k] + map.extent[k] * map.position[3 * i + k] / 65535)));
    }
    const middle = (values) => values.sort((a, b) => a - b)[Math.floor(values.length / 2)] || 0;
    this.centre = new THREE.Vector3(...['x', 'y', 'z'].map((k) => middle(points.map((p) => p[k]))));
    const distances = points.map((p) => p.distanceTo(this.centre)).sort((a, b) => a - b);
    const path = surfit.range(poses.map((pose) => surfit.positionOf(pose).distanceTo(this.centre)));
    this.size = Math.max(distances[Math.floor(0.9 * distances.length)] || 1, 1.1 * path[1]);
  }

  makeCell(run) {
    const errorRange = [0, Math.max(...this.runs.flatMap((r) => [...r.errors.values()]), 1e-9)];
    const cell = { scene: new THREE.Scene(), points: surfit.makePointCloud(run.map),
      estimate: surfit.makeEstimate(run, errorRange), truth: surfit.makeTruth(run),
      cameras: surfit.makeFrusta(run, 0.04 * this.size) };
    cell.scene.add(cell.points, cell.estimate, cell.truth, cell.cameras);
    return cell;
  }

  connect() {
    const on = (id, event, call) => surfit.byId(id).addEventListener(event, (e) => {
      call(e.target);
      this.draw();
    });
    on('color-mode', 'change', (select) => this.setMode(select.value));
    on('point-size', 'input', (range) => { this.pointSize = Number(range.value); });
    on('least-confidence', 'input', (range) => this.setLeastConfidence(Number(range.value)));
    on('cull', 'change', (box) => this.setUniform('cull', box.checked));
    for (const name of ['estimate', 'truth', 'cameras']) {
      on(`show-${name}`, 'change',
        (box) => this.cells.forEach((cell) => { cell[name].visible = box.checked; }));
    }
    on('reset-view', 'click', () => this.resetView());
  }

  setUniform(name, value) {
    for (const { points } of this.cells) points.material.uniforms[name].value = value;
  }

  // share: 0 shows all, 1 the most confident only, evenly in the logarithm.
  setLeastConfidence(share) {
    const [low, high] = surfit.modeRange(this.runs, 'confidence');
    const least = share > 0 ? 10 ** (low + share * (high - low)) : 0;
    this.setUniform('leastConfidence', least);
    surfit.byId('least-confidence-value').textContent = least.toPrecision(3);
  }

  setMode(mode) {
    const range = mode in surfit.scalarModes ? surfit.modeRange(this.runs, mode) : [0, 0];
    this.cells.forEach(({ points }, i) => surfit.colorPoints(points, this.runs[i].map, mode, range));
    surfit.showLegend(mode, range);
    this.draw();
  }

  resetView() {
    const up = surfit.upOf(this.runs[0]);
    const back = surfit.forwardOf(this.runs[0]).negate();
    back.addScaledVector(up, -back.dot(up));
    if (back.length() < 1e-3) back.set(up.y, up.z, up.x).cross(up);
    back.normalize();
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    const narrow = Math.max(1, clientHeight * this.cells.length / clientWidth);
    this.camera.up.copy(up);
    this.camera.position.copy(this.centre)
      .addScaledVector(up.clone().add(back), 1.5 * narrow * this.size);
    // The controls take what is up from the camera when they are made.
    if (this.controls) this.controls.dispose();
    this.controls = new THREE.OrbitControls(this.camera, this.canvas);
    this.controls.target.copy(this.centre);
    this.controls.addEventListener('change', () => this.draw());
    this.controls.update();
  }

  draw() {
    this.isComplete = false;
    clearTimeout(this.rest);
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.drawNow(surfit.pointsWhileChanging / this.cells.length);
      this.rest = setTimeout(() => {
        this.drawNow(Infinity);
        this.isComplete = true;
      }, surfit.restMs);
    });
  }

  // Only where it differs: the canvas is made anew.
  fitCanvas(width, height) {
    const size = this.renderer.getSize(new THREE.Vector2());
    if (size.x !== width || size.y !== height) this.renderer.setSize(width, height, false);
  }

  drawNow(most) {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    this.fitCanvas(clientWidth, clientHeight);
    const width = clientWidth / this.cells.length;
    this.camera.aspect = width / clientHeight;
    this.camera.updateProjectionMatrix();
    const pixels = clientHeight * window.devicePixelRatio;
    const tangent = Math.tan(this.camera.fov * Math.PI / 360);
    this.setUniform('pixelsAtOneMetre', pixels / (2 * tangent));
    this.cells.forEach(({ scene, points }, i) => {
      surfit.chooseFirst(points, this.runs[i].map, most, this.pointSize);
      this.renderer.setViewport(i * width, 0, width, clientHeight);
      this.renderer.setScissor(i * width, 0, width, clientHeight);
      this.renderer.render(scene, this.camera);
    });
  }
};

surfit.showLegend = (mode, range) => {
  const legend = surfit.byId('map-legend');
  legend.textContent = '';
  const say = (text) => surfit.element('span', legend, { textContent: text });
  if (mode === 'color') return say('the surfels’ own colours');
  if (mode === 'normal') return say('(1 + n) / 2 of the normal in the world: x red, y green, z blue');
  const { legend: name, show } = surfit.scalarModes[mode];
  say(name);
  say(show(range[0]));
  surfit.element('div', legend, { className: 'bar' }).style.background = surfit.scaleGradient();
  return say(show(range[1]));
};

surfit.showMapLabels = (runs) => {
  for (const run of runs) {
    const { points, shown } = run.map;
    const all = points === shown ? `all ${points} surfels`
      : `${shown} of ${points} surfels, evenly thinned out to what a browser holds`;
    const label = surfit.element('div', surfit.byId('map-labels'));
    surfit.element('h3', label, { textContent: run.label });
    surfit.element('p', label, { className: 'note', textContent: all });
  }
};
