'use strict';
// Crop box: surfels outside are not drawn. Its axes are right of and along the mean viewing direction of the first
// run, and up.
surfit.boxNames = ['right', 'ahead', 'up'];

surfit.CropBox = class {
  // axes: three unit vectors in the world of the first run. points: sample of the maps. changed: called after each
  // change of the box.
  constructor(axes, points, changed) {
    this.boxFromWorld = new THREE.Matrix3().set(...axes.flatMap((axis) => axis.toArray()));
    const margin = 0.05;
    this.whole = axes.map((axis) => surfit.range(points.map((p) => axis.dot(p)))).map(
      ([low, high]) => [low - margin, high + margin]);
    this.rows = surfit.boxNames.map((name, k) => this.makeRow(name, this.whole[k], changed));
    surfit.on('reset-crop', 'click', () => {
      this.reset();
      changed();
    });
    this.update();
  }

  makeRow(name, [min, max], changed) {
    const row = surfit.element('div', surfit.byId('crop-ranges'), { className: 'crop-row' });
    surfit.element('span', row, { textContent: name });
    return ['from', 'to'].map((side, k) => {
      const label = surfit.element('label', row, { textContent: `${side} ` });
      const range = surfit.element('input', label, { type: 'range', min, max, step: 'any', value: [min, max][k],
        ariaLabel: `${name}, ${side}, metres`, id: `crop-${name}-${side}` });
      const output = surfit.element('output', label);
      range.addEventListener('input', () => {
        this.update();
        changed();
      });
      return { range, output };
    });
  }

  reset() {
    this.rows.forEach((row, k) => row.forEach(({ range }, side) => { range.value = this.whole[k][side]; }));
    this.update();
  }

  update() {
    const value = (side) => this.rows.map((row) => Number(row[side].range.value));
    [this.low, this.high] = [new THREE.Vector3(...value(0)), new THREE.Vector3(...value(1))];
    for (const { range, output } of this.rows.flat()) output.textContent = `${Number(range.value).toFixed(2)} m`;
  }

  isWhole() {
    return surfit.boxNames.every((_, k) => this.low.getComponent(k) <= this.whole[k][0] + 1e-6
      && this.high.getComponent(k) >= this.whole[k][1] - 1e-6);
  }

  holds(pointInWorld) {
    const p = pointInWorld.clone().applyMatrix3(this.boxFromWorld);
    return ['x', 'y', 'z'].every((k) => p[k] >= this.low[k] && p[k] <= this.high[k]);
  }

  // The twelve edges as pairs of points.
  edges() {
    const worldFromBox = this.boxFromWorld.clone().transpose();
    const corner = (bits) => new THREE.Vector3(...[0, 1, 2].map(
      (k) => (bits >> k & 1 ? this.high : this.low).getComponent(k))).applyMatrix3(worldFromBox);
    const points = [];
    for (let bits = 0; bits < 8; ++bits) {
      for (let k = 0; k < 3; ++k) if (!(bits >> k & 1)) points.push(corner(bits), corner(bits | 1 << k));
    }
    return points;
  }
};
