'use strict';
// The paths from above, and the error along them.

// To the right of and along a run's mean line of sight, and up.
surfit.floorDirections = (run) => {
  const up = surfit.upOf(run);
  const ahead = surfit.forwardOf(run);
  ahead.addScaledVector(up, -ahead.dot(up));
  if (ahead.length() < 1e-3) ahead.set(up.y, up.z, up.x).cross(up);
  ahead.normalize();
  return [new THREE.Vector3().crossVectors(ahead, up), ahead, up];
};

// Coordinates on the floor, in metres.
surfit.floorAxes = (run) => {
  const [right, ahead] = surfit.floorDirections(run);
  return (p) => ({ x: right.dot(p), y: ahead.dot(p) });
};

// Makes a metre as long upwards as sideways, once the chart knows its size.
surfit.equalAspect = (chart) => {
  const points = chart.data.datasets.flatMap((set) => set.data);
  const spans = ['x', 'y'].map((k) => surfit.range(points.map((p) => p[k])));
  const { width, height } = chart.chartArea;
  const metresPerPixel = 1.08 * Math.max((spans[0][1] - spans[0][0]) / width,
    (spans[1][1] - spans[1][0]) / height, 1e-6);
  [width, height].forEach((pixels, k) => {
    const middle = (spans[k][0] + spans[k][1]) / 2;
    const scale = chart.options.scales['xy'[k]];
    scale.min = middle - metresPerPixel * pixels / 2;
    scale.max = middle + metresPerPixel * pixels / 2;
  });
  chart.update('none');
};

surfit.estimateDataset = (run, i, onFloor, errorRange) => {
  const poses = run.poses.poses;
  const more = run.errors.size === 0 ? {} : {
    pointRadius: 2, pointBorderWidth: 0,
    pointBackgroundColor: poses.map((pose) => surfit.cssColor(
      surfit.scaleColor(run.errors.get(pose[0]) || 0, ...errorRange))),
  };
  return surfit.line(`estimate: ${run.label}`, surfit.runColor(i),
    poses.map((pose) => onFloor(surfit.positionOf(pose).applyMatrix4(surfit.firstFromRun(run)))), more);
};

surfit.showTrajectories = (runs) => {
  const parent = surfit.byId('trajectory-charts');
  const onFloor = surfit.floorAxes(runs[0]);
  const errors = runs.flatMap((run) => [...run.errors.values()]);
  const errorRange = [0, surfit.range(errors)[1]];
  const datasets = runs.flatMap((run, i) => {
    const truth = (run.poses.truth || []).map((row) => onFloor(
      new THREE.Vector3(row[1], row[2], row[3]).applyMatrix4(surfit.firstFromRun(run))));
    const estimate = surfit.estimateDataset(run, i, onFloor, errorRange);
    return truth.length === 0 ? [estimate]
      : [estimate, surfit.line(`ground truth: ${run.label}`, '#ff8c1a', truth, { borderDash: [5, 3] })];
  });
  const note = errors.length === 0 ? 'No ground truth: errors are unknown.'
    : `Points are coloured by their distance from the ground truth, dark 0 to bright ${
      (1000 * errorRange[1]).toFixed(1)} mm; each ground truth is moved onto its run as for ATE.`;
  surfit.element('p', parent, { className: 'note', textContent: note });
  surfit.addChart(parent, 'from above', datasets, {
    x: surfit.axis('right, m'), y: surfit.axis('ahead, m'), className: 'chart tall', zoomMode: 'xy',
    plugins: { tooltip: { enabled: false } } }, (chart) => {
    // Observers call once at the beginning, too.
    new ResizeObserver(() => surfit.equalAspect(chart)).observe(chart.canvas.parentElement);
  });
  if (errors.length === 0) return;
  surfit.addChart(parent, 'position error', runs.map((run, i) => surfit.line(run.label, surfit.runColor(i),
    [...run.errors].map(([x, error]) => ({ x, y: 1000 * error })))), {
    x: surfit.axis('frame'), y: surfit.axis('mm', { beginAtZero: true }) });
};
