'use strict';
// The maps side by side on one canvas (one above the other where it is narrow), seen by one camera. Drawn
// when something changes only: at once with a part of the surfels, so that turning stays smooth without a
// graphics card, and with all as soon as nothing has changed for a moment.
surfit.pointsWhileChanging = 100000;  // of all maps
surfit.restMs = 200;
surfit.narrowPx = 700;
surfit.clickPx = 14;  // that a click may miss a camera by

surfit.MapView = class {
  constructor(runs) {
    this.runs = runs;
    this.canvas = surfit.byId('map-canvas');
    this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, alpha: true });
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.renderer.setScissorTest(true);
    this.discSize = 1;
    this.leastConfidence = 0;
    this.isComplete = false;  // whether all surfels are drawn
    this.camera = new THREE.PerspectiveCamera(50, 1, 0.02, 500);
    this.frameMaps();
    this.cells = runs.map((run) => this.makeCell(run));
    this.measure = new surfit.Measure(surfit.byId('measure'), surfit.byId('measured'));
    this.crop = new surfit.CropBox(surfit.floorDirections(runs[0]), this.samples, () => this.applyCrop());
    this.connect();
    new ResizeObserver(() => this.draw()).observe(this.canvas.parentElement);
    this.resetView();
    this.hideDust();
    this.setMode('color');
  }

  hideDust() {
    const [low, high] = surfit.modeRange(this.runs, 'confidence');
    const dust = Math.log10(Math.max(Math.min(...this.runs.map((run) => surfit.dustConfidence(run.map))), 1e-9));
    const share = high > low ? Math.min(Math.max((dust - low) / (high - low), 0), 1) : 0;
    surfit.byId('least-confidence').value = share;
    this.setLeastConfidence(share);
  }

  // The middle of all maps in the first run's world, and how far from it are all paths, and all
  // surfels but for the farthest tenth.
  frameMaps() {
    this.samples = this.runs.flatMap((run) => {
      const matrix = surfit.firstFromRun(run);
      const step = Math.ceil(run.map.shown / 5000);
      const points = [];
      for (let i = 0; i < run.map.shown; i += step) {
        points.push(surfit.positionOfSurfel(run.map, i).applyMatrix4(matrix));
      }
      return points;
    });
    const places = this.runs.flatMap((run) => run.poses.poses.map(
      (pose) => surfit.positionOf(pose).applyMatrix4(surfit.firstFromRun(run))));
    const middle = (values) => values.sort((a, b) => a - b)[Math.floor(values.length / 2)] || 0;
    this.centre = new THREE.Vector3(...['x', 'y', 'z'].map((k) => middle(this.samples.map((p) => p[k]))));
    const distances = this.samples.map((p) => p.distanceTo(this.centre)).sort((a, b) => a - b);
    const path = surfit.range(places.map((p) => p.distanceTo(this.centre)));
    this.size = Math.max(distances[Math.floor(0.9 * distances.length)] || 1, 1.1 * path[1]);
  }

  makeCell(run) {
    const errorRange = [0, Math.max(...this.runs.flatMap((r) => [...r.errors.values()]), 1e-9)];
    const cell = { run, scene: new THREE.Scene(), root: new THREE.Group(), paths: new THREE.Group(),
      points: surfit.makePointCloud(run.map), estimate: surfit.makeEstimate(run, errorRange),
      truth: surfit.makeTruth(run), cameras: surfit.makeFrusta(run, 0.04 * this.size),
      graph: surfit.makeGraph(run), refused: surfit.makeLoopEdges(run, 'refused'),
      selected: surfit.makeSegments(0xffc400), measured: surfit.makeSegments(0xff2fd0),
      box: surfit.makeSegments(0x8a949e) };
    cell.refused.visible = false;
    cell.root.applyMatrix(surfit.firstFromRun(run));
    cell.paths.add(cell.estimate, cell.truth, cell.cameras, cell.graph, cell.refused, cell.selected);
    cell.root.add(cell.points, cell.paths, cell.measured);
    cell.scene.add(cell.root, cell.box);
    cell.root.updateMatrixWorld(true);
    return cell;
  }

  connect() {
    const on = (id, event, call) => surfit.byId(id).addEventListener(event, (e) => {
      call(e.target);
      this.draw();
    });
    on('color-mode', 'change', (select) => this.setMode(select.value));
    on('disc-size', 'input', (range) => { this.discSize = Number(range.value); });
    on('least-confidence', 'input', (range) => this.setLeastConfidence(Number(range.value)));
    on('cull', 'change', (box) => this.setUniform('cull', box.checked));
    for (const name of ['estimate', 'truth', 'cameras', 'graph', 'refused']) {
      on(`show-${name}`, 'change',
        (box) => this.cells.forEach((cell) => { cell[name].visible = box.checked; }));
    }
    on('reset-view', 'click', () => this.resetView());
    on('measure', 'click', () => this.turnMeasure(!this.measure.isOn()));
    surfit.onClick(this.canvas, (x, y) => this.click(x, y));
    this.canvas.addEventListener('keydown', (event) => surfit.pressInMap(this, event));
  }

  setUniform(name, value) {
    for (const { points } of this.cells) points.material.uniforms[name].value = value;
  }

  applyCrop() {
    if (!this.crop) return;  // which is being made
    this.setUniform('boxFromWorld', this.crop.boxFromWorld);
    this.setUniform('boxLow', this.crop.low);
    this.setUniform('boxHigh', this.crop.high);
    for (const { box } of this.cells) {
      box.visible = !this.crop.isWhole();
      this.crop.fillEdges(box.geometry);
    }
    this.draw();
  }

  // share: 0 shows all, 1 the most confident only, evenly in the logarithm.
  setLeastConfidence(share) {
    const [low, high] = surfit.modeRange(this.runs, 'confidence');
    this.leastConfidence = share > 0 ? 10 ** (low + share * (high - low)) : 0;
    this.setUniform('leastConfidence', this.leastConfidence);
    surfit.byId('least-confidence-value').textContent = this.leastConfidence.toPrecision(3);
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
    const { width, height } = this.places()[0];
    const narrow = Math.max(1, 1.35 * height / width);
    this.camera.up.copy(up);
    this.camera.fov = 50;
    this.look(this.centre.clone().addScaledVector(up.clone().add(back), 1.5 * narrow * this.size), this.centre);
  }

  look(from, at) {
    this.camera.position.copy(from);
    // The controls take what is up from the camera when they are made.
    if (this.controls) this.controls.dispose();
    this.controls = new THREE.OrbitControls(this.camera, this.canvas);
    this.controls.enableKeys = false;  // of the whole window; pressInMap() has the canvas's
    this.controls.target.copy(at);
    this.controls.addEventListener('change', () => this.draw());
    this.controls.addEventListener('start', () => this.showPaths(true));
    this.controls.update();
    this.showPaths(true);
    this.draw();
  }

  showPaths(visible) {
    for (const { paths } of this.cells) paths.visible = visible;
  }

  // From a run's camera, as far as a level horizon allows; paths would hide what it sees.
  lookFrom(run, pose) {
    const cell = this.cells.find((c) => c.run === run);
    const eye = surfit.positionOf(pose).applyMatrix4(cell.root.matrix);
    const ahead = new THREE.Vector3(0, 0, 1).applyQuaternion(surfit.rotationOf(pose))
      .transformDirection(cell.root.matrix);
    const { camera } = run.poses;
    this.camera.fov = 2 * Math.atan(camera.height / 2 / camera.fy) * 180 / Math.PI;
    this.look(eye, eye.clone().addScaledVector(ahead, Math.max(0.5, 0.3 * this.size)));
    this.showPaths(false);
  }

  // The frame's camera, larger; and a line between a loop's two.
  select(run, frames) {
    for (const cell of this.cells) {
      const poses = cell.run !== run ? []
        : frames.map((frame) => run.poseOfFrame.get(frame)).filter(Boolean);
      const points = poses.flatMap((pose) => surfit.frustum(run, pose, 0.08 * this.size));
      if (poses.length === 2) points.push(...poses.map(surfit.positionOf));
      cell.selected.geometry.setFromPoints(points);
    }
    this.draw();
  }

  // Where the cells are on the canvas, in its CSS pixels from the top left.
  places() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    const count = this.runs.length;
    const stacked = clientWidth < surfit.narrowPx;
    const [width, height] = stacked ? [clientWidth, clientHeight / count] : [clientWidth / count, clientHeight];
    return this.runs.map((_, i) => ({ left: stacked ? 0 : i * width, top: stacked ? i * height : 0, width, height }));
  }

  // The cell at a place of the canvas, and the place in it, -1 to 1 to the right and upwards.
  cellAt(x, y) {
    const places = this.places();
    const i = places.findIndex((p) => x >= p.left && x < p.left + p.width && y >= p.top && y < p.top + p.height);
    if (i < 0) return null;
    const p = places[i];
    return { cell: this.cells[i], place: p,
      ndc: new THREE.Vector2(2 * (x - p.left) / p.width - 1, 1 - 2 * (y - p.top) / p.height) };
  }

  click(x, y) {
    const hit = this.cellAt(x, y);
    if (!hit) return;
    this.setAspect(hit.place);
    if (this.measure.isOn()) {
      this.measureAt(hit);
    } else {
      const pose = this.poseNear(hit);
      if (!pose) return;
      surfit.selectFrame(hit.cell.run, pose[0]);
      surfit.showMapFrame();
    }
  }

  measureAt({ cell, ndc }) {
    const caster = new THREE.Raycaster();
    caster.setFromCamera(ndc, this.camera);
    const runFromWorld = new THREE.Matrix4().getInverse(cell.root.matrix);
    const point = surfit.pick(cell.run.map, caster.ray.clone().applyMatrix4(runFromWorld), {
      cull: surfit.byId('cull').checked, leastConfidence: this.leastConfidence,
      isCropped: (px, py, pz) => !this.crop.holds(new THREE.Vector3(px, py, pz).applyMatrix4(cell.root.matrix)),
    });
    if (point) this.measure.add(cell, point);
    this.showMeasured();
  }

  turnMeasure(on) {
    this.measure.turn(on);
    if (on) surfit.byId('map-frame').hidden = true;
    this.showMeasured();
  }

  // A cross at each place and a line between them.
  showMeasured() {
    const arm = 0.01 * this.size;
    for (const cell of this.cells) {
      const points = this.measure.places.filter((place) => place.cell === cell).map((place) => place.point);
      const crosses = points.flatMap((p) => [[arm, 0, 0], [0, arm, 0], [0, 0, arm]].flatMap((d) => [
        p.clone().add(new THREE.Vector3(...d)), p.clone().sub(new THREE.Vector3(...d))]));
      cell.measured.geometry.setFromPoints(points.length === 2 ? [...crosses, ...points] : crosses);
    }
    this.draw();
  }

  // The pose whose camera is nearest to a place of the canvas, in pixels; null if none is near.
  poseNear({ cell, place, ndc }) {
    let [nearest, best] = [null, surfit.clickPx];
    for (const pose of cell.run.poses.poses) {
      const p = surfit.positionOf(pose).applyMatrix4(cell.root.matrix).project(this.camera);
      if (p.z > 1) continue;
      const px = Math.hypot((p.x - ndc.x) * place.width / 2, (p.y - ndc.y) * place.height / 2);
      if (px < best) [nearest, best] = [pose, px];
    }
    return nearest;
  }

  // Where a point of a run's world is on the canvas, in CSS pixels; null behind the camera.
  onCanvas(cell, point) {
    const place = this.places()[this.cells.indexOf(cell)];
    this.setAspect(place);
    const p = point.clone().applyMatrix4(cell.root.matrix).project(this.camera);
    if (p.z > 1) return null;
    return { x: place.left + (p.x + 1) * place.width / 2, y: place.top + (1 - p.y) * place.height / 2 };
  }

  showOverlay() {
    const overlay = surfit.byId('map-overlay');
    overlay.textContent = '';
    const metres = this.measure.metres();
    if (metres === null) return;
    const [a, b] = this.measure.places;
    const at = this.onCanvas(a.cell, a.point.clone().lerp(b.point, 0.5));
    if (!at) return;
    const tag = surfit.element('span', overlay, { className: 'tag', textContent: `${metres.toFixed(3)} m` });
    tag.style.left = `${at.x}px`;
    tag.style.top = `${at.y}px`;
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

  setAspect({ width, height }) {
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
  }

  drawNow(most) {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    this.fitCanvas(clientWidth, clientHeight);
    const places = this.places();
    this.setAspect(places[0]);
    const pixels = places[0].height * window.devicePixelRatio;
    const tangent = Math.tan(this.camera.fov * Math.PI / 360);
    this.setUniform('pixelsAtOneMetre', pixels / (2 * tangent));
    this.cells.forEach(({ scene, points }, i) => {
      const { left, top, width, height } = places[i];
      surfit.chooseFirst(points, this.runs[i].map, most, this.discSize);
      const below = clientHeight - top - height;
      this.renderer.setViewport(left, below, width, height);
      this.renderer.setScissor(left, below, width, height);
      this.renderer.render(scene, this.camera);
    });
    this.showOverlay();
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
  surfit.byId('color-mode').querySelector('[value="distance"]').hidden = !runs.some((run) => run.map.distance);
  surfit.hideAll('.of-graph', !runs.some((run) => (run.poses.keyframes || []).length > 0));
  surfit.hideAll('.of-loops', !runs.some((run) => run.loops.length > 0));
  for (const run of runs) {
    const { points, shown } = run.map;
    const all = points === shown ? `all ${points} surfels`
      : `${shown} of ${points} surfels, evenly thinned out to what a browser holds`;
    const label = surfit.element('div', surfit.byId('map-labels'));
    surfit.element('h3', label, { textContent: run.label });
    surfit.element('p', label, { className: 'note', textContent: all });
    const comparison = surfit.comparisonText(run, runs);
    if (comparison) surfit.element('p', label, { className: 'note', textContent: comparison });
  }
};
