'use strict';
// The maps of all runs on one canvas with a common camera: side by side, or stacked on a narrow canvas. During changes,
// only a part of the surfels is drawn, so that rotation is smooth without a graphics card. All surfels are drawn
// shortly after the last change.
surfit.pointsWhileChanging = 100000;  // total of all maps
surfit.restMs = 200;  // delay after the last change
surfit.narrowPx = 700;
surfit.clickPx = 14;  // largest distance of a click from a camera

surfit.MapView = class extends surfit.Scene {
  constructor(runs) {
    super(surfit.byId('map-canvas'));
    this.runs = runs;
    this.renderer.setScissorTest(true);
    this.discSize = 1;
    this.leastConfidence = 0;
    this.isComplete = false;  // whether all surfels are drawn
    const inFirst = (run, points) => points.map((point) => point.applyMatrix4(surfit.firstFromRun(run)));
    const samples = runs.flatMap((run) => inFirst(run, surfit.sampleOf(run.map)));
    this.bounds = surfit.boundsOf(samples,
      runs.flatMap((run) => inFirst(run, run.poses.poses.map(surfit.positionOf))));
    this.cells = runs.map((run) => this.makeCell(run));
    this.measure = new surfit.Measure(surfit.byId('measure'), surfit.byId('measured'));
    this.crop = new surfit.CropBox(surfit.floorDirections(runs[0]), samples, () => this.applyCrop());
    this.applyCrop();
    this.connect();
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

  makeCell(run) {
    const { camera, poses, truth } = run.poses, { size } = this.bounds;
    const step = Math.max(1, Math.ceil(poses.length / 30));  // every step-th camera is shown
    const cell = { run, scene: new THREE.Scene(), root: new THREE.Group(), paths: new THREE.Group(),
      discs: surfit.makeDiscs(new THREE.BufferGeometry(), run.map.origin, run.map.extent),
      estimate: surfit.makeLines(0xd1495b, poses.map(surfit.positionOf), THREE.Line),
      truth: surfit.makeLines(0xff8c1a, truth.map((row) => new THREE.Vector3(row[1], row[2], row[3])), THREE.Line),
      cameras: surfit.makeLines(0x2f81d6, poses.filter((_, i) => i % step === 0).flatMap(
        (pose) => surfit.frustum(camera, pose, 0.04 * size))),
      graph: surfit.makeGraph(run), refused: surfit.makeLoopEdges(run, 'refused'),
      selected: surfit.makeLines(0xffc400), measured: surfit.makeLines(0xff2fd0), box: surfit.makeLines(0x8a949e) };
    surfit.setDiscs(cell.discs.geometry, run.map);
    this.colorByError(cell);
    cell.refused.visible = false;
    cell.root.applyMatrix(surfit.firstFromRun(run));
    cell.paths.add(cell.estimate, cell.truth, cell.cameras, cell.graph, cell.refused, cell.selected);
    cell.root.add(cell.discs, cell.paths, cell.measured);
    cell.scene.add(cell.root, cell.box);
    cell.root.updateMatrixWorld(true);
    return cell;
  }

  colorByError({ run, estimate }) {
    if (run.errors.size === 0) return;
    const most = Math.max(...this.runs.flatMap((r) => [...r.errors.values()]), 1e-9);
    const colors = run.poses.poses.flatMap((pose) => surfit.scaleColor(run.errors.get(pose[0]) || 0, 0, most));
    estimate.geometry.setAttribute('color', new THREE.BufferAttribute(new Uint8Array(colors), 3, true));
    estimate.material = new THREE.LineBasicMaterial({ vertexColors: THREE.VertexColors });
  }

  connect() {
    const on = (id, event, call) => surfit.on(id, event, (element) => {
      call(element);
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
    surfit.connectKeys(this.canvas, this, {
      n: () => surfit.showNextFrame(1),
      p: () => surfit.showNextFrame(-1),
      v: () => surfit.lookFromFrame(),
      m: () => this.turnMeasure(!this.measure.isOn()),
      Escape: () => this.turnMeasure(false),
      r: () => this.resetView(),
    });
  }

  setUniform(name, value) {
    for (const { discs } of this.cells) discs.material.uniforms[name].value = value;
  }

  applyCrop() {
    this.setUniform('boxFromWorld', this.crop.boxFromWorld);
    this.setUniform('boxLow', this.crop.low);
    this.setUniform('boxHigh', this.crop.high);
    for (const { box } of this.cells) {
      box.visible = !this.crop.isWhole();
      surfit.setPoints(box, this.crop.edges());
    }
    this.draw();
  }

  // share: 0: all surfels, 1: the most confident surfels only. Logarithmic scale.
  setLeastConfidence(share) {
    const [low, high] = surfit.modeRange(this.runs, 'confidence');
    this.leastConfidence = share > 0 ? 10 ** (low + share * (high - low)) : 0;
    this.setUniform('leastConfidence', this.leastConfidence);
    surfit.byId('least-confidence-value').textContent = this.leastConfidence.toPrecision(3);
  }

  setMode(mode) {
    const range = mode in surfit.scalarModes ? surfit.modeRange(this.runs, mode) : [0, 0];
    for (const { discs, run } of this.cells) surfit.colorDiscs(discs, run.map, mode, range);
    surfit.showLegend(mode, range);
    this.draw();
  }

  aspect() {
    const { width, height } = this.places()[0];
    return width / height;
  }

  resetView() {
    const run = this.runs[0].poses;
    this.lookAtAll(this.bounds, surfit.forwardOf(run.poses), surfit.upOfRun(run));
  }

  look(from, at) {
    super.look(from, at);
    this.showPaths(true);
  }

  isTurned() { this.showPaths(true); }

  showPaths(visible) {
    for (const { paths } of this.cells) paths.visible = visible;
  }

  // Looks from a camera of a run with a level horizon. Hides the paths, which would occlude surfels.
  lookFrom(run, pose) {
    const { root } = this.cells.find((cell) => cell.run === run);
    const eye = surfit.positionOf(pose).applyMatrix4(root.matrix);
    const ahead = surfit.forwardOf([pose]).transformDirection(root.matrix);
    const { camera } = run.poses;
    this.camera.fov = 2 * Math.atan(camera.height / 2 / camera.fy) * 180 / Math.PI;
    this.look(eye, eye.clone().addScaledVector(ahead, Math.max(0.5, 0.3 * this.bounds.size)));
    this.showPaths(false);
  }

  // Highlights the cameras of frames. For two frames, also draws a line between them.
  select(run, frames) {
    for (const cell of this.cells) {
      const poses = cell.run !== run ? []
        : frames.map((frame) => run.poseOfFrame.get(frame)).filter(Boolean);
      const points = poses.flatMap((pose) => surfit.frustum(run.poses.camera, pose, 0.08 * this.bounds.size));
      if (poses.length === 2) points.push(...poses.map(surfit.positionOf));
      surfit.setPoints(cell.selected, points);
    }
    this.draw();
  }

  // Boxes of the cells on the canvas, in CSS pixels from the top left.
  places() {
    const { width, height } = this.canvasSize(), count = this.runs.length;
    return this.runs.map((_, i) => (width < surfit.narrowPx
      ? { left: 0, top: i * height / count, width, height: height / count }
      : { left: i * width / count, top: 0, width: width / count, height }));
  }

  // Index of the cell at a point of the canvas; -1 outside.
  cellAt(x, y) {
    return this.places().findIndex(
      (p) => x >= p.left && x < p.left + p.width && y >= p.top && y < p.top + p.height);
  }

  click(x, y) {
    const i = this.cellAt(x, y);
    if (i < 0) return;
    if (this.measure.isOn()) return this.measureAt(i, x, y);
    const { run } = this.cells[i], pose = this.poseNear(this.cells[i], x, y);
    if (!pose) return;
    surfit.selectFrame(run, pose[0]);
    surfit.showMapFrame();
  }

  measureAt(i, x, y) {
    const cell = this.cells[i], { left, top, width, height } = this.places()[i];
    this.setAspect({ width, height });
    const caster = new THREE.Raycaster();
    caster.setFromCamera({ x: 2 * (x - left) / width - 1, y: 1 - 2 * (y - top) / height }, this.camera);
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

  // Draws a cross at each point and a line between two points.
  showMeasured() {
    const arm = 0.01 * this.bounds.size;
    for (const cell of this.cells) {
      const points = this.measure.places.filter((place) => place.cell === cell).map((place) => place.point);
      const crosses = points.flatMap((p) => [[arm, 0, 0], [0, arm, 0], [0, 0, arm]].flatMap((d) => [
        p.clone().add(new THREE.Vector3(...d)), p.clone().sub(new THREE.Vector3(...d))]));
      surfit.setPoints(cell.measured, points.length === 2 ? [...crosses, ...points] : crosses);
    }
    this.draw();
  }

  // Pose of the camera that is nearest to a point of the canvas; null if no camera is within clickPx.
  poseNear(cell, x, y) {
    let [nearest, best] = [null, surfit.clickPx];
    for (const pose of cell.run.poses.poses) {
      const at = this.onCanvas(cell, surfit.positionOf(pose));
      const px = at ? Math.hypot(at.x - x, at.y - y) : Infinity;
      if (px < best) [nearest, best] = [pose, px];
    }
    return nearest;
  }

  // Projects a point in the world of a run to the canvas, in CSS pixels. Null behind the camera.
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
    Object.assign(tag.style, { left: `${at.x}px`, top: `${at.y}px` });
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

  // Draws at most `most` surfels per map: the first surfels, which are evenly spread over the map.
  drawNow(most) {
    this.fitCanvas(window.devicePixelRatio);
    const places = this.places();
    this.setAspect(places[0]);
    this.setUniform('pixelsAtOneMetre', this.pixelsAtOneMetre(places[0].height));
    this.cells.forEach(({ scene, discs, run: { map } }, i) => {
      const { left, top, width, height } = places[i];
      const below = this.canvasSize().height - top - height, drawn = Math.min(most, map.shown);
      discs.geometry.setDrawRange(0, drawn);
      discs.material.uniforms.metresPerRadius.value = map.max_radius * this.discSize * surfit.growth(map, drawn);
      this.renderer.setViewport(left, below, width, height);
      this.renderer.setScissor(left, below, width, height);
      this.renderer.render(scene, this.camera);
    });
    this.showOverlay();
  }
};

// Positions of about 5000 surfels in the world of the run.
surfit.sampleOf = (map) => {
  const points = [];
  const step = Math.ceil(map.shown / 5000);
  for (let i = 0; i < map.shown; i += step) points.push(surfit.positionOfSurfel(map, i));
  return points;
};

surfit.showMapLabels = (runs) => {
  surfit.byId('color-mode').querySelector('[value="distance"]').hidden = !runs.some((run) => run.map.distance);
  const hideAll = (selector, hidden) => {
    for (const element of document.querySelectorAll(selector)) element.hidden = hidden;
  };
  hideAll('.of-graph', !runs.some((run) => run.poses.keyframes.length > 0));
  hideAll('.of-loops', !runs.some((run) => run.loops.length > 0));
  for (const run of runs) {
    const { points, shown } = run.map;
    const label = surfit.element('div', surfit.byId('map-labels'));
    surfit.element('h3', label, { textContent: run.label });
    surfit.say(label, points === shown ? `all ${points} surfels`
      : `${shown} of ${points} surfels, sampled evenly`);
    if (runs.length > 1) surfit.say(label, surfit.comparisonText(run));
  }
};

// Calls `call` with the position of a click, in CSS pixels from the top left of the element. A long press or a drag
// rotates the map and is not a click.
surfit.onClick = (element, call) => {
  const mostPx = 5, mostMs = 600;
  let down = null;
  element.addEventListener('pointerdown', (event) => { down = event.button === 0 ? event : null; });
  window.addEventListener('pointerup', (event) => {
    if (down && Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY) <= mostPx
        && event.timeStamp - down.timeStamp <= mostMs) {
      const box = element.getBoundingClientRect();
      call(event.clientX - box.left, event.clientY - box.top);
    }
    down = null;
  });
};
